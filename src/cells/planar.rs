//! The mesh of a planar sample set.

use crate::sampling::SampleSet;
use bevy::{
    asset::RenderAssetUsages,
    mesh::{MeshVertexAttribute, PrimitiveTopology, VertexFormat},
    prelude::*,
};

/// The index of each vertex's triangle, for meshes whose shader cannot count vertices.
pub const ATTRIBUTE_TRIANGLE: MeshVertexAttribute =
    MeshVertexAttribute::new("CellTriangle", 0x6f0b_d2b0_0001, VertexFormat::Uint32);

/// The triangles of a planar set's own samples, three vertices each and without indices, at z = 0 and facing +z.
///
/// The UV is the position over the set's bounds, v from top to bottom, so that an image stands upright. Triangle t is that
/// of `set.seeds[t]`, which makes the mesh fit its set. Use it with `Mesh3d`
/// to draw a planar set in space; entities with `Mesh2d` get it from the plugin.
pub fn planar_mesh(set: &SampleSet) -> Mesh {
    let corners = corners(set);
    let (low, size) = bounds(set);
    let uv = |p: &Vec3| uv(*p, low, size);
    let triangles = (0..set.seeds.len() as u32).flat_map(|t| [t; 3]).collect::<Vec<_>>();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, corners.clone())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![Vec3::Z; 3 * set.seeds.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_UV_0, corners.iter().map(uv).collect::<Vec<_>>())
        .with_inserted_attribute(ATTRIBUTE_TRIANGLE, triangles)
}

/// Where the samples of a planar set lie in an image over the set's bounds: (0, 0) is its upper left corner.
pub fn planar_uvs(set: &SampleSet) -> Vec<Vec2> {
    let (low, size) = bounds(set);
    set.positions.iter().map(|&p| uv(p, low, size)).collect()
}

/// The corners of all triangles.
fn corners(set: &SampleSet) -> Vec<Vec3> {
    if set.corners.len() == set.seeds.len() {
        return set.corners.as_flattened().to_vec();
    }
    let position = |&seed: &u32| set.positions.get(seed as usize).copied().unwrap_or_default();
    set.seeds.as_flattened().iter().map(position).collect()
}

/// The lower left corner of what a set covers, and its size.
fn bounds(set: &SampleSet) -> (Vec2, Vec2) {
    let start = (Vec2::MAX, Vec2::MIN);
    let points = set.positions.iter().chain(set.corners.as_flattened());
    let (low, high) = points.fold(start, |(low, high), p| (low.min(p.truncate()), high.max(p.truncate())));
    (low, (high - low).max(Vec2::splat(f32::MIN_POSITIVE)))
}

fn uv(p: Vec3, low: Vec2, size: Vec2) -> Vec2 {
    let uv = (p.truncate() - low) / size;
    Vec2::new(uv.x, 1.0 - uv.y)
}
