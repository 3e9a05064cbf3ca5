//! The life of a pattern in the main world: from the components of an entity to the work of a frame.
//!
//! In: surfaces, fields and frequencies of all entities, and what changed in them. Out: a [`Frame`] for the GPU. A
//! pattern starts cold, follows changes warm, comes to rest, and then costs nothing.

use super::{
    arena::{PatternArena, Pool},
    layout::{FLAG_AXIS, FLAG_FOLLOW, FLAG_READY, FLAG_VECTOR, LevelRecord, PatternRecord},
    pack::{PackedGraph, PatternRanges, geometry},
    plan::{Frame, Member, Work, plan},
    render::GpuStatus,
    settings::{ColdStart, ValidSettings},
    state::{NeedsVector, PatternFailed, PatternReady, PatternState, RestartPattern},
};
use crate::{
    arena::Pool as _,
    diagnostics::QualityReport,
    error::PatternError,
    field::{DirectionField, FieldTurn, Frequency, PatternSpace, Symmetry, directions, frequencies, project_tangent},
    surface::{PatternMesh, Surface, SurfaceCache, SurfaceGraph, SurfaceState},
};
use bevy::{
    ecs::{lifecycle::HookContext, query::QueryData, system::SystemParam, world::DeferredWorld},
    math::Mat3A,
    mesh::MeshTag,
    platform::collections::HashMap,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};
use std::{mem::discriminant, sync::Arc};

/// The work that the render world has not taken yet.
#[derive(Resource, Default)]
pub(crate) struct Outbox(pub(crate) Frame);

/// Graphs in the shared buffers, by mesh.
#[derive(Resource, Default)]
pub(crate) struct PackedGraphs {
    by_mesh: HashMap<AssetId<Mesh>, Packed>,
    /// Graphs that are no mesh's any more, but perhaps still some pattern's.
    retired: Vec<Arc<PackedGraph>>,
}

impl PackedGraphs {
    fn retire(&mut self, mesh: AssetId<Mesh>) {
        self.retired
            .extend(self.by_mesh.remove(&mesh).map(|packed| packed.graph));
    }

    /// Frees the graphs that no pattern uses.
    fn free_unused(&mut self, arena: &mut PatternArena) {
        self.retired.extend(
            self.by_mesh
                .extract_if(|_, packed| Arc::strong_count(&packed.graph) == 1)
                .map(|(_, packed)| packed.graph),
        );
        self.retired.retain(|graph| {
            let used = Arc::strong_count(graph) > 1;
            if !used {
                graph.free(arena);
            }
            used
        });
    }
}

struct Packed {
    graph: Arc<PackedGraph>,
    topology: u32,
    geometry: u32,
}

/// An entity's pattern in the shared buffers; there while it has one.
#[derive(Component)]
#[component(on_discard = release)]
pub struct Pattern {
    ranges: PatternRanges,
    record: PatternRecord,
    levels: Vec<LevelRecord>,
    graph: Arc<PackedGraph>,
    topology: u32,
    geometry: u32,
    inputs: Inputs,
    /// Directions as last uploaded; empty where the GPU makes them.
    directions: Vec<Vec3>,
    /// Directions were uploaded, and the GPU has not taken them yet.
    uploaded: bool,
    task: Option<Task<Result<Directions, PatternError>>>,
    /// The inputs have changed since the task began.
    outdated: bool,
    phase: Phase,
}

/// Directions, and what they mean.
struct Directions {
    vectors: Vec<Vec3>,
    symmetry: Symmetry,
}

/// Small inputs, compared from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Inputs {
    symmetry: Symmetry,
    turn: f32,
    /// The entity's linear part, where the pattern lives in the world.
    linear: Option<Mat3A>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    /// Directions are not there yet.
    Waiting,
    /// Must be solved from nothing.
    Cold,
    /// Follows, for so many frames after the last change.
    Warm(u32),
    /// Sleeps.
    Asleep,
}

impl Pattern {
    /// Where the pattern lies in the shared buffers, as uploaded last: for reading phasors back, or for an own pass.
    pub fn record(&self) -> &PatternRecord {
        &self.record
    }

