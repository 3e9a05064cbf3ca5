#define_import_path bevy_field_patterns::coverage

// Periodic profiles seen through a pixel; the twin of `coverage.rs`. Pure functions.
//
// x      position in the period, 0 at the middle of the stripe   [periods]
// w      footprint: how much of a period a pixel covers           [periods/pixel]
// duty   share of a period that is stripe
//
// The filter is a box of width w taken twice, a tent of half-width w: continuous at the pixel's border, and zero at
// every multiple of 1/w, so that from one period per pixel on nothing but the mean is left.

const PI: f32 = 3.141592653589793;

struct Coverage {
    // Share of the pixel that is stripe, 0 to 1.
    value: f32,
    // Its derivative [1/period].
    slope: f32,
}

// The integral of the unit tent up to t: a smooth step from t = -1 to 1.
fn tent_step(t: f32) -> f32 {
    let u = 1.0 - min(abs(t), 1.0);
    let half = 0.5 * u * u;
    return select(half, 1.0 - half, t > 0.0);
}

fn tent(t: f32) -> f32 {
    return max(0.0, 1.0 - abs(t));
}

fn wrapped(x: f32) -> f32 {
    return x - round(x);
}

// The tent that softness and footprint make together. At softness 1 the stripe's slopes meet.
fn soft_width(softness: f32, duty: f32, w: f32) -> f32 {
    let soft = 0.5 * softness * min(duty, 1.0 - duty);
    return clamp(sqrt(soft * soft + w * w), 1e-4, 1.0);
}

// Stripes of width `duty`, through a tent of half-width w.
fn pulse_coverage(x: f32, duty: f32, w: f32) -> Coverage {
    let u = wrapped(x);
    let width = clamp(w, 1e-4, 1.0);
    var out: Coverage;
    for (var k = -1; k <= 1; k++) {
        let rise = (u + f32(k) + 0.5 * duty) / width;
        let fall = (u + f32(k) - 0.5 * duty) / width;
        out.value += tent_step(rise) - tent_step(fall);
        out.slope += (tent(rise) - tent(fall)) / width;
    }
    return out;
}

// The share of a wave's first harmonic that passes the filter: sinc^2.
fn harmonic_passed(w: f32) -> f32 {
    let a = PI * min(w, 1.0);
    let sinc = select(sin(a) / max(a, 1e-4), 1.0, a < 1e-3);
    return sinc * sinc;
}

fn sine_coverage(x: f32, w: f32) -> Coverage {
    let passed = harmonic_passed(w);
    let angle = 2.0 * PI * wrapped(x);
    return Coverage(0.5 + 0.5 * passed * cos(angle), -PI * passed * sin(angle));
}

// Rises from 0 to 1 over a period and drops at x = -1/4, where sin(Phi) = 0 and rises.
fn sawtooth_coverage(x: f32, w: f32) -> Coverage {
    let u = fract(x + 0.25);
    let width = clamp(w, 1e-4, 1.0);
    var out = Coverage(u + 1.0, 1.0);
    for (var k = 0; k <= 1; k++) {
        out.value -= tent_step((u - f32(k)) / width);
        out.slope -= tent((u - f32(k)) / width) / width;
    }
    return out;
}
