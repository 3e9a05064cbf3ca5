//! From sites on the refined mesh to samples on the given one.
//!
//! In: sites and labels. Out: a [`SampleSet`]: points of the graph's triangles, labels of their corners, and which cells
//! touch.

use super::{
    domain::{Scale, scaled},
    form,
    mesh::{FineMesh, NONE},
    nearest::PointTree,
    walk::{Site, closest_weights},
};
use crate::{
    sampling::{SampleSet, metric::on_surface},
    surface::{SurfaceGraph, order::group},
};
use bevy::prelude::*;
use glam_matrix_extras::SymmetricMat3;

/// The samples of a graph.
pub(super) fn sample_set(
    graph: &SurfaceGraph,
    metrics: &[SymmetricMat3],
    scale: Scale,
    mesh: &FineMesh,
    sites: &[Site],
    labels: &[u32],
) -> SampleSet {
    let mut set = SampleSet::default();
    for site in sites {
        let source = mesh.sources[site.triangle as usize];
        let corners = graph.triangles[source as usize];
        let in_frame = corners.map(|v| mesh.positions[mesh.vertex_of[v as usize] as usize]);
        let weights = closest_weights(site.position, in_frame);
        set.positions.push(blend(corners, weights, &graph.positions));
        let normal = normal(graph, corners, weights);
        set.normals.push(normal);
        let metric = form::blend(corners.map(|v| &metrics[v as usize]), weights);
        set.metrics.push(scaled(&on_surface(&metric, normal), scale.metric));
        set.triangles.push(source);
        set.barycentrics.push(weights);
    }
    let labels = everywhere(mesh, sites, labels);
    let label_of = |v: u32| labels[mesh.vertex_of[v as usize] as usize];
    set.seeds = graph.triangles.iter().map(|t| t.map(label_of)).collect();
    (set.neighbor_offsets, set.neighbors) = neighbors(mesh, &labels, sites.len());
    set
}

/// The labels, and where there are none that of the nearest site in space.
fn everywhere(mesh: &FineMesh, sites: &[Site], labels: &[u32]) -> Vec<u32> {
    let mut labels = labels.to_vec();
    if labels.contains(&NONE) {
        let positions: Vec<Vec3> = sites.iter().map(|site| site.position).collect();
        let tree = PointTree::new(&positions);
        for (label, &position) in labels.iter_mut().zip(&mesh.positions) {
            if *label == NONE {
                *label = tree.nearest(position).unwrap_or(0);
            }
        }
    }
    labels
}

/// Which cells touch: those of the two ends of an edge. In CSR form, ascending, without duplicates.
pub(super) fn neighbors(mesh: &FineMesh, labels: &[u32], sites: usize) -> (Vec<u32>, Vec<u32>) {
    let mut pairs: Vec<[u32; 2]> = (0..mesh.len())
        .flat_map(|v| mesh.neighbors(v).iter().map(move |&w| [labels[v], labels[w as usize]]))
        .filter(|[a, b]| a != b && *a != NONE && *b != NONE)
        .collect();
    // By the second, then stably by the first: sorted pairs in linear time.
    let by_second: Vec<u32> = group(&pairs.iter().map(|p| p[1]).collect::<Vec<_>>(), sites).1;
    pairs = by_second.into_iter().map(|k| pairs[k as usize]).collect();
    let by_first: Vec<u32> = group(&pairs.iter().map(|p| p[0]).collect::<Vec<_>>(), sites).1;
    pairs = by_first.into_iter().map(|k| pairs[k as usize]).collect();
    pairs.dedup();
    let (offsets, _) = group(&pairs.iter().map(|p| p[0]).collect::<Vec<_>>(), sites);
    (offsets, pairs.into_iter().map(|p| p[1]).collect())
}

fn blend(corners: [u32; 3], weights: Vec3, values: &[Vec3]) -> Vec3 {
    let [a, b, c] = corners.map(|v| values[v as usize]);
    a * weights.x + b * weights.y + c * weights.z
}

/// The vertices' normals, blended; where they cancel, the triangle's.
fn normal(graph: &SurfaceGraph, corners: [u32; 3], weights: Vec3) -> Vec3 {
    let [a, b, c] = corners.map(|v| graph.positions[v as usize].as_dvec3());
    let flat = || (b - a).cross(c - a).normalize_or(bevy::math::DVec3::Z).as_vec3();
    blend(corners, weights, &graph.normals)
        .try_normalize()
        .unwrap_or_else(flat)
}
