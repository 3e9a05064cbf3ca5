//! A mesh as a graph: welded vertices, neighbours, colours and a hierarchy of aggregates.
//!
//! In: a triangle mesh of any make. Out: a [`SurfaceGraph`], the ground that fields are given on and waves are solved
//! on, and the un-indexed copy of the mesh that is drawn. Pure CPU; nothing here knows of the GPU or of patterns.
//!
//! | step | file | what it does |
//! |---|---|---|
//! | 1 | `soup` | reads positions and triangles out of a `Mesh` and checks them |
//! | 2 | `weld` | makes one graph vertex of all mesh vertices at the same place |
//! | 3 | `adjacency` | collects the neighbours of every vertex |
//! | 4 | `coloring`, `order` | colours the graph and stores it colour by colour, along a Morton curve |
//! | 5 | `geometry` | normals and areas |
//! | 6 | `levels` | joins vertices to aggregates, again and again, until one per component is left |
//!
//! A point cloud takes the same steps, but for its neighbours and normals (`cloud`, `nearest`, `planes`).

mod adjacency;
mod asset;
mod cache;
mod cloud;
mod coloring;
mod creases;
pub(crate) mod geometry;
mod graph;
mod levels;
mod merged;
mod nearest;
pub(crate) mod order;
mod planes;
mod plugin;
mod soup;
mod weld;

pub use asset::*;
pub use cache::{PatternCloud, PatternWeld, Surface, SurfaceCache, SurfaceState};
pub(crate) use cache::{finish_surfaces, start_surfaces, watch_meshes};
pub use cloud::CloudOptions;
pub use graph::*;
pub use merged::MergedSurface;
pub(crate) use nearest::KdTree;
pub(crate) use plugin::SurfacePlugin;
pub use plugin::{PatternMesh, SurfaceSystems};
pub use soup::*;
pub use weld::*;
