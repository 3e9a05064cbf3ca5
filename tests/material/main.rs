//! The stripe material and the shader library on a GPU (or Mesa's software one): one app, many small pictures.
#![allow(unreachable_pub, reason = "modules of one test")]

mod bodies;
mod hatch;
mod light;
mod looks;
mod passes;
mod patches;
mod patterns;
mod probe;
mod seams;
mod smooth;
mod stage;
mod styles;
mod tensor;
mod textures;

use bevy::{mesh::MeshTag, prelude::*};
use bevy_field_patterns::{
    field::Symmetry,
    material::*,
    wave::{Waves, shade::sample_wave, shade_pair::sample_pair},
};
use patterns::{Memory, Pattern};
use probe::Probe;
use stage::{Lens, Picture, Stage};
use std::f32::consts::PI;

const WHITE: LinearRgba = LinearRgba::WHITE;

/// All patterns of the scenes, at known tags.
struct Scene {
    stage: Stage,
    memory: Memory,
    plane_mesh: Handle<Mesh>,
    /// 4 periods over a square of size 2, along x.
    plane_x: u32,
    /// 4 periods over a square of size 2 along each of two waves, with scalars; the second one's frames are turned.
    woven: [u32; 2],
    woven_mesh: Handle<Mesh>,
    torus_mesh: Handle<Mesh>,
    line: u32,
    vector: u32,
    /// Two waves: on a line field, on a vector field, on a cross field.
    pairs: [u32; 3],
}

impl Scene {
    fn new() -> Self {
        let mut stage = Stage::new((
            StripeMaterialPlugin,
            PatternTexturePlugin,
            HatchMaterialPlugin,
            TensorMaterialPlugin,
            MaterialPlugin::<Probe>::default(),
            PatternMaterialPlugin::<Probe>::default(),
        ));
        probe::add_shader(&mut stage.app);
        let plane = Pattern::plane(2.0, 4, Vec3::X, 2.0);
        let axis = Vec3::new(0.15, 1.0, 0.1).normalize();
        let line_torus = Pattern::torus(0.4, 0.6, axis, 10.0, Symmetry::Line);
        let vector_torus = Pattern::torus(0.4, 0.6, axis, 10.0, Symmetry::Vector);
        let mut memory = Memory::new();
        let plane_x = memory.push(&plane);
        let mut woven = [0, 1].map(|turns| Pattern::woven(2.0, Waves::ORTHOGONAL, |_| turns));
        for pattern in &mut woven {
            pattern.scalars = vec![Vec2::new(0.6, 0.3); pattern.positions.len()];
        }
        let woven_mesh = stage.add(woven[0].mesh());
        let woven = woven.map(|pattern| memory.push(&pattern));
        let line = memory.push(&line_torus);
        let vector = memory.push(&vector_torus);
        let pairs = [
            line_torus.clone().with_second_wave(Waves::Orthogonal { ratio: 0.6 }),
            vector_torus.with_second_wave(Waves::Orthogonal { ratio: 1.5 }),
            line_torus.clone().with_second_wave(Waves::Cross),
        ]
        .map(|pattern| memory.push(&pattern));
        memory.upload(&mut stage.app);
        let plane_mesh = stage.add(plane.mesh());
        let torus_mesh = stage.add(line_torus.mesh());
        Self {
            stage,
            memory,
            plane_mesh,
            plane_x,
            woven,
            woven_mesh,
            torus_mesh,
            line,
            vector,
            pairs,
        }
    }
}

impl Scene {
    /// Sends patterns that were added.
    fn upload(&mut self) {
        self.memory.upload(&mut self.stage.app);
        self.stage.app.world_mut().resource_mut::<BufferGeneration>().0 += 1;
    }
}

/// Black stripes in white gaps, unlit.
fn unlit(extension: Stripes) -> StripeMaterial {
    StripeMaterial {
        base: StandardMaterial {
            unlit: true,
            ..default()
        },
        extension,
    }
}

fn black_on_white() -> Stripes {
    Stripes {
        color: LinearRgba::BLACK,
        gap_color: WHITE,
        ..default()
    }
}

/// A view that the square of size 2 fills.
fn square_on(width: u32) -> Lens {
    Lens {
        width,
        height: width,
        orthographic: Some(2.0),
        ..default()
    }
}

