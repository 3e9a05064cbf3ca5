//! Metrics from scalars: long axes along the contour lines, small samples where much happens.
//!
//! In: scalars on a surface, the colours of an image, or a volume. Out: metrics. The structure tensor T = Σ ∇φ ∇φᵀ, a
//! mean over a neighbourhood, knows the direction of edges without a sign: its largest eigenvalue belongs to the
//! direction across them. With an energy t = tr T / (tr T + 0.3 mean tr T) in 0..1, and for each eigenvalue the coherence
//! c = (λₘₐₓ - λ) / (λₘₐₓ + λ), the semi-axes are (1 + (ratio - 1) c t) in proportion, of mean length 1 / (1 + detail t).

use super::{
    eigen::{SymmetricEigen2, SymmetricEigen3},
    tensor::{ellipse, on_plane},
};
use crate::{
    field::{any_tangent, project_tangent},
    parallel,
    surface::SurfaceGraph,
};
use bevy::{
    math::{DVec2, DVec3},
    prelude::*,
};
use glam_matrix_extras::{SymmetricDMat2, SymmetricDMat3, SymmetricMat3};

/// How scalars become ellipses. Below, those of an image of rings around its lower left corner.
///
#[doc = include_str!("../../../docs/images/metric_scalars.svg")]
#[derive(Reflect, Debug, Clone, Copy, PartialEq)]
#[reflect(Default, Clone, PartialEq)]
pub struct Structure {
    /// Ratio of the axes where edges are clearest, 1 or more. Default 4.
    pub ratio: f32,
    /// How much smaller samples are where much happens: their axes are divided by up to 1 + detail. 0 or more, default 1.
    pub detail: f32,
    /// Reach of the mean: in pixels of an image or voxels of a volume, in edges on a surface. Default 4.
    pub reach: f32,
}

impl Default for Structure {
    fn default() -> Self {
        Self {
            ratio: 4.0,
            detail: 1.0,
            reach: 4.0,
        }
    }
}

/// Share of the mean energy at which a neighbourhood counts for half.
const QUIET: f64 = 0.3;

impl Structure {
    /// t, the energy relative to the mean one, 0..1.
    fn energy(trace: f64, mean: f64) -> f64 {
        let sum = trace + QUIET * mean;
        if sum > 0.0 { trace / sum } else { 0.0 }
    }

    /// The unscaled semi-axis of an eigenvalue.
    fn axis(&self, value: f64, largest: f64, energy: f64) -> f64 {
        let sum = largest + value;
        let coherence = if sum > 0.0 {
            ((largest - value) / sum).clamp(0.0, 1.0)
        } else {
            0.0
        };
        1.0 + (f64::from(self.ratio).max(1.0) - 1.0) * coherence * energy
    }

    /// The mean semi-axis.
    fn size(&self, energy: f64) -> f64 {
        1.0 / (1.0 + f64::from(self.detail).max(0.0) * energy)
    }

    /// The semi-axes along the eigenvectors of a planar tensor, and the eigenvectors' first.
    fn semi_axes(&self, tensor: &SymmetricDMat2, mean: f64) -> (DVec2, DVec2) {
        let eigen = SymmetricEigen2::new(tensor);
        let energy = Self::energy(tensor.m00 + tensor.m11, mean);
        let axes = eigen
            .values
            .to_array()
            .map(|value| self.axis(value, eigen.values.y, energy));
        let scale = self.size(energy) / (axes[0] * axes[1]).sqrt();
        (DVec2::from_array(axes) * scale, eigen.vectors.x_axis)
    }

    pub(super) fn planar(&self, tensor: &SymmetricDMat2, mean: f64) -> SymmetricDMat2 {
        let (axes, first) = self.semi_axes(tensor, mean);
        SymmetricDMat2::from_outer_product(first / axes.x) + SymmetricDMat2::from_outer_product(first.perp() / axes.y)
    }

