// The passes that pose a surface: positions by morph targets and joints, then normals and areas. Twins: `twin.rs` and
// `surface/geometry.rs`. Glossary in `passes.wgsl`; words of a pose in `layout.rs`.
//
// A pose's positions are laid down where edge constants will be, so that every vertex finds those of its neighbours while
// its own place in the geometry is written.

#import bevy_field_patterns::layout::POSE_WORDS
#import bevy_field_patterns::passes::{surface, edges, load_item, load_level, WORKGROUP}

// As binding 3 of `passes.wgsl`, to be written.
@group(0) @binding(3) var<storage, read_write> posed: array<vec4<f32>>;

// Where weighted normals cancel to less than this part of their weights, there is none.
const CANCELED: f32 = 1e-5;
// A triangle with a smaller sine has no area.
const FLAT: f32 = 1e-6;

fn load_float(at: u32) -> f32 {
    return bitcast<f32>(surface[at]);
}

fn load_row(at: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(vec4(surface[at], surface[at + 1u], surface[at + 2u], surface[at + 3u]));
}

// A position through the matrix whose rows begin at a word.
fn carried(matrix: u32, p: vec3<f32>) -> vec3<f32> {
    let v = vec4(p, 1.0);
    return vec3(dot(load_row(matrix), v), dot(load_row(matrix + 4u), v), dot(load_row(matrix + 8u), v));
}

fn displaced(record: u32, pose: u32, i: u32) -> vec3<f32> {
    var p = posed[surface[pose + 4u] + 2u * i].xyz;
    let vertices = surface[record];
    let weights = pose + POSE_WORDS + 12u * surface[pose];
    for (var t = 0u; t < surface[pose + 1u]; t++) {
        let weight = load_float(weights + t);
        if weight != 0.0 {
            let at = surface[pose + 3u] + 3u * (t * vertices + i);
            p += weight * vec3(load_float(at), load_float(at + 1u), load_float(at + 2u));
        }
    }
    return p;
}

fn posed_vertex(record: u32, i: u32) -> vec3<f32> {
    let pose = surface[record + 26u];
    let matrices = pose + POSE_WORDS;
    let p = displaced(record, pose, i);
    if surface[pose + 2u] == 0u {
        return carried(matrices, p);
    }
    let skin = surface[pose + 2u] + 6u * i;
    let last = surface[pose] - 1u;
    var sum = vec3(0.0);
    for (var k = 0u; k < 4u; k++) {
        let joint = (surface[skin + k / 2u] >> (16u * (k % 2u))) & 0xffffu;
        let weight = load_float(skin + 2u + k);
        if weight != 0.0 {
            sum += weight * carried(matrices + 12u * min(joint, last), p);
        }
    }
    return sum;
}

@compute @workgroup_size(64)
fn pose_vertices(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let laid_down = load_level(item.x, 0u).edge_base;
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        let p = posed_vertex(item.x, i);
        edges[laid_down + 2u * i] = p.xy;
        edges[laid_down + 2u * i + 1u] = vec2(p.z, 0.0);
    }
}

fn load_position(laid_down: u32, i: u32) -> vec3<f32> {
    return vec3(edges[laid_down + 2u * i], edges[laid_down + 2u * i + 1u].x);
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

fn store_posed(record: u32, laid_down: u32, i: u32) {
    let pose = surface[record + 26u];
    let p = load_position(laid_down, i);
    var sum = vec3(0.0);
    var weight = 0.0;
    var area = 0.0;
    let end = surface[surface[pose + 5u] + i + 1u];
    for (var k = surface[surface[pose + 5u] + i]; k < end; k++) {
        let corner = surface[surface[pose + 6u] + k];
        let triangle = surface[record + 4u] + corner - corner % 3u;
        var ab = load_position(laid_down, surface[triangle + (corner + 1u) % 3u]) - p;
        var ac = load_position(laid_down, surface[triangle + (corner + 2u) % 3u]) - p;
        // Products of tiny edges would vanish, those of huge ones overflow.
        let scale = max(max_component(ab), max_component(ac));
        ab /= max(scale, 1e-37);
        ac /= max(scale, 1e-37);
        let bc = ac - ab;
        let product = cross(ab, ac);
        let sine = length(product);
        if sine > FLAT * max(max(dot(ab, ab), dot(ac, ac)), dot(bc, bc)) {
            let angle = angle_of(sine, dot(ab, ac));
            sum += angle / sine * product;
            weight += angle;
            area += sine / 6.0 * scale * scale;
        }
    }
    let r = length(sum);
    var normal = vec3(0.0, 0.0, 1.0);
    if r > CANCELED * weight {
        normal = sum / r;
    }
    let to = surface[record + 5u] + 2u * i;
    posed[to] = vec4(p, min(area, 3.4e38));
    posed[to + 1u] = vec4(normal, posed[surface[pose + 4u] + 2u * i + 1u].w);
}

@compute @workgroup_size(64)
fn pose_normals(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    let item = load_item(group);
    let laid_down = load_level(item.x, 0u).edge_base;
    for (var i = item.z + local; i < item.w; i += WORKGROUP) {
        store_posed(item.x, laid_down, i);
    }
}
