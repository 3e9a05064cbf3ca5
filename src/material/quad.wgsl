#define_import_path bevy_field_patterns::quad

// What the four fragments of a 2x2 quad tell each other.

// The value, or the mean of those of the fragment's quad that are `there`. A texture unit may take the gradients of one
// invocation for all four, also of one that only helps and does not see the buffers. Takes derivatives: call it in uniform
// control flow.
fn quad_shared(value: vec4<f32>, there: bool, frag_coord: vec4<f32>) -> vec4<f32> {
    let side = 1.0 - 2.0 * (floor(frag_coord.xy) - 2.0 * floor(0.5 * frag_coord.xy));
    let own = select(vec4(0.0), value, there);
    let one = select(0.0, 1.0, there);
    let row = 2.0 * own + side.x * dpdxFine(own);
    let row_count = 2.0 * one + side.x * dpdxFine(one);
    let sum = 2.0 * row + side.y * dpdyFine(row);
    let count = 2.0 * row_count + side.y * dpdyFine(row_count);
    return select(sum / max(count, 1.0), value, there);
}
