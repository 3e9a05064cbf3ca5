//! How cells look: borders, filters, every way Bevy draws a mesh, and a gallery.

use super::*;
use bevy::{
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass, MotionVectorPrepass, NormalPrepass},
    image::ImageSampler,
    material::OpaqueRendererMethod,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_field_patterns::cells::{SampleValues, planar_uvs};
use sets::{ellipse, triangulated};

#[test]
fn cells_look_as_they_should() {
    let stage = &mut cell_stage();
    borders_are_as_wide_as_asked(stage);
    far_cells_are_their_mean(stage);
    every_pass_draws(stage);
}

fn unlit(extension: Cells) -> CellMaterial {
    CellMaterial {
        base: StandardMaterial {
            unlit: true,
            ..default()
        },
        extension,
    }
}

/// White cells with black borders.
fn lines(border_width: BorderWidth) -> Cells {
    Cells {
        fill: CellFill::Base,
        border_width,
        border_color: LinearRgba::BLACK,
        ..default()
    }
}

/// Two samples with the same metric: their border is a line that is known.
fn borders_are_as_wide_as_asked(stage: &mut Stage) {
    let mesh = shapes::plane(8, 0.0, 1);
    let handle = stage.add(to_bevy_mesh(&mesh));
    for angle in [0.0_f32, 0.3, 0.8, 1.3] {
        // Neighbours along the direction of `angle`, with long axes askew to it.
        let across = Vec3::new(angle.cos(), angle.sin(), 0.0);
        let long = Vec3::new((angle + 0.7).cos(), (angle + 0.7).sin(), 0.0);
        let metric = ellipse(long, Vec3::Z, 1.2, 0.3);
        let mut set = SampleSet {
            positions: vec![-0.4 * across, 0.4 * across],
            normals: vec![Vec3::Z; 2],
            metrics: vec![metric; 2],
            neighbor_offsets: vec![0, 1, 2],
            neighbors: vec![1, 0],
            ..default()
        };
        sets::seed(&mut set, &mesh.positions, &mesh.triangles);
        let normal = (metric * across).normalize();
        // 64 pixels over 2 units; in the world twice as large.
        for (width, scale, expected) in [
            (BorderWidth::Pixels(3.0), 1.0, 3.0),
            (BorderWidth::Pixels(0.5), 1.0, 0.5),
            (BorderWidth::World(0.125), 1.0, 4.0),
            (BorderWidth::World(0.125), 2.0, 4.0),
            (BorderWidth::Relative(0.2), 1.0, 0.2 * 0.6 * 32.0),
        ] {
            let material = stage.add(unlit(lines(width)));
            let entity = spawn(stage, &handle, &set, &material);
            let at = Transform::from_scale(Vec3::splat(scale));
            stage.app.world_mut().entity_mut(entity).insert(at);
            let picture = stage.picture(square_on(64));
            stage.clear([entity]);
            let mut dark = 0.0;
            for y in 0..64 {
                for x in 0..64 {
                    let p = Vec3::new(x as f32 - 31.5, 31.5 - y as f32, 0.0);
                    let away = normal.dot(p).abs();
                    let value = picture.at(x, y).x;
                    if away > 0.5 * expected + 1.0 {
                        assert!(value > 0.99, "{width:?}: {value}, {away} pixels away");
                    }
                    if away < 0.5 * expected - 1.0 {
                        assert!(value < 0.01, "{width:?}: {value}, {away} pixels away");
                    }
                    dark += 1.0 - value;
                }
            }
            let length = 64.0 / normal.x.abs().max(normal.y.abs());
            let measured = dark / length;
            assert!(
                (measured - expected).abs() < 0.03 * expected + 0.02,
                "{width:?} at {angle}, scale {scale}: {measured} instead of {expected} pixels"
            );
        }
    }
}

/// Cells smaller than a pixel are their mean, and do not flicker; near ones are sharp.
fn far_cells_are_their_mean(stage: &mut Stage) {
    let (set, mesh) = on_square(600, FIELDS[1].1, 48);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let extension = Cells {
        fill: CellFill::Palette(vec![LinearRgba::BLACK, LinearRgba::WHITE]),
        border_width: BorderWidth::Pixels(0.0),
        ..default()
    };
    let material = stage.add(unlit(extension));
    let entity = spawn(stage, &mesh, &set, &material);
    let near = stage.picture(square_on(128));
    near.save("near");
    assert!(near.contrast() > 0.4, "contrast {} near", near.contrast());
    // About 25 by 25 cells over 8 pixels; the outer ones are background in part.
    let far = stage.picture(Lens {
        orthographic: Some(4.0),
        ..square_on(16)
    });
    stage.clear([entity]);
    for y in 5..11 {
        for x in 5..11 {
            let value = far.at(x, y).x;
            assert!((value - 0.5).abs() < 0.1, "{value} far");
        }
    }
}

