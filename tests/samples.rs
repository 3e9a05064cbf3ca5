//! Sampling as a component, in an app without a renderer.
#![allow(unreachable_pub, reason = "modules shared with the examples")]

use bevy::{
    app::PluginsState,
    asset::RenderAssetUsages,
    image::ImagePlugin,
    math::DVec2,
    mesh::{MeshPlugin, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use bevy_field_patterns::{
    cells::{check_samples, layout::Site},
    prelude::*,
    sampling::{metric::Structure, planar::PlanarDomain},
};
use mesh_file::to_bevy_mesh;

#[path = "../examples/common/mesh_file/mod.rs"]
#[allow(dead_code, reason = "only the mesh type is used here")]
mod mesh_file;
#[path = "../examples/common/shapes.rs"]
#[allow(dead_code, reason = "two shapes are enough here")]
mod shapes;

fn app() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        AssetPlugin::default(),
        ImagePlugin::default(),
        MeshPlugin,
        TransformPlugin,
        FieldPatternsPlugin,
    ));
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app
}

fn state(app: &App, entity: Entity) -> SamplingState {
    app.world().get::<SamplingState>(entity).cloned().unwrap_or_default()
}

/// Updates until the samples of `entity` are there, or never will be.
fn settle(app: &mut App, entity: Entity) -> SamplingState {
    for _ in 0..5000 {
        app.update();
        if matches!(state(app, entity), SamplingState::Ready | SamplingState::Failed(_)) {
            return state(app, entity);
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("still {:?}", state(app, entity));
}

fn samples(app: &App, entity: Entity) -> SampleSet {
    app.world().get::<SampleSet>(entity).cloned().unwrap_or_default()
}

fn torus(app: &mut App) -> Handle<Mesh> {
    let mesh = to_bevy_mesh(&shapes::torus(48, 24, 1.0, 0.4, 0.0, 1));
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

fn along_y(count: u32) -> AnisotropicSamples {
    AnisotropicSamples {
        metric: Metric::along(DirectionField::Axis(Dir3::Y), 3.0),
        density: Density::Count(count),
        ..default()
    }
}

#[test]
fn samples_follow_their_inputs() {
    let mut app = app();
    let mesh = torus(&mut app);
    let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), along_y(300))).id();
    let twin = app.world_mut().spawn((Mesh3d(mesh.clone()), along_y(300))).id();
    assert_eq!(settle(&mut app, entity), SamplingState::Ready);
    assert_eq!(settle(&mut app, twin), SamplingState::Ready);
    let first = samples(&app, entity);
    assert_eq!(first.len(), 300);
    assert!(first == samples(&app, twin), "the same inputs give the same samples");
    for (p, n) in first.positions.iter().zip(&first.normals) {
        let from_ring = *p - p.with_z(0.0).normalize();
        assert!((from_ring.length() - 0.4).abs() < 0.02, "{p} is not on the torus");
        assert!(n.dot(from_ring.normalize()) > 0.9);
    }

    // Nothing changes, nothing is done.
    for _ in 0..5 {
        app.update();
        assert_eq!(state(&app, entity), SamplingState::Ready);
    }

    // Another seed, another count.
    app.world_mut().get_mut::<AnisotropicSamples>(entity).unwrap().seed = 7;
    app.update();
    assert!(matches!(state(&app, entity), SamplingState::Sampling(_)));
    settle(&mut app, entity);
    assert!(samples(&app, entity) != first);
    app.world_mut().get_mut::<AnisotropicSamples>(twin).unwrap().density = Density::Count(17);
    settle(&mut app, twin);
    assert_eq!(samples(&app, twin).len(), 17);

    // The mesh moves, and the samples with it.
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mut moved = meshes.get_mut(&mesh).unwrap();
    if let Some(VertexAttributeValues::Float32x3(positions)) = moved.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
        positions.iter_mut().for_each(|p| p[2] += 5.0);
    }
    drop(moved);
    for _ in 0..5 {
        app.update();
    }
    settle(&mut app, entity);
    assert!(samples(&app, entity).positions.iter().all(|p| p.z > 4.0));

    // Followed samples move a little where the metric changes a little.
    let mut wish = app.world_mut().get_mut::<AnisotropicSamples>(entity).unwrap();
    wish.follow = true;
    wish.metric = Metric::along(DirectionField::Axis(Dir3::Y), 3.2);
    let before = samples(&app, entity);
    app.update();
    settle(&mut app, entity);
    let after = samples(&app, entity);
    assert_eq!(after.len(), before.len());
    let moves = before
        .positions
        .iter()
        .zip(&after.positions)
        .map(|(a, b)| a.distance(*b));
    let mean = moves.sum::<f32>() / before.len() as f32;
    assert!(mean > 0.0 && mean < 0.05, "followed samples moved by {mean}");

    // No wish, no samples.
    app.world_mut().entity_mut(entity).remove::<AnisotropicSamples>();
    app.update();
    assert!(app.world().get::<SampleSet>(entity).is_none());
    assert!(app.world().get::<SamplingState>(entity).is_none());
}

