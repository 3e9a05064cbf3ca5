//! The mesh that is drawn: an un-indexed copy of the user's mesh.
//!
//! In: a [`Mesh`] and its [`TriangleSoup`]. Out: a triangle list without indices, three vertices per triangle of
//! [`SurfaceGraph::triangles`] and in the same order. Vertex k of the copy is corner k % 3 of triangle k / 3, which is
//! how a shader knows where on the surface it is, without an attribute of its own.

use super::{
    graph::SurfaceGraph,
    soup::{TriangleSoup, access_error, check_indices, points, vertex_count},
};
use crate::error::PatternError;
use bevy::{
    math::bounding::Aabb3d,
    mesh::{Indices, Mesh, PrimitiveTopology, VertexAttributeValues, morph::MorphAttributes},
    prelude::*,
};

/// A copy of `mesh` without indices, three vertices per triangle of `soup`, which is the mesh's own.
///
/// All attributes (normals and skin among them) and morph targets are repeated as they are; names of morph targets,
/// bounds and usage are kept. A closed mesh grows to six times its vertices.
///
/// # Errors
/// [`MeshDataTaken`](PatternError::MeshDataTaken), and [`IndexOutOfRange`](PatternError::IndexOutOfRange) where `soup`
/// is that of a larger mesh.
pub fn unindexed(mesh: &Mesh, soup: &TriangleSoup) -> Result<Mesh, PatternError> {
    let vertices = vertex_count(mesh)?;
    check_indices(&soup.triangles, vertices)?;
    let mut copy = Mesh::new(PrimitiveTopology::TriangleList, mesh.asset_usage);
    for (attribute, values) in mesh.try_attributes().map_err(access_error)? {
        copy.insert_attribute(*attribute, values.clone());
    }
    // Bevy repeats the vertices of every format by the indices, and drops these.
    copy.insert_indices(Indices::U32(soup.triangles.as_flattened().to_vec()));
    copy.try_duplicate_vertices().map_err(access_error)?;

    if mesh.try_has_morph_targets().map_err(access_error)? {
        let targets = mesh.try_morph_targets().map_err(access_error)?;
        copy.set_morph_targets(unindexed_targets(targets, &soup.triangles, vertices));
    }
    if let Some(names) = mesh.try_morph_target_names().map_err(access_error)? {
        copy.set_morph_target_names(names.to_vec());
    }
    copy.enable_raytracing = mesh.enable_raytracing;
    copy.final_aabb = mesh.final_aabb;
    copy.set_skinned_mesh_bounds(mesh.skinned_mesh_bounds().cloned());
    Ok(copy)
}

/// Repeats the attributes of `mesh` once more in `copy`, the drawn copy of what the mesh was before its attributes changed;
/// `graph` is the mesh's own and gives normals where the mesh has none. `false` where this is not enough, since the mesh has
/// other attributes than before, morph targets, or an attribute that is no float: then a new copy is needed.
///
/// # Errors
/// [`MeshDataTaken`](PatternError::MeshDataTaken) of `mesh`.
pub(super) fn repeat_attributes(
    mesh: &Mesh,
    soup: &TriangleSoup,
    graph: &SurfaceGraph,
    copy: &mut Mesh,
) -> Result<bool, PatternError> {
    if mesh.try_has_morph_targets().map_err(access_error)? {
        return Ok(false);
    }
    let corners = soup.triangles.as_flattened();
    let given = mesh.try_attributes().map_err(access_error)?.count();
    let has_normals = mesh
        .try_contains_attribute(Mesh::ATTRIBUTE_NORMAL)
        .map_err(access_error)?;
    let Ok(repeated) = copy.try_attributes_mut() else {
        return Ok(false);
    };
    let mut count = 0;
    for (attribute, values) in repeated {
        count += 1;
        let done = match mesh.try_attribute_option(attribute.id).map_err(access_error)? {
            Some(given) => repeat(given, corners, values),
            None => match values {
                VertexAttributeValues::Float32x3(normals) if attribute.id == Mesh::ATTRIBUTE_NORMAL.id => gather(
                    bytemuck::cast_slice(&graph.normals),
                    graph.triangles.as_flattened(),
                    normals,
                ),
                _ => false,
            },
        };
        if !done {
            return Ok(false);
        }
    }
    copy.final_aabb = mesh.final_aabb.or_else(|| bounds(&soup.positions));
    copy.set_skinned_mesh_bounds(mesh.skinned_mesh_bounds().cloned());
    Ok(count == given + usize::from(!has_normals))
}