fn torus_view(width: u32, height: u32) -> Lens {
    Lens {
        width,
        height,
        from: Vec3::new(0.3, 2.3, 2.6),
        ..default()
    }
}

#[test]
fn materials() {
    let mut scene = Scene::new();
    numbers_agree_with_the_twin(&mut scene);
    texture_coordinates_agree_with_the_twin(&mut scene);
    phase_of_a_plane_is_where_it_should_be(&mut scene);
    no_tag_is_the_base(&mut scene);
    far_is_the_mean_and_near_is_sharp(&mut scene);
    styles::focus_limits(&mut scene);
    styles::images_are_profiles(&mut scene);
    styles::travelling_needs_a_vector_field(&mut scene);
    styles::debug_styles_draw(&mut scene);
    grown_buffers_are_seen(&mut scene);
    styles::gallery(&mut scene);
}

#[test]
fn pattern_textures() {
    let mut scene = Scene::new();
    textures::styles_say_what_they_need();
    textures::images_lie_on_the_waves(&mut scene);
    textures::scalars_choose_looks(&mut scene);
    patches::cells_have_one_middle(&mut scene);
    textures::cells_show_one_tile(&mut scene);
    textures::periods_have_no_seams(&mut scene);
}

#[test]
fn hatching() {
    let mut scene = Scene::new();
    hatch::darker_tones_keep_strokes(&mut scene);
    hatch::ink_is_the_share_of_the_tone(&mut scene);
    hatch::zooming_keeps_strokes(&mut scene);
    seams::quarter_turns_leave_no_seams(&mut scene);
    seams::stripes_of_two_waves(&mut scene);
    seams::line_fields_have_no_seams(&mut scene);
    hatch::tones_come_from_light_and_distance(&mut scene);
    hatch::tones_come_from_scalars(&mut scene);
    hatch::outlines_are_of_constant_width(&mut scene);
    hatch::depth_has_a_hue(&mut scene);
    hatch::styles_choose_their_pass(&mut scene);
}

#[test]
fn passes_of_bevy() {
    passes::every_pass_draws(&mut Scene::new());
}

#[test]
fn bodies_and_light_of_bevy() {
    let mut scene = Scene::new();
    bodies::skins_and_morph_targets_draw(&mut scene);
    bodies::instances_share_a_material(&mut scene);
    light::cut_outs_cast_striped_shadows(&mut scene);
    light::bumps_shade(&mut scene);
    light::fog_veils(&mut scene);
}

#[test]
fn tensors() {
    let mut scene = Scene::new();
    tensor::values_are_colours_and_widths(&mut scene);
    tensor::turns_and_holes(&mut scene);
}

#[test]
fn anti_aliasing() {
    smooth::one_sample_is_the_mean_of_many(&mut Scene::new());
}

fn probe_picture(scene: &mut Scene, mode: u32, mesh: &Handle<Mesh>, tag: u32, lens: Lens) -> Picture {
    let material = scene.stage.add(Probe::new(mode));
    let body = scene.stage.body(mesh, &material, tag, Transform::IDENTITY);
    let picture = scene.stage.picture(lens);
    scene.stage.clear([body]);
    picture
}

/// sin Φ of the fragment shader equals that of the CPU twin at the same barycentrics, odd triangles included.
fn numbers_agree_with_the_twin(scene: &mut Scene) {
    let mesh = scene.torus_mesh.clone();
    let lens = torus_view(160, 96);
    for tag in [scene.line, scene.vector] {
        let [values, barycentrics, triangles] = [probe::VALUE, probe::BARYCENTRICS, probe::TRIANGLE]
            .map(|mode| probe_picture(scene, mode, &mesh, tag, lens));
        let (mut compared, mut odd, mut worst, mut strange) = (0, 0, 0.0_f32, 0.0_f32);
        for ((value, b), triangle) in values.pixels.iter().zip(&barycentrics.pixels).zip(&triangles.pixels) {
            // Halves hold integers up to 2048.
            if triangle.w != 0.5 || triangle.x > 2048.0 {
                continue;
            }
            assert_eq!(triangle.y as u32, tag % 1024);
            let (b0, b1) = (probe::joined(b.x, b.y), probe::joined(b.z, b.w));
            let twin = sample_wave(
                &scene.memory.view(),
                tag,
                triangle.x as u32,
                Vec3::new(b0, b1, 1.0 - b0 - b1),
            );
            assert_eq!(twin.odd, value.w == 1.0);
            if twin.confidence < 0.2 {
                continue;
            }
            let shader = probe::joined(value.x, value.y);
            worst = worst.max((shader - twin.value).abs());
            // Another triangle's wave must differ, or the comparison shows nothing.
            let next = triangle.x as u32 + 1;
            let stranger = sample_wave(&scene.memory.view(), tag, next, Vec3::new(b0, b1, 1.0 - b0 - b1));
            strange = strange.max((shader - stranger.value).abs());
            compared += 1;
            odd += usize::from(twin.odd);
        }
        assert!(compared > 500, "only {compared} pixels compared");
        assert!(strange > 0.1, "the comparison cannot fail");
        assert!(
            worst < 1e-4,
            "largest difference {worst} of {compared} pixels ({odd} odd)"
        );
    }
}