#[test]
fn wishes_that_cannot_be_met_are_told() {
    let mut app = app();
    let mesh = torus(&mut app);
    let empty = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let empty = app.world_mut().resource_mut::<Assets<Mesh>>().add(empty);
    let spawn = |app: &mut App, samples| app.world_mut().spawn((Mesh3d(mesh.clone()), samples)).id();
    let failure = |app: &mut App, entity| match settle(app, entity) {
        SamplingState::Failed(error) => error,
        other => panic!("{other:?}"),
    };

    let entity = app.world_mut().spawn(along_y(10)).id();
    assert!(matches!(failure(&mut app, entity), PatternError::Domain(_)));
    let entity = app.world_mut().spawn((Mesh3d(empty), along_y(10))).id();
    assert!(matches!(
        failure(&mut app, entity),
        PatternError::NoPositions | PatternError::NoTriangles
    ));
    let entity = spawn(&mut app, along_y(0));
    assert!(matches!(failure(&mut app, entity), PatternError::OutOfRange { .. }));
    assert!(app.world().get::<SampleSet>(entity).is_none());
    // A change tries again.
    app.world_mut().entity_mut(entity).insert(along_y(5));
    assert_eq!(settle(&mut app, entity), SamplingState::Ready);
    assert_eq!(samples(&app, entity).len(), 5);
    // And what was there goes with the next failure.
    app.world_mut().entity_mut(entity).insert(along_y(0));
    failure(&mut app, entity);
    assert!(app.world().get::<SampleSet>(entity).is_none());

    let bad = |source| AnisotropicSamples {
        metric: Metric::new(source),
        ..default()
    };
    let entity = spawn(&mut app, bad(MetricSource::Vertices([].into())));
    assert!(matches!(
        failure(&mut app, entity),
        PatternError::WrongLength { found: 0, .. }
    ));
    let nan = SpaceFunction::new(|_| glam_matrix_extras::SymmetricMat3::IDENTITY * f32::NAN);
    let entity = spawn(&mut app, bad(MetricSource::Function(nan)));
    assert!(matches!(failure(&mut app, entity), PatternError::NotFinite { .. }));
    let field = DirectionField::default();
    let entity = spawn(
        &mut app,
        bad(MetricSource::Field {
            field,
            turn: 0.0,
            ratio: 0.5,
        }),
    );
    assert!(matches!(failure(&mut app, entity), PatternError::OutOfRange { .. }));
    let image = Handle::default();
    let structure = Structure::default();
    let entity = spawn(&mut app, bad(MetricSource::Image { image, structure }));
    assert!(matches!(failure(&mut app, entity), PatternError::Domain(_)));
}

