//! Every style of waves, of one type: what features of Bevy are tested with.

use bevy::{
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
};
use bevy_field_patterns::material::*;

use crate::{Scene, black_on_white, hatch::hatch, stage::Stage, tensor, textures::image};

/// A style that entities can wear, whatever its material is.
pub struct Look {
    pub name: &'static str,
    wear: Box<dyn Fn(&mut Stage, &StandardMaterial, &[Entity])>,
}

impl Look {
    pub fn new<S: MaterialExtension>(name: &'static str, style: S) -> Self {
        let wear = move |stage: &mut Stage, base: &StandardMaterial, bodies: &[Entity]| {
            let material = stage.add(ExtendedMaterial {
                base: base.clone(),
                extension: style.clone(),
            });
            for &body in bodies {
                let material = MeshMaterial3d(material.clone());
                stage.app.world_mut().entity_mut(body).insert(material);
            }
            // Levels of images are made in the frame after they have come.
            stage.app.update();
            stage.app.update();
        };
        Self {
            name,
            wear: Box::new(wear),
        }
    }

    /// Gives one material to all bodies.
    pub fn wear(&self, stage: &mut Stage, base: &StandardMaterial, bodies: &[Entity]) {
        (self.wear)(stage, base, bodies);
    }
}

/// A bar across the first wave's crests, as wide as half a period.
fn bar(scene: &mut Scene) -> PatternTexture {
    let bar = image(64, 64, |u, _| {
        [0.1, 0.1, 0.1, f32::from(u8::from((u - 0.5).abs() < 0.25))]
    });
    PatternTexture {
        image: scene.stage.add(bar),
        ..default()
    }
}

/// One stroke per period.
fn strokes(tone: HatchTone) -> Hatch {
    Hatch {
        hand: HatchHand::STEADY,
        strokes: HatchStrokes {
            spacing: StrokeSpacing::Period,
            density: 0.0,
            cross_from: 1.0,
            ..default()
        },
        darkest: 0.5,
        ..hatch(tone)
    }
}

/// Stripes of the first eigenvalue only.
fn eigenvalue(color: LinearRgba) -> Tensor {
    let mut style = tensor::style();
    for (part, width) in [(&mut style.first, 1.0), (&mut style.second, 0.0)] {
        *part = Eigenvalue {
            low_color: color,
            high_color: color,
            thin: width,
            thick: width,
            ..default()
        };
    }
    style
}

/// Dark stripes across d, drawn by each style.
pub fn plain(scene: &mut Scene) -> Vec<Look> {
    vec![
        Look::new("stripes", black_on_white()),
        Look::new("texture", bar(scene)),
        Look::new("hatching", strokes(HatchTone::Constant(0.5))),
        Look::new("tensor", eigenvalue(LinearRgba::BLACK)),
    ]
}

/// The same with holes between the stripes.
pub fn cut_out(scene: &mut Scene) -> Vec<Look> {
    // On a black ground.
    let strokes = |tone| Hatch {
        cutout: true,
        ink: LinearRgba::gray(0.6),
        ..strokes(tone)
    };
    let stripes = Stripes {
        cutout: true,
        ..default()
    };
    let texture = PatternTexture {
        cutout: true,
        ..bar(scene)
    };
    let tensor = Tensor {
        cutout: true,
        ..eigenvalue(LinearRgba::gray(0.6))
    };
    vec![
        Look::new("stripes cut-out", stripes),
        Look::new("texture cut-out", texture),
        Look::new("hatching cut-out", strokes(HatchTone::Constant(0.5))),
        Look::new(
            "hatching by light cut-out",
            strokes(HatchTone::Light { light: 0.5, dark: 0.0 }),
        ),
        Look::new("tensor cut-out", tensor),
    ]
}

/// Those that have a height, with a bump as high as `bump` and as much of a colour as `base_color`.
pub fn bumped(scene: &mut Scene, bump: f32, base_color: f32) -> Vec<Look> {
    let drive = PatternDrive {
        base_color,
        bump,
        ..default()
    };
    let stripes = Stripes { drive, ..default() };
    let texture = PatternTexture { drive, ..bar(scene) };
    vec![Look::new("stripes bump", stripes), Look::new("texture bump", texture)]
}

/// What only some passes know: light, outlines, a focus, emission.
pub fn special(scene: &mut Scene) -> Vec<Look> {
    let mut shaded = hatch(HatchTone::Constant(0.3));
    shaded.paper = LinearRgba::NONE;
    shaded.outline = HatchOutline::dashed(2.0, 8.0);
    let focused = Hatch {
        focus: Focus::sphere(Vec3::X, 0.6),
        ..shaded.clone()
    };
    let drive = PatternDrive {
        bump: 0.02,
        roughness: 0.1,
        emissive: 0.1,
        ..default()
    };
    let texture = PatternTexture { drive, ..bar(scene) };
    vec![
        Look::new("hatching by light", strokes(HatchTone::Light { light: 0.3, dark: 0.0 })),
        Look::new("hatching over shading", shaded),
        Look::new("hatching in focus", focused),
        Look::new("stripes driving", Stripes { drive, ..default() }),
        Look::new("texture driving", texture),
    ]
}