    fn member(&self) -> Member {
        Member {
            record: self.ranges.record,
            graph: self.graph.clone(),
        }
    }

    /// That of the directions in use, which is not the entity's while new ones are being computed.
    fn symmetry(&self) -> Symmetry {
        if self.record.flags & FLAG_VECTOR != 0 {
            Symmetry::Vector
        } else {
            Symmetry::Line
        }
    }

    /// Other directions come into use. They follow those before where phasors refer to these.
    fn begin_directions(&mut self, symmetry: Symmetry) {
        if symmetry != self.symmetry() && self.phase != Phase::Waiting {
            // The phasors of lines and of vectors mean different things.
            self.phase = Phase::Cold;
        }
        self.record.flags &= !(FLAG_VECTOR | FLAG_AXIS | FLAG_FOLLOW);
        if symmetry == Symmetry::Vector {
            self.record.flags |= FLAG_VECTOR;
        }
        if matches!(self.phase, Phase::Warm(_) | Phase::Asleep) {
            self.record.flags |= FLAG_FOLLOW;
        }
    }

    /// The GPU brings directions and edge constants up to date.
    fn push_inputs(&mut self, work: &mut Work) {
        if self.record.flags & FLAG_AXIS != 0 {
            work.axis.push(self.member());
        } else if std::mem::take(&mut self.uploaded) {
            work.given.push(self.member());
        }
        work.changed.push(self.member());
    }

    fn is_drawn(&self) -> bool {
        self.record.flags & FLAG_READY != 0
    }

    fn write_record(&self, arena: &mut PatternArena) {
        arena.write(Pool::Surface, self.ranges.record, &[self.record]);
    }
}

fn release(mut world: DeferredWorld, context: HookContext) {
    let Some(mut pattern) = world.get_mut::<Pattern>(context.entity) else {
        return;
    };
    let mut ranges = std::mem::take(&mut pattern.ranges);
    if let Some(mut arena) = world.get_resource_mut::<PatternArena>() {
        ranges.free(&mut arena);
    }
}

/// All that a pattern depends on.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Patterned {
    entity: Entity,
    mesh: Ref<'static, Mesh3d>,
    field: Ref<'static, DirectionField>,
    frequency: Ref<'static, Frequency>,
    symmetry: Option<Ref<'static, Symmetry>>,
    turn: Option<Ref<'static, FieldTurn>>,
    space: Option<Ref<'static, PatternSpace>>,
    transform: Option<&'static GlobalTransform>,
    tag: Option<&'static MeshTag>,
    needs_vector: Option<&'static NeedsVector>,
    meshes: Option<&'static PatternMesh>,
    pattern: Option<&'static mut Pattern>,
    state: &'static mut PatternState,
}

/// What updating a pattern needs of the world.
#[derive(SystemParam)]
pub(crate) struct Tools<'w, 's> {
    commands: Commands<'w, 's>,
    arena: ResMut<'w, PatternArena>,
    cache: ResMut<'w, SurfaceCache>,
    packed: ResMut<'w, PackedGraphs>,
    graphs: Res<'w, Assets<SurfaceGraph>>,
    meshes: Res<'w, Assets<Mesh>>,
    settings: Res<'w, ValidSettings>,
}

