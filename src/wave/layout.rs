//! How a pattern lies in the GPU's shared buffers; the same words as `layout.wgsl`.
//!
//! | buffer | element | what it holds |
//! |---|---|---|
//! | surface | `u32` | records of entities; triangles, neighbours, hierarchy of graphs |
//! | geometry | `vec4<f32>` | two per vertex of a graph: (position, area), (normal, id) |
//! | wave | `vec2<f32>` | per entity: d and f of each vertex, phasors of every level |
//! | edges | `vec2<f32>` | per entity, solver only: weight of each directed edge of every level |
//! | balance | `f32` | per entity, solver only: one number per node of every level |

use bevy::{asset::uuid_handle, prelude::*, render::storage::ShaderBuffer};
use bytemuck::{Pod, Zeroable};

/// The buffer of records, triangles and graphs, `array<u32>`. Bind it to a material as storage 100.
pub const SURFACE_BUFFER: Handle<ShaderBuffer> = uuid_handle!("6f0bd2b0-3f0e-4f3c-9a53-0f4a35b60f01");
/// The buffer of positions and normals, `array<vec4<f32>>`. Bind it to a material as storage 101.
pub const GEOMETRY_BUFFER: Handle<ShaderBuffer> = uuid_handle!("6f0bd2b0-3f0e-4f3c-9a53-0f4a35b60f02");
/// The buffer of directions, frequencies and phasors, `array<vec2<f32>>`. Bind it to a material as storage 102.
pub const WAVE_BUFFER: Handle<ShaderBuffer> = uuid_handle!("6f0bd2b0-3f0e-4f3c-9a53-0f4a35b60f03");
/// The solver's buffer of edge weights.
pub(crate) const EDGE_BUFFER: Handle<ShaderBuffer> = uuid_handle!("6f0bd2b0-3f0e-4f3c-9a53-0f4a35b60f04");
/// The solver's buffer of one number per node, of energies and branch counts, `array<f32>`.
pub const BALANCE_BUFFER: Handle<ShaderBuffer> = uuid_handle!("6f0bd2b0-3f0e-4f3c-9a53-0f4a35b60f05");

/// The pattern may be drawn: its phasors have been solved at least once.
pub const FLAG_READY: u32 = 1;
/// d and -d differ ([`Symmetry::Vector`](crate::field::Symmetry)).
pub const FLAG_VECTOR: u32 = 2;
/// The directions are [`PatternRecord::axis`], projected on the GPU.
pub const FLAG_AXIS: u32 = 4;
/// The directions follow those of the frame before: on a line field each keeps the sign nearest to its last one, to which
/// its phasor refers.
pub const FLAG_FOLLOW: u32 = 8;

/// What the GPU knows of one patterned entity. The entity's `MeshTag` is the record's word offset in the surface
/// buffer; 0 is a record of zeros and means "no pattern".
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct PatternRecord {
    /// Number of graph vertices.
    pub vertices: u32,
    /// Number of drawn triangles.
    pub triangles: u32,
    /// `FLAG_*`.
    pub flags: u32,
    /// Number of levels; their [`LevelRecord`]s follow this record.
    pub levels: u32,
    /// `surface[triangle_base + 3 t + c]` is the vertex at corner c of triangle t.
    pub triangle_base: u32,
    /// `geometry[geometry_base + 2 v]` is (position, area) of vertex v, the next one (normal, id); the id is the bits of a u32, the vertex's number in the mesh.
    pub geometry_base: u32,
    /// `wave[field_base + 2 v]` is (d.x, d.y) of vertex v, the next one (d.z, f).
    pub field_base: u32,
    /// `wave[phasor_base + v]` is the phasor z of vertex v.
    pub phasor_base: u32,
    /// `surface[class_base + c]` is the first vertex of colour class c, `surface[class_base + colors]` the vertex count.
    pub class_base: u32,
    /// Number of colour classes.
    pub colors: u32,
    /// Frequency of all vertices where [`FLAG_AXIS`] is set, in stripes per unit length.
    pub frequency: f32,
    /// Angle in radians by which a GPU-projected axis is turned about the normal.
    pub turn: f32,
    /// The axis to project, where [`FLAG_AXIS`] is set.
    pub axis: [f32; 3],
    /// `wave[delta_base + v]` is the momentum of the local rule; only where it is used.
    pub delta_base: u32,
    /// `balance[state_base..]`: energy and branch count of the entity, then partial sums.
    pub state_base: u32,
    /// Number of waves, 1 or 2; node n of wave r is node `waves * n + r` of every list of phasors, weights and balances.
    pub waves: u32,
    /// Frequency of the second wave over that of the first; 1 for a cross field.
    pub ratio: f32,
    /// `wave[scalar_base + v]` are the two scalars of vertex v that styles may show; 0: there are none.
    pub scalar_base: u32,
    /// Unused.
    pub pad: [u32; 6],
    /// `surface[pose_base..]` is the entity's [`PoseRecord`]; 0: its positions are not posed.
    pub pose_base: u32,
    /// Unused.
    pub pad_end: [u32; 5],
}

