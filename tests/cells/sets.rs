//! Sample sets made by hand: jittered, relaxed points with labels and neighbours found by looking at all of them.

use bevy::prelude::*;
use bevy_field_patterns::sampling::SampleSet;
use glam_matrix_extras::SymmetricMat3;

use crate::{mesh_file::RawMesh, shapes};

/// Numbers from 0 to 1.
pub struct Random(pub u32);

impl Random {
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }
}

/// A metric from the ellipse's long axis, its normal and its two radii.
pub fn ellipse(long: Vec3, normal: Vec3, r1: f32, r2: f32) -> SymmetricMat3 {
    let outer = |v: Vec3, r: f32| SymmetricMat3::from_outer_product(v) * (1.0 / (r * r));
    outer(long, r1) + outer(normal.cross(long), r2) + outer(normal, (r1 * r2).sqrt())
}

/// The sample nearest to a point in its own metric, of all.
pub fn nearest(set: &SampleSet, point: Vec3) -> usize {
    let distance = |i: &usize| set.distance_squared(*i, point);
    (0..set.len())
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap()
}

/// A field of metrics over the square [-1, 1]².
pub type Field = fn(Vec2) -> (Vec2, f32);

/// Long axis and ratio: round, constant 1:4, and a vortex from 1:1 in the middle to 1:10 at the border.
pub const FIELDS: [(&str, Field); 3] = [
    ("round", |_| (Vec2::X, 1.0)),
    ("ratio 4", |_| (Vec2::from_angle(0.5), 4.0)),
    ("vortex 10", |p| {
        (p.perp().normalize_or(Vec2::X), 1.0 + 9.0 * p.length().min(1.0))
    }),
];

/// Points of the square, relaxed to the middles of their cells, with the neighbours of a fine raster. No seeds yet.
pub fn planar(count: usize, field: Field, raster: usize, steps: usize, seed: u32) -> SampleSet {
    let mut random = Random(seed);
    let size = (4.0 / count as f32 / 12_f32.sqrt()).sqrt();
    let metric = |p: Vec3| {
        let (long, ratio) = field(p.truncate());
        ellipse(long.extend(0.0), Vec3::Z, size * ratio.sqrt(), size / ratio.sqrt())
    };
    let positions: Vec<Vec3> = (0..count)
        .map(|_| Vec3::new(2.0 * random.unit() - 1.0, 2.0 * random.unit() - 1.0, 0.0))
        .collect();
    let mut set = SampleSet {
        normals: vec![Vec3::Z; count],
        metrics: positions.iter().map(|&p| metric(p)).collect(),
        positions,
        ..default()
    };
    let at = |k: usize| {
        let place = |n: usize| (n as f32 + 0.5) / raster as f32 * 2.0 - 1.0;
        Vec3::new(place(k % raster), place(k / raster), 0.0)
    };
    let labels = |set: &SampleSet| (0..raster * raster).map(|k| nearest(set, at(k))).collect::<Vec<_>>();
    for _ in 0..steps {
        let mut sums = vec![(Vec3::ZERO, 0.0); count];
        for (k, &label) in labels(&set).iter().enumerate() {
            sums[label].0 += at(k);
            sums[label].1 += 1.0;
        }
        for (i, (sum, n)) in sums.into_iter().enumerate() {
            if n > 0.0 {
                set.positions[i] = sum / n;
                set.metrics[i] = metric(set.positions[i]);
            }
        }
    }
    let labels = labels(&set);
    let steps = |k: usize| [1, raster, raster + 1].map(|step| (labels[k], labels.get(k + step)));
    let pairs = (0..raster * raster)
        .filter(|k| (k + 1) % raster != 0)
        .flat_map(steps)
        .filter_map(|(a, b)| b.map(|&b| (a, b)));
    connect(&mut set, pairs.collect());
    set
}

/// Makes a set's neighbour lists of pairs.
fn connect(set: &mut SampleSet, mut pairs: Vec<(usize, usize)>) {
    pairs.extend(pairs.clone().iter().map(|&(a, b)| (b, a)));
    pairs.retain(|(a, b)| a != b);
    pairs.sort_unstable();
    pairs.dedup();
    set.neighbor_offsets = (0..=set.len())
        .map(|i| pairs.partition_point(|pair| pair.0 < i) as u32)
        .collect();
    set.neighbors = pairs.into_iter().map(|pair| pair.1 as u32).collect();
}

