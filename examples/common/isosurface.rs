//! The surface of a solid as an even triangle mesh.
//!
//! In: a signed distance ([`implicit`](super::implicit)), the box it lies in, the length of an edge. Out: a [`RawMesh`],
//! welded, facing outwards, its vertices on the surface. Surface nets on a grid give the connectivity; then vertices
//! are moved to the middle of their neighbours and back onto the surface while edges are flipped to the shorter diagonal,
//! until triangles are nearly equilateral. Where the box cuts the solid the mesh has a border in the face of the box.

use bevy::prelude::*;
use fast_surface_nets::{
    SurfaceNetsBuffer,
    ndshape::{RuntimeShape, Shape},
    surface_nets,
};
use std::collections::HashSet;

use super::{implicit::gradient, mesh_file::RawMesh};

/// How often vertices are moved and edges flipped.
const ROUNDS: usize = 10;

/// Grid points along the side of a block that is left out when it is empty.
const BLOCK: u32 = 8;

/// How much faster than the way a point moves a distance may change.
const STEEPEST: f32 = 1.6;

/// A face of the box, as normal and offset.
type Face = (Vec3, f32);

/// Meshes the solid where `distance` is negative, between the corners `min` and `max`, with edges about `edge` long.
pub fn mesh(distance: impl Fn(Vec3) -> f32, min: Vec3, max: Vec3, edge: f32) -> RawMesh {
    let mut mesh = nets(&distance, min, max, edge);
    let faces = cut_faces(&mesh, min, max);
    for round in 1..=ROUNDS {
        flip_edges(&mut mesh);
        relax(&mut mesh, &faces);
        let steps = if round == ROUNDS { 3 } else { 1 };
        for (p, face) in mesh.positions.iter_mut().zip(&faces) {
            *p = land(&distance, *p, face.unwrap_or_default(), edge, steps);
        }
    }
    flip_edges(&mut mesh);
    mesh
}

/// The surface next to a point, by Newton's method; within a face of the box if there is one.
fn land(distance: &impl Fn(Vec3) -> f32, p: Vec3, (normal, offset): Face, edge: f32, steps: usize) -> Vec3 {
    let from = p + normal * (offset - normal.dot(p));
    (0..steps).fold(from, |p, _| {
        let slope = gradient(distance, p, 0.1 * edge);
        let slope = slope - normal * normal.dot(slope);
        p - slope * (distance(p) / slope.length_squared().max(0.1)).clamp(-edge, edge)
    })
}

/// Surface nets: one vertex per cell of the grid that the surface passes through.
fn nets(distance: &impl Fn(Vec3) -> f32, min: Vec3, max: Vec3, edge: f32) -> RawMesh {
    let points = ((max - min) / edge).ceil().as_uvec3() + 1;
    let cell = (max - min) / (points - 1).as_vec3();
    let at = |point: UVec3| min + cell * point.as_vec3();
    let shape = RuntimeShape::<u32, 3>::new(points.to_array());
    let mut values = vec![0.0; shape.usize()];
    let blocks = (points + (BLOCK - 1)) / BLOCK;
    for block in cells(blocks) {
        let first = block * BLOCK;
        let last = (first + (BLOCK - 1)).min(points - 1);
        let middle = distance(at(first).midpoint(at(last)));
        let empty = middle.abs() > 0.5 * STEEPEST * at(first).distance(at(last));
        for point in cells(last - first + 1) {
            let point = first + point;
            values[shape.linearize(point.to_array()) as usize] = if empty { middle } else { distance(at(point)) };
        }
    }
    part_crossings(&mut values, points);
    let mut buffer = SurfaceNetsBuffer::default();
    surface_nets(&values, &shape, [0; 3], (points - 1).to_array(), &mut buffer);
    RawMesh {
        positions: buffer
            .positions
            .iter()
            .map(|p| min + cell * Vec3::from_array(*p))
            .collect(),
        triangles: buffer.indices.as_chunks().0.to_vec(),
    }
}

/// Fills points of the grid until no cell, and no side of one, has opposite corners inside and all others outside, or the
/// reverse: there two parts of the surface would share an edge or a vertex.
fn part_crossings(values: &mut [f32], points: UVec3) {
    let index = |point: UVec3| (point.x + points.x * (point.y + points.y * point.z)) as usize;
    let [x, y, z] = [UVec3::X, UVec3::Y, UVec3::Z].map(index);
    let mut filled = true;
    while filled {
        filled = false;
        for cell in cells(points - 1) {
            let corners = [0, x, y, x + y, z, x + z, y + z, x + y + z].map(|corner| index(cell) + corner);
            let inside = corners.iter().filter(|&&corner| values[corner] < 0.0).count();
            if inside == 0 || inside == 8 {
                continue;
            }
            for [a, b] in [[[0, 3], [1, 2]], [[0, 6], [2, 4]], [[0, 5], [1, 4]]] {
                let [a, b] = [a, b].map(|diagonal| diagonal.map(|i| corners[i]));
                filled |= fill(values, &a, &b) || fill(values, &b, &a);
            }
            for opposite in [[0, 7], [1, 6], [2, 5], [3, 4]] {
                let pair = opposite.map(|i| corners[i]);
                let others: Vec<usize> = corners.into_iter().filter(|corner| !pair.contains(corner)).collect();
                filled |= fill(values, &pair, &others) || fill(values, &others, &pair);
            }
        }
    }
}

