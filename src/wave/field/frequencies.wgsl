// The frequency pass: f of each vertex, from wherever the entity's frequencies come; after the direction pass, which may
// make scalars. The twin of `ramp.rs`. Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::{
    FREQUENCY_VERTICES, FREQUENCY_DISTANCE, FREQUENCY_SCREEN, FREQUENCY_SCALAR, FREQUENCY_BUFFER,
}
#import bevy_field_patterns::parameters::{number, vector, parameters, FREQUENCY}
#import bevy_field_patterns::passes::{surface, geometry, wave, load_item, WORKGROUP}

// From `from_frequency` to `to_frequency`.
fn blend(from_frequency: f32, to_frequency: f32, share: f32) -> f32 {
    return from_frequency + (to_frequency - from_frequency) * clamp(share, 0.0, 1.0);
}

// Parameters: the segment's ends, near, far and their frequencies.
fn distance_frequency(at: u32, p: vec3<f32>) -> f32 {
    let a = vector(at);
    let along = vector(at + 3u) - a;
    let r2 = dot(along, along);
    var share = 0.0;
    if r2 > 0.0 {
        share = clamp(dot(p - a, along) / r2, 0.0, 1.0);
    }
    let near = number(at + 6u);
    let r = distance(p, a + share * along);
    return blend(number(at + 8u), number(at + 9u), (r - near) / (number(at + 7u) - near));
}

// Parameters: the plane, the least size of a pixel, pixels of a period.
fn screen_frequency(at: u32, p: vec3<f32>) -> f32 {
    let size = max(dot(vector(at), p) + number(at + 3u), number(at + 4u));
    return 1.0 / (number(at + 5u) * size);
}

// Parameters: which scalar, the two values and their frequencies.
fn scalar_frequency(at: u32, scalars: vec2<f32>) -> f32 {
    let low = number(at + 1u);
    let s = select(scalars.x, scalars.y, surface[at] == 1u);
    return blend(number(at + 3u), number(at + 4u), (s - low) / (number(at + 2u) - low));
}

fn given(base: u32, i: u32) -> f32 {
    return geometry[base + i / 4u][i % 4u];
}

fn frequency(record: u32, i: u32) -> f32 {
    let vertex = surface[record + 5u] + 2u * i;
    let at = parameters(record) + FREQUENCY;
    switch (surface[record + 20u] >> 8u) & 255u {
        case FREQUENCY_VERTICES: {
            return given(surface[record + 22u], i);
        }
        case FREQUENCY_DISTANCE: {
            return distance_frequency(at, geometry[vertex].xyz);
        }
        case FREQUENCY_SCREEN: {
            return screen_frequency(at, geometry[vertex].xyz);
        }
        case FREQUENCY_SCALAR: {
            return scalar_frequency(at, wave[surface[record + 19u] + i]);
        }
        case FREQUENCY_BUFFER: {
            let f = given(surface[record + 22u], bitcast<u32>(geometry[vertex + 1u].w));
            return select(0.0, f, f > 0.0 && f < 3e38);
        }
        default: {
            return number(record + 10u);
        }
    }
}

@compute @workgroup_size(64)
fn frequencies(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        wave[surface[item.x + 6u] + 2u * i + 1u].y = frequency(item.x, i);
    }
}