    pub(super) fn spatial(&self, tensor: &SymmetricDMat3, mean: f64) -> SymmetricDMat3 {
        let eigen = SymmetricEigen3::new(tensor);
        let energy = Self::energy(tensor.diagonal().element_sum(), mean);
        let axes = eigen
            .values
            .to_array()
            .map(|value| self.axis(value.max(0.0), eigen.values.z, energy));
        let scale = self.size(energy) / (axes[0] * axes[1] * axes[2]).cbrt();
        let v = &eigen.vectors;
        SymmetricDMat3::from_outer_product(v.x_axis / (axes[0] * scale))
            + SymmetricDMat3::from_outer_product(v.y_axis / (axes[1] * scale))
            + SymmetricDMat3::from_outer_product(v.z_axis / (axes[2] * scale))
    }
}

/// The metric of a scalar φ on a surface: `scalars` and the result are per graph vertex, in solver order.
pub fn metric_of_scalars(graph: &SurfaceGraph, scalars: &[f32], structure: &Structure) -> Vec<SymmetricMat3> {
    let tensors = structure_tensors(graph, scalars, structure.reach.clamp(0.0, MOST_STEPS).round() as u32);
    let total: f64 = tensors.iter().map(|t| t.diagonal().element_sum()).sum();
    let mean = total / tensors.len().max(1) as f64;
    parallel::collect(graph.len(), |i| {
        let normal = graph.normals[i];
        let u = any_tangent(normal);
        let v = normal.cross(u);
        let planar = on_plane(&tensors[i], u.as_dvec3(), v.as_dvec3());
        let (axes, first) = structure.semi_axes(&planar, mean);
        let tangent = project_tangent(u * first.x as f32 + v * first.y as f32, normal);
        ellipse(tangent, normal, axes.x as f32, axes.y as f32)
    })
}

/// Means over more edges than this take long and show nothing new.
const MOST_STEPS: f32 = 200.0;

/// T per vertex: the area-weighted mean of ∇φ ∇φᵀ over the triangles around it, then over neighbours, `steps` times.
fn structure_tensors(graph: &SurfaceGraph, scalars: &[f32], steps: u32) -> Vec<SymmetricDMat3> {
    let mut sums = vec![(SymmetricDMat3::ZERO, 0.0_f64); graph.len()];
    for triangle in &graph.triangles {
        let corners = triangle.map(|v| v as usize);
        let [p0, p1, p2] = corners.map(|v| graph.positions[v].as_dvec3());
        let [s0, s1, s2] = corners.map(|v| f64::from(scalars[v]));
        let (e1, e2) = (p1 - p0, p2 - p0);
        let normal = e1.cross(e2);
        let double_area = normal.length();
        let gradient = ((s1 - s0) * e2.cross(normal) + (s2 - s0) * normal.cross(e1)) / normal.length_squared();
        if !gradient.is_finite() {
            continue;
        }
        for v in corners {
            sums[v].0 += SymmetricDMat3::from_outer_product(gradient) * double_area;
            sums[v].1 += double_area;
        }
    }
    let mut tensors: Vec<SymmetricDMat3> = sums
        .into_iter()
        .map(|(sum, area)| {
            if area > 0.0 {
                sum * (1.0 / area)
            } else {
                SymmetricDMat3::ZERO
            }
        })
        .collect();
    let level = graph.mesh_level();
    let mut next = tensors.clone();
    for _ in 0..steps {
        parallel::fill(&mut next, |i| {
            let edges = level.edges(i);
            let weight = 0.5 / edges.len().max(1) as f64;
            level.neighbors[edges]
                .iter()
                .fold(tensors[i] * 0.5, |sum, &j| sum + tensors[j as usize] * weight)
        });
        std::mem::swap(&mut tensors, &mut next);
    }
    tensors
}

