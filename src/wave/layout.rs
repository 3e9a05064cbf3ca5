//! How a pattern lies in the GPU's shared buffers; the same words as `layout.wgsl`.
//!
//! | buffer | element | what it holds |
//! |---|---|---|
//! | surface | `u32` | records of entities; triangles, neighbours, hierarchy of graphs |
//! | geometry | `vec4<f32>` | (position, area), (normal, id) per vertex of a graph, two more in a cloud; vectors; rigs, poses |
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
/// The directions follow those of the frame before: on a line field each keeps the sign nearest to its last one, to which
/// its phasor refers.
pub const FLAG_FOLLOW: u32 = 8;
/// d, n × d and their opposites are the same ([`Waves::Cross`](super::Waves)).
pub const FLAG_CROSS: u32 = 16;
/// A point cloud: triangles 2 p and 2 p + 1 are the square of one vertex, whose half axes follow the vertices' geometry.
pub const FLAG_DISCS: u32 = 256;

/// One axis for all vertices.
pub(crate) const DIRECTION_AXIS: u32 = 0;
/// A vector per vertex.
pub(crate) const DIRECTION_VECTORS: u32 = 1;
/// A tangent per vertex, taken as given.
pub(crate) const DIRECTION_TANGENTS: u32 = 2;
/// Two vectors per vertex, blended.
pub(crate) const DIRECTION_SNAPSHOTS: u32 = 3;
/// Flow around cores.
pub(crate) const DIRECTION_VORTICES: u32 = 4;
/// An eigenvector of a tensor per vertex.
pub(crate) const DIRECTION_TENSOR: u32 = 5;
/// A smoothed field.
pub(crate) const DIRECTION_SMOOTH: u32 = 6;
/// A vector per vertex of the mesh, copied from a user's buffer.
pub(crate) const DIRECTION_BUFFER: u32 = 7;
/// Principal curvature of a surface that is posed on the device.
pub(crate) const DIRECTION_CURVATURE: u32 = 8;
/// Number of `DIRECTION_*`.
pub(crate) const DIRECTION_KINDS: u32 = 9;

/// One frequency for all vertices.
pub(crate) const FREQUENCY_UNIFORM: u32 = 0;
/// A frequency per vertex.
pub(crate) const FREQUENCY_VERTICES: u32 = 1;
/// By the distance to a segment.
pub(crate) const FREQUENCY_DISTANCE: u32 = 2;
/// By the size of a pixel.
pub(crate) const FREQUENCY_SCREEN: u32 = 3;
/// By a scalar of the vertex.
pub(crate) const FREQUENCY_SCALAR: u32 = 4;
/// A frequency per vertex of the mesh, copied from a user's buffer.
pub(crate) const FREQUENCY_BUFFER: u32 = 5;
/// Number of `FREQUENCY_*`.
pub(crate) const FREQUENCY_KINDS: u32 = 6;

