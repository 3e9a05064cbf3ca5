#define_import_path bevy_field_patterns::parameters

// The parameters of a pattern's sources, in `surface` from `parameter_base` on; `parameters.rs` writes them.

#import bevy_field_patterns::passes::surface

// Of directions.
const LINEAR: u32 = 0u;           // columns of the linear map that carries given vectors into the pattern's space
const BLEND: u32 = 9u;            // weight of the second snapshot
const CORES: u32 = 10u;           // number of vortex cores
const CHOICE: u32 = 11u;          // eigenvector
const BASE: u32 = 12u;            // base flow

// Of frequencies.
const FREQUENCY: u32 = 16u;

// Then vortex cores: centre, radius, signed strength, falloff.
const FIRST_CORE: u32 = 32u;
const CORE_WORDS: u32 = 8u;

fn number(at: u32) -> f32 {
    return bitcast<f32>(surface[at]);
}

fn vector(at: u32) -> vec3<f32> {
    return vec3(number(at), number(at + 1u), number(at + 2u));
}

fn parameters(record: u32) -> u32 {
    return surface[record + 23u];
}

fn linear_map(record: u32) -> mat3x3<f32> {
    let at = parameters(record) + LINEAR;
    return mat3x3(vector(at), vector(at + 3u), vector(at + 6u));
}
