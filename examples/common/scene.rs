//! A studio: an orbiting camera and three lights that arrange themselves around what is to be seen.
//!
//! In: entities marked as [`Subject`], whose meshes (their own and their descendants') may arrive at any time. Out: a
//! camera at a three-quarter view that just holds them, a key light with soft shadows, a cool fill light
//! and a rim light. Left mouse button orbits, right button pans, wheel zooms.

use bevy::{
    camera::primitives::Aabb,
    core_pipeline::tonemapping::Tonemapping,
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    math::bounding::{Aabb3d, BoundingVolume},
    mesh::VertexAttributeValues,
    prelude::*,
    winit::WinitPlugin,
};
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};

/// From the subjects towards the camera, of any length. Default: from the front, a little from the right and from above.
#[derive(Resource, Clone, Copy, Debug)]
pub struct View(pub Vec3);

impl Default for View {
    fn default() -> Self {
        Self(Vec3::new(0.5, 0.42, 1.0))
    }
}

/// Room between the subject and the edge of the picture, as a part of half the picture.
const MARGIN: f32 = 0.1;

/// What the camera looks at: this entity's mesh and those of its descendants.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Transform, Visibility)]
pub struct Subject;

/// Spawns the studio's camera and lights and keeps them arranged.
pub struct StudioPlugin;

impl Plugin for StudioPlugin {
    fn build(&self, app: &mut App) {
        if app.is_plugin_added::<WinitPlugin>() {
            app.add_plugins(PanOrbitCameraPlugin);
        }
        app.insert_resource(ClearColor(Color::srgb(0.86, 0.88, 0.90)))
            .insert_resource(DirectionalLightShadowMap { size: 2048 })
            .init_resource::<View>()
            .add_systems(Startup, furnish)
            .add_systems(Update, (frame_subjects, fit_shadows).chain());
    }
}

/// The studio's camera.
#[derive(Component)]
pub struct StudioCamera;

/// The light that casts shadows.
#[derive(Component)]
struct KeyLight;

/// A sphere around the subjects, on the camera: what the shadow map has to cover.
#[derive(Component, Clone, Copy)]
struct Stage {
    centre: Vec3,
    radius: f32,
}

fn furnish(mut commands: Commands, view: Res<View>) {
    commands.spawn((
        StudioCamera,
        Camera3d::default(),
        Msaa::Sample4,
        Tonemapping::TonyMcMapface,
        Transform::from_translation(4.0 * view.0).looking_at(Vec3::ZERO, Vec3::Y),
        AmbientLight {
            color: Color::srgb(0.90, 0.95, 1.0),
            brightness: 250.0,
            ..default()
        },
    ));
    let light = |color, illuminance, from: Vec3| {
        let light = DirectionalLight {
            color,
            illuminance,
            ..default()
        };
        (light, Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y))
    };
    let (key, towards) = light(Color::srgb(1.0, 0.96, 0.90), 9_000.0, Vec3::new(-0.55, 1.0, 0.75));
    commands.spawn((
        KeyLight,
        DirectionalLight {
            shadow_maps_enabled: true,
            ..key
        },
        towards,
    ));
    commands.spawn(light(Color::srgb(0.82, 0.90, 1.0), 2_200.0, Vec3::new(1.0, 0.15, 0.6)));
    commands.spawn(light(Color::WHITE, 5_000.0, Vec3::new(0.35, 0.6, -1.0)));
}