/// The metric of an image, one per pixel, row by row from the top. `pixels` are linear colours, `size.x` per row; a
/// pixel is 1 × 1 and y points down.
pub fn metric_of_pixels(pixels: &[Vec3], size: UVec2, structure: &Structure) -> Vec<SymmetricDMat2> {
    let (w, h) = (size.x as usize, size.y as usize);
    if pixels.len() != w * h || pixels.is_empty() {
        return Vec::new();
    }
    let at = |x: isize, y: isize| pixels[y.clamp(0, h as isize - 1) as usize * w + x.clamp(0, w as isize - 1) as usize];
    let mut tensors: Vec<DVec3> = parallel::collect(w * h, |i| {
        let (x, y) = ((i % w) as isize, (i / w) as isize);
        // Scharr's derivatives.
        let column = |x: isize| (at(x, y - 1) + at(x, y + 1)) * (3.0 / 32.0) + at(x, y) * (10.0 / 32.0);
        let row = |y: isize| (at(x - 1, y) + at(x + 1, y)) * (3.0 / 32.0) + at(x, y) * (10.0 / 32.0);
        let (dx, dy) = (column(x + 1) - column(x - 1), row(y + 1) - row(y - 1));
        Vec3::new(dx.dot(dx), dx.dot(dy), dy.dot(dy)).as_dvec3()
    });
    let radius = structure.reach.clamp(0.0, w.max(h) as f32).round() as usize;
    for _ in 0..BOX_PASSES {
        tensors = box_mean(&tensors, [w, h, 1], radius);
    }
    let mean = tensors.iter().map(|t| t.x + t.z).sum::<f64>() / tensors.len() as f64;
    parallel::collect(w * h, |i| {
        let t = tensors[i];
        structure.planar(&SymmetricDMat2::new(t.x, t.y, t.z), mean)
    })
}

/// Means over boxes, as many times as it takes to look like a Gaussian.
const BOX_PASSES: u32 = 3;

/// The metric of a scalar volume, one per voxel, x fastest. A voxel is 1 × 1 × 1.
pub fn metric_of_voxels(voxels: &[f32], size: UVec3, structure: &Structure) -> Vec<SymmetricDMat3> {
    let extent = size.as_usizevec3().to_array();
    let [w, h, d] = extent;
    if voxels.len() != w * h * d || voxels.is_empty() {
        return Vec::new();
    }
    let at = |x: usize, y: usize, z: usize| f64::from(voxels[(z * h + y) * w + x]);
    let ends = |i: usize, length: usize| (i.saturating_sub(1), (i + 1).min(length - 1));
    let gradients: Vec<DVec3> = parallel::collect(voxels.len(), |i| {
        let (x, y, z) = (i % w, i / w % h, i / (w * h));
        let ((x0, x1), (y0, y1), (z0, z1)) = (ends(x, w), ends(y, h), ends(z, d));
        DVec3::new(
            (at(x1, y, z) - at(x0, y, z)) / (x1 - x0).max(1) as f64,
            (at(x, y1, z) - at(x, y0, z)) / (y1 - y0).max(1) as f64,
            (at(x, y, z1) - at(x, y, z0)) / (z1 - z0).max(1) as f64,
        )
    });
    let mut diagonal: Vec<DVec3> = gradients.iter().map(|g| *g * *g).collect();
    let mut mixed: Vec<DVec3> = gradients
        .iter()
        .map(|g| DVec3::new(g.x * g.y, g.x * g.z, g.y * g.z))
        .collect();
    let radius = structure.reach.clamp(0.0, w.max(h).max(d) as f32).round() as usize;
    for _ in 0..BOX_PASSES {
        diagonal = box_mean(&diagonal, extent, radius);
        mixed = box_mean(&mixed, extent, radius);
    }
    let mean = diagonal.iter().map(|t| t.element_sum()).sum::<f64>() / diagonal.len() as f64;
    parallel::collect(voxels.len(), |i| {
        let (t, m) = (diagonal[i], mixed[i]);
        structure.spatial(&SymmetricDMat3::new(t.x, m.x, m.y, t.y, m.z, t.z), mean)
    })
}

/// The mean over a box of 2 `radius` + 1 values along each axis, cut off at the ends: a third as wide for each pass of
/// three as the Gaussian that they make.
fn box_mean(values: &[DVec3], extent: [usize; 3], radius: usize) -> Vec<DVec3> {
    let mut values = values.to_vec();
    if radius == 0 {
        return values;
    }
    let strides = [1, extent[0], extent[0] * extent[1]];
    for axis in 0..3 {
        let (length, stride) = (extent[axis], strides[axis]);
        if length < 2 {
            continue;
        }
        let mut sums = vec![DVec3::ZERO; length + 1];
        for line in 0..values.len() / length {
            let first = line / stride * stride * length + line % stride;
            for k in 0..length {
                sums[k + 1] = sums[k] + values[first + k * stride];
            }
            for k in 0..length {
                let (low, high) = (k.saturating_sub(radius), (k + radius + 1).min(length));
                values[first + k * stride] = (sums[high] - sums[low]) / (high - low) as f64;
            }
        }
    }
    values
}
