#define_import_path bevy_field_patterns::cross

// Lines and crosses at the nodes of the hierarchy; the twin of the small functions of `smooth.rs`.
//
// ring   2: lines, 4: crosses
// u      cis(ring * angle) of a direction in its frame            [complex]
// frame  x and n of a tangent plane; y = n x x

#import bevy_field_patterns::kite::cmul
#import bevy_field_patterns::tangent::{any_tangent, VANISHING}

// Normals that are more opposite than this cosine say nothing of each other.
const OPPOSITE: f32 = -0.99;

struct Frame {
    x: vec3<f32>,
    n: vec3<f32>,
}

struct Pair {
    a: vec3<f32>,
    b: vec3<f32>,
}

fn frame_at(n: vec3<f32>) -> Frame {
    return Frame(any_tangent(n), n);
}

fn power(c: vec2<f32>, ring: u32) -> vec2<f32> {
    let squared = cmul(c, c);
    if ring == 4u {
        return cmul(squared, squared);
    }
    return squared;
}

// u of the tangent part of v; zero where v is normal.
fn power_of(frame: Frame, v: vec3<f32>, ring: u32) -> vec2<f32> {
    let c = vec2(dot(v, frame.x), dot(v, cross(frame.n, frame.x)));
    let r = length(c);
    if r > VANISHING * length(v) {
        return power(c / r, ring);
    }
    return vec2(0.0);
}

// A direction with this u; x where it is zero.
fn root_of(frame: Frame, u: vec2<f32>, ring: u32) -> vec3<f32> {
    if u.x == 0.0 && u.y == 0.0 {
        return frame.x;
    }
    let angle = atan2(u.y, u.x) / f32(ring);
    return frame.x * cos(angle) + cross(frame.n, frame.x) * sin(angle);
}

// u of a frame, in another one.
fn carried_power(frame: Frame, u: vec2<f32>, source: Frame, ring: u32) -> vec2<f32> {
    let c = dot(source.n, frame.n);
    if c < OPPOSITE {
        return vec2(0.0);
    }
    let w = cross(source.n, frame.n);
    let x = source.x + cross(w, source.x) + cross(w, cross(w, source.x)) / (1.0 + c);
    return cmul(power(vec2(dot(x, frame.x), dot(x, cross(frame.n, frame.x))), ring), u);
}

fn better(best: Pair, a: vec3<f32>, b: vec3<f32>) -> Pair {
    let c = dot(a, b);
    if abs(c) > dot(best.a, best.b) {
        return Pair(a, select(b, -b, c < 0.0));
    }
    return best;
}

// The representatives of two directions that fit best.
fn compatible(a: vec3<f32>, n_a: vec3<f32>, b: vec3<f32>, n_b: vec3<f32>, ring: u32) -> Pair {
    var best = Pair(a, select(b, -b, dot(a, b) < 0.0));
    if ring == 4u {
        let turned_a = cross(n_a, a);
        let turned_b = cross(n_b, b);
        best = better(best, a, turned_b);
        best = better(best, turned_a, b);
        best = better(best, turned_a, turned_b);
    }
    return best;
}
