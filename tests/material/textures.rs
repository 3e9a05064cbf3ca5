//! Images on two waves: where they lie, how they move, what scalars do to them, and which tile a cell has.
#![allow(clippy::print_stdout, reason = "what was measured")]

use bevy::{
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_field_patterns::{material::*, wave::Waves};

use crate::{
    Scene,
    patterns::Pattern,
    probe, probe_picture, square_on,
    stage::{Lens, Picture},
    torus_view,
};

pub fn image(width: u32, height: u32, texel: impl Fn(f32, f32) -> [f32; 4]) -> Image {
    let size = Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let at = |k: u32| {
        texel(
            ((k % width) as f32 + 0.5) / width as f32,
            ((k / width) as f32 + 0.5) / height as f32,
        )
    };
    let bytes = (0..width * height).flat_map(|k| at(k).map(|value| (255.0 * value).round() as u8));
    Image::new(
        size,
        TextureDimension::D2,
        bytes.collect(),
        TextureFormat::Rgba8Unorm,
        default(),
    )
}

fn unlit(extension: PatternTexture) -> PatternTextureMaterial {
    PatternTextureMaterial {
        base: StandardMaterial {
            base_color: Color::BLACK,
            unlit: true,
            ..default()
        },
        extension,
    }
}

/// A picture of a pattern with a style.
fn drawn(scene: &mut Scene, mesh: &Handle<Mesh>, tag: u32, style: PatternTexture, lens: Lens) -> Picture {
    let material = scene.stage.add(unlit(style));
    let body = scene.stage.body(mesh, &material, tag, Transform::IDENTITY);
    // Levels are made in the frame after an image has come.
    scene.stage.app.update();
    scene.stage.app.update();
    let picture = scene.stage.picture(lens);
    scene.stage.clear([body]);
    picture
}

/// Red grows to the right of the image and green to its top, both smooth from period to period.
fn waves_of_color(u: f32, v_down: f32) -> [f32; 4] {
    let wave = |x: f32| 0.5 + 0.5 * (std::f32::consts::TAU * x).sin();
    [wave(u), wave(1.0 - v_down), 0.0, 1.0]
}

/// On a plane the picture is known: right is d, top is n × d, shifted and travelling against d. No seam, no mirror.
pub fn images_lie_on_the_waves(scene: &mut Scene) {
    // The image's middle is at the crests, a quarter of a period after the phases' 0.
    let pair = Pattern::plane(2.0, 4, Vec3::X, 2.0).with_second_wave(Waves::Orthogonal { ratio: 1.0 });
    let mut pattern = pair;
    for v in 0..pattern.positions.len() {
        let p = pattern.positions[v];
        pattern.z[2 * v + 1] = Vec2::from_angle(std::f32::consts::TAU * 2.0 * p.y);
    }
    let tag = scene.memory.push(&pattern);
    scene.upload();
    let mesh = scene.plane_mesh.clone();
    let image = scene.stage.add(image(256, 256, waves_of_color));
    scene.stage.app.world_mut().resource_mut::<Time<Virtual>>().pause();
    for (offset, travel) in [
        (Vec2::ZERO, Travel::REST),
        (Vec2::new(0.2, 0.35), Travel::REST),
        (Vec2::ZERO, Travel::Periods(1.3)),
        (
            Vec2::ZERO,
            Travel::Speed {
                speed: 0.4,
                around: 2.0,
                cycle: 2.0,
            },
        ),
        (
            Vec2::ZERO,
            Travel::Speed {
                speed: 0.4,
                around: 1.5,
                cycle: 2.0,
            },
        ),
    ] {
        let style = PatternTexture {
            image: image.clone(),
            offset,
            travel,
            ..default()
        };
        let picture = drawn(scene, &mesh, tag, style, square_on(128));
        picture.save(&format!("texture {offset} {travel:?}"));
        let time = scene.stage.app.world().resource::<Time>().elapsed_secs_wrapped();
        let mut worst = 0.0_f32;
        for y in 0..128 {
            for x in 0..128 {
                let at = Vec2::new((x as f32 + 0.5) / 64.0 - 1.0, 1.0 - (y as f32 + 0.5) / 64.0);
                let expected: Vec2 = travel
                    .copies(2.0, time)
                    .map(|(shift, weight)| {
                        let uv = 2.0 * at + 0.25 - offset - Vec2::new(shift, 0.0);
                        let [red, green, ..] = waves_of_color(uv.x, 1.0 - uv.y);
                        weight * Vec2::new(red, green)
                    })
                    .into_iter()
                    .sum();
                worst = worst.max((picture.at(x, y).truncate().truncate() - expected).abs().max_element());
            }
        }
        assert!(worst < 0.012, "offset {offset}, {travel:?}: {worst}");
    }
    scene.stage.app.world_mut().resource_mut::<Time<Virtual>>().unpause();
}

/// Where an image is magnified no pixel reads a smaller level, also at the borders of periods and in odd triangles: levels
/// of another colour show nowhere near, and everywhere far.
pub fn periods_have_no_seams(scene: &mut Scene) {
    let levels = with_mipmaps(image(64, 64, |_, _| [1.0, 0.0, 0.0, 1.0])).unwrap();
    let mut marked = levels.clone();
    let data = marked.data.as_mut().unwrap();
    // The last one is the mean, to which branches fade.
    let last = data.len() - 4;
    for texel in data[4 * 64 * 64..last].chunks_exact_mut(4) {
        texel.copy_from_slice(&[0, 255, 0, 255]);
    }
    let marked = scene.stage.add(marked);
    let mesh = scene.torus_mesh.clone();
    for tag in scene.pairs {
        let style = PatternTexture {
            image: marked.clone(),
            ..default()
        };
        // A period of a tenth is some 100 pixels here, an image's texel more than one.
        let near = Lens {
            width: 160,
            height: 120,
            from: Vec3::new(0.0, 0.0, 1.62),
            to: Vec3::new(0.0, 0.0, 1.4),
            ..default()
        };
        let picture = drawn(scene, &mesh, tag, style.clone(), near);
        picture.save(&format!("seams {tag}"));
        let green: Vec<f32> = picture.pixels.iter().map(|p| p.y).collect();
        let seen = green.iter().filter(|&&g| g > 0.02).count();
        // Around branches the image is small indeed.
        assert!(
            seen < green.len() / 100,
            "{seen} pixels of {} read smaller levels",
            green.len()
        );
        let far = drawn(scene, &mesh, tag, style, torus_view(48, 32));
        assert!(
            far.mean().y > 3.0 * far.mean().x,
            "far levels must be seen: {}",
            far.mean()
        );
    }
}

/// Fade and colour follow the scalars as their twins say.
pub fn scalars_choose_looks(scene: &mut Scene) {
    let (pattern, flat) = Pattern::bent(24, 0.4, 4.0, 1.0, |p| p.x + 0.5 * p.y);
    let tag = scene.memory.push(&pattern);
    scene.upload();
    let mesh = scene.stage.add(pattern.mesh());
    let lens = Lens {
        width: 96,
        height: 96,
        ..square_on(96)
    };
    let white = scene.stage.add(image(4, 4, |_, _| [1.0; 4]));
    let blue = scene.stage.add(image(4, 4, |_, _| [0.0, 0.0, 1.0, 1.0]));
    let color = ScalarColor {
        map: ColorMap::Turbo,
        low: 0.8,
        high: -0.7,
        ..default()
    };
    let fade = TextureFade {
        image: Some(blue),
        begin: -0.3,
        end: 0.5,
        ..default()
    };
    let colored = PatternTexture {
        image: white.clone(),
        color: Some(color.clone()),
        ..default()
    };
    let faded = PatternTexture {
        image: white,
        fade: Some(fade),
        ..default()
    };
    let colored = drawn(scene, &mesh, tag, colored, lens);
    let faded = drawn(scene, &mesh, tag, faded, lens);
    let places = places(scene, &mesh, tag, lens, &pattern, &flat);
    assert!(places.len() > 2000);
    for (pixel, at) in places {
        let scalar = at.x + 0.5 * at.y;
        let expected = color.color(scalar).to_vec3();
        let found = colored.pixels[pixel].truncate();
        assert!(
            (found - expected).abs().max_element() < 0.02,
            "{found} for {scalar}, not {expected}"
        );
        let t = ((scalar + 0.3) / 0.8).clamp(0.0, 1.0);
        let quiet = t * t * (3.0 - 2.0 * t);
        let found = faded.pixels[pixel];
        assert!(
            (found.x - (1.0 - quiet)).abs() < 0.01 && (found.z - 1.0).abs() < 0.01,
            "{found} at {quiet}"
        );
    }
}

/// The pixels that show a bent square, and where on it they are.
fn places(
    scene: &mut Scene,
    mesh: &Handle<Mesh>,
    tag: u32,
    lens: Lens,
    pattern: &Pattern,
    flat: &[Vec2],
) -> Vec<(usize, Vec2)> {
    let [barycentrics, triangles] =
        [probe::BARYCENTRICS, probe::TRIANGLE].map(|mode| probe_picture(scene, mode, mesh, tag, lens));
    let seen = barycentrics.pixels.iter().zip(&triangles.pixels).enumerate();
    seen.filter(|(_, (_, triangle))| triangle.w == 0.5)
        .map(|(pixel, (b, triangle))| {
            let (b0, b1) = (probe::joined(b.x, b.y), probe::joined(b.z, b.w));
            let corners = pattern.triangles[triangle.x as usize].map(|v| flat[v as usize]);
            (pixel, b0 * corners[0] + b1 * corners[1] + (1.0 - b0 - b1) * corners[2])
        })
        .collect()
}

/// Every cell shows the tile of its middle, as is known of a bent square: cells of many triangles and triangles of many
/// cells alike.
pub fn cells_show_one_tile(scene: &mut Scene) {
    let tiles = 5_u32;
    let atlas = image(16 * tiles, 16, |u, _| [(u * tiles as f32).floor() / 8.0, 1.0, 0.0, 1.0]);
    let atlas = scene.stage.add(atlas);
    let scalar = |p: Vec2| 0.5 + 0.6 * p.x * p.y + 0.2 * p.x;
    let patches = Patches {
        columns: tiles,
        low: 0.0,
        high: 1.0,
        ..default()
    };
    let lens = Lens {
        width: 128,
        height: 128,
        orthographic: Some(1.7),
        ..default()
    };
    for (cells, frequency, ratio) in [(30, 1.5, 1.0), (30, 2.5, 0.6), (24, 12.0, 1.4), (7, 14.0, 1.0)] {
        let angle = 0.35;
        let (pattern, flat) = Pattern::bent(cells, angle, frequency, ratio, scalar);
        let tag = scene.memory.push(&pattern);
        scene.upload();
        let mesh = scene.stage.add(pattern.mesh());
        let style = PatternTexture {
            image: atlas.clone(),
            patches: Some(patches.clone()),
            ..default()
        };
        let picture = drawn(scene, &mesh, tag, style, lens);
        picture.save(&format!("tiles {cells} {frequency}"));
        let axes = [Vec2::from_angle(angle), Vec2::from_angle(angle).perp()];
        let scale = Vec2::new(frequency, frequency * ratio);
        let (mut compared, mut wrong, mut local) = (0, 0, 0);
        for (pixel, at) in places(scene, &mesh, tag, lens, &pattern, &flat) {
            let uv = Vec2::new(axes[0].dot(at), axes[1].dot(at)) * scale + 0.25;
            let middle = (uv.floor() + 0.5 - 0.25) / scale;
            let middle = middle.x * axes[0] + middle.y * axes[1];
            // A middle off the square is nobody's. Close to the border of a tile's range, or of the cell, either is right.
            let value = scalar(middle) * tiles as f32;
            let from_border = (uv - uv.round()).abs().min_element();
            if middle.abs().max_element() > 0.99 || (value - value.round()).abs() < 0.04 || from_border < 0.05 {
                continue;
            }
            let found = (8.0 * picture.pixels[pixel].x).round() as u32;
            compared += 1;
            wrong += usize::from(found != patches.tile(scalar(middle)));
            local += usize::from(patches.tile(scalar(at)) != patches.tile(scalar(middle)));
        }
        println!("{cells} cells, frequency {frequency}: {wrong} of {compared} wrong, {local} by their own scalar");
        assert!(compared > 1000, "only {compared} pixels compared");
        assert!(local > 40, "the comparison cannot fail");
        // Flat coordinates are linear in a triangle, waves on a bent square are not quite: large triangles differ a little.
        assert!(wrong * 200 < compared, "{wrong} of {compared} pixels show another tile");
    }
}

/// What moves is refused on a line field by the style's own word, and a texture asks for two waves.
pub fn styles_say_what_they_need() {
    let still = PatternTexture::default();
    assert_eq!(still.requires_vector_symmetry(), None);
    let moving = |travel| PatternTexture { travel, ..default() }.requires_vector_symmetry();
    assert_eq!(moving(Travel::Periods(1.0)), Some("PatternTexture::travel"));
    let speed = |speed| Travel::Speed {
        speed,
        around: 1.0,
        cycle: 1.0,
    };
    assert_eq!(moving(speed(0.5)), Some("PatternTexture::travel"));
    assert_eq!(moving(speed(0.0)), None);
    let shifted = PatternTexture {
        offset: Vec2::X,
        ..default()
    };
    assert_eq!(shifted.requires_vector_symmetry(), Some("PatternTexture::offset"));
}