/// Brings every pattern up to date and collects the work of the frame.
pub(crate) fn update_patterns(
    mut patterns: Query<Patterned>,
    mut tools: Tools,
    mut outbox: ResMut<Outbox>,
    status: Res<GpuStatus>,
    report: Res<QualityReport>,
    mut generation: Local<u32>,
    mut cold_start: Local<Option<ColdStart>>,
) {
    forget_unused(&mut tools);
    let device = status.generation();
    let lost = *generation != device && *generation != 0;
    *generation = device;
    // Another way to start asks for another memory layout as well.
    let restart = cold_start
        .as_ref()
        .is_some_and(|last| discriminant(last) != discriminant(&tools.settings.cold_start));
    *cold_start = Some(tools.settings.cold_start.clone());
    if lost {
        let PackedGraphs { by_mesh, retired } = &mut *tools.packed;
        retired.extend(by_mesh.drain().map(|(_, packed)| packed.graph));
    }
    let mut work = Work::default();
    let mut ready = Vec::new();
    for mut item in &mut patterns {
        if let Some(error) = status.error() {
            fail(&mut item, &mut tools, error);
            continue;
        }
        let fresh = lost || restart;
        match update_pattern(&mut item, &mut tools, fresh) {
            Ok(changed) => schedule(&mut item, changed, &status, &mut work, &mut tools, &mut ready),
            Err(error) => fail(&mut item, &mut tools, error),
        }
    }
    if status.is_ready() {
        if status.reports() && report.0 && !work.is_empty() {
            let drawn = patterns
                .iter()
                .filter_map(|item| item.pattern.filter(|pattern| pattern.is_drawn()));
            work.reported = drawn.map(Pattern::member).collect();
        }
        plan(&work, &tools.settings, status.item(), &mut outbox.0);
    }
    outbox.0.generation = device;
    outbox.0.uploads.extend(tools.arena.take_uploads());
    outbox.0.capacities = Pool::ALL.iter().map(|&pool| tools.arena.capacity(pool)).collect();
    for entity in ready {
        tools.commands.trigger(PatternReady { entity });
    }
}

/// Asks for the graphs of meshes that are new to their entities, in the frame in which their data are still there.
pub(crate) fn request_surfaces(
    changed: Query<
        (&Mesh3d, Option<&PatternMesh>),
        (
            With<DirectionField>,
            Or<(bevy::prelude::Changed<Mesh3d>, Added<DirectionField>)>,
        ),
    >,
    mut cache: ResMut<SurfaceCache>,
) {
    for (mesh, meshes) in &changed {
        if meshes.is_none_or(|meshes| meshes.drawn != mesh.0) {
            cache.request(mesh.id());
        }
    }
}

/// Makes graphs only, for an app that renders nothing.
pub(crate) fn update_graphs(
    mut patterns: Query<(Entity, &Mesh3d, Option<&PatternMesh>, &mut PatternState), With<DirectionField>>,
    mut cache: ResMut<SurfaceCache>,
    mut commands: Commands,
) {
    cache.take_removed();
    for (entity, mesh, meshes, mut state) in &mut patterns {
        let next = match cache.request(mesh.id()) {
            SurfaceState::Preparing => PatternState::Preparing,
            SurfaceState::Failed(error) => PatternState::Failed(error),
            SurfaceState::Ready(surface) => {
                let ready = PatternMesh {
                    source: mesh.0.clone(),
                    drawn: surface.drawn,
                    graph: surface.graph,
                };
                if meshes != Some(&ready) {
                    commands.entity(entity).try_insert(ready);
                }
                PatternState::NoGpu
            }
        };
        if let PatternState::Failed(error) = &next
            && *state != next
        {
            error!("no pattern on {entity}: {error}");
            commands.trigger(PatternFailed {
                entity,
                error: error.clone(),
            });
        }
        state.set_if_neq(next);
    }
}

/// Whether the app has a GPU to solve on.
pub(crate) fn renders(status: Res<GpuStatus>) -> bool {
    !status.is_absent()
}

/// Gives back the memory of graphs whose meshes are gone.
fn forget_unused(tools: &mut Tools) {
    for mesh in tools.cache.take_removed() {
        tools.packed.retire(mesh);
    }
    tools.packed.free_unused(&mut tools.arena);
}

/// What changed for a pattern in this frame.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Changed {
    /// Something it needs is not there yet.
    Waiting,
    /// Directions, frequencies or positions, written to the GPU.
    Inputs,
    /// Nothing.
    Nothing,
}