/// Where all of `inside` are inside and all of `outside` are not, fills the one that is nearest to the surface.
fn fill(values: &mut [f32], inside: &[usize], outside: &[usize]) -> bool {
    let crossed = inside.iter().all(|&i| values[i] < 0.0) && outside.iter().all(|&i| values[i] >= 0.0);
    let nearest = outside.iter().copied().min_by(|&a, &b| values[a].total_cmp(&values[b]));
    if let Some(nearest) = nearest.filter(|_| crossed) {
        values[nearest] = -f32::MIN_POSITIVE;
    }
    crossed
}

fn cells(size: UVec3) -> impl Iterator<Item = UVec3> {
    (0..size.z).flat_map(move |z| (0..size.y).flat_map(move |y| (0..size.x).map(move |x| UVec3::new(x, y, z))))
}

/// The face of the box that each vertex of a border belongs to.
fn cut_faces(mesh: &RawMesh, min: Vec3, max: Vec3) -> Vec<Option<Face>> {
    let mut faces = vec![None; mesh.positions.len()];
    let sides = sides(mesh);
    for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let [(a, b, _)] = *run {
            for vertex in [a, b] {
                let p = mesh.positions[vertex as usize];
                let candidates = Vec3::AXES
                    .into_iter()
                    .flat_map(|axis| [(axis, axis.dot(min)), (axis, axis.dot(max))]);
                faces[vertex as usize] =
                    candidates.min_by(|a, b| (a.0.dot(p) - a.1).abs().total_cmp(&(b.0.dot(p) - b.1).abs()));
            }
        }
    }
    faces
}

/// Each side of each triangle: lower vertex, higher vertex, triangle; sorted.
fn sides(mesh: &RawMesh) -> Vec<(u32, u32, u32)> {
    let mut sides: Vec<_> = (0..)
        .zip(&mesh.triangles)
        .flat_map(|(triangle, &[a, b, c])| [(a, b), (b, c), (c, a)].map(|(a, b)| (a.min(b), a.max(b), triangle)))
        .collect();
    sides.sort_unstable();
    sides
}

/// Moves vertices towards the middle of their neighbours; those of a border along the border.
fn relax(mesh: &mut RawMesh, faces: &[Option<Face>]) {
    const STEP: f32 = 0.6;
    let mut sums = vec![(Vec3::ZERO, 0.0); mesh.positions.len()];
    for &[a, b, c] in &mesh.triangles {
        for (vertex, neighbour) in [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)] {
            if faces[vertex as usize].is_none() || faces[neighbour as usize].is_some() {
                let sum = &mut sums[vertex as usize];
                sum.0 += mesh.positions[neighbour as usize];
                sum.1 += 1.0;
            }
        }
    }
    for (p, (sum, count)) in mesh.positions.iter_mut().zip(sums) {
        if count > 0.0 {
            *p = p.lerp(sum / count, STEP);
        }
    }
}

/// Flips the edges whose opposite angles make more than 180 degrees together.
fn flip_edges(mesh: &mut RawMesh) {
    let sides = sides(mesh);
    let exists = |a: u32, b: u32| {
        sides
            .binary_search_by(|side| (side.0, side.1).cmp(&(a.min(b), a.max(b))))
            .is_ok()
    };
    let mut touched = vec![false; mesh.triangles.len()];
    let mut made = HashSet::new();
    for &[(a, b, s), (c, d, t)] in sides.array_windows() {
        let (s, t) = (s as usize, t as usize);
        if (a, b) != (c, d) || touched[s] || touched[t] {
            continue;
        }
        let Some((a, b, p, q)) = diamond(mesh.triangles[s], mesh.triangles[t], a, b) else {
            continue;
        };
        if !exists(p, q) && !made.contains(&(p.min(q), p.max(q))) && should_flip(mesh, a, b, p, q) {
            mesh.triangles[s] = [a, q, p];
            mesh.triangles[t] = [b, p, q];
            (touched[s], touched[t]) = (true, true);
            made.insert((p.min(q), p.max(q)));
        }
    }
}

/// The edge a → b as the first of two triangles has it, then their other corners.
fn diamond(first: [u32; 3], second: [u32; 3], a: u32, b: u32) -> Option<(u32, u32, u32, u32)> {
    let other = |triangle: [u32; 3]| triangle.into_iter().find(|&v| v != a && v != b);
    let (p, q) = (other(first)?, other(second)?);
    let forward = [(0, 1), (1, 2), (2, 0)]
        .iter()
        .any(|&(i, j)| (first[i], first[j]) == (a, b));
    (p != q).then_some(if forward { (a, b, p, q) } else { (b, a, p, q) })
}

fn should_flip(mesh: &RawMesh, a: u32, b: u32, p: u32, q: u32) -> bool {
    let [a, b, p, q] = [a, b, p, q].map(|vertex| mesh.positions[vertex as usize]);
    let cotangent = |at: Vec3| {
        let (u, v) = (a - at, b - at);
        u.dot(v) / u.cross(v).length().max(f32::MIN_POSITIVE)
    };
    let normal = |a: Vec3, b: Vec3, c: Vec3| (b - a).cross(c - a).normalize_or_zero();
    let mean = normal(a, b, p) + normal(b, a, q);
    cotangent(p) + cotangent(q) < -1e-3
        && mean.length_squared() > 2.0
        && normal(a, q, p).dot(mean) > 0.5
        && normal(b, p, q).dot(mean) > 0.5
}
