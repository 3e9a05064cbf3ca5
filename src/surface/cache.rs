//! One graph per mesh asset: built off the main thread, shared by all entities with that mesh, kept up to date.
//!
//! In: mesh assets that somebody asks for. Out: per mesh a [`SurfaceGraph`] asset and the un-indexed mesh to draw.
//! A graph is rebuilt when the mesh's indices or its vertex count change; a change of positions or attributes alone keeps
//! weld, colours and levels, and is written in place.
//!
//! Bevy tells of a changed mesh at the end of the frame, and then moves the data of a mesh that is the render world's
//! alone away. Between the two, [`start_surfaces`] reads them.

use super::{
    CloudOptions, SurfaceGraph, TriangleSoup, WeldOptions, asset::repeat_attributes, discs, insert_missing_normals,
    is_points, points, triangle_soup, unindexed,
};
use crate::error::PatternError;
use bevy::{
    asset::RenderAssetUsages,
    platform::collections::HashMap,
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};

/// How vertices are welded; applies to meshes that are seen for the first time after a change.
#[derive(Resource, Debug, Clone, Default, Deref, DerefMut)]
pub struct PatternWeld(pub WeldOptions);

/// How lists of points become surfaces; applies to meshes that are seen for the first time after a change.
#[derive(Resource, Debug, Clone, Default, Deref, DerefMut)]
pub struct PatternCloud(pub CloudOptions);

/// The surface of a mesh asset.
#[derive(Debug, Clone)]
pub struct Surface {
    /// The graph.
    pub graph: Handle<SurfaceGraph>,
    /// The mesh to draw: a triangle list without indices, in the order of the graph's triangles.
    pub drawn: Handle<Mesh>,
    /// Changes when the graph was rebuilt.
    pub topology: u32,
    /// Changes when positions or attributes were written.
    pub geometry: u32,
    /// Changes when positions were written that differ.
    pub positions: u32,
}

/// What is known of a mesh asset's surface.
#[derive(Debug, Clone)]
pub enum SurfaceState {
    /// The mesh is being loaded, or its graph is being built.
    Preparing,
    /// Ready.
    Ready(Surface),
    /// The mesh cannot carry a pattern.
    Failed(PatternError),
}

type Built = Result<(SurfaceGraph, Mesh), PatternError>;

struct Entry {
    task: Option<Task<Built>>,
    state: SurfaceState,
    /// Set while the mesh differs from what was built last.
    stale: bool,
    /// What the mesh was when it changed during a build, where its data will be gone by the end of that.
    kept: Option<Mesh>,
}

/// The surfaces of all mesh assets that carry patterns.
#[derive(Resource, Default)]
pub struct SurfaceCache {
    entries: HashMap<AssetId<Mesh>, Entry>,
    version: u32,
    removed: Vec<AssetId<Mesh>>,
}

impl SurfaceCache {
    /// The surface of a mesh; the first call starts to build it.
    pub fn request(&mut self, mesh: AssetId<Mesh>) -> SurfaceState {
        let new = || Entry {
            task: None,
            state: SurfaceState::Preparing,
            stale: true,
            kept: None,
        };
        self.entries.entry(mesh).or_insert_with(new).state.clone()
    }

    /// The mesh is not what it was. During a build, data that will be moved away are kept until the next one.
    fn mark_stale(&mut self, mesh: AssetId<Mesh>, meshes: &Assets<Mesh>) {
        let Some(entry) = self.entries.get_mut(&mesh) else {
            return;
        };
        entry.stale = true;
        let passing = |mesh: &&Mesh| mesh.asset_usage == RenderAssetUsages::RENDER_WORLD;
        entry.kept = entry
            .task
            .as_ref()
            .and_then(|_| meshes.get(mesh).filter(passing).cloned());
    }

    /// Meshes whose surfaces are gone, since the last call.
    pub(crate) fn take_removed(&mut self) -> Vec<AssetId<Mesh>> {
        std::mem::take(&mut self.removed)
    }
}

