#define_import_path bevy_field_patterns::tangent

// Tangents at a vertex; the twin of `field/tangent.rs`, and how a pass stores them. Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::{FLAG_VECTOR, FLAG_FOLLOW}
#import bevy_field_patterns::passes::{surface, wave}

// A projected length below which a direction says nothing.
const VANISHING: f32 = 1e-6;

fn any_tangent(n: vec3<f32>) -> vec3<f32> {
    return normalize(cross(n, select(vec3(0.0, 1.0, 0.0), vec3(1.0, 0.0, 0.0), abs(n.x) < 0.6)));
}

fn project_tangent(v: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let tangent = v - n * dot(n, v);
    let r = length(tangent);
    if r > VANISHING {
        return tangent / r;
    }
    return any_tangent(n);
}

fn turn_tangent(d: vec3<f32>, n: vec3<f32>, angle: f32) -> vec3<f32> {
    return cos(angle) * d + sin(angle) * cross(n, d);
}

// A direction and a frequency of an entity's vertex.
fn store_direction(record: u32, i: u32, direction: vec3<f32>, frequency: f32) {
    var d = direction;
    let field = surface[record + 6u] + 2u * i;
    // A line field keeps the sign that the phasor refers to.
    if (surface[record + 2u] & (FLAG_VECTOR | FLAG_FOLLOW)) == FLAG_FOLLOW {
        let previous = vec3(wave[field], wave[field + 1u].x);
        if dot(previous, d) < 0.0 {
            d = -d;
        }
    }
    wave[field] = d.xy;
    wave[field + 1u] = vec2(d.z, frequency);
}

// The same, turned by the entity's angle.
fn store_turned(record: u32, i: u32, direction: vec3<f32>, n: vec3<f32>, frequency: f32) {
    let turn = bitcast<f32>(surface[record + 11u]);
    var d = direction;
    if turn != 0.0 {
        d = turn_tangent(d, n, turn);
    }
    store_direction(record, i, d, frequency);
}
