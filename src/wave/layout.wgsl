#define_import_path bevy_field_patterns::layout

// The words of a pattern's record in the surface buffer; `layout.rs` explains each of them.

const FLAG_READY: u32 = 1u;
const FLAG_VECTOR: u32 = 2u;
const FLAG_FOLLOW: u32 = 8u;
const FLAG_CROSS: u32 = 16u;
const FLAG_DISCS: u32 = 256u;

const DIRECTION_AXIS: u32 = 0u;
const DIRECTION_VECTORS: u32 = 1u;
const DIRECTION_TANGENTS: u32 = 2u;
const DIRECTION_SNAPSHOTS: u32 = 3u;
const DIRECTION_VORTICES: u32 = 4u;
const DIRECTION_TENSOR: u32 = 5u;
const DIRECTION_SMOOTH: u32 = 6u;
const DIRECTION_BUFFER: u32 = 7u;
const DIRECTION_CURVATURE: u32 = 8u;

const FREQUENCY_UNIFORM: u32 = 0u;
const FREQUENCY_VERTICES: u32 = 1u;
const FREQUENCY_DISTANCE: u32 = 2u;
const FREQUENCY_SCREEN: u32 = 3u;
const FREQUENCY_SCALAR: u32 = 4u;
const FREQUENCY_BUFFER: u32 = 5u;

const SOURCE_SCALARS: u32 = 65536u;

const RECORD_WORDS: u32 = 32u;
const LEVEL_WORDS: u32 = 12u;

const NO_VERTEX: u32 = 0xffffffffu;

struct PatternRecord {
    vertices: u32,
    triangles: u32,
    flags: u32,
    levels: u32,
    triangle_base: u32,
    geometry_base: u32,
    field_base: u32,
    phasor_base: u32,
    class_base: u32,
    colors: u32,
    frequency: f32,
    turn: f32,
    axis: vec3<f32>,
    delta_base: u32,
    state_base: u32,
    waves: u32,
    ratio: f32,
    scalar_base: u32,
    sources: u32,
    direction_base: u32,
    frequency_base: u32,
    parameter_base: u32,
    smooth_base: u32,
}

struct PoseRecord {
    joints: u32,
    targets: u32,
    matrix_base: u32,
    skin_base: u32,
    target_base: u32,
    rest_base: u32,
    position_base: u32,
    fan_offset_base: u32,
    fan_base: u32,
}

struct LevelRecord {
    nodes: u32,
    offset_base: u32,
    neighbor_base: u32,
    parent_base: u32,
    child_offset_base: u32,
    child_base: u32,
    node_base: u32,
    edge_base: u32,
    balance_base: u32,
    class_base: u32,
    colors: u32,
    waves: u32,
}
