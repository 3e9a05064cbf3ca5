// Cells over a StandardMaterial, in the main pass and in the deferred pass: the steps of Bevy's `pbr.wgsl` with one more,
// `apply_cells`, between the material's textures and its lighting.

#import bevy_pbr::{
    pbr_types,
    pbr_types::{PbrInput, STANDARD_MATERIAL_FLAGS_UNLIT_BIT},
    pbr_functions::alpha_discard,
    pbr_fragment::pbr_input_from_standard_material,
    decal::clustered::apply_decals,
}
#import bevy_field_patterns::bump::bumped_normal
#import bevy_field_patterns::cell_style::{CellPaint, ScreenFrame, screen_frame, styled_point}
#import bevy_field_patterns::cell_paint::{paint_cell, is_hole}
#import bevy_field_patterns::pattern_output::pattern_output

#ifdef PREPASS_PIPELINE
#import bevy_pbr::prepass_io::{VertexOutput, FragmentOutput}
#else
#import bevy_pbr::forward_io::{VertexOutput, FragmentOutput}
#endif

#ifdef VISIBILITY_RANGE_DITHER
#import bevy_pbr::pbr_functions::visibility_range_dither;
#endif

fn apply_cells(pbr: ptr<function, PbrInput>, paint: CellPaint, frame: ScreenFrame) {
    let material = &(*pbr).material;

#ifdef CELLS_CUTOUT
    let alpha_mode = (*material).flags & pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_RESERVED_BITS;
    if alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_OPAQUE
        || alpha_mode == pbr_types::STANDARD_MATERIAL_FLAGS_ALPHA_MODE_MASK {
        if is_hole(paint) {
            discard;
        }
    } else {
        (*material).base_color.a *= paint.solid;
    }
#endif

    let base = (*material).base_color;
    (*material).base_color = vec4(base.rgb * paint.layer.w + paint.layer.rgb, base.a);

#ifdef CELLS_BUMP
    // The normal prepass has bent its normals already, where they are read back.
#ifndef LOAD_PREPASS_NORMALS
    (*pbr).N = bumped_normal((*pbr).N, frame.dx, frame.dy, paint.slope);
    (*pbr).clearcoat_N = bumped_normal((*pbr).clearcoat_N, frame.dx, frame.dy, paint.slope);
#endif
#endif

#ifdef CELLS_DEBUG
    (*material).flags |= STANDARD_MATERIAL_FLAGS_UNLIT_BIT;
#endif
}

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
    visibility_range_dither(in.position, in.visibility_range_dither);
#endif

    var pbr = pbr_input_from_standard_material(in, is_front);
    pbr.material.base_color = alpha_discard(pbr.material, pbr.material.base_color);
    let paint = paint_cell(point, frame);
    if paint.defined {
        apply_cells(&pbr, paint, frame);
    }
    apply_decals(&pbr);
    return pattern_output(in, pbr);
}