/// Sampled and drawn, or refused by both with the same words.
#[test]
fn any_unit_of_length_will_do_or_is_refused() {
    let mut app = app();
    for (unit, fits) in [
        (1e-30, false),
        (1e-14, true),
        (1e-7, true),
        (1e7, true),
        (1e14, true),
        (1e30, false),
    ] {
        let mesh = Mesh::from(Torus::new(0.5 * unit, unit));
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        let on_mesh = app.world_mut().spawn((Mesh3d(mesh), along_y(200))).id();
        let domain = PlanarDomain::Rectangle {
            min: DVec2::ZERO,
            max: DVec2::splat(f64::from(unit)),
        };
        let wish = AnisotropicSamples {
            density: Density::Count(200),
            ..default()
        };
        let in_plane = app.world_mut().spawn((domain, wish)).id();
        for entity in [on_mesh, in_plane] {
            let state = settle(&mut app, entity);
            if fits {
                assert_eq!(state, SamplingState::Ready, "{unit}");
                let set = samples(&app, entity);
                assert_eq!((set.len(), check_samples(&set)), (200, Ok(())), "{unit}");
                for i in 0..set.len() {
                    let site = Site::new(set.positions[i], set.normals[i], set.metrics[i]);
                    let point = set.positions[set.ring(i)[0] as usize];
                    let (drawn, meant) = (
                        site.metric_offset(point).length_squared(),
                        set.distance_squared(i, point),
                    );
                    assert!((drawn - meant).abs() < 1e-3 * meant, "{unit}: {drawn} for {meant}");
                }
            } else {
                let too_far = |error: &PatternError| matches!(error, PatternError::OutOfRange { what, .. } if *what == "the radius of a sample");
                assert!(
                    matches!(&state, SamplingState::Failed(error) if too_far(error)),
                    "{unit}: {state:?}"
                );
            }
        }
    }
}

#[test]
fn a_plane_is_sampled_along_an_image_s_edges_and_by_its_brightness() {
    let mut app = app();
    // The left half is black, the right half is white.
    let texels: Vec<u8> = (0..64 * 32)
        .flat_map(|i| if i % 64 < 32 { [0, 0, 0, 255] } else { [255; 4] })
        .collect();
    let extent = Extent3d {
        width: 64,
        height: 32,
        depth_or_array_layers: 1,
    };
    let image = |texels: Vec<u8>| {
        let format = TextureFormat::Rgba8UnormSrgb;
        Image::new(
            extent,
            TextureDimension::D2,
            texels,
            format,
            RenderAssetUsages::default(),
        )
    };
    let handle = app.world_mut().resource_mut::<Assets<Image>>().reserve_handle();
    let domain = PlanarDomain::Rectangle {
        min: DVec2::ZERO,
        max: DVec2::new(2.0, 1.0),
    };
    let samples_of_image = AnisotropicSamples {
        metric: Metric {
            importance: Importance::Image {
                image: handle.clone(),
                floor: 0.2,
            },
            ..Metric::new(MetricSource::Image {
                image: handle.clone(),
                structure: Structure {
                    detail: 0.0,
                    ..default()
                },
            })
        },
        density: Density::Count(600),
        ..default()
    };
    let entity = app.world_mut().spawn((domain, samples_of_image)).id();
    // The image is not there yet.
    for _ in 0..3 {
        app.update();
        assert_eq!(state(&app, entity), SamplingState::Preparing);
    }
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    images.insert(&handle, image(texels.clone())).unwrap();
    assert_eq!(settle(&mut app, entity), SamplingState::Ready);
    let set = samples(&app, entity);
    assert_eq!(set.len(), 600);
    let on = |low: f32, high: f32| set.positions.iter().filter(|p| (low..high).contains(&p.x)).count() as f32;
    let share = on(1.2, 2.0) / on(0.0, 0.8);
    assert!((3.5..6.5).contains(&share), "white over black: {share}");
    let edge = set
        .positions
        .iter()
        .zip(&set.metrics)
        .filter(|(p, _)| (p.x - 1.0).abs() < 0.03);
    for (p, m) in edge {
        assert!(m.m00 > 2.0 * m.m11, "not along the edge at {p}: {m:?}");
    }

    // An image that changes is sampled anew.
    let inverted = texels
        .chunks(4)
        .flat_map(|t| [255 - t[0], 255 - t[1], 255 - t[2], 255])
        .collect();
    let mut images = app.world_mut().resource_mut::<Assets<Image>>();
    images.insert(&handle, image(inverted)).unwrap();
    for _ in 0..3 {
        app.update();
    }
    settle(&mut app, entity);
    let set = samples(&app, entity);
    let on = |low: f32, high: f32| set.positions.iter().filter(|p| (low..high).contains(&p.x)).count() as f32;
    assert!(on(0.0, 0.8) > 3.0 * on(1.2, 2.0));
}
