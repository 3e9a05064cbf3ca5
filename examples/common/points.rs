//! Points on a surface, as a scanner would see them.
//!
//! In: a mesh, a number of points, their noise, a seed. Out: positions with the normals of the triangles they come from,
//! spread evenly by area.

use bevy::{asset::RenderAssetUsages, mesh::PrimitiveTopology, prelude::*};

use super::{mesh_file::RawMesh, shapes::Random};

/// A point and the unit normal of the surface near it.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub position: Vec3,
    pub normal: Vec3,
}

/// `count` points on the triangles of `mesh`, moved by normally distributed `noise` (its deviation, in units of length)
/// in any direction.
pub fn scan(mesh: &RawMesh, count: usize, noise: f32, seed: u64) -> Vec<Point> {
    let mut random = Random(seed);
    let corners = |triangle: &[u32; 3]| triangle.map(|vertex| mesh.positions[vertex as usize]);
    let mut area = 0.0;
    let upto: Vec<f32> = mesh
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = corners(triangle);
            area += 0.5 * (b - a).cross(c - a).length();
            area
        })
        .collect();
    if area <= 0.0 {
        return Vec::new();
    }
    (0..count)
        .map(|i| {
            // One point per equal share of the area.
            let at = area * (i as f32 + random.unit()) / count as f32;
            let triangle = upto.partition_point(|&area| area < at).min(upto.len() - 1);
            let [a, b, c] = corners(&mesh.triangles[triangle]);
            let (s, t) = (random.unit().sqrt(), random.unit());
            let on_surface = a * (1.0 - s) + s * ((1.0 - t) * b + t * c);
            let shift = Vec3::new(random.normal(), random.normal(), random.normal());
            Point {
                position: on_surface + noise * shift,
                normal: (b - a).cross(c - a).normalize_or(Vec3::Y),
            }
        })
        .collect()
}

/// The points alone, as a scanner gives them: without normals.
pub fn to_bevy_mesh(cloud: &[Point]) -> Mesh {
    let positions: Vec<Vec3> = cloud.iter().map(|point| point.position).collect();
    Mesh::new(PrimitiveTopology::PointList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
}
