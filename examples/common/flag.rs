//! A flag in the wind.
//!
//! In: sizes, a time. Out: a grid of triangles at rest, and where its vertices are at any time. One edge is held by a pole
//! along y at the origin; waves run from there along +x and grow.

use bevy::prelude::*;
use std::f32::consts::TAU;

use super::mesh_file::RawMesh;

/// The cloth.
#[derive(Clone, Copy, Debug)]
pub struct Flag {
    /// Along x and along y.
    pub size: Vec2,
    /// Cells along x and along y, 1 or more each.
    pub cells: UVec2,
    /// Height of the waves at the loose end.
    pub amplitude: f32,
}

impl Default for Flag {
    fn default() -> Self {
        Self {
            size: Vec2::new(3.0, 1.8),
            cells: UVec2::new(150, 90),
            amplitude: 0.34,
        }
    }
}

impl Flag {
    /// The cloth at time 0, facing +z.
    pub fn mesh(&self) -> RawMesh {
        let vertex = |i: u32, j: u32| i * (self.cells.y + 1) + j;
        let cells = (0..self.cells.x).flat_map(|i| (0..self.cells.y).map(move |j| (i, j)));
        let triangles = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
                // Alternating diagonals have no direction of their own.
                if (i + j) % 2 == 0 {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                }
            })
            .collect();
        RawMesh {
            positions: self.positions(0.0),
            triangles,
        }
    }

    /// Where the vertices are after `seconds`, in the order of the mesh.
    pub fn positions(&self, seconds: f32) -> Vec<Vec3> {
        let UVec2 { x: columns, y: rows } = self.cells;
        let cell = self.size / self.cells.as_vec2();
        let mut positions = vec![Vec3::ZERO; ((columns + 1) * (rows + 1)) as usize];
        for j in 0..=rows {
            // Each row is a thread that cannot stretch: a step aside is taken from the step ahead.
            let y = cell.y * j as f32 - 0.5 * self.size.y;
            let (mut x, mut last) = (0.0, self.height(0.0, y, seconds));
            for i in 0..=columns {
                let s = cell.x * i as f32;
                let z = self.height(s, y, seconds);
                if i > 0 {
                    x += (cell.x.powi(2) - (z - last).powi(2)).max(0.04 * cell.x.powi(2)).sqrt();
                }
                last = z;
                let sag = 0.05 * s * s / self.size.x;
                positions[(i * (rows + 1) + j) as usize] = Vec3::new(x, y - sag, z);
            }
        }
        positions
    }

    fn height(&self, s: f32, y: f32, seconds: f32) -> f32 {
        let along = s / self.size.x;
        let run = TAU * (1.5 * along - 0.9 * seconds);
        let swell = self.amplitude * along.powf(0.8) * (1.0 - 0.25 * along);
        swell * ((run + 0.9 * y).sin() + 0.25 * (1.9 * run - 1.6 * y).sin())
    }
}
