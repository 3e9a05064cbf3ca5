//! The shared buffers of waves; see [`layout`](super::layout) for their elements.

use super::layout::{BALANCE_BUFFER, EDGE_BUFFER, GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER};
use crate::arena::Arena;
use bevy::{prelude::*, render::storage::ShaderBuffer};

/// Who owns which part of the shared buffers: graphs, and entities with a pattern.
pub type PatternArena = Arena<Pool>;

/// The shared buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pool {
    /// Records, triangles and graphs.
    Surface,
    /// Positions and normals.
    Geometry,
    /// Directions, frequencies and phasors.
    Wave,
    /// Edge weights.
    Edges,
    /// One number per node.
    Balance,
}

impl crate::arena::Pool for Pool {
    const ALL: &'static [Self] = &[Self::Surface, Self::Geometry, Self::Wave, Self::Edges, Self::Balance];

    fn index(self) -> usize {
        self as usize
    }

    fn handle(self) -> Handle<ShaderBuffer> {
        match self {
            Self::Surface => SURFACE_BUFFER,
            Self::Geometry => GEOMETRY_BUFFER,
            Self::Wave => WAVE_BUFFER,
            Self::Edges => EDGE_BUFFER,
            Self::Balance => BALANCE_BUFFER,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Surface => "pattern_surface",
            Self::Geometry => "pattern_geometry",
            Self::Wave => "pattern_wave",
            Self::Edges => "pattern_edges",
            Self::Balance => "pattern_balance",
        }
    }

    fn element(self) -> u64 {
        match self {
            Self::Surface | Self::Balance => 4,
            Self::Wave | Self::Edges => 8,
            Self::Geometry => 16,
        }
    }
}
