#define_import_path bevy_field_patterns::kite

// The aligned distance (Eq. 2 of Lichtenberg et al. 2018), complex numbers, and how the waves of two frames belong
// together; the twin of `kite.rs` and `waves.rs`.
//
// e        edge v_i - v_j, from a source j to a target i      [length]
// d_i, d_j unit directions at target and source
// turns    a phase                                             [periods]
// z        phasor cis(phase)
// frame    directions of the waves at a vertex: d and n x d
// k        quarter turns 0..3 about the normal that bring one frame nearest to another

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

// Which turns of a frame change nothing about a pattern.
struct Coupling {
    // 1 or 2.
    waves: u32,
    // d and -d differ.
    vector: bool,
    // d, n x d and their opposites are the same.
    cross: bool,
}

struct Frame {
    first: vec3<f32>,
    second: vec3<f32>,
}

// The turns that bring frame j nearest to frame i, among those that leave the pattern as it is.
fn quarter_turns(coupling: Coupling, j: Frame, i: Frame) -> u32 {
    var c = dot(i.first, j.first);
    if coupling.waves == 2u {
        c += dot(i.second, j.second);
    }
    if coupling.cross {
        let q = dot(i.first, j.second) - dot(i.second, j.first);
        if abs(c) < abs(q) {
            return select(3u, 1u, q > 0.0);
        }
    } else if coupling.vector {
        return 0u;
    }
    return select(0u, 2u, c < 0.0);
}

// What wave r of a frame is after k quarter turns: the wave that was, ...
fn turned_wave(k: u32, r: u32) -> u32 {
    return (k + r) & 1u;
}

// ... and whether it is reversed.
fn turned_reversed(k: u32, r: u32) -> bool {
    return ((k + r) & 2u) != 0u;
}

fn direction_of(frame: Frame, r: u32) -> vec3<f32> {
    return select(frame.first, frame.second, r == 1u);
}
