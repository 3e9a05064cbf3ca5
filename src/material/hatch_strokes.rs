//! Strokes of a tone, each a part of the strokes of every darker tone: the CPU twin of `hatch_strokes.wgsl`.
//!
//! In: a position in the period (0 at the crest), a tone as the share of the area that is ink, and how often the number of
//! strokes per period has doubled. Out: the share of the pixel that is ink. Strokes lie on the multiples of 1/2ⁿ of a
//! period. While n is on its way to n + 1, new strokes grow halfway between the old ones, and the old ones give up as much
//! area as the new ones take.
//!
//! What holds, whatever the settings:
//!
//! | theorem | why |
//! |---|---|
//! | ink covers `share` of every period | n strokes of width `share` / n; growing ones take from the others. Soft edges that meet, where `share` (1 + softness) > 1, leave a little less |
//! | a darker tone's ink contains a lighter tone's | `octaves` grows at most as fast as log2 `share`, so no stroke gets thinner |
//! | nearer by, all strokes stay where they are | multiples of 1/2ⁿ are multiples of 1/2ⁿ⁺¹ |
//! | Φ and π - Φ look the same | x becomes -x, and so does the set of strokes |
//!
//! Because of the last one a line field, on which only sin Φ is defined, can be hatched without seams.

use super::coverage::pulse_coverage;
use bevy::math::Vec2;

/// The most doublings of the number of strokes in a period.
pub const MAX_OCTAVES: f32 = 8.0;

/// Doublings of the number of strokes: `zoom` at the tone `width`, and `density` (0..=1) more with each doubling of the
/// tone; not above `most`.
pub fn octaves_of(share: f32, width: f32, density: f32, zoom: f32, most: f32) -> f32 {
    (zoom + density * (share.max(1e-4) / width).log2()).clamp(0.0, most.clamp(0.0, MAX_OCTAVES))
}

/// One stroke per unit of x, as wide as `width`; softer the wider it is, so that it covers all of any thinner one.
fn stroke(x: f32, width: f32, softness: f32, w: Vec2) -> f32 {
    let soft = 0.5 * softness * width;
    pulse_coverage(x, width, Vec2::new(soft.hypot(w.x), soft.hypot(w.y))).value
}

/// The share of a pixel that is ink, 0..=1; `w` in periods per pixel.
pub fn stroke_coverage(x: f32, share: f32, octaves: f32, softness: f32, w: Vec2) -> f32 {
    let whole = octaves.floor();
    let many = whole.exp2();
    // Of the distance between strokes.
    let grown = share * (whole - octaves).exp2();
    let growing = share - grown;
    let at = x * many;
    (stroke(at, grown, softness, w * many) + stroke(at + 0.5, growing, softness, w * many)).clamp(0.0, 1.0)
}

/// The shares of two families of strokes that cross, which together are ink over `share` of the area: the second sets in
/// at `cross_from` (0..=1), and from there both darken alike.
pub fn crossed_shares(share: f32, cross_from: f32) -> [f32; 2] {
    if share <= cross_from {
        return [share, 0.0];
    }
    let clear = ((1.0 - share) / (1.0 - cross_from).max(1e-6)).sqrt();
    [1.0 - clear * (1.0 - cross_from), 1.0 - clear]
}
