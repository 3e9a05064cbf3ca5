//! Patterns on whole scenes, such as glTF files.
//!
//! In: a [`PatternScene`] on the root of a hierarchy, and the meshes below it with their `StandardMaterial`s, which may
//! arrive, leave and change at any time. Out: on each of these meshes a field, a frequency, and a [`StripeMaterial`](crate::material::StripeMaterial) (or one
//! of another style: [`StyledScene`]) that extends the material it had. What is done is undone when the component, or the mesh, is taken away; what a mesh has of
//! its own is left alone.

use crate::{
    field::{DirectionField, FieldTurn, Frequency, PatternSpace, Symmetry},
    material::{FocusSource, Hatch, PatternTexture, SceneStyle, Stripes, Styled, Tensor},
    wave::{PatternSystems, Waves, pose::PatternPose},
};
use bevy::{
    asset::AssetEventSystems,
    ecs::{
        entity::EntityHashSet,
        query::QueryData,
        system::{EntityCommands, SystemParam},
    },
    platform::collections::HashMap,
    prelude::*,
};
use std::marker::PhantomData;

/// Gives every mesh at or below this entity a pattern and stripes over its own `StandardMaterial`.
///
/// ```
/// # use bevy::{prelude::*, world_serialization::WorldAssetRoot};
/// # use bevy_field_patterns::prelude::*;
/// fn setup(mut commands: Commands, server: Res<AssetServer>) {
///     commands.spawn((
///         WorldAssetRoot(server.load("models/vase.glb#Scene0")),
///         PatternScene { frequency: Frequency::Uniform(40.0), ..default() },
///     ));
/// }
/// ```
///
/// Meshes that share a material go on sharing one. Of nested `PatternScene`s the nearest counts. Removing the component
/// gives the meshes back what they had. A change of the style alone solves nothing again.
///
/// A mesh that has a [`DirectionField`], [`Frequency`], [`Symmetry`], [`FieldTurn`], [`PatternSpace`], [`PatternPose`] or [`Waves`] of
/// its own keeps it, now and afterwards; the scene fills in the others. (A field of its own comes with a frequency, the default one if there
/// is no other.)
///
/// Fields that a file brings along are vertex attributes whose names begin with an underscore. Bevy's loader has to know
/// them, by their names without it:
///
/// ```ignore
/// /// Three floats per vertex, called `_FIELD` in the file; any number will do as id.
/// const FIELD: MeshVertexAttribute = MeshVertexAttribute::new("Field", 0x5f_f1e1d, VertexFormat::Float32x3);
///
/// app.add_plugins(DefaultPlugins.set(GltfPlugin::default().add_custom_vertex_attribute("FIELD", FIELD)));
/// // …
/// PatternScene { field: DirectionField::Attribute(FIELD), ..default() }
/// ```
///
/// Bevy spawns a scene by reflection: without its feature `reflect_auto_register`, a program registers the types of the
/// scene's components itself (`app.register_type::<Mesh3d>()`, and so on).
pub type PatternScene = StyledScene<Stripes>;

/// A [`PatternScene`] of any style: [`Stripes`], [`PatternTexture`], [`Hatch`] or [`Tensor`].
///
/// A mesh can have one material: give a hierarchy scenes of one style.
#[derive(Component, Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Component, Default, Debug, Clone, PartialEq)]
pub struct StyledScene<S: SceneStyle> {
    /// What the patterns follow. Default: the major principal curvature.
    pub field: DirectionField,
    /// Whether d and -d are the same. Default `None`: [`DirectionField::default_symmetry`].
    pub symmetry: Option<Symmetry>,
    /// Turns the field in the tangent plane, in radians, finite. Default 0.
    pub turn: f32,
    /// The space of field and frequency. Default [`PatternSpace::Mesh`]; in [`PatternSpace::World`], meshes of different
    /// scale get stripes of one width.
    pub space: PatternSpace,
    /// Whether the patterns keep their spacing while skins and morph targets deform the meshes. Default
    /// [`PatternPose::Rest`]: they do not.
    pub pose: PatternPose,
    /// How many waves the patterns have. Default: one, which textures do not take.
    pub waves: Waves,
    /// Stripes per unit length of `space`, 0 or more. Default 10.
    pub frequency: Frequency,
    /// The look of all patterns.
    pub style: S,
}

