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

// What the frequency pass knows of an entity.
struct Source {
    geometry_base: u32,
    field_base: u32,
    given_base: u32,
    scalar_base: u32,
    // Of the parameters of frequencies.
    at: u32,
    uniform_frequency: f32,
}

fn load_source(record: u32) -> Source {
    return Source(
        surface[record + 5u],
        surface[record + 6u],
        surface[record + 22u],
        surface[record + 19u],
        parameters(record) + FREQUENCY,
        number(record + 10u),
    );
}

fn frequency(source: Source, i: u32) -> f32 {
    let vertex = source.geometry_base + 2u * i;
    switch #{KIND}u {
        case FREQUENCY_VERTICES: {
            return given(source.given_base, i);
        }
        case FREQUENCY_DISTANCE: {
            return distance_frequency(source.at, geometry[vertex].xyz);
        }
        case FREQUENCY_SCREEN: {
            return screen_frequency(source.at, geometry[vertex].xyz);
        }
        case FREQUENCY_SCALAR: {
            return scalar_frequency(source.at, wave[source.scalar_base + i]);
        }
        case FREQUENCY_BUFFER: {
            let f = given(source.given_base, bitcast<u32>(geometry[vertex + 1u].w));
            return select(0.0, f, f > 0.0 && f < 3e38);
        }
        default: {
            return source.uniform_frequency;
        }
    }
}

@compute @workgroup_size(64)
fn frequencies(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let source = load_source(item.x);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        wave[source.field_base + 2u * i + 1u].y = frequency(source, i);
    }
}