fn update_pattern(item: &mut PatternedItem, tools: &mut Tools, fresh: bool) -> Result<Changed, PatternError> {
    let symmetry = item
        .symmetry
        .as_ref()
        .map_or_else(|| item.field.default_symmetry(), |symmetry| **symmetry);
    if let (Some(style), Symmetry::Line) = (item.needs_vector, symmetry) {
        return Err(PatternError::NeedsVectorSymmetry(style.0));
    }
    // What a style refused starts anew once the style or the field allows it.
    let refused = matches!(&*item.state, PatternState::Failed(PatternError::NeedsVectorSymmetry(_)));
    let fresh = fresh || refused;
    let touched = item.mesh.is_changed()
        || item.field.is_changed()
        || item.frequency.is_changed()
        || item.symmetry.as_ref().is_some_and(|symmetry| symmetry.is_changed())
        || item.turn.as_ref().is_some_and(|turn| turn.is_changed())
        || item.space.as_ref().is_some_and(|space| space.is_changed())
        || matches!(&*item.state, PatternState::Failed(PatternError::MeshTagTaken));
    let own_mesh = item.meshes.is_some_and(|meshes| meshes.drawn == item.mesh.0);
    if !own_mesh && let Some(pattern) = item.pattern.as_mut() {
        // The pattern belongs to the mesh that was there before.
        pattern.phase = Phase::Waiting;
        if pattern.is_drawn() {
            pattern.record.flags &= !FLAG_READY;
            pattern.write_record(&mut tools.arena);
        }
    }
    let source = match item.meshes {
        Some(meshes) if own_mesh => meshes.source.clone(),
        _ => item.mesh.0.clone(),
    };
    let surface = match tools.cache.request(source.id()) {
        SurfaceState::Ready(surface) => surface,
        SurfaceState::Preparing => return Ok(Changed::Waiting),
        SurfaceState::Failed(error) => {
            if own_mesh {
                // What is drawn must be the user's mesh, not a copy of what it was.
                tools.commands.entity(item.entity).try_insert(Mesh3d(source));
            }
            return Err(error);
        }
    };
    if let PatternState::Failed(error) = &*item.state
        && !touched
        && !fresh
        && item
            .pattern
            .as_ref()
            .is_none_or(|pattern| pattern.geometry == surface.geometry)
    {
        return Err(error.clone());
    }
    let graph = pack(&surface, source.id(), tools)?;
    let in_world = item.space.as_ref().is_some_and(|space| **space == PatternSpace::World);
    let linear = item
        .transform
        .filter(|_| in_world)
        .map(|transform| transform.affine().matrix3);
    let inputs = Inputs {
        symmetry,
        turn: item.turn.as_ref().map_or(0.0, |turn| turn.0),
        linear,
    };
    let current = item.pattern.as_ref().is_some_and(|pattern| {
        pattern.topology == surface.topology && pattern.inputs.linear.is_some() == linear.is_some()
    });
    if !current || fresh || !own_mesh {
        // The tag of a cloned pattern is nobody's.
        let cloned = item.meshes.is_some() && item.pattern.is_none();
        let taken = item.tag.is_some_and(|tag| {
            tag.0 != 0
                && !cloned
                && item
                    .pattern
                    .as_ref()
                    .is_none_or(|pattern| pattern.ranges.record != tag.0)
        });
        if taken {
            return Err(PatternError::MeshTagTaken);
        }
        let mut pattern = Pattern::new(graph, &surface, inputs, tools)?;
        // Bad input leaves a pattern that waits for a better one.
        let updated = update_inputs(&mut pattern, item, &surface, inputs, source.id(), tools, true);
        let tag = pattern.ranges.record;
        let meshes = PatternMesh {
            source: source.clone(),
            drawn: surface.drawn.clone(),
            graph: surface.graph.clone(),
        };
        if let Some(old) = item.pattern.as_mut() {
            old.phase = Phase::Waiting;
            old.record.flags &= !FLAG_READY;
        }
        let (entity, drawn) = (item.entity, Mesh3d(surface.drawn.clone()));
        tools.commands.queue(move |world: &mut World| {
            match world.get_entity_mut(entity) {
                // Insertion replaces the old pattern, whose hook gives back its ranges.
                Ok(mut entity) if entity.contains::<DirectionField>() => {
                    entity.insert((pattern, MeshTag(tag), drawn, meshes));
                }
                _ => pattern.ranges.free(&mut world.resource_mut::<PatternArena>()),
            }
        });
        updated?;
        item.state.set_if_neq(PatternState::Preparing);
        return Ok(Changed::Waiting);
    }
    let Some(mut pattern) = item.pattern.take() else {
        return Ok(Changed::Waiting);
    };
    let changed = update_inputs(&mut pattern, item, &surface, inputs, source.id(), tools, false);
    item.pattern = Some(pattern);
    changed
}

