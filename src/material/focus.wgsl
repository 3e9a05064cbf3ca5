#define_import_path bevy_field_patterns::focus

// Where a style applies; `focus.rs` explains the settings. Pure functions.

const FOCUS_SHAPE: u32 = 3u;
const FOCUS_SPHERE: u32 = 1u;
const FOCUS_INVERT: u32 = 4u;
const FOCUS_CUTOUT: u32 = 8u;
const FOCUS_COLOR: u32 = 16u;
const FOCUS_WIDTH: u32 = 32u;

struct Focus {
    // Centre and radius, or normal and distance. [world units]
    region: vec4<f32>,
    // Width of the soft border, above 0. [world units]
    border: f32,
    flags: u32,
}

// 1 where the style applies, 0 where not.
fn focus_weight(focus: Focus, position: vec3<f32>) -> f32 {
    let shape = focus.flags & FOCUS_SHAPE;
    if shape == 0u {
        return 1.0;
    }
    let depth = select(
        dot(focus.region.xyz, position) - focus.region.w,
        focus.region.w - distance(focus.region.xyz, position),
        shape == FOCUS_SPHERE,
    );
    let inside = smoothstep(0.0, 1.0, depth / focus.border + 0.5);
    return select(inside, 1.0 - inside, (focus.flags & FOCUS_INVERT) != 0u);
}

// The weight, for what is limited by it; 1 for what is not.
fn limited(focus: Focus, weight: f32, what: u32) -> f32 {
    return select(1.0, weight, (focus.flags & what) != 0u);
}
