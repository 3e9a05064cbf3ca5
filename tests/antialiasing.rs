//! One sample per pixel looks like the mean of many: the analytic filter of stripes, and the filter of textures, against 196
//! unfiltered samples.
//!
//! In: a torus with 20 to 400 stripes, near, in the middle, far away; unlit and without tone mapping. The truth is the
//! same pattern without anti-aliasing, drawn 14 times as large and averaged in linear light; the camera of the large
//! picture is rolled, for samples in rows and columns would themselves miss an edge that runs along them by a part of their
//! distance. Pixels closer than two pixels to the silhouette do not count, for there the geometry is aliased, not the pattern.
//!
//! `PATTERN_SAMPLES=20` draws the truth 20 times as large; `PATTERN_PICTURES=directory` keeps the pictures.
#![allow(clippy::print_stdout, reason = "what was measured")]

mod common;

use bevy::{
    camera::RenderTarget,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    pbr::{ExtendedMaterial, MaterialExtension},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
};
use bevy_field_patterns::{field::Principal, prelude::*};
use common::{add_mesh, app, headless, settle, shapes, update};

const SIZE: UVec2 = UVec2::new(120, 90);
/// Height of the picture as seen from the distance 1: a lens of 45 degrees.
const HEIGHT: f32 = 0.828;
/// Samples along each side of a pixel.
const SAMPLES: u32 = 14;
/// Side of the rolled square that holds a picture, in its pixels.
const ROLLED: u32 = 150;
/// A roll that has no small fraction for a tangent: the golden ratio less 1.
const ROLL: f32 = 0.5536;
/// Where nothing is drawn; stripes are grey.
const BACKGROUND: LinearRgba = LinearRgba::RED;

/// Linear light: how bright, and what share of the pixel is surface.
struct Picture {
    size: UVec2,
    pixels: Vec<Vec2>,
}

impl Picture {
    /// `height` is that of the view at the distance 1.
    fn draw(app: &mut App, size: UVec2, height: f32, from: Transform) -> Self {
        let mut image = Image::new_target_texture(size.x, size.y, TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
        let camera = app
            .world_mut()
            .spawn((
                Camera3d::default(),
                Camera {
                    clear_color: ClearColorConfig::Custom(BACKGROUND.into()),
                    ..default()
                },
                Projection::Perspective(PerspectiveProjection {
                    fov: 2.0 * (0.5 * height).atan(),
                    ..default()
                }),
                RenderTarget::Image(target.clone().into()),
                Msaa::Off,
                Tonemapping::None,
                DebandDither::Disabled,
                from,
            ))
            .id();
        // Pipelines compile as they are needed; a new camera and a changed material show in the next frame.
        update(app);
        update(app);
        let image = headless::capture(app, &target).expect("a picture");
        app.world_mut().despawn(camera);
        let linear: Vec<f32> = (0..=255_u8)
            .map(|byte| Srgba::gamma_function(f32::from(byte) / 255.0))
            .collect();
        let (pixels, _) = image.data.as_deref().expect("pixels").as_chunks::<4>();
        let pixels = pixels
            .iter()
            .map(|p| [p[0], p[1]].map(|byte| linear[usize::from(byte)]))
            .map(|[red, green]| Vec2::new(green, 1.0 - (red - green)))
            .collect();
        Self { size, pixels }
    }

    /// The mean of many samples per pixel.
    fn supersampled(app: &mut App, mut from: Transform) -> Self {
        let side = samples_per_side();
        from.rotate_local_z(ROLL);
        let height = HEIGHT * ROLLED as f32 / SIZE.y as f32;
        let samples = Self::draw(app, UVec2::splat(ROLLED * side), height, from);
        let roll = Vec2::from_angle(-ROLL);
        let mut sums = vec![Vec3::ZERO; SIZE.element_product() as usize];
        for (k, sample) in (0..).zip(&samples.pixels) {
            let at = UVec2::new(k % samples.size.x, k / samples.size.x).as_vec2() + 0.5;
            let at = at / side as f32 - 0.5 * ROLLED as f32;
            let pixel = (roll.rotate(at) + 0.5 * SIZE.as_vec2()).floor();
            if pixel.cmpge(Vec2::ZERO).all() && pixel.cmplt(SIZE.as_vec2()).all() {
                sums[(pixel.y as u32 * SIZE.x + pixel.x as u32) as usize] += sample.extend(1.0);
            }
        }
        let pixels = sums.iter().map(|sum| sum.truncate() / sum.z).collect();
        Self { size: SIZE, pixels }
    }

    fn at(&self, pixel: UVec2) -> Vec2 {
        self.pixels[(pixel.y * self.size.x + pixel.x) as usize]
    }

    /// Pixels that are surface, as are all pixels up to two away.
    fn inside(&self) -> Vec<UVec2> {
        let whole = |x: u32, y: u32| self.at(UVec2::new(x, y)).y > 0.999;
        (2..self.size.y - 2)
            .flat_map(|y| (2..self.size.x - 2).map(move |x| UVec2::new(x, y)))
            .filter(|p| (p.y - 2..=p.y + 2).all(|y| (p.x - 2..=p.x + 2).all(|x| whole(x, y))))
            .collect()
    }
}

/// `SAMPLES`, or what the environment asks for.
fn samples_per_side() -> u32 {
    let asked = std::env::var("PATTERN_SAMPLES").ok();
    let asked = asked.map(|text| text.parse().expect("PATTERN_SAMPLES is a whole number, such as 20"));
    asked.unwrap_or(SAMPLES)
}

fn deviation(values: &[f32]) -> f32 {
    let mean = values.iter().sum::<f32>() / values.len() as f32;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt()
}

/// How far the filtered picture is from the truth.
#[derive(Debug)]
struct Difference {
    /// Root of the mean square, in shares of white.
    rms: f32,
    /// Of the unfiltered picture, for comparison.
    unfiltered: f32,
    /// Contrast (standard deviation) as a share of the truth's.
    contrast: f32,
    pixels: usize,
}

/// Black on white, unlit.
type Styled<E> = ExtendedMaterial<StandardMaterial, E>;

struct Scene<E: MaterialExtension> {
    app: App,
    mesh: Handle<Mesh>,
    entity: Entity,
    filtered: Handle<Styled<E>>,
    unfiltered: Handle<Styled<E>>,
}

impl<E: MaterialExtension> Scene<E> {
    /// `style` is given the app and whether to filter.
    fn new(mut style: impl FnMut(&mut App, bool) -> E) -> Self {
        let mut app = app();
        let mesh = add_mesh(&mut app, &shapes::torus(160, 64, 1.0, 0.4, 0.3, 3));
        let mut material = |filtered| {
            let extension = style(&mut app, filtered);
            let base = StandardMaterial {
                unlit: true,
                ..default()
            };
            app.world_mut()
                .resource_mut::<Assets<Styled<E>>>()
                .add(Styled { base, extension })
        };
        let (filtered, unfiltered) = (material(true), material(false));
        let entity = app.world_mut().spawn_empty().id();
        Self {
            app,
            mesh,
            entity,
            filtered,
            unfiltered,
        }
    }