/// The graph in the shared buffers, written when it is new or its positions have changed.
fn pack(surface: &Surface, mesh: AssetId<Mesh>, tools: &mut Tools) -> Result<Arc<PackedGraph>, PatternError> {
    let Some(graph) = tools.graphs.get(&surface.graph) else {
        return Err(PatternError::MeshDataTaken);
    };
    match tools.packed.by_mesh.get_mut(&mesh) {
        Some(packed) if packed.topology == surface.topology => {
            if packed.geometry != surface.geometry {
                packed.geometry = surface.geometry;
                packed.graph.write_geometry(graph, &mut tools.arena);
            }
            Ok(packed.graph.clone())
        }
        _ => {
            tools.packed.retire(mesh);
            let packed = Arc::new(PackedGraph::new(graph, &mut tools.arena)?);
            let entry = Packed {
                graph: packed.clone(),
                topology: surface.topology,
                geometry: surface.geometry,
            };
            tools.packed.by_mesh.insert(mesh, entry);
            Ok(packed)
        }
    }
}

impl Pattern {
    fn new(
        graph: Arc<PackedGraph>,
        surface: &Surface,
        inputs: Inputs,
        tools: &mut Tools,
    ) -> Result<Self, PatternError> {
        let local = matches!(tools.settings.cold_start, ColdStart::Local(_));
        let (ranges, record, levels) = PatternRanges::new(&graph, &mut tools.arena, inputs.linear.is_some(), local)?;
        let pattern = Self {
            ranges,
            record,
            levels,
            graph,
            topology: surface.topology,
            geometry: surface.geometry,
            inputs,
            directions: Vec::new(),
            uploaded: false,
            task: None,
            outdated: false,
            phase: Phase::Waiting,
        };
        pattern.write_record(&mut tools.arena);
        let levels = pattern.ranges.record + super::pack::RECORD_WORDS;
        tools.arena.write(Pool::Surface, levels, &pattern.levels);
        Ok(pattern)
    }
}

