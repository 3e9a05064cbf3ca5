#define_import_path bevy_field_patterns::tangent

// Tangent vectors at a vertex; the twin of `tangent.rs`.
//
// n    unit normal of a vertex
// d    unit tangent, with <d, n> = 0
// u    line: the square (x + iy)^2 of a tangent's coordinates in the frame (any_tangent(n), n x any_tangent(n))

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

// The direction of v, however long it is; zero where it has none.
fn unit_or_zero(v: vec3<f32>) -> vec3<f32> {
    let a = abs(v);
    let largest = max(a.x, max(a.y, a.z));
    if largest > 0.0 && largest < 3e38 {
        return normalize(v / largest);
    }
    return vec3(0.0);
}

fn turn_tangent(d: vec3<f32>, n: vec3<f32>, angle: f32) -> vec3<f32> {
    return cos(angle) * d + sin(angle) * cross(n, d);
}

// The line of v, as long as its tangential part; zero where v is normal.
fn squared_line(v: vec3<f32>, x: vec3<f32>, n: vec3<f32>) -> vec2<f32> {
    let c = vec2(dot(v, x), dot(v, cross(n, x)));
    let r = length(c);
    if r > VANISHING * length(v) {
        return vec2(c.x * c.x - c.y * c.y, 2.0 * c.x * c.y) / r;
    }
    return vec2(0.0);
}

// The tangent at half the angle of u in the frame (x, n x x); x where u is zero.
fn line_of(u: vec2<f32>, x: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let r = length(u);
    if !(r > 0.0) {
        return x;
    }
    let c = u / r;
    // The direction of 1 + c, written so that nothing cancels.
    let half = select(vec2(abs(c.y), select(1.0 - c.x, c.x - 1.0, c.y < 0.0)), vec2(1.0 + c.x, c.y), c.x > 0.0);
    return normalize(x * half.x + cross(n, x) * half.y);
}
