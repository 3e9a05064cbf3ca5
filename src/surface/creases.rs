//! Sharp features: where a surface is folded, and where it ends.
//!
//! In: the triangles of a graph. Out: for each vertex whether it lies on an edge at which two triangles meet at more than
//! an angle, or on a border. Triangles without an area do not count; where more than two share an edge, it is sharp.

use super::{geometry::double_area, graph::SurfaceGraph, order::argsort};
use bevy::prelude::*;

impl SurfaceGraph {
    /// Which vertices lie on a crease: an edge whose two triangles' normals part by more than `angle` radians, or which
    /// more than two triangles share; with `boundary` also an edge of one triangle only. In solver order; all `false` for
    /// a point cloud, which has no edges to be sharp.
    pub fn creases(&self, angle: f32, boundary: bool) -> Vec<bool> {
        let mut sides = Vec::new();
        for (&[a, b, c], t) in self.triangles.iter().zip(0..) {
            if self.unit_normal([a, b, c]).is_some() {
                sides.extend([(a, b), (b, c), (c, a)].map(|(from, to)| Side { from, to, triangle: t }));
            }
        }
        let keys: Vec<u64> = sides.iter().map(Side::key).collect();
        let sorted: Vec<Side> = argsort(&keys).into_iter().map(|i| sides[i as usize]).collect();
        let flattest = angle.cos();
        let mut on_crease = vec![false; self.len()];
        for edge in sorted.chunk_by(|a, b| a.key() == b.key()) {
            let sharp = match edge {
                [_] => boundary,
                [one, other] => self.cosine(one, other).is_some_and(|cosine| cosine < flattest),
                _ => true,
            };
            if sharp {
                on_crease[edge[0].from as usize] = true;
                on_crease[edge[0].to as usize] = true;
            }
        }
        on_crease
    }

    fn unit_normal(&self, triangle: [u32; 3]) -> Option<Vec3> {
        let normal = double_area(triangle.map(|v| self.positions[v as usize]))?;
        Some(normal.normalize().as_vec3())
    }

    /// The cosine between the normals of two triangles at a common edge, seen from the same side of the surface.
    fn cosine(&self, one: &Side, other: &Side) -> Option<f32> {
        let normal = |side: &Side| self.unit_normal(self.triangles[side.triangle as usize]);
        // Triangles that face alike run along their common edge in opposite directions.
        let alike = if one.from == other.to { 1.0 } else { -1.0 };
        Some(alike * normal(one)?.dot(normal(other)?))
    }
}

/// A directed side of a triangle.
#[derive(Clone, Copy)]
struct Side {
    from: u32,
    to: u32,
    triangle: u32,
}

impl Side {
    /// The same for both directions.
    fn key(&self) -> u64 {
        u64::from(self.from.min(self.to)) << 32 | u64::from(self.from.max(self.to))
    }
}
