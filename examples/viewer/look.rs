//! Turns the [`ViewerSettings`] into a [`PatternScene`] on the model.

use std::{path::PathBuf, sync::Arc};

use bevy::{
    camera::primitives::Aabb,
    math::bounding::{Aabb3d, BoundingVolume},
    prelude::*,
};
use bevy_field_patterns::{material::SceneStyle, prelude::*, wave::SolverSettings};

use crate::{
    common::{headless::ReadyChecks, scene::outline},
    model::{Model, Notice},
    settings::{Field, Style, ViewerSettings},
    styles::{Ground, srgb},
};

/// Keeps the look of the model as the settings say.
pub struct LookPlugin;

impl Plugin for LookPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(FieldPatternsPlugin)
            .init_resource::<FieldFile>()
            .add_systems(Update, (set_solver, measure, set_scene, set_scalars, set_gaps).chain());
        if let Some(mut checks) = app.world_mut().get_resource_mut::<ReadyChecks>() {
            checks.0.push(model_is_dressed);
        }
    }
}

/// The box around all meshes of a model, in world units.
#[derive(Component, Clone, Copy, PartialEq)]
struct Extent {
    middle: Vec3,
    /// Above 0.
    diagonal: f32,
}

/// The field file read last, for it is long: path, vertices, and what was found.
#[derive(Resource, Default)]
struct FieldFile(Option<(PathBuf, Option<usize>, Result<DirectionField, String>)>);

fn set_solver(settings: Res<ViewerSettings>, mut solver: ResMut<SolverSettings>) {
    solver.set_if_neq(settings.solver.clone());
}

/// Measures a model whenever one of its meshes has arrived.
fn measure(
    arrived: Query<(), Added<Aabb>>,
    models: Query<(Entity, Option<&Extent>), With<Model>>,
    children: Query<&Children>,
    parts: Query<(&Aabb, &GlobalTransform, &Mesh3d)>,
    meshes: Res<Assets<Mesh>>,
    mut commands: Commands,
) {
    if arrived.is_empty() {
        return;
    }
    for (model, known) in &models {
        let points: Vec<Vec3> = [model]
            .into_iter()
            .chain(children.iter_descendants(model))
            .filter_map(|part| parts.get(part).ok())
            .flat_map(|(aabb, transform, mesh)| outline(aabb, transform, meshes.get(mesh)))
            .collect();
        if points.is_empty() {
            continue;
        }
        let bounds = Aabb3d::from_point_cloud(Isometry3d::IDENTITY, points.into_iter());
        let extent = Extent {
            middle: bounds.center().into(),
            diagonal: (2.0 * bounds.half_size().length()).max(f32::MIN_POSITIVE),
        };
        if known != Some(&extent) {
            commands.entity(model).insert(extent);
        }
    }
}

/// Gives the model its pattern, or takes it away.
fn set_scene(
    settings: Res<ViewerSettings>,
    models: Query<(Entity, &Model, Ref<Extent>, Scenes)>,
    assets: Res<AssetServer>,
    mut file: ResMut<FieldFile>,
    mut notice: ResMut<Notice>,
    mut commands: Commands,
) {
    for (entity, model, extent, scenes) in &models {
        if !settings.is_changed() && !extent.is_changed() {
            continue;
        }
        let failed = matches!(&file.0, Some((.., Err(error))) if notice.0.as_ref() == Some(error));
        let field = match file.field(&settings.field, model.vertices) {
            Ok(field) => field,
            Err(error) => {
                notice.0 = Some(error);
                continue;
            }
        };
        if failed {
            notice.0 = None;
        }
        let frequency = settings.frequency / extent.diagonal;
        let base = PatternScene {
            field,
            symmetry: Some(settings.symmetry),
            space: PatternSpace::World,
            pose: settings.pose,
            waves: settings.waves(),
            frequency: Frequency::Uniform(frequency),
            ..default()
        };
        let ground = Ground {
            is_vector: settings.symmetry == Symmetry::Vector,
            waves: base.waves,
            period: 1.0 / frequency.max(f32::MIN_POSITIVE),
            focus: settings.focus.focus(extent.middle, extent.diagonal),
        };
        let mut entity = commands.entity(entity);
        let style = settings.style;
        let is_stripes = !matches!(style, Style::Texture | Style::Hatch | Style::Tensor | Style::Plain);
        let stripes = is_stripes.then(|| settings.stripes.look(&ground, style));
        give(&mut entity, &base, stripes, scenes.0);
        let texture = (style == Style::Texture).then(|| settings.texture.look(&ground, &assets));
        give(&mut entity, &base, texture, scenes.1);
        let hatch = (style == Style::Hatch).then(|| settings.hatch.look(&ground));
        give(&mut entity, &base, hatch, scenes.2);
        let tensor = (style == Style::Tensor).then(|| settings.tensor.look(&ground));
        give(&mut entity, &base, tensor, scenes.3);
    }
}

