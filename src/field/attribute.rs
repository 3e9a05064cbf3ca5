//! Values per vertex of the mesh, brought to the welded vertices of its graph.
//!
//! In: a mesh attribute or a user's list. Out: one value per graph vertex, in solver order. The copies of a vertex at a
//! seam are averaged: scalars and vectors arithmetically, lines as lines.

use super::{Symmetry, any_tangent, project_tangent, tangent};
use crate::{error::PatternError, parallel, surface::SurfaceGraph};
use bevy::{
    math::{DVec2, DVec3, Vec3},
    mesh::{Mesh, MeshAccessError, MeshVertexAttribute, VertexAttributeValues, VertexFormat},
};

/// Stands for an attribute that reflection cannot carry: a value that was rebuilt through reflection names this one.
pub(super) fn lost_in_reflection() -> MeshVertexAttribute {
    MeshVertexAttribute::new(
        "(lost in reflection; set it from code)",
        u64::MAX,
        VertexFormat::Float32x3,
    )
}

fn values(mesh: &Mesh, attribute: MeshVertexAttribute) -> Result<&VertexAttributeValues, PatternError> {
    mesh.try_attribute(attribute).map_err(|error| match error {
        MeshAccessError::ExtractedToRenderWorld => PatternError::MeshDataTaken,
        MeshAccessError::NotFound => PatternError::MissingAttribute(attribute.name.into()),
    })
}

fn wrong_format(
    attribute: MeshVertexAttribute,
    values: &VertexAttributeValues,
    expected: &'static str,
) -> PatternError {
    PatternError::AttributeFormat {
        name: attribute.name.into(),
        found: format!("{:?}", VertexFormat::from(values)),
        expected,
    }
}

/// The attribute's values, which must be `Float32x3`.
pub(super) fn vectors(mesh: &Mesh, attribute: MeshVertexAttribute) -> Result<&[[f32; 3]], PatternError> {
    match values(mesh, attribute)? {
        VertexAttributeValues::Float32x3(vectors) => Ok(vectors),
        other => Err(wrong_format(attribute, other, "Float32x3")),
    }
}

/// The attribute's values, which must be `Float32`.
pub(crate) fn scalars(mesh: &Mesh, attribute: MeshVertexAttribute) -> Result<&[f32], PatternError> {
    match values(mesh, attribute)? {
        VertexAttributeValues::Float32(scalars) => Ok(scalars),
        other => Err(wrong_format(attribute, other, "Float32")),
    }
}

fn check_length(found: usize, graph: &SurfaceGraph, what: &'static str) -> Result<(), PatternError> {
    let expected = graph.vertex_of.len();
    if found == expected {
        Ok(())
    } else {
        Err(PatternError::WrongLength { what, found, expected })
    }
}

/// One scalar per graph vertex: the mean over the copies. `list` and `item` name the values in errors.
pub(crate) fn weld_scalars(
    scalars: &[f32],
    graph: &SurfaceGraph,
    list: &'static str,
    item: &'static str,
) -> Result<Vec<f32>, PatternError> {
    check_length(scalars.len(), graph, list)?;
    let mut sums = vec![(0.0_f64, 0_u32); graph.len()];
    for (index, (&scalar, &vertex)) in scalars.iter().zip(&graph.vertex_of).enumerate() {
        if !scalar.is_finite() {
            return Err(PatternError::NotFinite { what: item, index });
        }
        let (sum, copies) = &mut sums[vertex as usize];
        *sum += f64::from(scalar);
        *copies += 1;
    }
    Ok(sums
        .into_iter()
        .map(|(sum, copies)| (sum / f64::from(copies.max(1))) as f32)
        .collect())
}

/// One vector per graph vertex: the mean over the copies. `list` and `item` name the values in errors.
pub(super) fn weld_means<V: Copy + Into<Vec3>>(
    vectors: &[V],
    graph: &SurfaceGraph,
    list: &'static str,
    item: &'static str,
) -> Result<Vec<DVec3>, PatternError> {
    check_vectors(vectors, graph, list, item)?;
    let mut sums = vec![(DVec3::ZERO, 0_u32); graph.len()];
    for (&v, &vertex) in vectors.iter().zip(&graph.vertex_of) {
        let (sum, copies) = &mut sums[vertex as usize];
        *sum += v.into().as_dvec3();
        *copies += 1;
    }
    Ok(sums
        .into_iter()
        .map(|(sum, copies)| sum / f64::from(copies.max(1)))
        .collect())
}