/// Notices changed and removed meshes.
pub(crate) fn watch_meshes(
    mut cache: ResMut<SurfaceCache>,
    mut events: MessageReader<AssetEvent<Mesh>>,
    meshes: Res<Assets<Mesh>>,
) {
    for event in events.read() {
        match *event {
            AssetEvent::Modified { id } => cache.mark_stale(id, &meshes),
            // Another mesh may have taken the place within the frame.
            AssetEvent::Removed { id } if meshes.contains(id) => cache.mark_stale(id, &meshes),
            AssetEvent::Removed { id } => {
                if cache.entries.remove(&id).is_some() {
                    cache.removed.push(id);
                }
            }
            // A mesh that was asked for before it was there is stale already.
            AssetEvent::Added { .. } | AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
}

/// Starts the builds of meshes that have changed, and writes changed positions in place.
pub(crate) fn start_surfaces(
    mut cache: ResMut<SurfaceCache>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut graphs: ResMut<Assets<SurfaceGraph>>,
    weld: Res<PatternWeld>,
    cloud: Res<PatternCloud>,
) {
    let SurfaceCache { entries, version, .. } = &mut *cache;
    // A build that has begun is finished, so that a mesh that changes in every frame is drawn as well.
    for (&id, entry) in entries
        .iter_mut()
        .filter(|(_, entry)| entry.stale && entry.task.is_none())
    {
        let kept = entry.kept.take();
        if kept.is_none() && !meshes.contains(id) {
            continue;
        }
        entry.stale = false;
        let written = match &mut entry.state {
            SurfaceState::Ready(surface) => {
                // What is drawn is taken out, to be written while the mesh is read.
                let mut copy = meshes.get_mut_untracked(&surface.drawn).map(take);
                let mesh = kept.as_ref().or_else(|| meshes.get(id));
                let written = match (mesh, graphs.get_mut(&surface.graph), &mut copy) {
                    (Some(mesh), Some(mut graph), Some(copy)) => written_in_place(mesh, &mut graph, copy),
                    _ => Ok(None),
                };
                if let Ok(Some(moved)) = written {
                    *version += 1;
                    surface.geometry = *version;
                    if moved {
                        surface.positions = *version;
                    }
                    // Bevy is told of it where there is news only.
                    entry.stale = copy.is_some_and(|copy| meshes.insert(&surface.drawn, copy).is_err());
                } else if let (Some(place), Some(copy)) = (meshes.get_mut_untracked(&surface.drawn), copy) {
                    *place = copy;
                }
                written
            }
            _ => Ok(None),
        };
        match written {
            Ok(Some(_)) => {}
            Ok(None) => {
                let Some(mesh) = kept.or_else(|| meshes.get(id).cloned()) else {
                    continue;
                };
                let (weld, cloud) = (weld.0, cloud.0);
                entry.task = Some(AsyncComputeTaskPool::get().spawn(async move { build(&mesh, &weld, &cloud) }));
            }
            Err(error) => entry.state = SurfaceState::Failed(error),
        }
    }
}

/// Takes over the builds that have come to their end.
pub(crate) fn finish_surfaces(
    mut cache: ResMut<SurfaceCache>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut graphs: ResMut<Assets<SurfaceGraph>>,
) {
    let SurfaceCache { entries, version, .. } = &mut *cache;
    for entry in entries.values_mut() {
        let Some(built) = entry.task.as_mut().and_then(|task| block_on(poll_once(task))) else {
            continue;
        };
        entry.task = None;
        *version += 1;
        entry.state = match built {
            Ok((graph, copy)) => SurfaceState::Ready(Surface {
                graph: graphs.add(graph),
                drawn: meshes.add(copy),
                topology: *version,
                geometry: *version,
                positions: *version,
            }),
            Err(error) => SurfaceState::Failed(error),
        };
    }
}

fn build(mesh: &Mesh, weld: &WeldOptions, cloud: &CloudOptions) -> Built {
    if is_points(mesh) {
        let soup = points(mesh)?;
        let graph = SurfaceGraph::from_points(&soup.points, soup.normals.as_deref(), weld, cloud)?;
        let copy = drawn_discs(mesh, &graph)?;
        return Ok((graph, copy));
    }
    let soup = triangle_soup(mesh)?;
    let graph = SurfaceGraph::from_triangles(&soup.positions, &soup.triangles, weld)?;
    let copy = drawn_triangles(mesh, &soup, &graph)?;
    Ok((graph, copy))
}

fn drawn_discs(mesh: &Mesh, graph: &SurfaceGraph) -> Result<Mesh, PatternError> {
    let mut copy = discs(mesh, graph)?;
    insert_missing_normals(&mut copy, graph)?;
    Ok(copy)
}

fn drawn_triangles(mesh: &Mesh, soup: &TriangleSoup, graph: &SurfaceGraph) -> Result<Mesh, PatternError> {
    let mut copy = unindexed(mesh, soup)?;
    insert_missing_normals(&mut copy, graph)?;
    Ok(copy)
}

/// A mesh, which leaves an empty one behind.
fn take(mesh: &mut Mesh) -> Mesh {
    let empty = Mesh::new(mesh.primitive_topology(), mesh.asset_usage);
    std::mem::replace(mesh, empty)
}

/// Takes a mesh's new positions and attributes over into the graph and the drawn `copy` that it has already; whether any
/// position is another one, or `None` where both must be built anew.
fn written_in_place(mesh: &Mesh, graph: &mut SurfaceGraph, copy: &mut Mesh) -> Result<Option<bool>, PatternError> {
    if is_points(mesh) != graph.is_cloud() {
        return Ok(None);
    }
    if graph.is_cloud() {
        let soup = points(mesh)?;
        if soup.points.len() != graph.vertex_of.len() {
            return Ok(None);
        }
        graph.update_points(&soup.points, soup.normals.as_deref())?;
        *copy = drawn_discs(mesh, graph)?;
        return Ok(Some(true));
    }
    let soup = triangle_soup(mesh)?;
    let same = soup.positions.len() == graph.vertex_of.len()
        && soup.triangles.len() == graph.triangles.len()
        && soup
            .triangles
            .iter()
            .zip(&graph.triangles)
            .all(|(new, old)| new.map(|v| graph.vertex_of[v as usize]) == *old);
    if !same {
        return Ok(None);
    }
    let moved = graph.update_positions(&soup.positions)?;
    if !repeat_attributes(mesh, &soup, graph, copy)? {
        *copy = drawn_triangles(mesh, &soup, graph)?;
    }
    Ok(Some(moved))
}
