//! What textures on waves need besides a GPU's pixels: mip levels, colours for numbers, copies that travel, and patterns
//! that fit the style.

mod common;

use bevy::{
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_field_patterns::{error::PatternError, material::with_mipmaps, prelude::*};
use common::{add_mesh, app, settle, shapes, update};

fn image(width: u32, height: u32, format: TextureFormat, texel: impl Fn(u32, u32) -> [u8; 4]) -> Image {
    let size = Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let data = (0..width * height).flat_map(|k| texel(k % width, k / width)).collect();
    Image::new(size, TextureDimension::D2, data, format, default())
}

/// The levels' texels.
fn levels(image: &Image) -> Vec<Vec<[u8; 4]>> {
    let mut data = image.data.as_deref().unwrap();
    let (mut width, mut height) = (image.width() as usize, image.height() as usize);
    let mut levels = vec![];
    for _ in 0..image.texture_descriptor.mip_level_count {
        let (level, rest) = data.split_at(4 * width * height);
        levels.push(level.as_chunks::<4>().0.to_vec());
        data = rest;
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
    }
    assert!(data.is_empty(), "{} bytes are left", data.len());
    levels
}

/// Means are taken in linear light: black and white make a grey of half the light. What is transparent gives no colour.
#[test]
fn levels_are_means_of_light() {
    let checks = image(8, 8, TextureFormat::Rgba8UnormSrgb, |x, y| {
        if (x + y) % 2 == 0 {
            [255, 255, 255, 255]
        } else {
            [0, 0, 0, 255]
        }
    });
    for level in &levels(&with_mipmaps(checks).unwrap())[1..] {
        assert!(level.iter().all(|texel| *texel == [188, 188, 188, 255]), "{level:?}");
    }
    let holes = image(4, 4, TextureFormat::Rgba8Unorm, |x, _| {
        if x % 2 == 0 { [200, 100, 0, 255] } else { [0, 0, 255, 0] }
    });
    for level in &levels(&with_mipmaps(holes).unwrap())[1..] {
        assert!(level.iter().all(|texel| *texel == [200, 100, 0, 128]), "{level:?}");
    }
    let clear = image(2, 2, TextureFormat::Rgba8Unorm, |_, _| [10, 20, 30, 0]);
    assert_eq!(levels(&with_mipmaps(clear).unwrap())[1], [[10, 20, 30, 0]]);
}

/// The smallest level is the mean of the image, whatever its size.
#[test]
fn the_last_level_is_the_mean() {
    for (width, height) in [(1, 1), (2, 1), (5, 3), (37, 64), (100, 7), (96, 32)] {
        let value = |x: u32, y: u32| ((x * 7919 + y * 104_729) % 251) as u8;
        let image = image(width, height, TextureFormat::Rgba8Unorm, |x, y| {
            [value(x, y), 0, 0, 255]
        });
        let mean = (0..width * height)
            .map(|k| f64::from(value(k % width, k / width)))
            .sum::<f64>()
            / f64::from(width * height);
        let made = with_mipmaps(image).unwrap();
        let last = levels(&made).pop().unwrap();
        assert_eq!(last.len(), 1);
        assert!(
            (f64::from(last[0][0]) - mean).abs() < 0.51,
            "{width} × {height}: {last:?}, not {mean}"
        );
        // Levels that are there are not made again.
        assert_eq!(with_mipmaps(made.clone()).unwrap().data, made.data);
    }
}

#[test]
fn levels_that_cannot_be_made_are_refused() {
    let floats = image(2, 1, TextureFormat::Rgba8Unorm, |_, _| [0; 4]);
    let mut taken = floats.clone();
    taken.data = None;
    let mut other = floats;
    other.texture_descriptor.format = TextureFormat::Rg16Float;
    for image in [taken, other] {
        assert!(matches!(with_mipmaps(image), Err(PatternError::Image(_))));
    }
}

/// Legends tell what shaders draw: ends, middle, and a range that is turned round.
#[test]
fn legends_tell_the_colors() {
    let color = ScalarColor {
        map: ColorMap::Colors(vec![LinearRgba::RED, LinearRgba::GREEN, LinearRgba::BLUE]),
        low: 4.0,
        high: -4.0,
        ..default()
    };
    let legend = color.legend(5);
    let values: Vec<f32> = legend.iter().map(|entry| entry.value).collect();
    assert_eq!(values, [4.0, 2.0, 0.0, -2.0, -4.0]);
    assert_eq!(legend[0].color, LinearRgba::RED);
    assert_eq!(legend[1].color, LinearRgba::RED.mix(&LinearRgba::GREEN, 0.5));
    assert_eq!(legend[4].color, color.color(-100.0));
    for entry in legend {
        assert_eq!(entry.color, color.color(entry.value));
    }
    for map in [ColorMap::Viridis, ColorMap::Turbo, ColorMap::CoolWarm, ColorMap::Gray] {
        let stops = map.stops();
        assert_eq!((map.color(0.0), map.color(1.0)), (stops[0], stops[15]));
    }
    assert_eq!(ColorMap::Colors(vec![]).color(0.3), LinearRgba::WHITE);
}

/// At a constant speed v a copy moves by f v periods per second, copies' weights sum to 1, and a copy jumps only when it
/// is not seen.
#[test]
fn travelling_copies_keep_their_speed() {
    let (speed, around, cycle, frequency) = (0.7, 3.0, 1.6, 4.5);
    let travel = Travel::Speed { speed, around, cycle };
    let step = 1.0 / 1024.0;
    for k in 0..8192 {
        let time = k as f32 * step;
        let [now, next] = [time, time + step].map(|time| travel.copies(frequency, time));
        assert!((now[0].1 + now[1].1 - 1.0).abs() < 1e-5);
        for (a, b) in now.into_iter().zip(next) {
            let moved = b.0 - a.0 - frequency * speed * step;
            let jumps = (moved - moved.round()).abs() > 1e-3;
            assert!(
                !jumps || a.1.min(b.1) < 0.002,
                "a copy jumps at {time} with weight {}",
                a.1
            );
        }
        let [a, b] = travel.copies(around, time);
        assert!((a.0 - b.0).abs() < 1e-4, "around its frequency both copies are one");
    }
}

/// A style that a pattern cannot have fails with a word for what is missing, and is drawn once that is there.
#[test]
fn patterns_fit_their_style() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::torus(24, 12, 1.0, 0.4, 0.0, 1));
    let still = PatternTextureMaterial::default();
    let mut moving = still.clone();
    moving.extension.travel = Travel::Periods(1.0);
    let [still, moving] = [still, moving].map(|material| {
        let mut materials = app.world_mut().resource_mut::<Assets<PatternTextureMaterial>>();
        MeshMaterial3d(materials.add(material))
    });
    let field = DirectionField::Axis(Dir3::Y);
    let entity = app
        .world_mut()
        .spawn((
            Mesh3d(mesh),
            still.clone(),
            field,
            Symmetry::Line,
            Frequency::Uniform(3.0),
        ))
        .id();
    let state = |app: &mut App| {
        update(app);
        settle(app);
        app.world().get::<PatternState>(entity).unwrap().clone()
    };
    let wants_waves = PatternState::Failed(PatternError::NeedsTwoWaves("PatternTexture"));
    let wants_vector = PatternState::Failed(PatternError::NeedsVectorSymmetry("PatternTexture::travel"));
    assert_eq!(state(&mut app), wants_waves);
    app.world_mut().entity_mut(entity).insert(Waves::ORTHOGONAL);
    assert_eq!(state(&mut app), PatternState::Converged);
    app.world_mut().entity_mut(entity).insert(moving);
    assert_eq!(state(&mut app), wants_vector);
    app.world_mut().entity_mut(entity).insert(Symmetry::Vector);
    assert_eq!(state(&mut app), PatternState::Converged);
    // A cross field has no symmetry but its own.
    app.world_mut().entity_mut(entity).insert(Waves::Cross);
    assert_eq!(state(&mut app), wants_vector);
    app.world_mut().entity_mut(entity).insert(still);
    assert_eq!(state(&mut app), PatternState::Converged);
    app.world_mut().entity_mut(entity).insert(Waves::Single);
    assert_eq!(state(&mut app), wants_waves);
    // Stripes take what is there.
    let stripes = app
        .world_mut()
        .resource_mut::<Assets<StripeMaterial>>()
        .add(StripeMaterial::default());
    app.world_mut()
        .entity_mut(entity)
        .remove::<MeshMaterial3d<PatternTextureMaterial>>()
        .insert(MeshMaterial3d(stripes.clone()));
    assert_eq!(state(&mut app), PatternState::Converged);
    // But not one of two that are not told apart.
    app.world_mut().entity_mut(entity).insert(Waves::Cross);
    let wants_both = PatternState::Failed(PatternError::NeedsBothWaves("StripeWaves::First"));
    assert_eq!(state(&mut app), wants_both);
    let mut materials = app.world_mut().resource_mut::<Assets<StripeMaterial>>();
    if let Some(mut material) = materials.get_mut(&stripes) {
        material.extension.waves = StripeWaves::Both;
    }
    assert_eq!(state(&mut app), PatternState::Converged);
}
