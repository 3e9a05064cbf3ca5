// Cells in shadow maps and in the depth, normal and motion vector prepasses: the steps of Bevy's `pbr_prepass.wgsl`, with
// the holes of a cut-out and the normals of a bump.

#import bevy_pbr::{
    pbr_bindings,
    pbr_functions,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_prepass_functions,
    pbr_types,
    prepass_io::{VertexOutput, FragmentOutput},
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::cells::CellPoint
#import bevy_field_patterns::cell_style::{CellPaint, ScreenFrame, styled_point}
#import bevy_field_patterns::cell_paint::{paint_cell, is_hole}

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
    let frame = ScreenFrame(dpdx(in.world_position.xyz), dpdy(in.world_position.xyz));

#ifdef VISIBILITY_RANGE_DITHER
    pbr_functions::visibility_range_dither(in.position, in.visibility_range_dither);
#endif
    pbr_prepass_functions::prepass_alpha_discard(in);

    var out: FragmentOutput;
#ifdef UNCLIPPED_DEPTH_ORTHO_EMULATION
    out.frag_depth = in.unclipped_depth;
#endif
#ifdef MOTION_VECTOR_PREPASS
    out.motion_vector = pbr_prepass_functions::calculate_motion_vector(in.world_position, in.previous_world_position);
#endif
#ifdef NORMAL_PREPASS
    var normal = in.world_normal;
    if (pbr_bindings::material.flags & pbr_types::STANDARD_MATERIAL_FLAGS_UNLIT_BIT) == 0u {
        // The base's normal map included.
        normal = pbr_input_from_standard_material(in, is_front).N;
    }
#endif

#ifdef CELLS_SHAPE
    let paint = paint_cell(point, frame);
    if paint.defined {
        cut_out(paint);
#ifdef NORMAL_PREPASS
#ifdef CELLS_BUMP
        normal = bumped_normal(normal, frame.dx, frame.dy, paint.slope);
#endif
#endif
    }
#endif

#ifdef NORMAL_PREPASS
    out.normal = vec4(normal * 0.5 + vec3(0.5), 1.0);
#endif
    return out;
}
#else
@fragment
fn fragment(
    in: VertexOutput,
    @location(10) @interpolate(flat) pattern: vec2<u32>,
    @location(12) rest: vec3<f32>,
) {
    let point = styled_point(pattern, rest);
    let frame = ScreenFrame(dpdx(in.world_position.xyz), dpdy(in.world_position.xyz));
    pbr_prepass_functions::prepass_alpha_discard(in);
#ifdef CELLS_CUTOUT
    cut_out(paint_cell(point, frame));
#endif
}
#endif