    /// `stripes` is the number of periods along the circle of radius 1 in the tube.
    fn pattern(&mut self, field: DirectionField, waves: Waves, stripes: f32) {
        let frequency = Frequency::Uniform(stripes / std::f32::consts::TAU);
        let world = self.app.world_mut();
        world.despawn(self.entity);
        let material = MeshMaterial3d(self.filtered.clone());
        self.entity = world
            .spawn((Mesh3d(self.mesh.clone()), material, field, waves, frequency))
            .id();
        settle(&mut self.app);
    }

    fn wear(&mut self, material: Handle<Styled<E>>) -> &mut App {
        self.app
            .world_mut()
            .entity_mut(self.entity)
            .insert(MeshMaterial3d(material));
        &mut self.app
    }

    fn difference(&mut self, from: Transform, name: &str) -> Difference {
        let filtered = Picture::draw(self.wear(self.filtered.clone()), SIZE, HEIGHT, from);
        let unfiltered = Picture::draw(self.wear(self.unfiltered.clone()), SIZE, HEIGHT, from);
        let truth = Picture::supersampled(&mut self.app, from);
        if let Ok(directory) = std::env::var("PATTERN_PICTURES") {
            for (picture, kind) in [(&filtered, "filtered"), (&unfiltered, "unfiltered"), (&truth, "truth")] {
                save(picture, &format!("{directory}/{name} {kind}.png"));
            }
        }
        let inside = truth.inside();
        let values = |picture: &Picture| inside.iter().map(|&p| picture.at(p).x).collect::<Vec<_>>();
        let (filtered, unfiltered, truth) = (values(&filtered), values(&unfiltered), values(&truth));
        let rms = |values: &[f32]| {
            let squares = values.iter().zip(&truth).map(|(a, b)| (a - b).powi(2));
            (squares.sum::<f32>() / truth.len() as f32).sqrt()
        };
        Difference {
            rms: rms(&filtered),
            unfiltered: rms(&unfiltered),
            contrast: deviation(&filtered) / deviation(&truth),
            pixels: truth.len(),
        }
    }
}

fn save(picture: &Picture, path: &str) {
    let bytes = picture.pixels.iter().flat_map(|p| {
        let v = (255.0 * Srgba::gamma_function_inverse(p.x)) as u8;
        [v, v, v, 255]
    });
    let mut image = Image::new_target_texture(picture.size.x, picture.size.y, TextureFormat::Rgba8UnormSrgb, None);
    image.data = Some(bytes.collect());
    headless::save_png(&image, path.as_ref()).expect("a file");
}

/// From 40 degrees off the torus's axis, where no part of it hides another.
fn from(distance: f32, towards: Vec3) -> Transform {
    let (sin, cos) = 40_f32.to_radians().sin_cos();
    Transform::from_translation(towards + distance * Vec3::new(0.0, cos, sin)).looking_at(towards, Vec3::Y)
}

/// Differences from near, from the middle and from far; those that are larger than `allowed` as failures.
fn compare<E: MaterialExtension>(scene: &mut Scene<E>, what: &str, allowed: f32) -> Vec<String> {
    let mut failures = Vec::new();
    for (view, distance, towards) in [
        ("near", 1.1, Vec3::new(0.0, 0.3, 1.0)),
        ("middle", 4.5, Vec3::ZERO),
        ("far", 9.0, Vec3::ZERO),
    ] {
        let name = format!("{what} {view}");
        let found = scene.difference(from(distance, towards), &name);
        println!("{name:24} {found:?}");
        let contrast = if view == "near" { 0.95 } else { 0.0 };
        // What is smooth and large is nearly right without a filter.
        let blind = found.unfiltered > 0.1 && found.unfiltered < 3.0 * found.rms;
        if found.pixels < 80 || found.rms > allowed || blind || found.contrast < contrast {
            failures.push(format!("{name}: {found:?}"));
        }
    }
    failures
}

fn curvature() -> DirectionField {
    DirectionField::PrincipalCurvature {
        direction: Principal::Minor,
        smoothing: 10,
    }
}

#[test]
fn one_sample_is_the_mean_of_many() {
    let mut scene = Scene::new(|_, anti_aliasing| Stripes {
        color: LinearRgba::BLACK,
        gap_color: LinearRgba::WHITE,
        anti_aliasing,
        ..default()
    });
    let mut failures = Vec::new();
    let axis = DirectionField::Axis(Dir3::X);
    // Directions of curvature turn within a pixel, where the filter takes the phase for linear.
    for (name, field, counts, allowed) in [
        ("axis", axis, &[20.0, 90.0, 400.0][..], 0.022),
        ("curvature", curvature(), &[90.0], 0.032),
    ] {
        for &stripes in counts {
            scene.pattern(field.clone(), Waves::Single, stripes);
            failures.extend(compare(&mut scene, &format!("{name} {stripes}"), allowed));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A grey image with its levels.
fn grey(app: &mut App, value: fn(Vec2) -> f32) -> Handle<Image> {
    const SIDE: u32 = 128;
    let texel = |k: u32| {
        let at = (UVec2::new(k % SIDE, k / SIDE).as_vec2() + 0.5) / SIDE as f32;
        let grey = (255.0 * value(at)).round() as u8;
        [grey, grey, grey, 255]
    };
    let size = Extent3d {
        width: SIDE,
        height: SIDE,
        depth_or_array_layers: 1,
    };
    let bytes = (0..SIDE * SIDE).flat_map(texel).collect();
    let image = Image::new(size, TextureDimension::D2, bytes, TextureFormat::Rgba8Unorm, default());
    app.world_mut().resource_mut::<Assets<Image>>().add(image)
}

/// Waves of light: no edge anywhere. The same after half a turn, as on a line field it must be.
fn smooth(p: Vec2) -> f32 {
    let angle = std::f32::consts::TAU * p;
    0.5 + 0.25 * angle.x.cos() + 0.25 * (angle.x + 2.0 * angle.y).cos()
}

/// A black lozenge on white.
fn hard(p: Vec2) -> f32 {
    let q = 2.0 * p - 1.0;
    if (q.x + 0.5 * q.y).abs() < 0.5 && q.y.abs() < 0.7 {
        0.0
    } else {
        1.0
    }
}

#[test]
fn textures_are_filtered() {
    let mut failures = Vec::new();
    let values: [(&str, fn(Vec2) -> f32, f32); 2] = [("smooth", smooth, 0.02), ("hard", hard, 0.03)];
    for (name, value, allowed) in values {
        let mut scene = Scene::new(|app, anti_aliasing| PatternTexture {
            image: grey(app, value),
            anti_aliasing,
            ..default()
        });
        for (field_name, field) in [("axis", DirectionField::Axis(Dir3::X)), ("curvature", curvature())] {
            for stripes in [20.0, 90.0] {
                scene.pattern(field.clone(), Waves::ORTHOGONAL, stripes);
                let what = format!("{name} {field_name} {stripes}");
                failures.extend(compare(&mut scene, &what, allowed));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
