// A pattern of points on the vertices of another surface; the twin of `carry.rs`, where it is explained. Glossary in
// `passes.wgsl`.
//
// surface[carry_base] is the record of the points' pattern, then follow the nearest points of each vertex.

#import bevy_field_patterns::layout::{FLAG_CROSS, FLAG_VECTOR, NO_VERTEX}
#import bevy_field_patterns::kite::{
    Coupling, Frame, aligned_distance, cmul, direction_of, phasor, quarter_turns, reversed, turned_reversed, turned_wave,
}
#import bevy_field_patterns::passes::{surface, geometry, wave, load_item, normalize_or, WORKGROUP}
#import bevy_field_patterns::tangent::project_tangent

// As in `carry.rs`.
const POINTS: u32 = 6u;
const SAME_SIDE: f32 = 0.2;

// An entity's places in the shared buffers.
struct Places {
    geometry_base: u32,
    field_base: u32,
    phasor_base: u32,
}

fn load_places(record: u32) -> Places {
    return Places(surface[record + 5u], surface[record + 6u], surface[record + 7u]);
}

fn load_frame(points: Places, j: u32) -> Frame {
    let n = geometry[points.geometry_base + 2u * j + 1u].xyz;
    let d = vec3(wave[points.field_base + 2u * j], wave[points.field_base + 2u * j + 1u].x);
    return Frame(d, cross(n, d));
}

// The direction of wave r of a frame after some turns.
fn turned_direction(frame: Frame, turns: u32, r: u32) -> vec3<f32> {
    let d = direction_of(frame, turned_wave(turns, r));
    return select(d, -d, turned_reversed(turns, r));
}

fn carry_vertex(points: Places, own: Places, coupling: Coupling, ratio: f32, nearest: u32, i: u32) {
    let place = geometry[own.geometry_base + 2u * i].xyz;
    let normal = geometry[own.geometry_base + 2u * i + 1u].xyz;
    var reach = 0.0;
    var any_aside = false;
    for (var n = 0u; n < POINTS; n++) {
        let j = surface[nearest + n];
        if j != NO_VERTEX {
            reach = distance(geometry[points.geometry_base + 2u * j].xyz, place);
            any_aside = any_aside || dot(geometry[points.geometry_base + 2u * j + 1u].xyz, normal) > SAME_SIDE;
        }
    }
    // Weight of each point, 0 where it does not count, and its turns.
    var weights: array<f32, 6>;
    var turns: array<u32, 6>;
    var first = Frame(vec3(0.0), vec3(0.0));
    var found = false;
    var total = 0.0;
    var mean = vec3(0.0);
    var frequency = 0.0;
    for (var n = 0u; n < POINTS; n++) {
        let j = surface[nearest + n];
        weights[n] = 0.0;
        turns[n] = 0u;
        if j == NO_VERTEX {
            continue;
        }
        let n_j = geometry[points.geometry_base + 2u * j + 1u].xyz;
        if any_aside && dot(n_j, normal) <= SAME_SIDE {
            continue;
        }
        let frame = load_frame(points, j);
        if !found {
            first = frame;
            found = true;
        }
        let t = distance(geometry[points.geometry_base + 2u * j].xyz, place) / max(reach, 1.17549435e-38);
        let near = max(1.0 - t * t, 0.0);
        weights[n] = near * near + 1e-4;
        turns[n] = quarter_turns(coupling, frame, first);
        total += weights[n];
        mean += weights[n] * turned_direction(frame, turns[n], 0u);
        frequency += weights[n] * wave[points.field_base + 2u * j + 1u].y;
    }
    frequency /= max(total, 1e-4);
    let r_mean = length(mean);
    let d = project_tangent(select(vec3(0.0), mean / max(r_mean, 1e-37), r_mean > 0.0), normal);
    let own_frame = Frame(d, cross(normal, d));
    wave[own.field_base + 2u * i] = d.xy;
    wave[own.field_base + 2u * i + 1u] = vec2(d.z, frequency);
    for (var r = 0u; r < coupling.waves; r++) {
        var sum = vec2(0.0);
        for (var n = 0u; n < POINTS; n++) {
            if weights[n] > 0.0 {
                let j = surface[nearest + n];
                let f = 0.5 * (wave[points.field_base + 2u * j + 1u].y + frequency) * select(1.0, ratio, r == 1u);
                var z = wave[points.phasor_base + coupling.waves * j + turned_wave(turns[n], r)];
                z = normalize_or(z, vec2(1.0, 0.0));
                z = select(z, reversed(z), turned_reversed(turns[n], r));
                let along = turned_direction(load_frame(points, j), turns[n], r);
                let way = place - geometry[points.geometry_base + 2u * j].xyz;
                sum += weights[n] * cmul(z, phasor(f * aligned_distance(way, along, direction_of(own_frame, r))));
            }
        }
        wave[own.phasor_base + coupling.waves * i + r] = normalize_or(sum, vec2(1.0, 0.0));
    }
}

@compute @workgroup_size(64)
fn carry(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let carry_base = surface[item.x + 25u];
    let points = load_places(surface[carry_base]);
    let own = load_places(item.x);
    let flags = surface[item.x + 2u];
    let coupling = Coupling(surface[item.x + 17u], (flags & FLAG_VECTOR) != 0u, (flags & FLAG_CROSS) != 0u);
    let ratio = bitcast<f32>(surface[item.x + 18u]);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        carry_vertex(points, own, coupling, ratio, carry_base + 1u + POINTS * i, i);
    }
}
