// The direction pass: d of each vertex, from wherever the entity's directions come. Glossaries in `passes.wgsl`,
// `tangent.wgsl`. Its twins are the functions of `field/`.

#import bevy_field_patterns::cross::{frame_at, root_of}
#import bevy_field_patterns::deform::carrying_map
#import bevy_field_patterns::layout::{
    FLAG_CROSS, FLAG_FOLLOW, FLAG_VECTOR, SOURCE_SCALARS, DIRECTION_VECTORS, DIRECTION_TANGENTS, DIRECTION_SNAPSHOTS,
    DIRECTION_VORTICES, DIRECTION_TENSOR, DIRECTION_SMOOTH, DIRECTION_BUFFER, DIRECTION_CURVATURE,
}
#import bevy_field_patterns::parameters::{number, vector, parameters, BLEND, CHOICE}
#import bevy_field_patterns::passes::{surface, geometry, wave, edges, load_item, load_level, WORKGROUP}
#import bevy_field_patterns::tangent::{
    any_tangent, project_tangent, unit_or_zero, turn_tangent, squared_line, line_of,
}
#import bevy_field_patterns::tensor::{eigen, carried_tensor}
#import bevy_field_patterns::vortices::vortex_flow

fn store_direction(record: u32, i: u32, direction: vec3<f32>) {
    var d = direction;
    let field = surface[record + 6u] + 2u * i;
    let flags = surface[record + 2u];
    // A line field keeps the sign that the phasor refers to, a cross field the arm.
    if (flags & (FLAG_VECTOR | FLAG_FOLLOW)) == FLAG_FOLLOW {
        let previous = vec3(wave[field], wave[field + 1u].x);
        if (flags & FLAG_CROSS) != 0u {
            let n = geometry[surface[record + 5u] + 2u * i + 1u].xyz;
            d = select(d, cross(n, d), abs(dot(previous, cross(n, d))) > abs(dot(previous, d)));
        }
        if dot(previous, d) < 0.0 {
            d = -d;
        }
    }
    wave[field] = d.xy;
    wave[field + 1u].x = d.z;
}

// Between the snapshots of even and of odd number.
fn snapshot_direction(record: u32, base: u32, i: u32, n: vec3<f32>) -> vec3<f32> {
    let map = carrying_map(record, i);
    let a = map * geometry[base + i].xyz;
    let b = map * geometry[base + surface[record] + i].xyz;
    let share = number(parameters(record) + BLEND);
    if (surface[record + 2u] & FLAG_VECTOR) != 0u {
        return project_tangent(unit_or_zero(mix(a, b, share)), n);
    }
    let x = any_tangent(n);
    let d = line_of(mix(squared_line(a, x, n), squared_line(b, x, n), share), x, n);
    return select(d, -d, dot(d, select(b, a, share < 0.5)) < 0.0);
}

fn tensor_direction(record: u32, base: u32, i: u32, n: vec3<f32>) -> vec3<f32> {
    let t = carried_tensor(geometry[base + 2u * i].xyz, geometry[base + 2u * i + 1u].xyz, carrying_map(record, i));
    let e = eigen(t[0], t[1]);
    if (surface[record + 20u] & SOURCE_SCALARS) != 0u {
        wave[surface[record + 19u] + i] = e.values.xy;
    }
    return project_tangent(select(e.vectors[0], e.vectors[1], surface[parameters(record) + CHOICE] == 1u), n);
}

// Of the directions of a cross, the one nearest to the last.
fn smooth_direction(record: u32, i: u32, n: vec3<f32>) -> vec3<f32> {
    let choice = surface[parameters(record) + CHOICE];
    let is_cross = (choice & 1u) != 0u;
    var d = root_of(frame_at(n), wave[surface[record + 24u] + 2u * i], select(2u, 4u, is_cross));
    if (choice & 4u) != 0u {
        d = cross(d, n);
    }
    if is_cross && (surface[record + 2u] & FLAG_FOLLOW) != 0u {
        let field = surface[record + 6u] + 2u * i;
        let previous = vec3(wave[field], wave[field + 1u].x);
        let turned = cross(n, d);
        d = select(d, turned, abs(dot(previous, turned)) > abs(dot(previous, d)));
        d = select(d, -d, dot(previous, d) < 0.0);
    }
    return d;
}

// Of a posed surface, whose lines lie where edge constants will be.
fn curvature_direction(record: u32, i: u32, n: vec3<f32>) -> vec3<f32> {
    let choice = surface[parameters(record) + CHOICE];
    let lines = load_level(record, 0u).edge_base + select(0u, surface[record], (choice & 2u) != 0u);
    let sign = select(1.0, -1.0, (choice & 1u) != 0u);
    return line_of(sign * edges[lines + i], any_tangent(n), n);
}

fn direction(record: u32, i: u32) -> vec3<f32> {
    let vertex = surface[record + 5u] + 2u * i;
    let n = geometry[vertex + 1u].xyz;
    let base = surface[record + 21u];
    switch surface[record + 20u] & 255u {
        case DIRECTION_VECTORS: {
            return project_tangent(unit_or_zero(carrying_map(record, i) * geometry[base + i].xyz), n);
        }
        case DIRECTION_TANGENTS: {
            return unit_or_zero(geometry[base + i].xyz);
        }
        case DIRECTION_SNAPSHOTS: {
            return snapshot_direction(record, base, i, n);
        }
        case DIRECTION_VORTICES: {
            return project_tangent(unit_or_zero(vortex_flow(record, geometry[vertex].xyz, n)), n);
        }
        case DIRECTION_TENSOR: {
            return tensor_direction(record, base, i, n);
        }
        case DIRECTION_SMOOTH: {
            return smooth_direction(record, i, n);
        }
        case DIRECTION_BUFFER: {
            // The vertex of the mesh that this one is.
            let id = bitcast<u32>(geometry[vertex + 1u].w);
            return project_tangent(unit_or_zero(carrying_map(record, i) * geometry[base + id].xyz), n);
        }
        case DIRECTION_CURVATURE: {
            return curvature_direction(record, i, n);
        }
        default: {
            return project_tangent(vector(record + 12u), n);
        }
    }
}

@compute @workgroup_size(64)
fn directions(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        var d = direction(item.x, i);
        let turn = number(item.x + 11u);
        if turn != 0.0 {
            d = turn_tangent(d, geometry[surface[item.x + 5u] + 2u * i + 1u].xyz, turn);
        }
        store_direction(item.x, i, d);
    }
}