/// In [`PatternRecord::sources`]: the eigenvalues of tensors become the scalars.
pub(crate) const SOURCE_SCALARS: u32 = 1 << 16;

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
    /// `surface[triangle_base + 3 t + c]` is the vertex at corner c of triangle t. Behind these,
    /// `surface[triangle_base + 3 * triangles + 3 t + c]` is the triangle across the edge from corner c to the next,
    /// [`NO_TRIANGLE`](crate::surface::NO_TRIANGLE) at borders.
    pub triangle_base: u32,
    /// `geometry[geometry_base + 2 v]` is (position, area) of vertex v, the next one (normal, id); the id is the bits of a
    /// u32, the vertex's number in the mesh. With [`FLAG_DISCS`], `geometry[geometry_base + 2 vertices + 2 v]` and the
    /// next one are the half axes of its square.
    pub geometry_base: u32,
    /// `wave[field_base + 2 v]` is (d.x, d.y) of vertex v, the next one (d.z, f).
    pub field_base: u32,
    /// `wave[phasor_base + waves * v + r]` is the phasor z of wave r of vertex v.
    pub phasor_base: u32,
    /// `surface[class_base + c]` is the first vertex of colour class c, `surface[class_base + colors]` the vertex count.
    pub class_base: u32,
    /// Number of colour classes.
    pub colors: u32,
    /// Frequency of all vertices, in stripes per unit length, where it is uniform.
    pub frequency: f32,
    /// Angle in radians by which directions are turned about the normal.
    pub turn: f32,
    /// The axis that directions are projected from, where they are.
    pub axis: [f32; 3],
    /// `wave[delta_base + waves * v + r]` is the momentum of the local rule; only where it is used.
    pub delta_base: u32,
    /// `balance[state_base..]`: energy and branch count of the entity, then partial sums.
    pub state_base: u32,
    /// Number of waves, 1 or 2; node n of wave r is node `waves * n + r` of every list of phasors, weights and balances.
    pub waves: u32,
    /// Frequency of the second wave over that of the first; 1 for a cross field.
    pub ratio: f32,
    /// `wave[scalar_base + v]` are the two scalars of vertex v that styles may show; 0: there are none.
    pub scalar_base: u32,
    /// Where directions and frequencies come from: `DIRECTION_*` in the lowest byte, `FREQUENCY_*` in the next one, and
    /// `SOURCE_SCALARS`.
    pub sources: u32,
    /// `geometry[direction_base..]` are the vectors or tensors that directions are made from.
    pub direction_base: u32,
    /// `geometry[frequency_base..]` are frequencies that were given, four to an element.
    pub frequency_base: u32,
    /// `surface[parameter_base..]` are the parameters of the sources.
    pub parameter_base: u32,
    /// `wave[smooth_base..]`: the smoothed field of every node, then what it is drawn to; see `smooth.wgsl`.
    pub smooth_base: u32,
    /// `surface[carry_base]` is the record of the entity whose pattern this one carries, then follow the six vertices of it that
    /// are nearest to each vertex of this one; only where it carries one.
    pub carry_base: u32,
    /// `surface[pose_base..]` is the entity's [`PoseRecord`]; 0: its positions are not posed.
    pub pose_base: u32,
    /// Unused.
    pub pad_pose: [u32; 3],
    /// Bit i % 32 of `surface[pin_base + i / 32]` tells whether vertex i is drawn to a crest; 0: none is.
    pub pin_base: u32,
    /// How much such a vertex is drawn to a crest, as the weight of an edge; below 0: to a trough.
    pub pull: f32,
}

/// How an entity is posed.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct PoseRecord {
    /// Number of matrices, 1 or more; the first is everybody's where there is no skin.
    pub joints: u32,
    /// Number of weights of morph targets.
    pub targets: u32,
    /// `geometry[matrix_base + 3 j]` and the next two are the rows of the matrix of joint j. Behind them all, the first
    /// component of element t is the weight of morph target t.
    pub matrix_base: u32,
    /// `geometry[skin_base + 2 v]` are the four joints of vertex v as numbers, the next one their weights; 0: there is no
    /// skin.
    pub skin_base: u32,
    /// `geometry[target_base + t V + v]` is by how much morph target t displaces vertex v of V.
    pub target_base: u32,
    /// Positions, areas, normals and ids at rest, as [`PatternRecord::geometry_base`].
    pub rest_base: u32,
    /// `geometry[position_base + v]` is the posed position of vertex v.
    pub position_base: u32,
    /// `surface[fan_offset_base + v] .. surface[fan_offset_base + v + 1]` are the entries of vertex v's fans.
    pub fan_offset_base: u32,
    /// `surface[fan_base + k]`: vertices around a vertex, counter-clockwise, each of which makes a triangle with the vertex
    /// and the next entry; [`NO_VERTEX`] between two fans.
    pub fan_base: u32,
    /// Unused.
    pub pad: [u32; 3],
}

/// Between the fans of a vertex.
pub const NO_VERTEX: u32 = u32::MAX;

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
    /// `wave[node_base + waves * i + r]` is the phasor of wave r of node i (of the finest level: z).
    pub node_base: u32,
    /// With n = `waves * k + r` for wave r over edge k: finest level: `edges[edge_base + n]` = E. Coarser:
    /// `edges[edge_base + 2 n]` = A, the next one B.
    pub edge_base: u32,
    /// `balance[balance_base + waves * i + r]`: the sign is sigma of wave r of node i, the lowest bit tells whether it
    /// follows its parent's other wave, the modulus is 1 / sum of weights (finest level only).
    pub balance_base: u32,
    /// `surface[class_base + c] .. surface[class_base + c + 1]` are the nodes of colour class c.
    pub class_base: u32,
    /// Number of colour classes.
    pub colors: u32,
    /// Number of waves, as [`PatternRecord::waves`].
    pub waves: u32,
}
