// Directions of a posed surface that are made from those at rest: carried along by the deformation, or projected from an
// axis. Twin: `carry_directions` in `twin.rs`. Glossary in `passes.wgsl`; words of a pose in `layout.rs`.

#import bevy_field_patterns::layout::POSE_AXIS
#import bevy_field_patterns::passes::{surface, geometry, wave, load_item, load_level, WORKGROUP}
#import bevy_field_patterns::tangent::{any_tangent, project_tangent, store_turned}

// Added to the matrix of a vertex's edges, which is divided by its trace.
const RIDGE: f32 = 1e-6;

// Where the deformation takes the tangent d of vertex i.
fn deformed(record: u32, rest: u32, i: u32, d: vec3<f32>) -> vec3<f32> {
    let base = surface[record + 5u];
    let n = geometry[rest + 2u * i + 1u].xyz;
    let x = any_tangent(n);
    let y = cross(n, x);
    let v = geometry[rest + 2u * i];
    let v_now = geometry[base + 2u * i].xyz;
    let scale = inverseSqrt(max(v.w, 1.17549435e-38));
    let level = load_level(record, 0u);
    let first = surface[level.offset_base + i];
    let end = surface[level.offset_base + i + 1u];
    var aa = 0.0;
    var ab = 0.0;
    var bb = 0.0;
    // Sums of the edges as they are now, times the tangential coordinates they had.
    var along_x = vec3(0.0);
    var along_y = vec3(0.0);
    for (var k = first; k < end; k++) {
        let j = surface[level.neighbor_base + k];
        let e = (geometry[rest + 2u * j].xyz - v.xyz) * scale;
        let moved = (geometry[base + 2u * j].xyz - v_now) * scale;
        let a = dot(e, x);
        let b = dot(e, y);
        aa += a * a;
        ab += a * b;
        bb += b * b;
        along_x += a * moved;
        along_y += b * moved;
    }
    let trace = aa + bb;
    if !(trace > 0.0) {
        return d;
    }
    aa = aa / trace + RIDGE;
    ab = ab / trace;
    bb = bb / trace + RIDGE;
    let p = dot(d, x);
    let q = dot(d, y);
    let t = (bb * p - ab * q) * along_x + (aa * q - ab * p) * along_y;
    let r = length(t);
    return select(d, t / max(r, 1e-37), r > 1e-30);
}

fn carry_vertex(record: u32, i: u32) {
    let pose = surface[record + 26u];
    let n = geometry[surface[record + 5u] + 2u * i + 1u].xyz;
    let rest_field = surface[pose + 7u] + 2u * i;
    let last = wave[rest_field + 1u];
    var d = vec3(wave[rest_field], last.x);
    if (surface[pose + 9u] & POSE_AXIS) == 0u {
        d = deformed(record, surface[pose + 4u], i, d);
    }
    store_turned(record, i, project_tangent(d, n), n, last.y);
}

@compute @workgroup_size(64)
fn carry_directions(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        carry_vertex(item.x, i);
    }
}