/// Computes and uploads whatever has changed of directions, frequencies and positions.
fn update_inputs(
    pattern: &mut Pattern,
    item: &PatternedItem,
    surface: &Surface,
    inputs: Inputs,
    mesh: AssetId<Mesh>,
    tools: &mut Tools,
    fresh: bool,
) -> Result<Changed, PatternError> {
    let moved = fresh || pattern.geometry != surface.geometry || pattern.inputs.linear != inputs.linear;
    let turned = moved || item.field.is_changed() || pattern.inputs != inputs;
    let uniform = match (&*item.field, &*item.frequency) {
        (DirectionField::Axis(axis), Frequency::Uniform(f)) => Some((*axis, *f)),
        _ => None,
    };
    pattern.geometry = surface.geometry;
    pattern.inputs = inputs;
    let waits = pattern.phase == Phase::Waiting;
    if !turned && !item.frequency.is_changed() && pattern.task.is_none() && !waits {
        return Ok(Changed::Nothing);
    }
    let Some(graph) = tools.graphs.get(&surface.graph) else {
        return Ok(Changed::Waiting);
    };
    if moved && let (Some(linear), Some(first)) = (inputs.linear, pattern.ranges.geometry) {
        tools
            .arena
            .write(Pool::Geometry, first, &geometry(&in_world(graph, linear)));
    }
    if let Some((axis, frequency)) = uniform {
        check_uniform(axis, frequency, inputs.turn)?;
        pattern.task = None;
        pattern.directions.clear();
        pattern.uploaded = false;
        pattern.begin_directions(inputs.symmetry);
        pattern.record.flags |= FLAG_AXIS;
        pattern.record.axis = axis.to_array();
        pattern.record.frequency = frequency;
        pattern.record.turn = inputs.turn;
        pattern.write_record(&mut tools.arena);
        if pattern.phase == Phase::Waiting {
            pattern.phase = Phase::Cold;
        }
        return Ok(Changed::Inputs);
    }
    let slow = matches!(*item.field, DirectionField::PrincipalCurvature { .. });
    let mut new = None;
    if turned || pattern.directions.is_empty() {
        let source = tools.meshes.get(mesh).ok_or(PatternError::MeshDataTaken)?;
        if slow {
            // A computation that has begun is finished, so that a field that changes in every frame is seen to.
            pattern.outdated |= pattern.task.is_some() && turned;
            let start = || compute_directions(DirectionField::clone(&item.field), inputs, graph.clone());
            pattern.task.get_or_insert_with(start);
        } else {
            pattern.task = None;
            new = Some(Directions {
                vectors: directions_in(&item.field, inputs, graph, source)?,
                symmetry: inputs.symmetry,
            });
        }
    }
    if let Some(task) = &mut pattern.task {
        let Some(done) = block_on(poll_once(task)) else {
            return Ok(Changed::Waiting);
        };
        let start = || compute_directions(DirectionField::clone(&item.field), inputs, graph.clone());
        pattern.task = std::mem::take(&mut pattern.outdated).then(start);
        new = Some(done?);
    }
    match new {
        Some(new) => {
            pattern.begin_directions(new.symmetry);
            pattern.directions = new.vectors;
        }
        None => pattern.begin_directions(pattern.symmetry()),
    }
    pattern.write_record(&mut tools.arena);
    let source = tools.meshes.get(mesh).ok_or(PatternError::MeshDataTaken)?;
    let frequencies = frequencies(&item.frequency, graph, source)?;
    let field: Vec<Vec4> = pattern
        .directions
        .iter()
        .zip(&frequencies)
        .map(|(d, &f)| d.extend(f))
        .collect();
    tools.arena.write(Pool::Edges, pattern.ranges.edges, &field);
    pattern.uploaded = true;
    if pattern.phase == Phase::Waiting {
        pattern.phase = Phase::Cold;
    }
    Ok(Changed::Inputs)
}

/// Computes directions off the main thread.
fn compute_directions(
    field: DirectionField,
    inputs: Inputs,
    graph: SurfaceGraph,
) -> Task<Result<Directions, PatternError>> {
    AsyncComputeTaskPool::get().spawn(async move {
        let empty = Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default());
        Ok(Directions {
            vectors: directions_in(&field, inputs, &graph, &empty)?,
            symmetry: inputs.symmetry,
        })
    })
}

fn check_uniform(axis: Dir3, frequency: f32, turn: f32) -> Result<(), PatternError> {
    if !axis.is_finite() || !turn.is_finite() {
        Err(PatternError::NotFinite {
            what: "direction of vertex",
            index: 0,
        })
    } else if !frequency.is_finite() {
        Err(PatternError::NotFinite {
            what: "frequency of vertex",
            index: 0,
        })
    } else if frequency < 0.0 {
        Err(PatternError::NegativeFrequency(frequency))
    } else {
        Ok(())
    }
}

/// A graph with positions and normals carried into the world by the linear part of a transform.
fn in_world(graph: &SurfaceGraph, linear: Mat3A) -> SurfaceGraph {
    let normal = linear.inverse().transpose();
    let mut world = graph.clone();
    world.positions.iter_mut().for_each(|p| *p = linear * *p);
    world
        .normals
        .iter_mut()
        .for_each(|n| *n = (normal * *n).normalize_or(*n));
    world
}

/// The directions of a field in the space of the pattern.
fn directions_in(
    field: &DirectionField,
    inputs: Inputs,
    graph: &SurfaceGraph,
    mesh: &Mesh,
) -> Result<Vec<Vec3>, PatternError> {
    let Some(linear) = inputs.linear else {
        return directions(field, inputs.symmetry, inputs.turn, graph, mesh);
    };
    let world = in_world(graph, linear);
    match field {
        // These are vectors of the mesh, which are carried along; the others are made from the world's positions.
        DirectionField::Attribute(_) | DirectionField::Vertices(_) | DirectionField::Tangents(_) => {
            let mut d = directions(field, inputs.symmetry, inputs.turn, graph, mesh)?;
            d.iter_mut()
                .zip(&world.normals)
                .for_each(|(d, &n)| *d = project_tangent(linear * *d, n));
            Ok(d)
        }
        _ => directions(field, inputs.symmetry, inputs.turn, &world, mesh),
    }
}

