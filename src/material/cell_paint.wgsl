#define_import_path bevy_field_patterns::cell_paint

// What a fragment of cells looks like: fill, texture, border, bump and the mean far away, put together. Words and units as
// in `cell_style.wgsl`.

#import bevy_field_patterns::cells::{CellPoint, Cell, find_cell, seen_from, TINY}
#import bevy_field_patterns::cell_style::{
    CellPaint, ScreenFrame, style, fill_of, mean_fill, over, premultiplied, line_coverage, to_ellipse, world_scale,
    FLAG_ELLIPSES, UNIT_PIXELS, UNIT_WORLD, UNIT_RELATIVE, PACKED, MAX_PIXEL_LINE,
}
#ifdef CELLS_TEXTURE
#import bevy_field_patterns::cell_style::{tile_gradient, tile_of}
#endif
#ifdef CELLS_DEBUG
#import bevy_field_patterns::cell_debug::debug_color
#endif

// How many ellipse radii a pixel covers, along the screen's axis that covers more.
fn cells_per_pixel(cell: Cell, point: CellPoint) -> f32 {
    let dx = seen_from(cell.site, cell.site.p + point.dx);
    let dy = seen_from(cell.site, cell.site.p + point.dy);
    return max(length(dx), length(dy));
}

// The unit in which borders are measured. [unit/length]
fn border_scale(per_pixel: vec2<f32>, world: f32, cell: Cell) -> f32 {
    switch style.border_unit {
        case UNIT_WORLD: { return world; }
        case UNIT_RELATIVE: { return 1.0 / max(cell.site.radius, TINY); }
        default: { return 1.0 / max(length(per_pixel), TINY); }
    }
}

// The height of a cell over its border, from 0 there to 1 at `bump_width` from it, on either side of the border.
fn pillow(border: f32, radius: f32) -> f32 {
    let t = min(abs(border) / max(style.bump_width * radius, TINY), 1.0);
    return t * (2.0 - t);
}

// Takes derivatives: call it in uniform control flow.
fn paint_cell(point: CellPoint, frame: ScreenFrame) -> CellPaint {
    var paint: CellPaint;
    var cell = find_cell(point, style.rounding);
#ifdef CELLS_TEXTURE
    let gradient = tile_gradient(point, cell, frame);
#endif
    if !cell.defined {
        return paint;
    }
    paint.defined = true;
    let ellipses = (style.flags & FLAG_ELLIPSES) != 0u;
    if ellipses {
        cell = to_ellipse(cell, point.normal);
    }
    let extent = cells_per_pixel(cell, point);
    paint.fade = smoothstep(0.8, 2.0, extent);

    let per_pixel = vec2(dot(cell.inwards, point.dx), dot(cell.inwards, point.dy));
    let world = world_scale(per_pixel, frame);
    let scale = border_scale(per_pixel, world, cell);
    let b = scale * cell.border;
    let pixel = scale * length(per_pixel);
    var half_width = 0.5 * style.border_width;
    if style.border_unit == UNIT_PIXELS {
        half_width = min(half_width, MAX_PIXEL_LINE / max(extent, TINY));
    }

    var fill = fill_of(point.tag, cell.sample);
    let inside = clamp(0.5 + b / max(pixel, TINY), 0.0, 1.0);
    if ellipses {
        fill = mix(premultiplied(style.gap_color), fill, inside);
    } else if inside < 1.0 && style.rounding == 0.0 {
        fill = mix(fill_of(point.tag, cell.neighbor), fill, inside);
    }
#ifdef CELLS_TEXTURE
    fill = over(fill, mix(vec4(0.0, 0.0, 0.0, 1.0), tile_of(point, cell, gradient), inside));
#endif
    var line = line_coverage(b, half_width, pixel);
    if style.rounding > 0.0 && !ellipses {
        // All that lies beyond the rounded border.
        line = clamp(0.5 + (half_width - b) / max(pixel, TINY), 0.0, 1.0);
    }
    let near = over(fill, mix(vec4(0.0, 0.0, 0.0, 1.0), premultiplied(style.border_color), line));
    paint.layer = mix(near, far_layer(point.tag, half_width / max(pixel, TINY) * extent, ellipses), paint.fade);
    paint.solid = select(1.0 - line, clamp(0.5 + (b + half_width) / max(pixel, TINY), 0.0, 1.0), ellipses);

    // The mean slope over the pixel, so that grooves narrower than a pixel do not glitter.
    let across = length(per_pixel);
    let low = pillow(cell.border - 0.5 * across, cell.site.radius);
    let high = pillow(cell.border + 0.5 * across, cell.site.radius);
    let slope = style.bump * cell.site.radius * (high - low) / max(across, TINY);
    paint.slope = slope * (1.0 - paint.fade) * per_pixel * world;
#ifdef CELLS_DEBUG
    paint.layer = vec4(debug_color(style.debug, cell, point), 0.0);
    paint.solid = 1.0;
#endif
    return paint;
}

// The mean of cells that are smaller than a pixel. `line`: half a border's width in ellipse radii.
fn far_layer(tag: u32, line: f32, ellipses: bool) -> vec4<f32> {
    let share = min(PACKED * style.ellipse_radius * style.ellipse_radius, 1.0);
    let inner = 1.0 - min(line, 1.0);
    let border = select(1.0 - inner * inner, min(4.0 * line * style.ellipse_radius * PACKED, 1.0), ellipses);
    let fill = mix(premultiplied(style.gap_color), mean_fill(tag), select(1.0, share, ellipses));
    return over(fill, mix(vec4(0.0, 0.0, 0.0, 1.0), premultiplied(style.border_color), border));
}

// Whether a cut-out has a hole here.
fn is_hole(paint: CellPaint) -> bool {
    return paint.defined && paint.solid < 0.5;
}