/// Looks at all subjects anew whenever the mesh of one has arrived.
///
/// Meshes that move or change later do not move the camera.
fn frame_subjects(
    arrived: Query<Entity, Added<Aabb>>,
    subjects: Query<Entity, With<Subject>>,
    children: Query<&Children>,
    parents: Query<&ChildOf>,
    parts: Query<(&Aabb, &GlobalTransform, &Mesh3d)>,
    meshes: Res<Assets<Mesh>>,
    camera: Single<(Entity, &mut Transform, &mut Projection), With<StudioCamera>>,
    view: Res<View>,
    mut commands: Commands,
) {
    let belongs = |entity| {
        parents
            .iter_ancestors(entity)
            .chain([entity])
            .any(|ancestor| subjects.contains(ancestor))
    };
    if !arrived.iter().any(belongs) {
        return;
    }
    let all = subjects
        .iter()
        .flat_map(|subject| [subject].into_iter().chain(children.iter_descendants(subject)));
    let outline: Vec<Vec3> = all
        .filter_map(|part| parts.get(part).ok())
        .flat_map(|(aabb, transform, mesh)| outline(aabb, transform, meshes.get(mesh)))
        .collect();
    let (entity, mut transform, mut projection) = camera.into_inner();
    let Projection::Perspective(lens) = projection.as_mut() else {
        return;
    };
    if outline.is_empty() {
        return;
    }
    let bounds = Aabb3d::from_point_cloud(Isometry3d::IDENTITY, outline.iter().copied());
    let centre = Vec3::from(bounds.center());
    let radius = Vec3::from(bounds.half_size()).length().max(f32::MIN_POSITIVE);
    let distance = framing_distance(&outline, centre, view.0, lens).max(f32::MIN_POSITIVE);
    (lens.near, lens.far) = (0.01 * radius, 1000.0 * radius);
    *transform = Transform::from_translation(centre + distance * view.0.normalize()).looking_at(centre, Vec3::Y);
    let orbit = PanOrbitCamera {
        focus: centre,
        zoom_lower_limit: 0.05 * radius,
        ..default()
    };
    commands.entity(entity).insert((Stage { centre, radius }, orbit));
}

/// The mesh's vertices in the world, or the corners of its box where they cannot be read.
pub fn outline(aabb: &Aabb, transform: &GlobalTransform, mesh: Option<&Mesh>) -> Vec<Vec3> {
    let positions = mesh
        .and_then(|mesh| mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).ok())
        .and_then(VertexAttributeValues::as_float3);
    let points = match positions {
        Some(positions) => positions.iter().copied().map(Vec3::from_array).collect(),
        None => (0..8_u8)
            .map(|corner| {
                let sign = |axis: u8| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
                Vec3::from(aabb.center) + Vec3::from(aabb.half_extents) * Vec3::new(sign(0), sign(1), sign(2))
            })
            .collect::<Vec<_>>(),
    };
    points
        .into_iter()
        .map(|point| transform.transform_point(point))
        .collect()
}

/// The smallest distance from `centre` towards `view` from which the lens sees all points and a [`MARGIN`].
fn framing_distance(points: &[Vec3], centre: Vec3, view: Vec3, lens: &PerspectiveProjection) -> f32 {
    let to_camera = Transform::default().looking_to(-view, Vec3::Y).rotation.inverse();
    let tan = (0.5 * lens.fov).tan() * Vec2::new(lens.aspect_ratio, 1.0);
    let distances = points.iter().map(|&point| {
        let point = to_camera * (point - centre);
        point.z + (point.xy().abs() * (1.0 + MARGIN) / tan).max_element()
    });
    distances.fold(0.0, f32::max)
}

/// Spends the whole shadow map on the subjects, from wherever the camera looks.
fn fit_shadows(
    camera: Single<(&Transform, &Stage), (With<StudioCamera>, Changed<Transform>)>,
    key: Single<(&mut CascadeShadowConfig, &mut DirectionalLight), With<KeyLight>>,
) {
    let (transform, stage) = *camera;
    let distance = transform.translation.distance(stage.centre);
    let (mut shadows, mut light) = key.into_inner();
    // Bevy's default is for subjects of some metres.
    light.shadow_depth_bias = 0.005 * stage.radius;
    *shadows = CascadeShadowConfigBuilder {
        num_cascades: 1,
        minimum_distance: (distance - 1.1 * stage.radius).max(0.01 * stage.radius),
        maximum_distance: distance + 1.1 * stage.radius,
        ..default()
    }
    .build();
}
