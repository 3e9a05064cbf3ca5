// The passes that pose a surface: positions by morph targets and joints, then normals and areas. Twins: `twin.rs` and
// `surface/geometry.rs`. Glossary in `passes.wgsl`; words of a pose in `layout.rs`.
//
// Posed positions are laid down apart, so that every vertex finds those of its neighbours while its own place in the
// geometry is written.

#import bevy_field_patterns::layout::{NO_VERTEX, PoseRecord}
#import bevy_field_patterns::passes::{surface, load_item, WORKGROUP}

// As binding 3 of `passes.wgsl`, to be written.
@group(0) @binding(3) var<storage, read_write> posed: array<vec4<f32>>;

// Where weighted normals cancel to less than this part of their weights, there is none.
const CANCELED: f32 = 1e-5;
// A triangle with a smaller sine has no area.
const FLAT: f32 = 1e-6;

fn load_pose(record: u32) -> PoseRecord {
    let at = surface[record + 26u];
    return PoseRecord(
        surface[at], surface[at + 1u], surface[at + 2u], surface[at + 3u], surface[at + 4u], surface[at + 5u],
        surface[at + 6u], surface[at + 7u], surface[at + 8u],
    );
}

// A position through the matrix of a joint.
fn carried(pose: PoseRecord, joint: u32, p: vec3<f32>) -> vec3<f32> {
    let row = pose.matrix_base + 3u * joint;
    let v = vec4(p, 1.0);
    return vec3(dot(posed[row], v), dot(posed[row + 1u], v), dot(posed[row + 2u], v));
}

fn displaced(pose: PoseRecord, vertices: u32, i: u32) -> vec3<f32> {
    var p = posed[pose.rest_base + 2u * i].xyz;
    for (var t = 0u; t < pose.targets; t++) {
        let weight = posed[pose.matrix_base + 3u * pose.joints + t].x;
        if weight != 0.0 {
            p += weight * posed[pose.target_base + t * vertices + i].xyz;
        }
    }
    return p;
}

fn posed_vertex(pose: PoseRecord, vertices: u32, i: u32) -> vec3<f32> {
    let p = displaced(pose, vertices, i);
    if pose.skin_base == 0u {
        return carried(pose, 0u, p);
    }
    let joints = vec4<u32>(posed[pose.skin_base + 2u * i]);
    let weights = posed[pose.skin_base + 2u * i + 1u];
    var sum = vec3(0.0);
    for (var k = 0u; k < 4u; k++) {
        if weights[k] != 0.0 {
            sum += weights[k] * carried(pose, min(joints[k], pose.joints - 1u), p);
        }
    }
    return sum;
}

@compute @workgroup_size(64)
fn pose_vertices(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let pose = load_pose(item.x);
    let vertices = surface[item.x];
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        posed[pose.position_base + i] = vec4(posed_vertex(pose, vertices, i), 0.0);
    }
}

fn max_component(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// The angle 0 .. pi with a sine >= 0 and a cosine, up to a common factor; off by 2e-6 at most, where atan2 may be off by
// much more.
fn angle_of(sine: f32, cosine: f32) -> f32 {
    let a = abs(cosine);
    let r = min(sine, a) / max(max(sine, a), 1e-37);
    let s = r * r;
    let series = ((((-0.01172120 * s + 0.05265332) * s - 0.11643287) * s + 0.19354346) * s - 0.33262347) * s + 0.99997726;
    let acute = select(series * r, 1.57079633 - series * r, sine > a);
    return select(acute, 3.14159265 - acute, cosine < 0.0);
}

// What a triangle with edges ab and ac contributes to vertex a: its normal times the angle there, and that angle; and a
// third of its area.
struct Share {
    normal: vec4<f32>,
    area: f32,
}

fn share_of(edge_b: vec3<f32>, edge_c: vec3<f32>) -> Share {
    // Products of tiny edges would vanish, those of huge ones overflow.
    let scale = max(max_component(edge_b), max_component(edge_c));
    let shrink = 1.0 / clamp(scale, 1e-37, 1e37);
    let ab = edge_b * shrink;
    let ac = edge_c * shrink;
    let bc = ac - ab;
    let product = cross(ab, ac);
    let sine = length(product);
    if sine > FLAT * max(max(dot(ab, ab), dot(ac, ac)), dot(bc, bc)) {
        let angle = angle_of(sine, dot(ab, ac));
        return Share(vec4(angle / sine * product, angle), sine / 6.0 * scale * scale);
    }
    return Share(vec4(0.0), 0.0);
}

// `to` is where (position, area) goes.
fn store_posed(pose: PoseRecord, to: u32, i: u32) {
    let p = posed[pose.position_base + i].xyz;
    var sum = vec4(0.0);
    var area = 0.0;
    var before = vec3(0.0);
    var continues = false;
    let end = surface[pose.fan_offset_base + i + 1u];
    for (var k = surface[pose.fan_offset_base + i]; k < end; k++) {
        let j = surface[pose.fan_base + k];
        let is_vertex = j != NO_VERTEX;
        let edge = posed[pose.position_base + select(i, j, is_vertex)].xyz - p;
        if is_vertex && continues {
            let share = share_of(before, edge);
            sum += share.normal;
            area += share.area;
        }
        before = edge;
        continues = is_vertex;
    }
    let r = length(sum.xyz);
    var normal = vec3(0.0, 0.0, 1.0);
    if r > CANCELED * sum.w {
        normal = sum.xyz / r;
    }
    posed[to] = vec4(p, min(area, 3.4e38));
    posed[to + 1u] = vec4(normal, posed[pose.rest_base + 2u * i + 1u].w);
}

@compute @workgroup_size(64)
fn pose_normals(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let pose = load_pose(item.x);
    let to = surface[item.x + 5u];
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        store_posed(pose, to + 2u * i, i);
    }
}
