#define_import_path bevy_field_patterns::coverage

// Periodic profiles seen through a pixel; the twin of `coverage.rs`. Pure functions.
//
// x      position in the period, 0 at the middle of the stripe                  [periods]
// w      how far the phase moves along the pixel's two sides                     [periods/pixel]
// a, b   the larger and the smaller of the two                                   [periods/pixel]
// duty   share of a period that is stripe
//
// Inside a pixel the phase is linear, so the mean over the pixel's square is the profile through two boxes, one per
// side, of widths a and b: a trapezoid, in closed form. That is what supersampling converges to.

const PI: f32 = 3.141592653589793;
// Behind this nothing but the mean is left.
const MAX_PERIODS: f32 = 64.0;
// The signs of a second difference over the trapezoid's four corners.
const CORNERS = vec4(1.0, -1.0, -1.0, 1.0);

struct Coverage {
    // Share of the pixel that is stripe, 0 to 1.
    value: f32,
    // Its derivative [1/period].
    slope: f32,
}

// The trapezoid: reach of its foot and of its top, and a b.
struct Pixel {
    foot: f32,
    top: f32,
    area: f32,
}

fn pixel_of(w: vec2<f32>) -> Pixel {
    let a = clamp(max(w.x, w.y), 1e-4, MAX_PERIODS);
    // A tenth does not show, and keeps the differences below exact.
    let b = clamp(min(w.x, w.y), 0.1 * a, MAX_PERIODS);
    return Pixel(0.5 * (a + b), 0.5 * (a - b), a * b);
}

// The trapezoid's corners, seen from x.
fn corners(x: f32, pixel: Pixel) -> vec4<f32> {
    return x + vec4(pixel.foot, pixel.top, -pixel.top, -pixel.foot);
}

// A step from 0 to 1 at t = 0, through the trapezoid.
fn step_coverage(t: f32, pixel: Pixel) -> Coverage {
    let at = clamp(t, -pixel.foot, pixel.foot);
    let r = max(corners(at, pixel), vec4(0.0));
    let signs = CORNERS / pixel.area;
    return Coverage(0.5 * dot(signs, r * r), dot(signs, r));
}

fn wrapped(x: f32) -> f32 {
    return x - round(x);
}

// Two boxes as wide as the softness asks for, next to those of the pixel. At softness 1 the stripe's slopes meet.
fn soft_width(softness: f32, duty: f32, w: vec2<f32>) -> vec2<f32> {
    let soft = 0.5 * softness * min(duty, 1.0 - duty);
    return sqrt(soft * soft + w * w);
}

// Stripes of width `duty`.
fn pulse_coverage(x: f32, duty: f32, w: vec2<f32>) -> Coverage {
    let pixel = pixel_of(w);
    let u = wrapped(x);
    let h = 0.5 * duty;
    if pixel.foot > 0.5 {
        // More than two edges are in reach: differences of the second integral of the profile less its mean.
        let signs = CORNERS / pixel.area;
        let beyond = corners(u, pixel);
        let at = beyond - round(beyond);
        let inside = clamp(at, vec4(-h), vec4(h));
        let integral = at * at * (1.0 - duty) - (at - inside) * (at - inside);
        return Coverage(duty + 0.5 * dot(signs, integral), dot(signs, inside - duty * at));
    }
    let v = abs(u);
    let near = step_coverage(h - v, pixel);
    let far = step_coverage(h + v, pixel);
    let next = step_coverage(h + v - 1.0, pixel);
    return Coverage(near.value + far.value + next.value - 1.0, sign(u) * (far.slope + next.slope - near.slope));
}

// The share of a wave's first harmonic that passes the filter.
fn harmonic_passed(w: vec2<f32>) -> f32 {
    let a = PI * min(w, vec2(MAX_PERIODS));
    let sinc = select(sin(a) / max(a, vec2(1e-4)), vec2(1.0), a < vec2(1e-3));
    return sinc.x * sinc.y;
}

fn sine_coverage(x: f32, w: vec2<f32>) -> Coverage {
    let passed = harmonic_passed(w);
    let angle = 2.0 * PI * wrapped(x);
    return Coverage(0.5 + 0.5 * passed * cos(angle), -PI * passed * sin(angle));
}

// Rises from 0 to 1 over a period and drops at x = -1/4, where sin(Phi) = 0 and rises.
fn sawtooth_coverage(x: f32, w: vec2<f32>) -> Coverage {
    let pixel = pixel_of(w);
    let u = fract(x + 0.25);
    if pixel.foot > 0.5 {
        let signs = CORNERS / pixel.area;
        let at = fract(corners(u, pixel));
        let integral = at * (at * (at / 6.0 - 0.25) + 1.0 / 12.0);
        return Coverage(0.5 + dot(signs, integral), dot(signs, 0.5 * at * (at - 1.0)));
    }
    let drop = step_coverage(u, pixel);
    let next = step_coverage(u - 1.0, pixel);
    return Coverage(u + 1.0 - drop.value - next.value, 1.0 - drop.slope - next.slope);
}