/// Gives a set the seeds of a mesh.
pub fn seed(set: &mut SampleSet, positions: &[Vec3], triangles: &[[u32; 3]]) {
    let labels: Vec<u32> = positions.iter().map(|&p| nearest(set, p) as u32).collect();
    set.seeds = triangles.iter().map(|t| t.map(|v| labels[v as usize])).collect();
}

/// A planar set with the seeds of a grid mesh of `cells`² squares over the square, and that mesh.
pub fn on_square(count: usize, field: Field, cells: usize) -> (SampleSet, RawMesh) {
    let mesh = shapes::plane(cells, 0.2, 7);
    let mut set = planar(count, field, 260, 4, 11);
    seed(&mut set, &mesh.positions, &mesh.triangles);
    (set, mesh)
}

/// Samples on a torus about z with ellipses of 1 to 4 along its rings, and its mesh.
pub fn on_torus(count: usize, seed_of_random: u32) -> (SampleSet, RawMesh) {
    let (major, minor) = (1.0, 0.45);
    let mesh = shapes::torus(120, 60, major, minor, 0.2, 3);
    let ring = |p: Vec3| Vec3::new(p.x, p.y, 0.0).normalize();
    let normal = |p: Vec3| (p - major * ring(p)).normalize();
    let area = 4.0 * std::f32::consts::PI.powi(2) * major * minor;
    let size = (area / count as f32 / 12_f32.sqrt()).sqrt();
    let metric = |p: Vec3| ellipse(Vec3::Z.cross(ring(p)), normal(p), 2.0 * size, 0.5 * size);
    let mut random = Random(seed_of_random);
    // Best candidates: the vertex that is farthest from all samples so far.
    let mut chosen: Vec<usize> = vec![];
    while chosen.len() < count {
        let candidates: Vec<usize> = (0..12)
            .map(|_| (random.unit() * mesh.positions.len() as f32) as usize)
            .collect();
        let distance = |&v: &usize| {
            let to = |&c: &usize| {
                let r = mesh.positions[c] - mesh.positions[v];
                r.dot(metric(mesh.positions[c]) * r)
            };
            chosen.iter().map(to).fold(f32::MAX, f32::min)
        };
        chosen.extend(
            candidates
                .into_iter()
                .max_by(|a, b| distance(a).total_cmp(&distance(b))),
        );
    }
    let positions: Vec<Vec3> = chosen.iter().map(|&v| mesh.positions[v]).collect();
    let mut set = SampleSet {
        normals: positions.iter().map(|&p| normal(p)).collect(),
        metrics: positions.iter().map(|&p| metric(p)).collect(),
        positions,
        ..default()
    };
    seed(&mut set, &mesh.positions, &mesh.triangles);
    let pairs = set
        .seeds
        .iter()
        .flat_map(|s| [(s[0], s[1]), (s[1], s[2]), (s[2], s[0])]);
    let pairs = pairs.map(|(a, b)| (a as usize, b as usize)).collect();
    connect(&mut set, pairs);
    (set, mesh)
}

/// A planar set whose seeds are its own Delaunay triangles; round samples.
pub fn triangulated(count: usize, seed: u32) -> SampleSet {
    use spade::{DelaunayTriangulation, Point2, Triangulation};
    let mut set = planar(count, FIELDS[0].1, 200, 4, seed);
    // Corners, so that the triangles cover the square.
    for (i, corner) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)]
        .into_iter()
        .enumerate()
    {
        set.positions[i] = Vec3::new(corner.0, corner.1, 0.0);
    }
    let points = set.positions.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let triangulation = DelaunayTriangulation::<Point2<f32>>::bulk_load_stable(points).unwrap();
    set.seeds = triangulation
        .inner_faces()
        .map(|face| face.vertices().map(|v| v.index() as u32))
        .collect();
    let pairs = set
        .seeds
        .iter()
        .flat_map(|s| [(s[0], s[1]), (s[1], s[2]), (s[2], s[0])]);
    let pairs = pairs.map(|(a, b)| (a as usize, b as usize)).collect();
    connect(&mut set, pairs);
    set
}
