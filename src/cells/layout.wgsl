#define_import_path bevy_field_patterns::cell_layout

// The words of a cell record in the cell buffer, and the flags in it; `layout.rs` explains each of them.

const FLAG_VALUES: u32 = 1u;
const CHECK: u32 = 0x5A3CE117u;

const SAMPLES: u32 = 0u;
const TRIANGLES: u32 = 1u;
const FLAGS: u32 = 2u;
const CHECK_WORD: u32 = 3u;
const SITE_BASE: u32 = 4u;
const OFFSET_BASE: u32 = 5u;
const NEIGHBOR_BASE: u32 = 6u;
const SEED_BASE: u32 = 7u;
const VALUE_BASE: u32 = 8u;
const RADIUS: u32 = 9u;
const MEAN_VALUE: u32 = 12u;
