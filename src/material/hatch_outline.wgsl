#define_import_path bevy_field_patterns::hatch_outline

// Contours: lines where the surface turns out of sight, of the same width on the screen everywhere, solid or dashed.
//
// q          (n . v) |n . v|, zero at the contour. There n . v grows as the square root of the distance on the screen, so
//            q grows with the distance itself, and q / |grad q| is the distance                              [pixels]
// along      unit vector along the contour, on the screen
// position   a coordinate of the surface that dashes are counted along, and its derivatives along the screen
//
// Close to a contour the surface falls away: a coordinate changes with the square root of the distance, too. Twice its
// change across a pixel times the distance is what it has changed since the contour, where dashes take it from.

#import bevy_field_patterns::hatch_style::{TAU, hatch}
#import bevy_field_patterns::hatch_strokes::{MAX_OCTAVES, stroke_coverage}
#import bevy_field_patterns::triangle_wave::Wave
#import bevy_field_patterns::wave::{PatternPoint, pattern_frame, sample_pair}

const OUTLINE_POSITION: f32 = 1.0;

struct Contour {
    // From the contour, inwards [pixels].
    distance: f32,
    inward: vec2<f32>,
    rest: vec3<f32>,
    rest_dx: vec3<f32>,
    rest_dy: vec3<f32>,
}

// Takes derivatives.
fn contour_of(facing: f32, rest: vec3<f32>) -> Contour {
    let q = facing * abs(facing);
    let slope = vec2(dpdx(q), dpdy(q));
    let steep = length(slope);
    return Contour(q / max(steep, 1e-12), slope / max(steep, 1e-12), rest, dpdx(rest), dpdy(rest));
}

// Share of the pixel that is gap, of dashes along a coordinate that moves by `slope` along the screen [periods].
fn gap_along(contour: Contour, position: f32, slope: vec2<f32>, least_octave: f32) -> f32 {
    let along = vec2(-contour.inward.y, contour.inward.x);
    let rate = abs(dot(slope, along));
    let at_contour = position - 2.0 * max(contour.distance, 0.0) * dot(slope, contour.inward);
    let octaves = clamp(-log2(max(rate * hatch.outline.y, 1e-20)), least_octave, MAX_OCTAVES);
    // Below 0 the coordinate itself is stretched.
    let stretch = exp2(min(floor(octaves), 0.0));
    let left = octaves - min(floor(octaves), 0.0);
    let w = hatch.filter_width * vec2(rate, 0.1 * rate) * stretch;
    return stroke_coverage(at_contour * stretch, hatch.outline.z, left, 0.0, w);
}

fn wave_gap(contour: Contour, wave: Wave) -> f32 {
    return gap_along(contour, atan2(wave.phasor.y, wave.phasor.x) / TAU - 0.25, wave.per_pixel, 0.0);
}

fn moves_along(contour: Contour, wave: Wave) -> f32 {
    return abs(dot(wave.per_pixel, vec2(-contour.inward.y, contour.inward.x)));
}

fn dash_gap(contour: Contour, point: PatternPoint, wave: Wave) -> f32 {
    if hatch.outline.w == OUTLINE_POSITION {
        // The axis that the contour follows most.
        let along = vec2(-contour.inward.y, contour.inward.x);
        let rates = abs(contour.rest_dx * along.x + contour.rest_dy * along.y);
        let axis = select(select(2u, 1u, rates.y >= rates.z), 0u, rates.x >= max(rates.y, rates.z));
        let slope = vec2(contour.rest_dx[axis], contour.rest_dy[axis]);
        return gap_along(contour, contour.rest[axis], slope, -32.0);
    }
    let frame = pattern_frame(point);
    if frame.pieces == 0u {
        return wave_gap(contour, wave);
    }
    let pair = sample_pair(frame, point, 0u);
    if moves_along(contour, pair.second) > moves_along(contour, pair.first) {
        return wave_gap(contour, pair.second);
    }
    return wave_gap(contour, pair.first);
}

// Share of the pixel that is contour.
fn outline_ink(contour: Contour, point: PatternPoint, wave: Wave) -> f32 {
    let line = clamp(hatch.outline.x - contour.distance + 0.5, 0.0, 1.0);
    if line <= 0.0 || hatch.outline.y <= 0.0 {
        return line;
    }
    return line * (1.0 - dash_gap(contour, point, wave));
}
