//! Meshes of three sizes.
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each bench compiles this module for itself and uses a part of it"
)]

#[path = "../../examples/common/mesh_file/mod.rs"]
pub mod mesh_file;
#[path = "../../examples/common/shapes.rs"]
pub mod shapes;

use bevy_field_patterns::surface::{SurfaceGraph, WeldOptions};
use mesh_file::RawMesh;

/// A jittered torus of 35,000 vertices.
pub fn torus() -> (&'static str, RawMesh) {
    ("torus 35k", shapes::torus(266, 132, 1.0, 0.4, 0.25, 1))
}

/// An icosphere of 164,000 vertices; of 10,000 where benches are only tried.
pub fn sphere() -> (&'static str, RawMesh) {
    if measures() {
        ("icosphere 164k", shapes::icosphere(7, 1.0))
    } else {
        ("icosphere 10k", shapes::icosphere(5, 1.0))
    }
}

/// All meshes; one with a million vertices where benches are measured.
pub fn meshes() -> Vec<(&'static str, RawMesh)> {
    let mut meshes = vec![torus(), sphere()];
    if measures() {
        meshes.push(("torus 1M", shapes::torus(1414, 708, 1.0, 0.4, 0.25, 1)));
    }
    meshes
}

pub fn graph(raw: &RawMesh) -> SurfaceGraph {
    SurfaceGraph::from_triangles(&raw.positions, &raw.triangles, &WeldOptions::default()).expect("a good mesh")
}

/// `cargo bench` says so; `cargo test` runs every bench once.
fn measures() -> bool {
    std::env::args().any(|argument| argument == "--bench")
}
