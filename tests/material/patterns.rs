//! Patterns made by hand: surfaces with a field and phases, written into the shared buffers.

use bevy::{asset::RenderAssetUsages, mesh::PrimitiveTopology, prelude::*, render::storage::ShaderBuffer};
use bevy_field_patterns::{
    field::Symmetry,
    surface::NO_TRIANGLE,
    wave::{
        Waves,
        kite::{cmul, edge_phase, phasor, reversed},
        layout::{FLAG_CROSS, FLAG_READY, FLAG_VECTOR, GEOMETRY_BUFFER, PatternRecord, SURFACE_BUFFER, WAVE_BUFFER},
        shade::PatternMemory,
    },
};
use std::f32::consts::{PI, TAU};

const RECORD_WORDS: usize = size_of::<PatternRecord>() / 4;

/// A surface with a wave on it, given per vertex.
#[derive(Clone)]
pub struct Pattern {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
    pub directions: Vec<Vec3>,
    pub frequencies: Vec<f32>,
    pub z: Vec<Vec2>,
    pub symmetry: Symmetry,
    /// Two waves are there: those of vertex v are `z[2 v]` and `z[2 v + 1]`.
    pub pair: Option<Waves>,
    /// Two scalars per vertex, or nothing.
    pub scalars: Vec<Vec2>,
}

impl Pattern {
    /// A square of `size` in the plane z = 0 with `cells` squared cells, and exact phases of a constant field.
    pub fn plane(size: f32, cells: u32, direction: Vec3, frequency: f32) -> Self {
        let n = cells + 1;
        let points = (0..n * n).map(|k| {
            Vec3::new(
                (k % n) as f32 / cells as f32 - 0.5,
                (k / n) as f32 / cells as f32 - 0.5,
                0.0,
            ) * size
        });
        let positions: Vec<Vec3> = points.collect();
        let triangles = (0..cells * cells)
            .flat_map(|k| {
                let at = k / cells * n + k % cells;
                [[at, at + 1, at + n], [at + 1, at + n + 1, at + n]]
            })
            .collect();
        Self {
            normals: vec![Vec3::Z; positions.len()],
            directions: vec![direction; positions.len()],
            frequencies: vec![frequency; positions.len()],
            z: positions.iter().map(|p| phasor(frequency * p.dot(direction))).collect(),
            positions,
            triangles,
            symmetry: Symmetry::Vector,
            pair: None,
            scalars: vec![],
        }
    }

    /// A square of size 2 with two waves along x and y, exact; vertex v's frame is turned by `turns(v)` quarter turns.
    pub fn woven(frequency: f32, waves: Waves, turns: impl Fn(usize) -> usize) -> Self {
        let mut plane = Self::plane(2.0, 8, Vec3::X, frequency);
        plane.z = (0..plane.positions.len())
            .flat_map(|v| {
                let p = plane.positions[v];
                let mut frame = [Vec3::X, Vec3::Y];
                let mut z = [phasor(frequency * p.x), phasor(frequency * waves.ratio() * p.y)];
                for _ in 0..turns(v) {
                    frame = [frame[1], -frame[0]];
                    z = [z[1], reversed(z[0])];
                }
                plane.directions[v] = frame[0];
                z
            })
            .collect();
        plane.pair = Some(waves);
        plane
    }

