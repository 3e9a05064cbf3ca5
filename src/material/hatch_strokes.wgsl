#define_import_path bevy_field_patterns::hatch_strokes

// Strokes of a tone, each a part of the strokes of every darker tone; the twin of `hatch_strokes.rs`. Pure functions.
//
// x        position in the period, 0 at the crest                             [periods]
// share    share of the area that is ink: the tone
// octaves  how often the number of strokes per period has doubled, not whole while new strokes grow
// w        how far the phase moves along the pixel's two sides                 [periods/pixel]

#import bevy_field_patterns::coverage::pulse_coverage

const MAX_OCTAVES: f32 = 8.0;

// `zoom` doublings at the tone `width`; `density` more with each doubling of the tone; not above `most`.
fn octaves_of(share: f32, width: f32, density: f32, zoom: f32, most: f32) -> f32 {
    return clamp(zoom + density * log2(max(share, 1e-4) / width), 0.0, clamp(most, 0.0, MAX_OCTAVES));
}

// One stroke per unit of x, as wide as `width`; softer the wider it is, so that it covers all of any thinner one.
fn stroke(x: f32, width: f32, softness: f32, w: vec2<f32>) -> f32 {
    let soft = 0.5 * softness * width;
    return pulse_coverage(x, width, sqrt(soft * soft + w * w)).value;
}

// Share of the pixel that is ink. Strokes lie on the multiples of 1/2^n of a period; those that grow, halfway between.
fn stroke_coverage(x: f32, share: f32, octaves: f32, softness: f32, w: vec2<f32>) -> f32 {
    let whole = floor(octaves);
    let many = exp2(whole);
    // Of the distance between strokes.
    let grown = share * exp2(whole - octaves);
    let growing = share - grown;
    let at = x * many;
    return clamp(stroke(at, grown, softness, w * many) + stroke(at + 0.5, growing, softness, w * many), 0.0, 1.0);
}

// Shares of two families of strokes that cross, which together are ink over `share` of the area: the second sets in at
// `cross_from`, and from there both darken alike.
fn crossed_shares(share: f32, cross_from: f32) -> vec2<f32> {
    if share <= cross_from {
        return vec2(share, 0.0);
    }
    let clear = sqrt((1.0 - share) / max(1.0 - cross_from, 1e-6));
    return 1.0 - vec2(clear * (1.0 - cross_from), clear);
}
