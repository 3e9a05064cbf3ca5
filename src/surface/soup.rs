//! The triangles of a mesh, as they are drawn, or its points.
//!
//! In: a [`Mesh`] of triangles: a list or a strip, with 16-bit indices, 32-bit indices or none; or a list of points. Out:
//! positions and triangles, checked: every index is in range and every position is finite. This is the only place that
//! knows of topologies and index formats; all else starts from a [`TriangleSoup`] or a [`PointSoup`].

use crate::error::PatternError;
use bevy::{
    mesh::{Indices, Mesh, MeshAccessError, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};

/// The vertices of a mesh and its triangles in drawing order, degenerate ones included.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleSoup {
    /// Position of each vertex of the mesh, in the mesh's units; finite.
    pub positions: Vec<Vec3>,
    /// The three vertices of each drawn triangle, counter-clockwise; all smaller than `positions.len()`.
    pub triangles: Vec<[u32; 3]>,
}

/// Reads positions and triangles out of a triangle list or a triangle strip.
///
/// Where attributes have different lengths, the shortest decides on the number of vertices, as it does in Bevy's vertex
/// buffers. A last triangle that lacks corners is not drawn by the GPU and is left out. In a strip every other triangle
/// is turned round, and the largest index (`0xFFFF` or `0xFFFF_FFFF`) begins a new strip.
///
/// # Errors
/// [`MeshDataTaken`](PatternError::MeshDataTaken), [`Topology`](PatternError::Topology),
/// [`NoPositions`](PatternError::NoPositions), [`NotFinite`](PatternError::NotFinite) and
/// [`IndexOutOfRange`](PatternError::IndexOutOfRange). A mesh without a triangle is no error here.
pub fn triangle_soup(mesh: &Mesh) -> Result<TriangleSoup, PatternError> {
    let topology = mesh.primitive_topology();
    if !matches!(
        topology,
        PrimitiveTopology::TriangleList | PrimitiveTopology::TriangleStrip
    ) {
        return Err(PatternError::Topology(format!("{topology:?}")));
    }
    let positions = positions(mesh)?;
    let vertices = positions.len();
    let strip = topology == PrimitiveTopology::TriangleStrip;
    let triangles = match mesh.try_indices_option().map_err(access_error)? {
        Some(Indices::U16(indices)) if strip => strips(indices, u16::MAX),
        Some(Indices::U32(indices)) if strip => strips(indices, u32::MAX),
        Some(Indices::U16(indices)) => list(indices),
        Some(Indices::U32(indices)) => list(indices),
        None if strip => strip_triangles(&(0..vertices as u32).collect::<Vec<_>>()).collect(),
        None => list(&(0..vertices as u32).collect::<Vec<_>>()),
    };
    check_indices(&triangles, vertices)?;
    Ok(TriangleSoup { positions, triangles })
}

/// The points of a cloud.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PointSoup {
    /// Position of each vertex of the mesh, in the mesh's units; finite.
    pub points: Vec<Vec3>,
    /// Their normals of any length, where the mesh has any.
    pub normals: Option<Vec<Vec3>>,
}

/// Whether a mesh is a list of points.
pub fn is_points(mesh: &Mesh) -> bool {
    mesh.primitive_topology() == PrimitiveTopology::PointList
}

/// Reads positions and normals out of a list of points. Indices count for nothing: every vertex is a point.
///
/// # Errors
/// [`MeshDataTaken`](PatternError::MeshDataTaken), [`Topology`](PatternError::Topology) of another mesh,
/// [`NoPositions`](PatternError::NoPositions) and [`NotFinite`](PatternError::NotFinite).
pub fn points(mesh: &Mesh) -> Result<PointSoup, PatternError> {
    if !is_points(mesh) {
        return Err(PatternError::Topology(format!("{:?}", mesh.primitive_topology())));
    }
    let points = positions(mesh)?;
    let normals = match mesh
        .try_attribute_option(Mesh::ATTRIBUTE_NORMAL)
        .map_err(access_error)?
    {
        Some(VertexAttributeValues::Float32x3(normals)) => {
            Some(normals[..points.len()].iter().copied().map(Vec3::from).collect())
        }
        _ => None,
    };
    Ok(PointSoup { points, normals })
}

fn positions(mesh: &Mesh) -> Result<Vec<Vec3>, PatternError> {
    let positions = mesh.try_attribute(Mesh::ATTRIBUTE_POSITION).map_err(access_error)?;
    let VertexAttributeValues::Float32x3(positions) = positions else {
        return Err(PatternError::NoPositions);
    };
    let positions: Vec<Vec3> = positions[..vertex_count(mesh)?]
        .iter()
        .copied()
        .map(Vec3::from)
        .collect();
    check_finite(&positions)?;
    Ok(positions)
}

/// Number of vertices that Bevy draws with: the length of the shortest attribute.
pub(super) fn vertex_count(mesh: &Mesh) -> Result<usize, PatternError> {
    let attributes = mesh.try_attributes().map_err(access_error)?;
    Ok(attributes.map(|(_, values)| values.len()).min().unwrap_or(0))
}

pub(super) fn access_error(error: MeshAccessError) -> PatternError {
    match error {
        MeshAccessError::ExtractedToRenderWorld => PatternError::MeshDataTaken,
        MeshAccessError::NotFound => PatternError::NoPositions,
    }
}

/// Refuses NaN and infinite positions.
pub(super) fn check_finite(positions: &[Vec3]) -> Result<(), PatternError> {
    match positions.iter().position(|p| !p.is_finite()) {
        Some(index) => Err(PatternError::NotFinite {
            what: "position of vertex",
            index,
        }),
        None => Ok(()),
    }
}

/// Refuses triangles with a corner behind the last vertex.
pub(super) fn check_indices(triangles: &[[u32; 3]], vertices: usize) -> Result<(), PatternError> {
    match triangles
        .as_flattened()
        .iter()
        .find(|&&index| index as usize >= vertices)
    {
        Some(&index) => Err(PatternError::IndexOutOfRange { index, vertices }),
        None => Ok(()),
    }
}

fn list<I: Copy + Into<u32>>(indices: &[I]) -> Vec<[u32; 3]> {
    let triangles = indices.as_chunks::<3>().0.iter();
    triangles.map(|triangle| triangle.map(Into::into)).collect()
}

/// All strips of an index buffer, each as long as it goes without the restart index.
fn strips<I: Copy + PartialEq + Into<u32>>(indices: &[I], restart: I) -> Vec<[u32; 3]> {
    indices
        .split(|&index| index == restart)
        .flat_map(strip_triangles)
        .collect()
}

/// The triangles of one strip. Every other one is turned round so that all face the same way; its first vertex stays
/// the first, which keeps flat-interpolated values where the GPU takes them from.
fn strip_triangles<I: Copy + Into<u32>>(strip: &[I]) -> impl Iterator<Item = [u32; 3]> {
    let corners = strip
        .array_windows()
        .map(|&[a, b, c]: &[I; 3]| [a.into(), b.into(), c.into()]);
    corners
        .enumerate()
        .map(|(i, [a, b, c])| if i % 2 == 0 { [a, b, c] } else { [a, c, b] })
}