/// A mesh that a [`PatternScene`] has given a pattern. Set by the plugin.
pub type PatternScenePart = StyledScenePart<Stripes>;

/// A mesh that a [`StyledScene`] has given a pattern. Set by the plugin.
///
/// To give the mesh another base, insert another `MeshMaterial3d<StandardMaterial>`.
#[derive(Component, Reflect, Debug, Clone, PartialEq)]
#[reflect(Component, Debug, Clone, PartialEq)]
pub struct StyledScenePart<S: SceneStyle> {
    /// The entity with the [`StyledScene`].
    pub scene: Entity,
    /// The material that the pattern lies over. Changes of it are followed.
    pub base: Handle<StandardMaterial>,
    given: Given,
    #[reflect(ignore)]
    style: PhantomData<S>,
}

/// What a mesh has got from its scene. A component with another value is the user's.
#[derive(Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Debug, Clone, PartialEq, Default)]
struct Given {
    field: Option<DirectionField>,
    frequency: Option<Frequency>,
    symmetry: Option<Symmetry>,
    turn: Option<FieldTurn>,
    space: Option<PatternSpace>,
    pose: Option<PatternPose>,
    waves: Option<Waves>,
}

/// Keeps the meshes of [`PatternScene`]s as these say, in `PostUpdate`, before patterns are updated.
#[derive(Debug, Default, Clone, Copy)]
pub struct PatternScenePlugin;

impl Plugin for PatternScenePlugin {
    fn build(&self, app: &mut App) {
        add_style::<Stripes>(app);
        add_style::<PatternTexture>(app);
        add_style::<Hatch>(app);
        add_style::<Tensor>(app);
    }
}

#[derive(SystemSet, Debug, Clone, PartialEq, Eq, Hash)]
struct SceneSystems;

fn add_style<S: SceneStyle>(app: &mut App) {
    app.init_resource::<SceneMaterials<S>>()
        .register_type::<StyledScene<S>>()
        .register_type::<StyledScenePart<S>>()
        .configure_sets(
            PostUpdate,
            SceneSystems
                .after(TransformSystems::Propagate)
                .before(PatternSystems)
                .before(AssetEventSystems)
                .run_if(resource_exists::<Assets<StandardMaterial>>),
        )
        .add_systems(
            PostUpdate,
            (carry_focus::<S>, restyle::<S>, dress_parts::<S>)
                .chain()
                .in_set(SceneSystems),
        );
}

/// The material of a scene for a base, as long as one of its meshes uses it.
#[derive(Resource)]
struct SceneMaterials<S: SceneStyle>(HashMap<(Entity, AssetId<StandardMaterial>), AssetId<Styled<S>>>);

impl<S: SceneStyle> Default for SceneMaterials<S> {
    fn default() -> Self {
        Self(HashMap::default())
    }
}

/// Writes the region of a focus that an entity carries along into the styles of its scenes, where it differs.
fn carry_focus<S: SceneStyle>(
    sources: Query<(&FocusSource<S>, &GlobalTransform)>,
    mut scenes: Query<&mut StyledScene<S>>,
) {
    for (source, transform) in &sources {
        let shape = source.shape.transformed(&transform.affine());
        let mut scenes = scenes.iter_many_mut(&source.scenes);
        while let Some(mut scene) = scenes.fetch_next() {
            if scene.style.focus().shape != shape {
                scene.style.focus_mut().shape = shape;
            }
        }
    }
}