/// Cells are drawn, and alike, in every way Bevy can draw them.
fn every_pass_draws(stage: &mut Stage) {
    let sun = stage.sun(Vec3::new(1.0, -2.0, 3.0), true);
    let (set, mesh) = on_torus(120, 2);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let lens = torus_view(96, 72);
    let looks = [
        ("colour", lines(BorderWidth::Pixels(2.0))),
        (
            "bump",
            Cells {
                bump: 0.3,
                ..lines(BorderWidth::Relative(0.1))
            },
        ),
        (
            "cut-out",
            Cells {
                cutout: true,
                ..lines(BorderWidth::Relative(0.3))
            },
        ),
    ];
    for (name, extension) in looks {
        let base = StandardMaterial {
            perceptual_roughness: 0.9,
            ..default()
        };
        let forward = stage.add(CellMaterial {
            base: base.clone(),
            extension: extension.clone(),
        });
        let deferred = stage.add(CellMaterial {
            base: StandardMaterial {
                opaque_render_method: OpaqueRendererMethod::Deferred,
                ..base
            },
            extension,
        });
        let entity = spawn(stage, &mesh, &set, &forward);
        let expected = stage.picture(lens);
        expected.save(&format!("pass {name}"));
        assert!(expected.contrast() > 0.02, "{name}: nothing drawn");
        for (what, msaa, prepass) in [
            ("prepass", Msaa::Off, 1),
            ("msaa", Msaa::Sample4, 0),
            ("msaa prepass", Msaa::Sample4, 1),
            ("deferred", Msaa::Off, 2),
        ] {
            let material = if prepass == 2 { &deferred } else { &forward };
            stage
                .app
                .world_mut()
                .entity_mut(entity)
                .insert(MeshMaterial3d(material.clone()));
            let (camera, target) = stage.camera(Lens { msaa, ..lens });
            let mut camera = stage.app.world_mut().entity_mut(camera);
            if prepass > 0 {
                camera.insert((DepthPrepass, MotionVectorPrepass));
            }
            if prepass == 1 {
                camera.insert(NormalPrepass);
            }
            if prepass == 2 {
                camera.insert(DeferredPrepass);
            }
            let camera = camera.id();
            settle(stage);
            stage.settle();
            let picture = stage.read(&target);
            stage.clear([camera]);
            let pairs = picture.luminance().into_iter().zip(expected.luminance());
            let apart = pairs.map(|(a, b)| (a - b).abs()).sum::<f32>() / picture.pixels.len() as f32;
            assert!(
                apart < 0.2 * expected.mean().y,
                "{name}, {what}: {apart} of {}",
                expected.mean().y
            );
        }
        stage.clear([entity]);
    }
    stage.clear([sun]);
}

/// An atlas of two tiles: rings, and a stroke along u.
fn atlas() -> Image {
    let size = 64_usize;
    let texel = |x: usize, y: usize| {
        let p = Vec2::new((x % size) as f32 + 0.5, y as f32 + 0.5) / size as f32 * 2.0 - 1.0;
        let ring = (0.5 + 0.5 * (p.length() * 14.0).cos()) * f32::from(p.length() < 0.9);
        let stroke = (1.0 - (p.y * 4.0).powi(2)).max(0.0) * f32::from(p.x.abs() < 0.8);
        let ink = if x < size { ring } else { stroke };
        [200, 60, 30, (255.0 * ink) as u8]
    };
    let data: Vec<u8> = (0..size)
        .flat_map(|y| (0..2 * size).flat_map(move |x| texel(x, y)))
        .collect();
    let extent = Extent3d {
        width: 2 * size as u32,
        height: size as u32,
        depth_or_array_layers: 1,
    };
    let mut image = Image::new(
        extent,
        TextureDimension::D2,
        data,
        TextureFormat::Rgba8UnormSrgb,
        default(),
    );
    image.sampler = ImageSampler::linear();
    image
}

/// Pictures for the eye, written where `PATTERN_PICTURES` says.
#[test]
fn gallery() {
    let stage = &mut cell_stage();
    let sun = stage.sun(Vec3::new(1.0, -2.0, 3.0), true);
    let (set, mesh) = on_torus(400, 5);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let image = stage.add(atlas());
    let looks = [
        ("stones", Cells::default()),
        (
            "cobbles",
            Cells {
                bump: 0.5,
                rounding: 0.15,
                jitter: 0.3,
                border_width: BorderWidth::Relative(0.15),
                ..default()
            },
        ),
        (
            "tissue",
            Cells {
                fill: CellFill::Palette(vec![LinearRgba::rgb(0.8, 0.25, 0.2)]),
                noise: 0.16,
                border_width: BorderWidth::Relative(0.1),
                jitter: 0.2,
                ..default()
            },
        ),
        (
            "ellipses",
            Cells {
                shape: CellShape::Ellipse { radius: 0.9 },
                ..default()
            },
        ),
        (
            "atlas",
            Cells {
                texture: Some(CellTexture {
                    image,
                    columns: 2,
                    ..default()
                }),
                ..default()
            },
        ),
        (
            "seeds",
            Cells {
                debug: CellDebug::Seed,
                ..default()
            },
        ),
    ];
    for (name, extension) in looks {
        let material = stage.add(CellMaterial {
            base: StandardMaterial::default(),
            extension,
        });
        let entity = spawn(stage, &mesh, &set, &material);
        let picture = stage.picture(torus_view(480, 360));
        picture.save(name);
        assert!(picture.contrast() > 0.01, "{name}: nothing drawn");
        stage.clear([entity]);
    }
    stage.clear([sun]);

    // A mosaic of an image with a disc.
    let set = triangulated(700, 3);
    let disc = |uv: Vec2| {
        let inside = uv.distance(Vec2::new(0.4, 0.35)) < 0.25;
        if inside {
            LinearRgba::rgb(0.9, 0.5, 0.05)
        } else {
            LinearRgba::rgb(uv.x, 0.2, uv.y)
        }
    };
    let values = SampleValues(planar_uvs(&set).into_iter().map(disc).collect());
    let material = stage.add(CellMaterial2d {
        cells: Cells {
            fill: CellFill::Values,
            ..default()
        },
        ..default()
    });
    let parts = (Mesh2d::default(), MeshMaterial2d(material), set, values);
    let entity = stage.app.world_mut().spawn(parts).id();
    settle(stage);
    let picture = picture_2d(stage, 400);
    picture.save("mosaic");
    // The disc is left of the middle and above it.
    assert!(
        picture.at(160, 140).x > 0.5 && picture.at(160, 140).z < 0.1,
        "{}",
        picture.at(160, 140)
    );
    stage.clear([entity]);
}