/// The directions of a posed surface are [`PatternRecord::axis`], projected, with frequencies of their own.
pub const POSE_AXIS: u32 = 1;
/// They are those of the minor principal curvature, not of the major one.
pub const POSE_MINOR: u32 = 2;

/// How an entity is posed. The matrices of its joints follow, three rows of four numbers each, and then the weights of its
/// morph targets.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct PoseRecord {
    /// Number of matrices, 1 or more; the first is everybody's where there is no skin.
    pub joints: u32,
    /// Number of weights.
    pub targets: u32,
    /// `surface[skin_base + 6 v]` are two joints of vertex v, 16 bits each, the next one two more, then four weights; 0: there is no skin.
    pub skin_base: u32,
    /// `surface[target_base + 3 (t V + v)]`.. is by how much morph target t displaces vertex v of V.
    pub target_base: u32,
    /// Positions, areas, normals and ids at rest, as [`PatternRecord::geometry_base`].
    pub rest_base: u32,
    /// `surface[corner_offset_base + v] .. surface[corner_offset_base + v + 1]` are the corners around vertex v.
    pub corner_offset_base: u32,
    /// `surface[corner_base + k]` is corner c of triangle t, as 3 t + c.
    pub corner_base: u32,
    /// Directions and frequencies at rest, as [`PatternRecord::field_base`].
    pub field_base: u32,
    /// Steps of smoothing of curvature directions.
    pub smoothing: u32,
    /// `POSE_*`.
    pub flags: u32,
    /// Unused.
    pub pad: [u32; 2],
}

/// One level of an entity's hierarchy.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct LevelRecord {
    /// Number of nodes.
    pub nodes: u32,
    /// `surface[offset_base + i] .. surface[offset_base + i + 1]` are the directed edges into node i.
    pub offset_base: u32,
    /// `surface[neighbor_base + k]` is the source node of edge k.
    pub neighbor_base: u32,
    /// `surface[parent_base + i]` is the coarser node of node i.
    pub parent_base: u32,
    /// `surface[child_offset_base + p]` .. as for edges: the children of the next level's node p.
    pub child_offset_base: u32,
    /// `surface[child_base + c]` is a node of this level; the first child of a parent is its root.
    pub child_base: u32,
    /// `wave[node_base + i]` is the phasor of node i (of the finest level: z).
    pub node_base: u32,
    /// Finest level: `edges[edge_base + k]` = E of edge k. Coarser: `edges[edge_base + 2 k]` = A, the next one B.
    pub edge_base: u32,
    /// `balance[balance_base + i]`: the sign is sigma of node i, the modulus 1 / sum of weights (finest level only).
    pub balance_base: u32,
    /// `surface[class_base + c] .. surface[class_base + c + 1]` are the nodes of colour class c.
    pub class_base: u32,
    /// Number of colour classes.
    pub colors: u32,
    /// Number of waves, as [`PatternRecord::waves`].
    pub waves: u32,
}