/// Brings materials up to date with the style of their scene and with their base.
fn restyle<S: SceneStyle>(
    scenes: Query<Ref<StyledScene<S>>>,
    mut changes: MessageReader<AssetEvent<StandardMaterial>>,
    bases: Option<Res<Assets<StandardMaterial>>>,
    styled: Option<ResMut<Assets<Styled<S>>>>,
    mut made: ResMut<SceneMaterials<S>>,
) {
    let (Some(bases), Some(mut styled)) = (bases, styled) else {
        return;
    };
    let modified: Vec<_> = changes
        .read()
        .filter_map(|change| match change {
            AssetEvent::Modified { id } => Some(*id),
            _ => None,
        })
        .collect();
    made.0.retain(|&(scene, base), &mut id| {
        let Ok(scene) = scenes.get(scene) else { return false };
        let Some(current) = styled.get(id) else { return false };
        let outdated = modified.contains(&base) || scene.is_changed() && current.extension != scene.style;
        if outdated
            && let Some(base) = bases.get(base)
            && let Some(mut material) = styled.get_mut(id)
        {
            material.base = base.clone();
            material.extension = scene.style.clone();
        }
        true
    });
}

/// What may be a part of a scene.
#[derive(QueryData)]
struct PartData<S: SceneStyle> {
    plain: Option<&'static MeshMaterial3d<StandardMaterial>>,
    part: Option<&'static StyledScenePart<S>>,
    given: (
        Option<&'static DirectionField>,
        Option<&'static Frequency>,
        Option<&'static Symmetry>,
        Option<&'static FieldTurn>,
        Option<&'static PatternSpace>,
        Option<&'static PatternPose>,
        Option<&'static Waves>,
    ),
}

/// Where a mesh or one of its ancestors may have come into a scene or left it.
#[derive(SystemParam)]
struct Stirred<'w, 's, S: SceneStyle> {
    changed: Query<
        'w,
        's,
        Entity,
        Or<(
            Changed<StyledScene<S>>,
            Changed<ChildOf>,
            Added<Mesh3d>,
            Changed<MeshMaterial3d<StandardMaterial>>,
        )>,
    >,
    scenes_gone: RemovedComponents<'w, 's, StyledScene<S>>,
    orphaned: RemovedComponents<'w, 's, ChildOf>,
    children: Query<'w, 's, &'static Children>,
}

impl<S: SceneStyle> Stirred<'_, '_, S> {
    /// These entities and all below them.
    fn collect(&mut self) -> EntityHashSet {
        let tops = self
            .changed
            .iter()
            .chain(self.scenes_gone.read())
            .chain(self.orphaned.read());
        tops.flat_map(|top| [top].into_iter().chain(self.children.iter_descendants(top)))
            .collect()
    }
}

/// Dresses the meshes that belong to a scene, undresses those that no longer do.
fn dress_parts<S: SceneStyle>(
    mut stirred: Stirred<S>,
    mut waiting: Local<EntityHashSet>,
    parts: Query<PartData<S>, With<Mesh3d>>,
    scenes: Query<&StyledScene<S>>,
    parents: Query<&ChildOf>,
    bases: Option<Res<Assets<StandardMaterial>>>,
    styled: Option<ResMut<Assets<Styled<S>>>>,
    mut made: ResMut<SceneMaterials<S>>,
    mut commands: Commands,
) {
    let (Some(bases), Some(mut styled)) = (bases, styled) else {
        return;
    };
    let mut entities = stirred.collect();
    entities.extend(waiting.drain());
    for entity in entities {
        let Ok(data) = parts.get(entity) else { continue };
        let Some(base) = data.plain.map(|plain| &plain.0).or(data.part.map(|part| &part.base)) else {
            continue;
        };
        let nearest = [entity]
            .into_iter()
            .chain(parents.iter_ancestors(entity))
            .find_map(|at| Some((at, scenes.get(at).ok()?)));
        let Some((root, scene)) = nearest else {
            if data.part.is_some() {
                undress(commands.entity(entity), data.plain.is_none().then_some(base), &data);
            }
            continue;
        };
        let mut entity_commands = commands.entity(entity);
        let known = data.part.is_some_and(|part| part.scene == root && part.base == *base);
        if data.plain.is_some() || !known {
            let known = made.0.get(&(root, base.id()));
            let material = match known.and_then(|&id| styled.get_strong_handle(id)) {
                Some(material) => material,
                None => {
                    let Some(base) = bases.get(base) else {
                        // It is still being loaded.
                        waiting.insert(entity);
                        continue;
                    };
                    let extension = scene.style.clone();
                    styled.add(Styled {
                        base: base.clone(),
                        extension,
                    })
                }
            };
            made.0.insert((root, base.id()), material.id());
            entity_commands
                .try_remove::<MeshMaterial3d<StandardMaterial>>()
                .try_insert(MeshMaterial3d(material));
        }
        let part = StyledScenePart {
            scene: root,
            base: base.clone(),
            given: give_pattern(&mut entity_commands, scene, &data),
            style: PhantomData,
        };
        if data.part != Some(&part) {
            entity_commands.try_insert(part);
        }
    }
}