    /// A square of side 2 bent to a part of a cylinder of radius 1 about the y axis, with `cells` squared jittered cells and
    /// two exact waves along `angle` and across it, of `frequency` and `ratio` times that. In the bent square's own
    /// coordinates, `flat`, phases are 0 at the origin; the first scalar is `scalar` there.
    pub fn bent(cells: u32, angle: f32, frequency: f32, ratio: f32, scalar: impl Fn(Vec2) -> f32) -> (Self, Vec<Vec2>) {
        let mut pattern = Self::plane(2.0, cells, Vec3::X, frequency);
        let mut seed = 7_u32;
        let mut random = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        let inside = |x: f32| x.abs() < 0.999;
        let jitter = 1.0 / cells as f32;
        let flat: Vec<Vec2> = pattern
            .positions
            .iter()
            .map(|p| {
                let moved = jitter * Vec2::new(random(), random());
                p.truncate() + Vec2::new(f32::from(inside(p.x)), f32::from(inside(p.y))) * moved
            })
            .collect();
        let along = Vec2::from_angle(angle);
        pattern.positions = flat.iter().map(|p| Vec3::new(p.x.sin(), p.y, p.x.cos())).collect();
        pattern.normals = flat.iter().map(|p| Vec3::new(p.x.sin(), 0.0, p.x.cos())).collect();
        let tangent = |p: &Vec2| Vec3::new(along.x * p.x.cos(), along.y, -along.x * p.x.sin());
        pattern.directions = flat.iter().map(tangent).collect();
        let phases = |p: &Vec2| [along.dot(*p), ratio * along.perp().dot(*p)].map(|x| phasor(frequency * x));
        pattern.z = flat.iter().flat_map(phases).collect();
        pattern.pair = Some(Waves::Orthogonal { ratio });
        pattern.scalars = flat.iter().map(|&p| Vec2::new(scalar(p), 0.0)).collect();
        (pattern, flat)
    }

    /// The triangle across each edge, by comparing all with all that share a vertex.
    fn triangles_across(&self) -> Vec<[u32; 3]> {
        let mut edges = std::collections::HashMap::<[u32; 2], Vec<u32>>::new();
        let ends = |t: &[u32; 3], c: usize| {
            let (a, b) = (t[c], t[(c + 1) % 3]);
            [a.min(b), a.max(b)]
        };
        for (k, t) in (0..).zip(&self.triangles) {
            (0..3).for_each(|c| edges.entry(ends(t, c)).or_default().push(k));
        }
        let across = |k: u32, t: &[u32; 3], c: usize| match edges[&ends(t, c)][..] {
            [a, b] => a + b - k,
            _ => NO_TRIANGLE,
        };
        let all = (0..).zip(&self.triangles);
        all.map(|(k, t)| [0, 1, 2].map(|c| across(k, t, c))).collect()
    }

    /// Adds a second wave along n × d, of any phases; on a cross field the frames are turned by any quarter turns.
    pub fn with_second_wave(mut self, waves: Waves) -> Self {
        self.z = (0..self.positions.len())
            .flat_map(|v| {
                let (p, n) = (self.positions[v], self.normals[v]);
                let mut frame = [self.directions[v], n.cross(self.directions[v])];
                let mut z = [self.z[v], phasor(self.frequencies[v] * waves.ratio() * p.x)];
                for _ in 0..if waves == Waves::Cross { v * 7 % 4 } else { 0 } {
                    frame = [frame[1], -frame[0]];
                    z = [z[1], reversed(z[0])];
                }
                self.directions[v] = frame[0];
                z
            })
            .collect();
        self.pair = Some(waves);
        self
    }

    /// Adds a second wave along n × d, `ratio` times as frequent, relaxed as the first one is.
    pub fn with_relaxed_second_wave(mut self, ratio: f32) -> Self {
        let vertices = || self.normals.iter().zip(&self.directions);
        let directions: Vec<Vec3> = vertices().map(|(n, d)| n.cross(*d)).collect();
        let frequencies: Vec<f32> = self.frequencies.iter().map(|f| ratio * f).collect();
        let mut second = Self {
            z: vec![Vec2::X; directions.len()],
            directions,
            frequencies,
            ..self.clone()
        };
        second.relax(300);
        self.z = self
            .z
            .iter()
            .zip(&second.z)
            .flat_map(|(&one, &two)| [one, two])
            .collect();
        self.pair = Some(Waves::Orthogonal { ratio });
        self
    }

