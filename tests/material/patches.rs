//! Period cells of a texture: where their middles are, and which tile they show.
#![allow(clippy::print_stdout, reason = "what was measured")]

use bevy::prelude::*;
use bevy_field_patterns::{
    field::Symmetry,
    wave::{
        shade_pair::{WavePair, sample_pair},
        shade_patch::{SurfacePoint, cell_middle},
    },
};

use crate::{Scene, patterns::Pattern, probe, probe_picture, torus_view};

/// A fragment of a picture: the waves there, and where the shader and the twin say that its cell has its middle.
struct Fragment {
    pair: WavePair,
    middle: Vec3,
    twin: Vec3,
}

/// What a picture of the probes shows; `None` where it shows no pattern.
fn fragments(scene: &mut Scene, tag: u32, mesh: &Handle<Mesh>) -> Vec<Option<Fragment>> {
    let lens = torus_view(WIDTH as u32, HEIGHT as u32);
    let modes = [probe::BARYCENTRICS, probe::TRIANGLE, probe::MIDDLE_XY, probe::MIDDLE_Z];
    let [barycentrics, triangles, xy, z] = modes.map(|mode| probe_picture(scene, mode, mesh, tag, lens));
    let memory = scene.memory.view();
    let fragment = |k: usize| {
        let triangle = triangles.pixels[k];
        // Halves hold integers up to 2048.
        if triangle.w != 0.5 || triangle.x > 2048.0 {
            return None;
        }
        let [xy, z] = [xy.pixels[k], z.pixels[k]];
        let b = barycentrics.pixels[k];
        let (b0, b1) = (probe::joined(b.x, b.y), probe::joined(b.z, b.w));
        let point = SurfacePoint {
            triangle: triangle.x as u32,
            barycentrics: Vec3::new(b0, b1, 1.0 - b0 - b1),
        };
        let pair_at = |at: SurfacePoint| sample_pair(&memory, tag, at.triangle, at.barycentrics)[0];
        let twin = cell_middle(&memory, tag, point, Vec2::splat(0.5)).expect("two waves");
        Some(Fragment {
            pair: pair_at(point),
            middle: Vec3::new(
                probe::joined(xy.x, xy.y),
                probe::joined(xy.z, xy.w),
                probe::joined(z.x, z.y),
            ),
            twin: pair_at(twin).waves[0].position,
        })
    };
    (0..WIDTH * HEIGHT).map(fragment).collect()
}

const WIDTH: usize = 192;
const HEIGHT: usize = 128;
/// Further than this from where a fragment expects its cell's middle, in periods, is another cell's, or none.
const ASTRAY: f32 = 0.3;
/// Pixels around a fragment in which nothing branches.
const CALM: usize = 9;

impl Fragment {
    fn confidence(&self) -> f32 {
        self.pair
            .waves
            .map(|wave| wave.confidence)
            .into_iter()
            .fold(1.0, f32::min)
    }

    /// How far `middle` is from where the fragment's own waves expect the middle of its cell, in periods.
    fn off(&self, middle: Vec3) -> f32 {
        let step = middle - self.pair.waves[0].position;
        let moved = self.pair.waves.map(|wave| wave.gradient.dot(step));
        (self.pair.uv() + Vec2::from_array(moved) - 0.5).length()
    }
}

/// On a solved torus all fragments of a cell find its middle, and the shader finds what the twin finds.
pub fn cells_have_one_middle(scene: &mut Scene) {
    let axis = Vec3::new(0.15, 1.0, 0.1).normalize();
    let mesh = scene.torus_mesh.clone();
    for (symmetry, frequency) in [(Symmetry::Line, 5.0), (Symmetry::Vector, 5.0), (Symmetry::Line, 12.0)] {
        let pattern = Pattern::torus(0.4, 0.6, axis, frequency, symmetry).with_relaxed_second_wave(0.8);
        let tag = scene.memory.push(&pattern);
        scene.upload();
        let fragments = fragments(scene, tag, &mesh);
        let (mut seen, mut apart, mut calm, mut astray, mut by_place) = (0, 0, 0, 0, 0);
        for (k, fragment) in fragments.iter().enumerate() {
            let Some(fragment) = fragment else { continue };
            let (x, y) = (k % WIDTH, k / WIDTH);
            seen += 1;
            apart += usize::from(fragment.middle.distance(fragment.twin) > 0.01 / frequency);
            let around = |v: usize, end: usize| v.saturating_sub(CALM)..(v + CALM + 1).min(end);
            let is_calm = around(y, HEIGHT).all(|y| {
                let row = fragments[y * WIDTH..][around(x, WIDTH)].iter();
                row.flatten().all(|near| near.confidence() > 0.85)
            });
            if is_calm {
                calm += 1;
                astray += usize::from(fragment.off(fragment.middle) > ASTRAY);
                by_place += usize::from(fragment.off(fragment.pair.waves[0].position) > ASTRAY);
            }
        }
        println!(
            "{symmetry:?} {frequency}: {apart} of {seen} not as the twin, {astray} of {calm} calm ones astray, {by_place} \
             by their own place"
        );
        assert!(
            seen > 1000 && calm > 150,
            "only {seen} fragments seen, {calm} of them calm"
        );
        assert!(
            apart * 200 < seen,
            "{apart} of {seen} fragments are not as the twin says"
        );
        // Waves that turn or are stretched are not where a fragment expects them.
        assert!(
            astray * 100 < calm,
            "{astray} of {calm} fragments away from branches are astray"
        );
        assert!(by_place * 2 > calm, "the comparison cannot fail");
    }
}