/// Gives a mesh what it lacks of a pattern, and tells what it has from the scene now.
fn give_pattern<S: SceneStyle>(entity: &mut EntityCommands, scene: &StyledScene<S>, data: &PartDataItem<S>) -> Given {
    let old = data.part.map(|part| part.given.clone()).unwrap_or_default();
    let (field, frequency, symmetry, turn, space, pose, waves) = data.given;
    let wanted_turn = (scene.turn != 0.0).then_some(FieldTurn(scene.turn));
    let wanted_space = (scene.space != PatternSpace::default()).then_some(scene.space);
    let wanted_waves = (scene.waves != Waves::default()).then_some(scene.waves);
    let wanted_pose = (scene.pose != PatternPose::default()).then_some(scene.pose);
    Given {
        // The field comes last: it would bring a frequency along.
        frequency: give(entity, Some(scene.frequency.clone()), frequency, old.frequency),
        symmetry: give(entity, scene.symmetry, symmetry, old.symmetry),
        turn: give(entity, wanted_turn, turn, old.turn),
        space: give(entity, wanted_space, space, old.space),
        pose: give(entity, wanted_pose, pose, old.pose),
        waves: give(entity, wanted_waves, waves, old.waves),
        field: give(entity, Some(scene.field.clone()), field, old.field),
    }
}

/// Sets one component where it differs, for what is set counts as changed and is solved again. A user's own stays. What
/// the component has from the scene then.
fn give<C: Component + Clone + PartialEq>(
    entity: &mut EntityCommands,
    wanted: Option<C>,
    has: Option<&C>,
    given: Option<C>,
) -> Option<C> {
    if has.is_some() && has != given.as_ref() {
        return None;
    }
    match &wanted {
        Some(wanted) if has != Some(wanted) => {
            entity.try_insert(wanted.clone());
        }
        None if has.is_some() => {
            entity.try_remove::<C>();
        }
        _ => {}
    }
    wanted
}

/// Takes back what was given, and gives a mesh its material again, unless it has a plain one already.
fn undress<S: SceneStyle>(mut entity: EntityCommands, base: Option<&Handle<StandardMaterial>>, data: &PartDataItem<S>) {
    let given = data.part.map(|part| part.given.clone()).unwrap_or_default();
    let (field, frequency, symmetry, turn, space, pose, waves) = data.given;
    give(&mut entity, None, field, given.field);
    give(&mut entity, None, frequency, given.frequency);
    give(&mut entity, None, symmetry, given.symmetry);
    give(&mut entity, None, turn, given.turn);
    give(&mut entity, None, space, given.space);
    give(&mut entity, None, pose, given.pose);
    give(&mut entity, None, waves, given.waves);
    entity.try_remove::<(StyledScenePart<S>, MeshMaterial3d<Styled<S>>)>();
    if let Some(base) = base {
        entity.try_insert(MeshMaterial3d(base.clone()));
    }
}