    /// A torus of radii 1 and `minor`, jittered, with the field of an axis; `d` has random signs on a line field.
    /// Phases are relaxed by some sweeps from a guess, which leaves branches.
    pub fn torus(minor: f32, jitter: f32, axis: Vec3, frequency: f32, symmetry: Symmetry) -> Self {
        let (rings, sides) = (96, 48);
        let mut seed = 1_u32;
        let mut random = move || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 8) as f32 / (1 << 24) as f32
        };
        let mut pattern = Self {
            positions: vec![],
            normals: vec![],
            triangles: vec![],
            directions: vec![],
            frequencies: vec![],
            z: vec![],
            symmetry,
            pair: None,
            scalars: vec![],
        };
        for i in 0..rings {
            for j in 0..sides {
                let u = (i as f32 + jitter * (random() - 0.5)) / rings as f32 * TAU;
                let v = (j as f32 + jitter * (random() - 0.5)) / sides as f32 * TAU;
                let radial = Vec3::new(u.cos(), 0.0, u.sin());
                let normal = radial * v.cos() + Vec3::Y * v.sin();
                let p = radial + minor * normal;
                let d = axis.reject_from(normal).normalize_or(Vec3::X);
                // Drawn for both symmetries, so that both have the same vertices.
                let turned = (random() < 0.3) && symmetry == Symmetry::Line;
                let z = phasor(frequency * p.dot(axis));
                pattern.positions.push(p);
                pattern.normals.push(normal);
                pattern.directions.push(if turned { -d } else { d });
                pattern.frequencies.push(frequency);
                pattern.z.push(if turned { reversed(z) } else { z });
                let at = |i: u32, j: u32| (i % rings) * sides + j % sides;
                pattern.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                pattern.triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
            }
        }
        pattern.relax(30);
        pattern
    }

    /// A ball of radius 1, of rings from pole to pole, with the field of an axis; its phases are exact.
    pub fn ball(rings: u32, axis: Vec3, frequency: f32) -> Self {
        let sides = 2 * rings;
        let mut ball = Self {
            positions: vec![],
            triangles: vec![],
            ..Self::plane(1.0, 1, axis, frequency)
        };
        for i in 0..=rings {
            for j in 0..sides {
                let (u, v) = (i as f32 / rings as f32 * PI, j as f32 / sides as f32 * TAU);
                ball.positions
                    .push(Vec3::new(u.sin() * v.cos(), u.cos(), u.sin() * v.sin()));
            }
        }
        for (i, j) in (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j))) {
            let at = |i: u32, j: u32| i * sides + j % sides;
            let quad = [at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)];
            ball.triangles.push([quad[0], quad[1], quad[2]]);
            ball.triangles.push([quad[2], quad[1], quad[3]]);
        }
        ball.triangles.retain(|t| {
            let [a, b, c] = t.map(|v| ball.positions[v as usize]);
            (b - a).cross(c - a).length() > 1e-8
        });
        ball.normals = ball.positions.clone();
        ball.directions = ball
            .normals
            .iter()
            .map(|n| axis.reject_from(*n).normalize_or(Vec3::X))
            .collect();
        ball.frequencies = vec![frequency; ball.positions.len()];
        // Along a meridian the axis's coordinate is the sine of the latitude, and the length is the latitude.
        ball.z = ball
            .positions
            .iter()
            .map(|p| phasor(frequency * p.dot(axis).clamp(-1.0, 1.0).asin()))
            .collect();
        ball
    }

    /// Sweeps of block descent: every phasor becomes the mean of what its neighbours predict.
    fn relax(&mut self, sweeps: usize) {
        let mut neighbors = vec![vec![]; self.positions.len()];
        for t in &self.triangles {
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let (i, j) = (t[a] as usize, t[b] as usize);
                neighbors[i].push(j);
                neighbors[j].push(i);
            }
        }
        for _ in 0..sweeps {
            for (i, around) in neighbors.iter().enumerate() {
                let sum: Vec2 = around.iter().map(|&j| self.prediction(i, j)).sum();
                self.z[i] = sum.normalize_or(self.z[i]);
            }
        }
    }

    fn prediction(&self, i: usize, j: usize) -> Vec2 {
        let e = self.positions[i] - self.positions[j];
        let edge = edge_phase(e, self.directions[j], self.directions[i], self.symmetry);
        let f = 0.5 * (self.frequencies[i] + self.frequencies[j]);
        let z = edge.weight * cmul(self.z[j], phasor(f * edge.distance));
        if edge.flip { reversed(z) } else { z }
    }

    fn corners<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.triangles.iter().flatten().map(|&v| values[v as usize]).collect()
    }

    /// The mesh drawn: without indices, in the order of the triangles.
    pub fn mesh(&self) -> Mesh {
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.corners(&self.positions))
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.corners(&self.normals))
    }
}