fn repeat(given: &VertexAttributeValues, corners: &[u32], values: &mut VertexAttributeValues) -> bool {
    use VertexAttributeValues::{Float32, Float32x2, Float32x3, Float32x4};
    match (given, values) {
        (Float32(given), Float32(values)) => gather(given, corners, values),
        (Float32x2(given), Float32x2(values)) => gather(given, corners, values),
        (Float32x3(given), Float32x3(values)) => gather(given, corners, values),
        (Float32x4(given), Float32x4(values)) => gather(given, corners, values),
        _ => false,
    }
}

/// One value per corner; whether there were as many.
fn gather<T: Copy>(given: &[T], corners: &[u32], values: &mut [T]) -> bool {
    if values.len() != corners.len() {
        return false;
    }
    for (value, &corner) in values.iter_mut().zip(corners) {
        *value = given[corner as usize];
    }
    true
}

/// The box around positions, so that Bevy need not look for it among all corners.
fn bounds(positions: &[Vec3]) -> Option<Aabb3d> {
    let first = *positions.first()?;
    let (min, max) = positions
        .iter()
        .fold((first, first), |(min, max), &p| (min.min(p), max.max(p)));
    Some(Aabb3d::from_min_max(min, max))
}

/// A copy of a list of points in which each point is a square of two triangles, in the order of
/// [`SurfaceGraph::triangles`]; all attributes but positions are repeated as they are.
///
/// # Errors
/// [`MeshDataTaken`](PatternError::MeshDataTaken), [`Topology`](PatternError::Topology) of a mesh that is no list of
/// points, and [`WrongLength`](PatternError::WrongLength) where `graph` is not that of `mesh`.
pub fn discs(mesh: &Mesh, graph: &SurfaceGraph) -> Result<Mesh, PatternError> {
    let points = points(mesh)?.points;
    if !graph.is_cloud() || graph.vertex_of.len() != points.len() {
        return Err(PatternError::WrongLength {
            what: "points",
            found: points.len(),
            expected: if graph.is_cloud() { graph.vertex_of.len() } else { 0 },
        });
    }
    let soup = TriangleSoup {
        triangles: (0..points.len() as u32).flat_map(|v| [[v; 3]; 2]).collect(),
        positions: points,
    };
    let mut copy = unindexed(mesh, &soup)?;
    let corners = graph.vertex_of.iter().flat_map(|&v| {
        let corners = graph.disc_corners(v as usize);
        [0, 1, 2, 0, 2, 3].map(|corner| corners[corner])
    });
    copy.insert_attribute(Mesh::ATTRIBUTE_POSITION, corners.collect::<Vec<_>>());
    Ok(copy)
}

/// Gives an un-indexed copy the smooth normals of its graph, if it has none of its own; without normals it would be
/// unlit.
///
/// # Errors
/// [`MeshDataTaken`](PatternError::MeshDataTaken), and [`WrongLength`](PatternError::WrongLength) where `copy` is not
/// an un-indexed copy of the graph's mesh.
pub fn insert_missing_normals(copy: &mut Mesh, graph: &SurfaceGraph) -> Result<(), PatternError> {
    if copy
        .try_contains_attribute(Mesh::ATTRIBUTE_NORMAL)
        .map_err(access_error)?
    {
        return Ok(());
    }
    let (found, expected) = (vertex_count(copy)?, 3 * graph.triangles.len());
    if found != expected {
        return Err(PatternError::WrongLength {
            what: "corners of triangles",
            found,
            expected,
        });
    }
    let corners = graph.triangles.as_flattened().iter();
    let normals: Vec<Vec3> = corners.map(|&v| graph.normals[v as usize]).collect();
    copy.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
    Ok(())
}

/// Morph targets lie one after the other, each with one entry per vertex.
fn unindexed_targets(targets: &[MorphAttributes], triangles: &[[u32; 3]], vertices: usize) -> Vec<MorphAttributes> {
    let corners = triangles.as_flattened();
    let of_target = |target: &'_ [MorphAttributes]| corners.iter().map(|&v| target[v as usize]).collect::<Vec<_>>();
    targets.chunks_exact(vertices.max(1)).flat_map(of_target).collect()
}
