// The direction pass: d of each vertex, from wherever the entity's directions come. Glossaries in `passes.wgsl`,
// `tangent.wgsl`. Its twins are the functions of `field/`.

#import bevy_field_patterns::cross::{frame_at, root_of}
#import bevy_field_patterns::deform::{Carrier, carrying_map, load_carrier}
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

// What the direction pass knows of an entity.
struct Source {
    record: u32,
    flags: u32,
    geometry_base: u32,
    field_base: u32,
    // Of given vectors or tensors.
    vector_base: u32,
    // Number of vertices.
    vertices: u32,
    // Of the lines of curvature.
    line_base: u32,
    // Of what a smoothed field or lines of curvature are followed from, two elements per vertex; 0: they are not.
    smooth_base: u32,
    // Of scalars that are made of a tensor; 0: none are.
    scalar_base: u32,
    choice: u32,
    blend: f32,
    axis: vec3<f32>,
    turn: f32,
    carrier: Carrier,
}

fn load_source(record: u32) -> Source {
    let at = parameters(record);
    let choice = surface[at + CHOICE];
#if KIND == 8
    // Lines of a posed surface lie where edge constants will be.
    let line_base = load_level(record, 0u).edge_base + select(0u, surface[record], (choice & 2u) != 0u);
#else
    let line_base = 0u;
#endif
    let makes_scalars = (surface[record + 20u] & SOURCE_SCALARS) != 0u;
    return Source(
        record,
        surface[record + 2u],
        surface[record + 5u],
        surface[record + 6u],
        surface[record + 21u],
        surface[record],
        line_base,
        surface[record + 24u],
        select(0u, surface[record + 19u], makes_scalars),
        choice,
        number(at + BLEND),
        vector(record + 12u),
        number(record + 11u),
        load_carrier(record),
    );
}

fn previous_direction(source: Source, i: u32) -> vec3<f32> {
    let field = source.field_base + 2u * i;
    return vec3(wave[field], wave[field + 1u].x);
}

fn store_direction(source: Source, i: u32, direction: vec3<f32>, n: vec3<f32>) {
    var d = direction;
    let field = source.field_base + 2u * i;
    // A line field keeps the sign that the phasor refers to, a cross field the arm.
    if (source.flags & (FLAG_VECTOR | FLAG_FOLLOW)) == FLAG_FOLLOW {
        let previous = previous_direction(source, i);
        let turned = cross(n, d);
        if (source.flags & FLAG_CROSS) != 0u && abs(dot(previous, turned)) > abs(dot(previous, d)) {
            d = turned;
        }
        if dot(previous, d) < 0.0 {
            d = -d;
        }
    }
    wave[field] = d.xy;
    wave[field + 1u].x = d.z;
}

// What the next frame continues from.
fn store_line(source: Source, i: u32, line: vec3<f32>) {
    let at = source.smooth_base + 2u * i;
    wave[at] = line.xy;
    wave[at + 1u] = vec2(line.z, 0.0);
}

// Between the snapshots of even and of odd number.
fn snapshot_direction(source: Source, i: u32, n: vec3<f32>) -> vec3<f32> {
    let map = carrying_map(source.carrier, i);
    let a = map * geometry[source.vector_base + i].xyz;
    let b = map * geometry[source.vector_base + source.vertices + i].xyz;
    if (source.flags & FLAG_VECTOR) != 0u {
        return project_tangent(unit_or_zero(mix(a, b, source.blend)), n);
    }
    let x = any_tangent(n);
    let d = line_of(mix(squared_line(a, x, n), squared_line(b, x, n), source.blend), x, n);
    return select(d, -d, dot(d, select(b, a, source.blend < 0.5)) < 0.0);
}

fn tensor_direction(source: Source, i: u32, n: vec3<f32>) -> vec3<f32> {
    let at = source.vector_base + 2u * i;
    let t = carried_tensor(geometry[at].xyz, geometry[at + 1u].xyz, carrying_map(source.carrier, i));
    let e = eigen(t[0], t[1]);
    if source.scalar_base != 0u {
        wave[source.scalar_base + i] = e.values.xy;
    }
    return project_tangent(select(e.vectors[0], e.vectors[1], source.choice == 1u), n);
}

// Of the directions of a cross, the one nearest to the last.
fn smooth_direction(source: Source, i: u32, n: vec3<f32>) -> vec3<f32> {
    let is_cross = (source.choice & 1u) != 0u;
    var d = root_of(frame_at(n), wave[source.smooth_base + 2u * i], select(2u, 4u, is_cross));
    store_line(source, i, d);
    if (source.choice & 4u) != 0u {
        d = cross(d, n);
    }
    if is_cross && (source.flags & FLAG_FOLLOW) != 0u {
        let previous = previous_direction(source, i);
        let turned = cross(n, d);
        d = select(d, turned, abs(dot(previous, turned)) > abs(dot(previous, d)));
        d = select(d, -d, dot(previous, d) < 0.0);
    }
    return d;
}

fn curvature_direction(source: Source, i: u32, n: vec3<f32>) -> vec3<f32> {
    let u = edges[source.line_base + i];
    let x = any_tangent(n);
    let major = line_of(u, x, n);
    if source.smooth_base != 0u {
        store_line(source, i, length(u) * major);
    }
    if (source.choice & 1u) == 0u {
        return major;
    }
    return line_of(-u, x, n);
}

fn vector_direction(source: Source, i: u32, at: u32, n: vec3<f32>) -> vec3<f32> {
    return project_tangent(unit_or_zero(carrying_map(source.carrier, i) * geometry[source.vector_base + at].xyz), n);
}

// `normal` holds the vertex of the mesh that this one is, too.
fn direction(source: Source, i: u32, normal: vec4<f32>) -> vec3<f32> {
    let n = normal.xyz;
    switch #{KIND}u {
        case DIRECTION_VECTORS: {
            return vector_direction(source, i, i, n);
        }
        case DIRECTION_TANGENTS: {
            return unit_or_zero(geometry[source.vector_base + i].xyz);
        }
        case DIRECTION_SNAPSHOTS: {
            return snapshot_direction(source, i, n);
        }
        case DIRECTION_VORTICES: {
            let p = geometry[source.geometry_base + 2u * i].xyz;
            return project_tangent(unit_or_zero(vortex_flow(source.record, p, n)), n);
        }
        case DIRECTION_TENSOR: {
            return tensor_direction(source, i, n);
        }
        case DIRECTION_SMOOTH: {
            return smooth_direction(source, i, n);
        }
        case DIRECTION_BUFFER: {
            return vector_direction(source, i, bitcast<u32>(normal.w), n);
        }
        case DIRECTION_CURVATURE: {
            return curvature_direction(source, i, n);
        }
        default: {
            return project_tangent(source.axis, n);
        }
    }
}

@compute @workgroup_size(64)
fn directions(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let source = load_source(item.x);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let normal = geometry[source.geometry_base + 2u * i + 1u];
        var d = direction(source, i, normal);
        if source.turn != 0.0 {
            d = turn_tangent(d, normal.xyz, source.turn);
        }
        store_direction(source, i, d, normal.xyz);
    }
}
