#define_import_path bevy_field_patterns::kite

// The aligned distance (Eq. 2 of Lichtenberg et al. 2018) and complex numbers; the twin of `kite.rs`.
//
// e        edge v_i - v_j, from a source j to a target i      [length]
// d_i, d_j unit directions at target and source
// turns    a phase                                             [periods]
// z        phasor cis(phase)

const TAU: f32 = 6.283185307179586;

// For directions that are oriented alike. At most sqrt(2) |e|. [length]
fn aligned_distance(e: vec3<f32>, d_j: vec3<f32>, d_i: vec3<f32>) -> f32 {
    return dot(e, d_j + d_i) / (1.0 + max(0.0, dot(d_i, d_j)));
}

fn phasor(turns: f32) -> vec2<f32> {
    let angle = TAU * (turns - round(turns));
    return vec2(cos(angle), sin(angle));
}

fn cmul(a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// The phasor of pi - phase: z seen from a direction turned round, -conj(z).
fn reversed(z: vec2<f32>) -> vec2<f32> {
    return vec2(-z.x, z.y);
}