/// So do the texture coordinates of two waves.
fn texture_coordinates_agree_with_the_twin(scene: &mut Scene) {
    let mesh = scene.torus_mesh.clone();
    let lens = torus_view(160, 96);
    for tag in scene.pairs {
        let [coordinates, barycentrics, triangles] = [probe::TEXTURE, probe::BARYCENTRICS, probe::TRIANGLE]
            .map(|mode| probe_picture(scene, mode, &mesh, tag, lens));
        let (mut compared, mut odd, mut worst, mut strange) = (0, 0, 0.0_f32, 0.0_f32);
        for ((uv, b), triangle) in coordinates
            .pixels
            .iter()
            .zip(&barycentrics.pixels)
            .zip(&triangles.pixels)
        {
            if triangle.w != 0.5 || triangle.x > 2048.0 {
                continue;
            }
            let (b0, b1) = (probe::joined(b.x, b.y), probe::joined(b.z, b.w));
            let memory = scene.memory.view();
            let twin = |t| sample_pair(&memory, tag, t, Vec3::new(b0, b1, 1.0 - b0 - b1))[0];
            let pair = twin(triangle.x as u32);
            if pair.waves.iter().any(|wave| wave.confidence < 0.2) {
                continue;
            }
            let shader = Vec2::new(probe::joined(uv.x, uv.y), probe::joined(uv.z, uv.w));
            let apart = |twin: Vec2| (shader - twin - (shader - twin).round()).abs().max_element();
            worst = worst.max(apart(pair.uv()));
            strange = strange.max(apart(twin(triangle.x as u32 + 1).uv()));
            compared += 1;
            odd += usize::from(pair.waves[0].odd);
        }
        assert!(compared > 500, "only {compared} pixels compared");
        assert!(strange > 0.1, "the comparison cannot fail");
        assert!(
            worst < 1e-4,
            "largest difference {worst} of {compared} pixels ({odd} odd)"
        );
    }
}

/// On a plane with a constant field the picture is known without the twin.
fn phase_of_a_plane_is_where_it_should_be(scene: &mut Scene) {
    let mesh = scene.plane_mesh.clone();
    let picture = probe_picture(scene, probe::VALUE, &mesh, scene.plane_x, square_on(64));
    let footprints = probe_picture(scene, probe::TRIANGLE, &mesh, scene.plane_x, square_on(64));
    for y in 0..64 {
        for x in 0..64 {
            let position = (x as f32 + 0.5) / 32.0 - 1.0;
            let value = probe::joined(picture.at(x, y).x, picture.at(x, y).y);
            assert!(
                (value - (std::f32::consts::TAU * 2.0 * position).sin()).abs() < 1e-4,
                "{value} at {x}, {y}"
            );
            assert!(
                (footprints.at(x, y).z - 2.0 / 32.0).abs() < 1e-4,
                "footprint at {x}, {y}"
            );
        }
    }
}