/// The contents of the shared buffers.
#[derive(Default)]
pub struct Memory {
    surface: Vec<u32>,
    geometry: Vec<Vec4>,
    wave: Vec<Vec2>,
}

impl Memory {
    pub fn new() -> Self {
        Self {
            surface: vec![0; RECORD_WORDS],
            ..default()
        }
    }

    /// Writes a pattern and returns its tag.
    pub fn push(&mut self, pattern: &Pattern) -> u32 {
        let count = pattern.positions.len() as u32;
        let tag = self.surface.len() as u32;
        let triangle_base = tag + RECORD_WORDS as u32;
        let class_base = triangle_base + 6 * pattern.triangles.len() as u32;
        let vector = if pattern.symmetry == Symmetry::Vector {
            FLAG_VECTOR
        } else {
            0
        };
        let cross = if pattern.pair == Some(Waves::Cross) {
            FLAG_CROSS
        } else {
            0
        };
        let record = PatternRecord {
            vertices: count,
            triangles: pattern.triangles.len() as u32,
            flags: FLAG_READY | vector | cross,
            waves: pattern.pair.unwrap_or_default().count() as u32,
            ratio: pattern.pair.unwrap_or_default().ratio(),
            triangle_base,
            geometry_base: self.geometry.len() as u32,
            field_base: self.wave.len() as u32,
            phasor_base: self.wave.len() as u32 + 2 * count,
            class_base,
            colors: 3,
            scalar_base: match pattern.scalars.len() {
                0 => 0,
                _ => (self.wave.len() + pattern.z.len()) as u32 + 2 * count,
            },
            ..default()
        };
        self.surface.extend_from_slice(bytemuck::cast_slice(&[record]));
        self.surface.extend(pattern.triangles.iter().flatten());
        self.surface.extend(pattern.triangles_across().iter().flatten());
        self.surface.extend([0, count / 3, 2 * count / 3, count]);
        for v in 0..pattern.positions.len() {
            self.geometry
                .extend([pattern.positions[v].extend(0.0), pattern.normals[v].extend(0.0)]);
            let d = pattern.directions[v];
            self.wave.extend([d.truncate(), Vec2::new(d.z, pattern.frequencies[v])]);
        }
        self.wave.extend(&pattern.z);
        self.wave.extend(&pattern.scalars);
        tag
    }

    pub fn view(&self) -> PatternMemory<'_> {
        PatternMemory {
            surface: &self.surface,
            geometry: &self.geometry,
            wave: &self.wave,
        }
    }

    /// Sends the contents to the GPU.
    pub fn upload(&self, app: &mut App) {
        let parts: [(Handle<ShaderBuffer>, &[u8]); 3] = [
            (SURFACE_BUFFER, bytemuck::cast_slice(&self.surface)),
            (GEOMETRY_BUFFER, bytemuck::cast_slice(&self.geometry)),
            (WAVE_BUFFER, bytemuck::cast_slice(&self.wave)),
        ];
        for (handle, bytes) in parts {
            let buffer = ShaderBuffer::new(bytes, RenderAssetUsages::default());
            app.world_mut()
                .resource_mut::<Assets<ShaderBuffer>>()
                .insert(handle.id(), buffer)
                .unwrap();
        }
    }
}
