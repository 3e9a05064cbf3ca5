//! Pictures of patterns against references in `tests/pictures`, by structural similarity.
//!
//! `BLESS=1 cargo test --test pictures` writes the references anew: look at them before you commit them. Pictures that do
//! not match are written next to the test's binary, and the message says where.
#![allow(clippy::print_stdout, reason = "what was measured")]

mod common;

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::tonemapping::{DebandDither, Tonemapping},
    image::{CompressedImageFormats, ImageSampler, ImageType},
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    prelude::*,
};
use bevy_field_patterns::{field::Principal, prelude::*};
use common::{add_mesh, headless, mesh_file::RawMesh, settle, shapes, update};
use image_compare::{Algorithm, rgb_similarity_structure};
use std::path::{Path, PathBuf};

const SIZE: UVec2 = UVec2::new(160, 120);
/// Structural similarity of pictures that look alike; 1 is equal.
const ALIKE: f64 = 0.98;

struct Studio {
    app: App,
    /// What the next scene replaces.
    bodies: Vec<Entity>,
    failures: Vec<String>,
}

impl Studio {
    fn new() -> Self {
        let mut app = headless::headless_app(SIZE).expect("a device");
        app.add_plugins(FieldPatternsPlugin)
            .insert_resource(ClearColor(Color::srgb(0.8, 0.83, 0.86)))
            .insert_resource(DirectionalLightShadowMap { size: 1024 });
        let world = app.world_mut();
        world.spawn((
            Camera3d::default(),
            Msaa::Off,
            Tonemapping::None,
            DebandDither::Disabled,
            AmbientLight {
                brightness: 300.0,
                ..default()
            },
            Transform::from_xyz(0.5, 2.6, 3.2).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        let shadows = CascadeShadowConfigBuilder {
            num_cascades: 1,
            minimum_distance: 1.0,
            maximum_distance: 8.0,
            ..default()
        };
        world.spawn((
            DirectionalLight {
                illuminance: 4_000.0,
                shadow_maps_enabled: true,
                ..default()
            },
            shadows.build(),
            Transform::from_xyz(-1.0, 2.5, 1.5).looking_at(Vec3::ZERO, Vec3::Y),
        ));
        Self {
            app,
            bodies: Vec::new(),
            failures: Vec::new(),
        }
    }

    /// Clears the studio and shows a pattern.
    fn show(&mut self, raw: &RawMesh, pattern: impl Bundle, stripes: Stripes) -> Entity {
        for entity in self.bodies.drain(..) {
            self.app.world_mut().despawn(entity);
        }
        let mesh = add_mesh(&mut self.app, raw);
        let world = self.app.world_mut();
        let material = world.resource_mut::<Assets<StripeMaterial>>().add(StripeMaterial {
            base: StandardMaterial {
                base_color: Color::srgb(0.9, 0.88, 0.8),
                perceptual_roughness: 0.7,
                cull_mode: None,
                double_sided: true,
                ..default()
            },
            extension: stripes,
        });
        let body = world.spawn((Mesh3d(mesh), MeshMaterial3d(material), pattern)).id();
        self.bodies.push(body);
        body
    }

    /// A floor for shadows to fall on.
    fn floor(&mut self) {
        let world = self.app.world_mut();
        let mesh = world
            .resource_mut::<Assets<Mesh>>()
            .add(Plane3d::default().mesh().size(8.0, 8.0));
        let material = world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial::from(Color::srgb(0.7, 0.7, 0.7)));
        let at = Transform::from_xyz(0.0, -1.1, 0.0);
        self.bodies
            .push(world.spawn((Mesh3d(mesh), MeshMaterial3d(material), at)).id());
    }

    fn picture(&mut self) -> Image {
        update(&mut self.app);
        settle(&mut self.app);
        headless::picture(&mut self.app).expect("a picture")
    }

    /// Compares the scene with its reference; gives the similarity.
    fn compare(&mut self, name: &str) -> f64 {
        let picture = self.picture();
        let file = references().join(format!("{name}.png"));
        if std::env::var_os("BLESS").is_some() {
            headless::save_png(&picture, &file).expect("a file");
        }
        let found = similarity(&picture, &file);
        let found = found.unwrap_or_else(|error| panic!("{error}; BLESS=1 writes it"));
        if found < ALIKE {
            let seen = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"));
            headless::save_png(&picture, &seen).expect("a file");
            println!("{name}: {found:.4}, see {}", seen.display());
        }
        found
    }

    /// The scene must look like its reference.
    fn check(&mut self, name: &str) {
        let found = self.compare(name);
        if found < ALIKE {
            self.failures.push(format!("{name}: {found:.4}"));
        }
    }
}

fn references() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/pictures")
}

