//! A mesh as a graph: welded vertices, neighbours, colours and a hierarchy of aggregates.
//!
//! In: a triangle mesh of any make. Out: a [`SurfaceGraph`], the ground that fields are given on and waves are solved
//! on. Pure CPU; nothing here knows of the GPU or of patterns.

mod graph;

pub use graph::*;