/// Frames of soft sweeps after the last change, before a pattern comes to rest.
const FRAMES_TO_REST: u32 = 10;

/// Decides what a pattern takes part in.
fn schedule(
    item: &mut PatternedItem,
    changed: Changed,
    status: &GpuStatus,
    work: &mut Work,
    tools: &mut Tools,
    ready: &mut Vec<Entity>,
) {
    let Some(pattern) = item.pattern.as_mut() else {
        item.state.set_if_neq(PatternState::Preparing);
        return;
    };
    if !status.is_ready() || pattern.phase == Phase::Waiting {
        if !pattern.is_drawn() {
            item.state.set_if_neq(PatternState::Preparing);
        }
        if changed == Changed::Inputs && pattern.phase != Phase::Waiting {
            pattern.phase = Phase::Cold;
        }
        return;
    }
    if pattern.task.is_some() && pattern.phase == Phase::Asleep {
        // The old field is drawn until the new one is computed.
        item.state.set_if_neq(PatternState::Solving);
    }
    let member = pattern.member();
    if pattern.phase == Phase::Cold {
        pattern.push_inputs(work);
        work.cold.push(member);
        if !pattern.is_drawn() {
            ready.push(item.entity);
        }
        pattern.record.flags = (pattern.record.flags | FLAG_READY) & !FLAG_FOLLOW;
        pattern.write_record(&mut tools.arena);
        pattern.phase = Phase::Asleep;
        item.state.set_if_neq(PatternState::Converged);
    } else if changed == Changed::Inputs {
        pattern.push_inputs(work);
        work.warm.push(member);
        pattern.phase = Phase::Warm(FRAMES_TO_REST);
        item.state.set_if_neq(PatternState::Solving);
    } else if let Phase::Warm(frames) = pattern.phase {
        if frames > 0 {
            work.warm.push(member);
            pattern.phase = Phase::Warm(frames - 1);
        } else {
            work.settling.push(member);
            pattern.phase = Phase::Asleep;
            item.state.set_if_neq(PatternState::Converged);
        }
    }
}

/// Says once why a pattern cannot be drawn, and draws the base material.
fn fail(item: &mut PatternedItem, tools: &mut Tools, error: PatternError) {
    let failed = PatternState::Failed(error.clone());
    if *item.state == failed {
        return;
    }
    *item.state = failed;
    error!("no pattern on {}: {error}", item.entity);
    if let Some(pattern) = item.pattern.as_mut() {
        pattern.record.flags &= !FLAG_READY;
        pattern.phase = Phase::Waiting;
        pattern.write_record(&mut tools.arena);
    }
    tools.commands.trigger(PatternFailed {
        entity: item.entity,
        error,
    });
}

/// Solves a pattern from nothing.
pub(crate) fn restart(event: On<RestartPattern>, mut patterns: Query<&mut Pattern>) {
    if let Ok(mut pattern) = patterns.get_mut(event.entity)
        && pattern.phase != Phase::Waiting
    {
        pattern.phase = Phase::Cold;
    }
}

/// An entity without a field has its own mesh and no pattern.
pub(crate) fn remove_pattern(
    event: On<Remove, DirectionField>,
    patterns: Query<(Option<&PatternMesh>, Has<Pattern>)>,
    mut commands: Commands,
) {
    let (Ok((meshes, has_pattern)), Ok(mut entity)) = (patterns.get(event.entity), commands.get_entity(event.entity))
    else {
        return;
    };
    entity.try_remove::<PatternState>();
    if has_pattern {
        entity.try_remove::<(Pattern, MeshTag)>();
    }
    if let Some(meshes) = meshes {
        entity.try_insert(Mesh3d(meshes.source.clone()));
        entity.try_remove::<PatternMesh>();
    }
}
