// The field passes: directions of an entity, projected from its axis (the twin of `tangent.rs`) or given by the processor.
// Glossary in `passes.wgsl`.

#import bevy_field_patterns::layout::{FLAG_CROSS, FLAG_FOLLOW, FLAG_VECTOR}
#import bevy_field_patterns::passes::{surface, geometry, wave, edges, load_item, load_level, WORKGROUP}

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

fn store_direction(record: u32, i: u32, direction: vec3<f32>, frequency: f32) {
    var d = direction;
    let field = surface[record + 6u] + 2u * i;
    let flags = surface[record + 2u];
    // A line field keeps the sign that the phasor refers to, a cross field the arm.
    if (flags & (FLAG_VECTOR | FLAG_FOLLOW)) == FLAG_FOLLOW {
        let previous = vec3(wave[field], wave[field + 1u].x);
        if (flags & FLAG_CROSS) != 0u {
            let n = geometry[surface[record + 5u] + 2u * i + 1u].xyz;
            let other = cross(n, d);
            if abs(dot(previous, other)) > abs(dot(previous, d)) {
                d = other;
            }
        }
        if dot(previous, d) < 0.0 {
            d = -d;
        }
    }
    wave[field] = d.xy;
    wave[field + 1u] = vec2(d.z, frequency);
}

fn project_vertex(record: u32, i: u32) {
    let n = geometry[surface[record + 5u] + 2u * i + 1u].xyz;
    let frequency = bitcast<f32>(surface[record + 10u]);
    let turn = bitcast<f32>(surface[record + 11u]);
    let axis = bitcast<vec3<f32>>(vec3(surface[record + 12u], surface[record + 13u], surface[record + 14u]));
    var d = project_tangent(axis, n);
    if turn != 0.0 {
        d = turn_tangent(d, n, turn);
    }
    store_direction(record, i, d, frequency);
}

@compute @workgroup_size(64)
fn project_axis(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        project_vertex(item.x, i);
    }
}

// The processor lays (d, f) of each vertex down where the edge constants will be, which follow from them.
@compute @workgroup_size(64)
fn take_directions(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let given = load_level(item.x, 0u).edge_base;
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let last = edges[given + 2u * i + 1u];
        store_direction(item.x, i, vec3(edges[given + 2u * i], last.x), last.y);
    }
}