fn similarity(picture: &Image, file: &Path) -> Result<f64, String> {
    let bytes = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let reference = Image::from_buffer(
        &bytes,
        ImageType::Extension("png"),
        CompressedImageFormats::NONE,
        true,
        ImageSampler::default(),
        RenderAssetUsages::MAIN_WORLD,
    )
    .map_err(|error| error.to_string())?;
    let pixels = |image: &Image| image.clone().try_into_dynamic().map(|image| image.to_rgb8());
    let (reference, picture) = (
        pixels(&reference).map_err(|error| error.to_string())?,
        pixels(picture).map_err(|error| error.to_string())?,
    );
    rgb_similarity_structure(&Algorithm::MSSIMSimple, &reference, &picture)
        .map(|similarity| similarity.score)
        .map_err(|error| error.to_string())
}

fn axis(direction: Vec3, frequency: f32) -> (DirectionField, Frequency) {
    let axis = Dir3::new(direction).expect("a direction");
    (DirectionField::Axis(axis), Frequency::Uniform(frequency))
}

fn curvature(frequency: f32) -> (DirectionField, Frequency) {
    let field = DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing: 20,
    };
    (field, Frequency::Uniform(frequency))
}

#[test]
fn patterns_look_as_they_did() {
    let mut studio = Studio::new();
    let torus = shapes::torus(96, 40, 1.0, 0.4, 0.25, 1);
    let tilted = Vec3::new(0.3, 1.0, 0.2);

    let body = studio.show(&torus, axis(tilted, 6.0), Stripes::default());
    studio.check("torus axis");
    // The comparison can fail: the field turned by a tenth of a right angle shows, and turned back it does not.
    studio.app.world_mut().entity_mut(body).insert(FieldTurn(0.16));
    update(&mut studio.app);
    studio.app.world_mut().trigger(RestartPattern { entity: body });
    if std::env::var_os("BLESS").is_none() {
        let turned = studio.compare("torus axis");
        assert!(turned < ALIKE, "a turned field has similarity {turned}");
    }

    studio.show(
        &shapes::knot(240, 24),
        (curvature(5.0), Transform::from_scale(Vec3::splat(0.8))),
        Stripes::default(),
    );
    studio.check("knot curvature");

    let cutout = Stripes {
        cutout: true,
        ..default()
    };
    studio.show(&torus, axis(tilted, 3.0), cutout);
    studio.floor();
    studio.check("torus cut-out");

    // A constant frequency around a sphere needs branches.
    let sphere = shapes::icosphere(4, 1.25);
    let around: Vec<Vec3> = sphere
        .positions
        .iter()
        .map(|p| Vec3::Y.cross(*p).normalize_or_zero())
        .collect();
    let rings = || {
        (
            DirectionField::Vertices(around.clone().into()),
            Frequency::Uniform(4.0),
            Symmetry::Vector,
        )
    };
    studio.show(&sphere, rings(), Stripes::default());
    studio.check("sphere branches");

    for (name, debug) in [
        ("phase", DebugStyle::Phase),
        ("singular", DebugStyle::Singular),
        ("angle", DebugStyle::Angle),
        ("energy", DebugStyle::Energy),
    ] {
        studio.show(&sphere, rings(), Stripes { debug, ..default() });
        studio.check(&format!("sphere {name}"));
    }
    assert!(studio.failures.is_empty(), "{}", studio.failures.join("\n"));
}