/// Without a pattern the picture is that of the base material, to the bit.
fn no_tag_is_the_base(scene: &mut Scene) {
    let base = StandardMaterial {
        base_color: Color::srgb(0.8, 0.3, 0.1),
        ..default()
    };
    let stripes = scene.stage.add(StripeMaterial {
        base: base.clone(),
        extension: black_on_white(),
    });
    let plain = scene.stage.add(base);
    // With its indices, as a user's own mesh.
    let mesh = scene.stage.add(Mesh::from(Torus::default()));
    let sun = scene.stage.sun(Vec3::new(1.0, 2.0, 3.0), true);
    let lens = Lens {
        from: Vec3::new(0.0, 2.0, 2.5),
        ..default()
    };
    let first = scene.stage.body(&mesh, &plain, 0, Transform::IDENTITY);
    let expected = scene.stage.picture(lens);
    scene.stage.clear([first]);
    let second = scene.stage.body(&mesh, &stripes, 0, Transform::IDENTITY);
    let picture = scene.stage.picture(lens);
    scene.stage.clear([second, sun]);
    assert!(expected.contrast() > 0.01, "the scene must be seen");
    assert_eq!(picture.max_difference(&expected), 0.0);
}

/// Fine stripes far away are their mean; near ones keep their contrast.
fn far_is_the_mean_and_near_is_sharp(scene: &mut Scene) {
    let mesh = scene.plane_mesh.clone();
    // The tip of a saw-tooth is as blunt as a pixel.
    for (name, profile, duty, mean, least) in [
        ("square", Profile::Square, 0.3, 0.7, 0.95),
        ("sine", Profile::Sine, 0.5, 0.5, 0.95),
        ("sawtooth", Profile::Sawtooth, 0.5, 0.5, 0.9),
    ] {
        let material = scene.stage.add(unlit(Stripes {
            profile,
            duty,
            ..black_on_white()
        }));
        let body = scene.stage.body(&mesh, &material, scene.plane_x, Transform::IDENTITY);
        let near = scene.stage.picture(square_on(128));
        let values = near.luminance();
        let swing = values.iter().copied().fold(0.0, f32::max) - values.iter().copied().fold(1.0, f32::min);
        assert!(swing > least, "{name}: contrast {swing} near");
        assert!(
            (near.mean().x - mean).abs() < 0.02,
            "{name}: mean {} near",
            near.mean().x
        );
        // Less than a period per pixel, one, more than one; turned against the pixels, too.
        for periods in [0.9, 1.0, 1.37, 2.5, 7.3] {
            for angle in [0.0, 0.4] {
                let turn = Transform::from_rotation(Quat::from_rotation_z(angle));
                scene
                    .stage
                    .app
                    .world_mut()
                    .entity_mut(body)
                    .insert(turn.with_scale(Vec3::splat(1.0)));
                // 4 periods over 2 units; the view is square_on(8) zoomed out until a pixel is `periods` wide.
                let pixel = periods / 2.0;
                let far = scene.stage.picture(Lens {
                    orthographic: Some(16.0 * pixel),
                    ..square_on(16)
                });
                let inside = 0.7 / pixel;
                for y in 0..16 {
                    for x in 0..16 {
                        let from_center = Vec2::new(x as f32 - 7.5, y as f32 - 7.5).length();
                        if from_center + 0.71 < inside {
                            let value = far.at(x, y).x;
                            // What the mean over a pixel's square lets through of the first harmonic.
                            let sinc = |w: f32| if w < 1e-3 { 1.0 } else { (PI * w).sin() / (PI * w) };
                            let passed = sinc(periods * f32::cos(angle)) * sinc(periods * f32::sin(angle));
                            let allowed = 0.04 + 1.3 * passed.abs();
                            assert!(
                                (value - mean).abs() < allowed * mean.max(0.5),
                                "{name}: {value} instead of {mean} at {periods} periods per pixel, angle {angle}"
                            );
                        }
                    }
                }
            }
        }
        scene.stage.clear([body]);
    }
}

/// A buffer that was made anew is seen, once its generation is told.
fn grown_buffers_are_seen(scene: &mut Scene) {
    let material = scene.stage.add(unlit(black_on_white()));
    let mesh = scene.plane_mesh.clone();
    let body = scene.stage.body(&mesh, &material, scene.plane_x, Transform::IDENTITY);
    let lens = square_on(32);
    let before = scene.stage.picture(lens);
    let added = scene.memory.push(&Pattern::plane(2.0, 4, Vec3::Y, 3.0));
    scene.upload();
    scene.stage.app.world_mut().entity_mut(body).insert(MeshTag(added));
    let after = scene.stage.picture(lens);
    scene.stage.clear([body]);
    assert!(before.max_difference(&after) > 0.9);
    assert!(
        (0..32).all(|x| (after.at(x, 9) - after.at(0, 9)).length() < 0.05),
        "stripes along y now"
    );
}
