// Cells in shadow maps and in the depth, normal and motion vector prepasses: the steps of Bevy's `pbr_prepass.wgsl`, with
// the holes of a cut-out and the normals of a bump.

#import bevy_pbr::{
    pbr_functions,
    pbr_prepass_functions,
    prepass_io::VertexOutput,
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::cells::CellPoint
#import bevy_field_patterns::cell_style::{CellPaint, screen_frame, styled_point}
#import bevy_field_patterns::cell_paint::{paint_cell, is_hole}

#ifdef PREPASS_FRAGMENT
#import bevy_pbr::prepass_io::FragmentOutput
#import bevy_field_patterns::pattern_output::prepass_output
#ifdef NORMAL_PREPASS
#import bevy_field_patterns::pattern_output::prepass_normal
#endif
#endif

// As in the main pass, so that both draw the same pixels.
fn cut_out(paint: CellPaint) {
#ifdef CELLS_CUTOUT
    if is_hole(paint) {
        discard;
    }
#endif
}

#ifdef PREPASS_FRAGMENT
@fragment
fn fragment(
    in: VertexOutput,
    @builtin(front_facing) is_front: bool,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(12) rest: vec3<f32>,
) -> FragmentOutput {
    let point = styled_point(pattern, rest);
    let frame = screen_frame(in.world_position.xyz, in.position);

#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    pbr_prepass_functions::prepass_alpha_discard(in);

    var normal = vec3(0.0);
#ifdef NORMAL_PREPASS
    normal = prepass_normal(in, is_front);
#endif

#ifdef CELLS_SHAPE
    let paint = paint_cell(point, frame);
    if paint.defined {
        cut_out(paint);
#ifdef CELLS_BUMP
        normal = bumped_normal(normal, frame.dx, frame.dy, paint.slope);
#endif
    }
#endif

    return prepass_output(in, normal);
}
#else
@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(12) rest: vec3<f32>,
) {
    let point = styled_point(pattern, rest);
    let frame = screen_frame(in.world_position.xyz, in.position);
    pbr_prepass_functions::prepass_alpha_discard(in);
#ifdef CELLS_CUTOUT
    cut_out(paint_cell(point, frame));
#endif
}
#endif