/// [`weld_means`] of lines: each copy counts with the sign nearest to the first one.
pub(super) fn weld_aligned(
    vectors: &[Vec3],
    graph: &SurfaceGraph,
    list: &'static str,
    item: &'static str,
) -> Result<Vec<DVec3>, PatternError> {
    check_vectors(vectors, graph, list, item)?;
    let mut first = vec![None; graph.len()];
    let aligned: Vec<Vec3> = vectors
        .iter()
        .zip(&graph.vertex_of)
        .map(|(&v, &vertex)| {
            let first: Vec3 = *first[vertex as usize].get_or_insert(v);
            if v.dot(first) < 0.0 { -v } else { v }
        })
        .collect();
    weld_means(&aligned, graph, list, item)
}

/// One unit tangent per graph vertex: the mean over the copies, as vectors or as lines. Vectors of any length.
pub(super) fn weld_directions<V: Copy + Into<Vec3>>(
    vectors: &[V],
    symmetry: Symmetry,
    graph: &SurfaceGraph,
) -> Result<Vec<Vec3>, PatternError> {
    check_vectors(vectors, graph, "directions", "direction of vertex")?;
    let copies = vectors
        .iter()
        .zip(&graph.vertex_of)
        .map(|(&v, &vertex)| (v.into(), vertex as usize));
    Ok(match symmetry {
        Symmetry::Vector => mean_vectors(copies, graph),
        Symmetry::Line => mean_lines(copies, graph),
    })
}

/// One unit vector per graph vertex: that of its first copy as given, normalised; any tangent where it is zero.
pub(super) fn first_directions(vectors: &[Vec3], graph: &SurfaceGraph) -> Result<Vec<Vec3>, PatternError> {
    check_vectors(vectors, graph, "directions", "direction of vertex")?;
    let mut directions = vec![Vec3::ZERO; graph.len()];
    for (v, &vertex) in vectors.iter().zip(&graph.vertex_of).rev() {
        directions[vertex as usize] = v.as_dvec3().normalize_or_zero().as_vec3();
    }
    for (d, &n) in directions.iter_mut().zip(&graph.normals) {
        if *d == Vec3::ZERO {
            *d = any_tangent(n);
        }
    }
    Ok(directions)
}

fn check_vectors<V: Copy + Into<Vec3>>(
    vectors: &[V],
    graph: &SurfaceGraph,
    list: &'static str,
    item: &'static str,
) -> Result<(), PatternError> {
    check_length(vectors.len(), graph, list)?;
    match vectors.iter().position(|&v| !v.into().is_finite()) {
        Some(index) => Err(PatternError::NotFinite { what: item, index }),
        None => Ok(()),
    }
}

fn mean_vectors(copies: impl Iterator<Item = (Vec3, usize)>, graph: &SurfaceGraph) -> Vec<Vec3> {
    // In f64, so that neither huge nor tiny vectors leave the range.
    let mut sums = vec![DVec3::ZERO; graph.len()];
    for (v, vertex) in copies {
        sums[vertex] += v.as_dvec3();
    }
    parallel::collect(graph.len(), |i| {
        project_tangent(sums[i].normalize_or_zero().as_vec3(), graph.normals[i])
    })
}

fn mean_lines(copies: impl Iterator<Item = (Vec3, usize)>, graph: &SurfaceGraph) -> Vec<Vec3> {
    #[derive(Clone, Copy, Default)]
    struct Sum {
        /// Sum of (x + iy)² / |x + iy|.
        line: DVec2,
        /// The first copy: its sign is kept.
        first: DVec3,
    }
    let mut sums = vec![Sum::default(); graph.len()];
    for (v, vertex) in copies {
        let (v, n) = (v.as_dvec3(), graph.normals[vertex]);
        let x = any_tangent(n);
        let c = DVec2::new(v.dot(x.as_dvec3()), v.dot(n.cross(x).as_dvec3()));
        let sum = &mut sums[vertex];
        // A vector along the normal has no line; its rounding noise must not become one.
        if c.length() > 1e-6 * v.length() {
            sum.line += c.rotate(c) / c.length();
            if sum.first == DVec3::ZERO {
                sum.first = v;
            }
        }
    }
    parallel::collect(graph.len(), |i| {
        let (Sum { line, first }, n) = (sums[i], graph.normals[i]);
        let d = tangent::line_of(line.normalize_or_zero().as_vec2(), any_tangent(n), n);
        if d.as_dvec3().dot(first) < 0.0 { -d } else { d }
    })
}
