#define_import_path bevy_field_patterns::focus

// How much a point of the world is in focus, the twin of `Focus::weight`. Pure functions.
//
// region   centre and radius of a ball, or normal and distance of a plane   [world units]
// border   width of the soft border                                          [world units]
// weight   1 where a style applies, 0 where not

const FOCUS_SHAPE: u32 = 3u;
const FOCUS_SPHERE: u32 = 1u;
const FOCUS_INVERT: u32 = 4u;
const FOCUS_CUTOUT: u32 = 8u;
const FOCUS_COLOR: u32 = 16u;
const FOCUS_WIDTH: u32 = 32u;

struct Focus {
    region: vec4<f32>,
    border: f32,
    flags: u32,
}

fn focus_weight(focus: Focus, position: vec3<f32>) -> f32 {
    let shape = focus.flags & FOCUS_SHAPE;
    if shape == 0u {
        return 1.0;
    }
    let region = focus.region;
    let depth = select(
        dot(region.xyz, position) - region.w,
        region.w - distance(region.xyz, position),
        shape == FOCUS_SPHERE,
    );
    let inside = smoothstep(0.0, 1.0, depth / focus.border + 0.5);
    return select(inside, 1.0 - inside, (focus.flags & FOCUS_INVERT) != 0u);
}

// The weight where the focus limits `what`, else 1.
fn limited(focus: Focus, weight: f32, what: u32) -> f32 {
    return select(1.0, weight, (focus.flags & what) != 0u);
}
