//! What a style can say: focus, images, travelling, debug looks; and pictures of them to look at.

use bevy::{
    image::{ImageAddressMode, ImageSampler, ImageSamplerDescriptor},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_field_patterns::material::*;

use crate::{
    Scene, WHITE, square_on,
    stage::{Lens, Picture},
    torus_view, unlit,
};

/// Stripes are drawn inside a focus, not outside, and the twin of the weight agrees.
pub fn focus_limits(scene: &mut Scene) {
    let focus = Focus {
        border: 0.2,
        ..Focus::sphere(Vec3::new(0.3, 0.0, 0.0), 0.5)
    };
    let extension = Stripes {
        color: LinearRgba::BLACK,
        gap_color: LinearRgba::BLACK,
        focus,
        ..default()
    };
    let material = scene.stage.add(unlit(extension));
    let body = scene
        .stage
        .body(&scene.plane_mesh.clone(), &material, scene.plane_x, Transform::IDENTITY);
    let picture = scene.stage.picture(square_on(64));
    picture.save("focus");
    scene.stage.clear([body]);
    for y in 0..64 {
        for x in 0..64 {
            let position = Vec3::new((x as f32 + 0.5) / 32.0 - 1.0, 1.0 - (y as f32 + 0.5) / 32.0, 0.0);
            let expected = 1.0 - focus.weight(position);
            assert!((picture.at(x, y).x - expected).abs() < 2e-3, "at {position}");
        }
    }
}

/// Images are read over sin Φ and over Φ; far away they are their mean, weighted as the wave dwells on them.
pub fn images_are_profiles(scene: &mut Scene) {
    let texels: [[u8; 4]; 4] = [[255, 0, 0, 255], [255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]];
    let size = Extent3d {
        width: 4,
        height: 1,
        depth_or_array_layers: 1,
    };
    let mut image = Image::new(
        size,
        TextureDimension::D2,
        texels.concat(),
        TextureFormat::Rgba8Unorm,
        default(),
    );
    image.sampler = ImageSampler::Descriptor(ImageSamplerDescriptor {
        address_mode_u: ImageAddressMode::Repeat,
        ..ImageSamplerDescriptor::nearest()
    });
    let image = scene.stage.add(image);
    // The wave spends a third of a period below -1/2, a third above 1/2 and a third between.
    let over_sine = Vec3::new(0.5, 1.0 / 6.0, 1.0 / 3.0);
    let over_phase = Vec3::new(0.5, 0.25, 0.25);
    let looks = [
        ("ramp", Profile::Ramp(image.clone()), over_sine),
        ("periodic", Profile::Periodic(image), over_phase),
    ];
    for (name, profile, mean) in looks {
        let material = scene.stage.add(unlit(Stripes {
            color: WHITE,
            profile,
            ..default()
        }));
        let mesh = scene.plane_mesh.clone();
        let body = scene.stage.body(&mesh, &material, scene.plane_x, Transform::IDENTITY);
        let near = scene.stage.picture(square_on(128));
        near.save(name);
        let far = scene.stage.picture(Lens {
            orthographic: Some(8.0),
            ..square_on(8)
        });
        scene.stage.clear([body]);
        assert!(
            (near.mean().truncate() - mean).abs().max_element() < 0.02,
            "{name}: mean {} near",
            near.mean()
        );
        let center = far.at(4, 4).truncate();
        assert!((center - mean).abs().max_element() < 0.07, "{name}: {center} far");
        // A quarter of a period after sin Φ = 0 rising.
        let crest = near.at(64 + 8, 64).truncate();
        assert!(name != "ramp" || crest == Vec3::Z, "{crest} at the crest");
    }
}

/// A travelling phase moves stripes of a vector field and leaves those of a line field alone.
pub fn travelling_needs_a_vector_field(scene: &mut Scene) {
    let still = Stripes {
        color: LinearRgba::BLACK,
        gap_color: WHITE,
        ..default()
    };
    let moved = Stripes {
        phase_offset: 0.25,
        phase_speed: 3.0,
        ..still.clone()
    };
    assert_eq!(still.requires_vector_symmetry(), None);
    assert!(moved.requires_vector_symmetry().is_some());
    let mesh = scene.torus_mesh.clone();
    for (tag, changes) in [(scene.line, false), (scene.vector, true)] {
        let pictures = [still.clone(), moved.clone()].map(|stripes| {
            let material = scene.stage.add(unlit(stripes));
            let body = scene.stage.body(&mesh, &material, tag, Transform::IDENTITY);
            let picture = scene.stage.picture(torus_view(96, 64));
            scene.stage.clear([body]);
            picture
        });
        assert_eq!(pictures[0].max_difference(&pictures[1]) > 0.5, changes);
    }
}

/// Every debug style draws something of its own.
pub fn debug_styles_draw(scene: &mut Scene) {
    let styles = [
        DebugStyle::Phase,
        DebugStyle::Singular,
        DebugStyle::Angle,
        DebugStyle::Colors,
        DebugStyle::Energy,
    ];
    let mesh = scene.torus_mesh.clone();
    let saving = std::env::var("PATTERN_PICTURES").is_ok();
    let lens = if saving {
        torus_view(400, 300)
    } else {
        torus_view(96, 64)
    };
    let mut pictures: Vec<Picture> = vec![];
    for (kind, tag) in [("line", scene.line), ("vector", scene.vector)] {
        for debug in styles {
            let material = scene.stage.add(StripeMaterial {
                base: default(),
                extension: Stripes { debug, ..default() },
            });
            let body = scene.stage.body(&mesh, &material, tag, Transform::IDENTITY);
            let picture = scene.stage.picture(lens);
            picture.save(&format!("debug {debug:?} {kind}"));
            scene.stage.clear([body]);
            if tag == scene.line {
                let new = pictures.iter().all(|other| other.max_difference(&picture) > 0.05);
                assert!(new && picture.contrast() > 0.02, "{debug:?} shows nothing");
                pictures.push(picture);
            }
        }
    }
}

/// Larger pictures to look at; drawn only where `PATTERN_PICTURES` names a directory.
pub fn gallery(scene: &mut Scene) {
    if std::env::var("PATTERN_PICTURES").is_err() {
        return;
    }
    let sun = scene.stage.sun(Vec3::new(1.0, 3.0, 2.0), true);
    let floor = scene.stage.add(Mesh::from(Plane3d::default().mesh().size(20.0, 20.0)));
    let white = scene.stage.add(StandardMaterial {
        perceptual_roughness: 1.0,
        ..default()
    });
    let ground = scene.stage.body(&floor, &white, 0, Transform::from_xyz(0.0, -0.6, 0.0));
    let base = StandardMaterial {
        base_color: Color::srgb(0.9, 0.85, 0.75),
        perceptual_roughness: 0.5,
        ..default()
    };
    let mesh = scene.torus_mesh.clone();
    let two_sided = StandardMaterial {
        double_sided: true,
        cull_mode: None,
        ..base.clone()
    };
    let emboss = PatternDrive {
        bump: 0.015,
        roughness: -0.3,
        base_color: 0.5,
        ..default()
    };
    let looks = [
        ("stripes", base.clone(), Stripes::default()),
        (
            "soft",
            base.clone(),
            Stripes {
                softness: 1.0,
                ..default()
            },
        ),
        (
            "thin",
            base.clone(),
            Stripes {
                duty: 0.15,
                ..default()
            },
        ),
        (
            "cut-out",
            two_sided,
            Stripes {
                cutout: true,
                ..default()
            },
        ),
        (
            "bump",
            base.clone(),
            Stripes {
                drive: emboss,
                ..default()
            },
        ),
    ];
    for (name, base, extension) in looks {
        for (kind, tag) in [("line", scene.line), ("vector", scene.vector)] {
            let material = scene.stage.add(StripeMaterial {
                base: base.clone(),
                extension: extension.clone(),
            });
            let body = scene.stage.body(&mesh, &material, tag, Transform::IDENTITY);
            // Three distances of the plain stripes, one of the others.
            let distances = [("middle", 1.0), ("near", 0.45), ("far", 6.0)];
            for (distance, scale) in distances.into_iter().take(if name == "stripes" { 3 } else { 1 }) {
                let from = Vec3::new(0.3, 2.3, 2.6) * scale;
                let to = if scale < 1.0 {
                    Vec3::new(0.5, 0.2, 0.8)
                } else {
                    Vec3::ZERO
                };
                let picture = scene.stage.picture(Lens {
                    width: 400,
                    height: 300,
                    from,
                    to,
                    ..default()
                });
                picture.save(&format!("gallery {name} {kind} {distance}"));
            }
            scene.stage.clear([body]);
        }
    }
    scene.stage.clear([sun, ground]);
}
