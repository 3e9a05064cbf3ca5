//! A studio: an orbiting camera and three lights that arrange themselves around what is to be seen.
//!
//! In: entities marked as [`Subject`], whose meshes (their own and their descendants') may arrive at any time. Out: a
//! camera at a three-quarter view that just holds their bounding box, a key light with soft shadows, a cool fill light
//! and a rim light. Left mouse button orbits, right button pans, wheel zooms.

use bevy::{
    camera::primitives::Aabb,
    core_pipeline::tonemapping::Tonemapping,
    light::{CascadeShadowConfig, CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    math::bounding::{Aabb3d, BoundingVolume},
    prelude::*,
    winit::WinitPlugin,
};
use bevy_panorbit_camera::{PanOrbitCamera, PanOrbitCameraPlugin};

/// From the subject towards the camera: from the front, a little from the right and from above.
const VIEW: Vec3 = Vec3::new(0.5, 0.42, 1.0);

/// Room between the subject and the edge of the picture, as a part of the subject.
const MARGIN: f32 = 0.08;

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

fn furnish(mut commands: Commands) {
    commands.spawn((
        StudioCamera,
        Camera3d::default(),
        Msaa::Sample4,
        Tonemapping::AgX,
        Transform::from_translation(4.0 * VIEW).looking_at(Vec3::ZERO, Vec3::Y),
        AmbientLight {
            color: Color::srgb(0.90, 0.95, 1.0),
            brightness: 350.0,
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
    bounds: Query<(&Aabb, &GlobalTransform)>,
    camera: Single<(Entity, &mut Transform, &mut Projection), With<StudioCamera>>,
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
    let parts = subjects
        .iter()
        .flat_map(|subject| [subject].into_iter().chain(children.iter_descendants(subject)));
    let boxes = parts
        .filter_map(|part| bounds.get(part).ok())
        .map(|(aabb, transform)| world_box(aabb, transform));
    let Some(all) = boxes.reduce(|a, b| a.merge(&b)) else {
        return;
    };

    let (entity, mut transform, mut projection) = camera.into_inner();
    let Projection::Perspective(lens) = projection.as_mut() else {
        return;
    };
    let stage = Stage {
        centre: all.center().into(),
        radius: Vec3::from(all.half_size()).length().max(f32::MIN_POSITIVE),
    };
    let distance = framing_distance(&all, lens);
    (lens.near, lens.far) = (0.01 * stage.radius, 1000.0 * stage.radius);
    *transform =
        Transform::from_translation(stage.centre + distance * VIEW.normalize()).looking_at(stage.centre, Vec3::Y);
    let orbit = PanOrbitCamera {
        focus: stage.centre,
        zoom_lower_limit: 0.05 * stage.radius,
        ..default()
    };
    commands.entity(entity).insert((stage, orbit));
}

fn world_box(aabb: &Aabb, transform: &GlobalTransform) -> Aabb3d {
    let linear = transform.affine().matrix3;
    let half = linear.x_axis.abs() * aabb.half_extents.x
        + linear.y_axis.abs() * aabb.half_extents.y
        + linear.z_axis.abs() * aabb.half_extents.z;
    Aabb3d::new(transform.transform_point(aabb.center.into()), half)
}

/// The smallest distance from the box's centre, along [`VIEW`], from which the lens sees all eight corners.
fn framing_distance(bounds: &Aabb3d, lens: &PerspectiveProjection) -> f32 {
    let to_camera = Transform::default().looking_to(-VIEW, Vec3::Y).rotation.inverse();
    let tan = (0.5 * lens.fov).tan() * Vec2::new(lens.aspect_ratio, 1.0);
    let signs = [-1.0, 1.0];
    let corners = signs
        .iter()
        .flat_map(|&x| signs.iter().flat_map(move |&y| signs.map(|z| Vec3::new(x, y, z))));
    corners
        .map(|sign| {
            let corner = to_camera * (sign * Vec3::from(bounds.half_size()) * (1.0 + MARGIN));
            corner.z + (corner.xy().abs() / tan).max_element()
        })
        .fold(f32::MIN_POSITIVE, f32::max)
}

/// Spends the whole shadow map on the subjects, from wherever the camera looks.
fn fit_shadows(
    camera: Single<(&Transform, &Stage), (With<StudioCamera>, Changed<Transform>)>,
    mut shadows: Single<&mut CascadeShadowConfig, With<KeyLight>>,
) {
    let (transform, stage) = *camera;
    let distance = transform.translation.distance(stage.centre);
    **shadows = CascadeShadowConfigBuilder {
        num_cascades: 1,
        minimum_distance: (distance - 1.1 * stage.radius).max(0.01 * stage.radius),
        maximum_distance: distance + 1.1 * stage.radius,
        ..default()
    }
    .build();
}
