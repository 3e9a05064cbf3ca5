//! What a smooth field is drawn to.
//!
//! In: a graph, and what the user has painted on its mesh. Out: per vertex a direction and a weight, 0 where the field is
//! free.

use super::{FieldRing, SmoothField, any_tangent, attribute, curvature, tangent};
use crate::{error::PatternError, surface::SurfaceGraph};
use bevy::{mesh::MeshVertexAttribute, platform::collections::HashMap, prelude::*};
use std::sync::Arc;

/// What a smooth field is drawn to.
#[derive(Reflect, Debug, Clone, PartialEq, Default)]
#[reflect(Default)]
pub enum Alignment {
    /// The direction of major principal curvature, the more the clearer it is.
    #[default]
    Curvature,
    /// The edges of an open surface.
    Boundary,
    /// Edges between two triangles whose normals differ by at least this angle, in radians, above 0 and at most π. 35
    /// degrees, 0.61, is a good one.
    Creases(f32),
    /// Directions of your own.
    Painted(Painted),
}

/// Directions that a user sets, one vector per vertex of the mesh, in the mesh's space. Its length is its weight; zero
/// leaves the field free. Copies of a vertex at a seam are averaged, as lines.
#[derive(Reflect, Debug, Clone, PartialEq)]
pub enum Painted {
    /// A vertex attribute of format `Float32x3`. Reflection cannot carry the attribute: set it from code.
    Attribute(#[reflect(ignore, default = "attribute::lost_in_reflection")] MeshVertexAttribute),
    /// A list in the mesh's order.
    Vertices(Arc<[Vec3]>),
}

impl Default for Painted {
    fn default() -> Self {
        Self::Vertices(Arc::from([]))
    }
}

impl Alignment {
    pub(super) fn check(&self) -> Result<(), PatternError> {
        match *self {
            Self::Creases(angle) if !(angle > 0.0 && angle <= std::f32::consts::PI) => Err(PatternError::OutOfRange {
                what: "Alignment::Creases",
                value: angle,
                expected: "above 0 and at most π",
            }),
            _ => Ok(()),
        }
    }
}

/// The direction that a field is drawn to at each vertex of `graph`, a unit vector, and its weight.
///
/// # Errors
/// [`OutOfRange`](PatternError::OutOfRange) of the field's numbers; [`NotFinite`](PatternError::NotFinite),
/// [`WrongLength`](PatternError::WrongLength) and those of attributes for painted directions.
pub fn smooth_constraints(field: &SmoothField, graph: &SurfaceGraph, mesh: &Mesh) -> Result<Vec<Vec4>, PatternError> {
    field.check()?;
    let mut constraints: Vec<Vec4> = match &field.align {
        Alignment::Curvature => curvature::lines(graph)
            .iter()
            .zip(&graph.normals)
            .map(|(&u, &n)| tangent::line_of(u, any_tangent(n), n).extend(u.length()))
            .collect(),
        Alignment::Boundary => along_edges(graph, field.ring, |normals| normals.len() == 1),
        Alignment::Creases(angle) => {
            let cos = angle.cos();
            let is_crease = |normals: &[Vec3]| normals.len() == 2 && normals[0].dot(normals[1]) <= cos;
            along_edges(graph, field.ring, is_crease)
        }
        Alignment::Painted(Painted::Attribute(attribute)) => {
            let vectors: Vec<Vec3> = attribute::vectors(mesh, *attribute)?
                .iter()
                .map(|&v| v.into())
                .collect();
            painted(&vectors, graph)?
        }
        Alignment::Painted(Painted::Vertices(vectors)) => painted(vectors, graph)?,
    };
    constraints.iter_mut().for_each(|c| c.w *= field.weight);
    Ok(constraints)
}

fn painted(vectors: &[Vec3], graph: &SurfaceGraph) -> Result<Vec<Vec4>, PatternError> {
    let means = attribute::weld_aligned(vectors, graph, "painted directions", "painted direction of vertex")?;
    Ok(means
        .into_iter()
        .map(|mean| mean.normalize_or_zero().as_vec3().extend(mean.length() as f32))
        .collect())
}

/// At each vertex the mean direction of its edges that `counts` picks by the unit normals of their triangles, as lines or
/// crosses; its weight is how well they agree.
fn along_edges(graph: &SurfaceGraph, ring: FieldRing, counts: impl Fn(&[Vec3]) -> bool) -> Vec<Vec4> {
    let mut edges: HashMap<[u32; 2], Vec<Vec3>> = HashMap::default();
    for triangle in &graph.triangles {
        let [a, b, c] = triangle.map(|v| graph.positions[v as usize].as_dvec3());
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            continue;
        };
        for k in 0..3 {
            let (i, j) = (triangle[k], triangle[(k + 1) % 3]);
            edges.entry([i.min(j), i.max(j)]).or_default().push(normal.as_vec3());
        }
    }
    let mut sums = vec![(Vec2::ZERO, 0_u32); graph.len()];
    for (ends, _) in edges.iter().filter(|(_, normals)| counts(normals)) {
        let [a, b] = ends.map(|v| graph.positions[v as usize]);
        for end in ends.map(|v| v as usize) {
            let n = graph.normals[end];
            let (x, e) = (any_tangent(n), b - a);
            let c = Vec2::new(e.dot(x), e.dot(n.cross(x))).normalize_or_zero();
            let line = tangent::squared(c);
            sums[end].0 += if ring == FieldRing::Four {
                tangent::squared(line)
            } else {
                line
            };
            sums[end].1 += 1;
        }
    }
    sums.iter()
        .zip(&graph.normals)
        .map(|(&(sum, edges), &n)| {
            let line = match ring {
                FieldRing::Two => sum,
                FieldRing::Four => Vec2::from_angle(0.5 * sum.to_angle()),
            };
            tangent::line_of(line, any_tangent(n), n).extend(sum.length() / edges.max(1) as f32)
        })
        .collect()
}