/// The scenes that a model may have, of which it has one.
type Scenes = (
    Option<&'static StyledScene<Stripes>>,
    Option<&'static StyledScene<PatternTexture>>,
    Option<&'static StyledScene<Hatch>>,
    Option<&'static StyledScene<Tensor>>,
);

/// Gives the model a scene of this style, or takes it away.
fn give<S: SceneStyle>(
    entity: &mut EntityCommands,
    base: &PatternScene,
    style: Option<S>,
    has: Option<&StyledScene<S>>,
) {
    let wanted = style.map(|style| StyledScene {
        field: base.field.clone(),
        symmetry: base.symmetry,
        turn: base.turn,
        space: base.space,
        pose: base.pose,
        waves: base.waves,
        frequency: base.frequency.clone(),
        style,
    });
    match wanted {
        Some(wanted) if has != Some(&wanted) => {
            entity.insert(wanted);
        }
        None if has.is_some() => {
            entity.remove::<StyledScene<S>>();
        }
        _ => {}
    }
}

impl FieldFile {
    fn field(&mut self, field: &Field, vertices: Option<usize>) -> Result<DirectionField, String> {
        let Field::File(path) = field else {
            self.0 = None;
            return field.direction(vertices);
        };
        match &self.0 {
            Some((known, count, found)) if known == path && *count == vertices => found.clone(),
            _ => {
                let found = field.direction(vertices);
                self.0 = Some((path.clone(), vertices, found.clone()));
                found
            }
        }
    }
}

/// Gives every patterned mesh its height as a scalar, 0 at its lowest vertex and 1 at its highest. Of a tensor, whose
/// eigenvalues are the scalars, it is taken away.
fn set_scalars(
    settings: Res<ViewerSettings>,
    parts: Query<(Entity, &Mesh3d, Has<PatternScalars>), With<PatternState>>,
    meshes: Res<Assets<Mesh>>,
    mut commands: Commands,
) {
    for (entity, mesh, has_scalars) in &parts {
        let wants_scalars = settings.field != Field::Tensor;
        if has_scalars && !wants_scalars {
            commands.entity(entity).remove::<PatternScalars>();
        } else if !has_scalars
            && wants_scalars
            && let Some(heights) = meshes.get(&mesh.0).and_then(heights)
        {
            commands.entity(entity).insert(PatternScalars {
                first: ScalarSource::Vertices(heights),
                ..default()
            });
        }
    }
}

fn heights(mesh: &Mesh) -> Option<Arc<[f32]>> {
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION)?.as_float3()?;
    let heights = || positions.iter().map(|[_, y, _]| *y);
    let lowest = heights().fold(f32::MAX, f32::min);
    let reach = heights().fold(f32::MIN, f32::max) - lowest;
    let height = |y: f32| (y - lowest) / reach.max(f32::MIN_POSITIVE);
    Some(heights().map(height).collect())
}

/// Gives the settings' colour to the material of a model whose file has none.
fn set_gaps(settings: Res<ViewerSettings>, models: Query<Ref<Model>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    for model in &models {
        let Some(handle) = model.material.as_ref() else {
            continue;
        };
        let color = srgb(settings.gap_color);
        let differs = |material: &StandardMaterial| material.base_color != color;
        if (settings.is_changed() || model.is_added())
            && materials.get(handle).is_some_and(differs)
            && let Some(mut material) = materials.get_mut(handle)
        {
            material.base_color = color;
        }
    }
}

/// For pictures: the pattern is on the model, or will never be.
fn model_is_dressed(world: &mut World) -> Result<Option<String>, String> {
    if let Some(error) = &world.resource::<Notice>().0 {
        return Err(error.clone());
    }
    let is_plain = world.resource::<ViewerSettings>().style == Style::Plain;
    let mut patterns = world.query::<&PatternState>();
    let is_dressed = is_plain || patterns.iter(world).next().is_some();
    Ok((!is_dressed).then(|| "the model".to_owned()))
}
