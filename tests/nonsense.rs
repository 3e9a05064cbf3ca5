//! What users get wrong: styles, fields and samples that do not fit, and numbers that are none. Each is an error that is
//! said once, or is drawn all the same.

mod common;

use bevy::{
    mesh::{MeshVertexAttribute, VertexFormat},
    prelude::*,
};
use bevy_field_patterns::{
    material::{SceneStyle, Styled},
    prelude::*,
    sampling::{
        surface::{SurfaceSampling, sample_surface},
        surface_metric,
    },
    surface::SurfaceGraph,
    wave::StyleNeeds,
};
use common::{add_mesh, app, mesh_file::to_bevy_mesh, settle, shapes, update};

fn add<A: Asset>(app: &mut App, asset: A) -> Handle<A> {
    app.world_mut().resource_mut::<Assets<A>>().add(asset)
}

fn state(app: &App, entity: Entity) -> PatternState {
    app.world().get::<PatternState>(entity).expect("a state").clone()
}

#[derive(Resource, Default)]
struct Failures(u32);

/// An error about NaN does not equal itself.
#[test]
fn an_error_about_a_value_that_is_no_number_is_said_once() {
    let mut app = app();
    app.init_resource::<Failures>()
        .add_observer(|_: On<PatternFailed>, mut failures: ResMut<Failures>| failures.0 += 1);
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let ratio = Waves::Orthogonal { ratio: f32::NAN };
    let crease = CreasePhase {
        weight: f32::NAN,
        ..default()
    };
    let axis = || DirectionField::Axis(Dir3::Y);
    let entities = [
        app.world_mut().spawn((Mesh3d(mesh.clone()), axis(), ratio)).id(),
        app.world_mut().spawn((Mesh3d(mesh), axis(), crease)).id(),
    ];
    settle(&mut app);
    for _ in 0..10 {
        update(&mut app);
    }
    for entity in entities {
        assert!(
            matches!(
                state(&app, entity),
                PatternState::Failed(PatternError::OutOfRange { .. })
            ),
            "{:?}",
            state(&app, entity)
        );
    }
    assert_eq!(app.world().resource::<Failures>().0, 2);
}

/// Numbers that are none become those of the default, or 0; others stay as they are, infinite ones too where these mean
/// something.
#[test]
fn styles_are_put_right() {
    let mut app = app();
    let nan = f32::NAN;
    let stripes = Stripes {
        duty: nan,
        softness: 0.25,
        phase_speed: f32::INFINITY,
        color: LinearRgba::new(0.5, nan, 0.25, 1.0),
        focus: Focus::sphere(Vec3::new(1.0, nan, 2.0), 3.0),
        ..default()
    };
    let stripes = add(
        &mut app,
        StripeMaterial {
            extension: stripes,
            ..default()
        },
    );
    let texture = PatternTexture {
        travel: Travel::Periods(nan),
        ..default()
    };
    let texture = add(
        &mut app,
        PatternTextureMaterial {
            extension: texture,
            ..default()
        },
    );
    let hatch = Hatch {
        lightest: nan,
        darkest: nan,
        tone: HatchTone::Constant(nan),
        ..default()
    };
    let hatch = add(
        &mut app,
        HatchMaterial {
            extension: hatch,
            ..default()
        },
    );
    let tensor = add(&mut app, TensorMaterial::default());
    let cells = Cells {
        noise: nan,
        border_width: BorderWidth::World(nan),
        ..default()
    };
    let cells = add(
        &mut app,
        CellMaterial {
            extension: cells,
            ..default()
        },
    );
    update(&mut app);

    fn style<S: SceneStyle>(app: &App, handle: &Handle<Styled<S>>) -> S {
        let materials = app.world().resource::<Assets<Styled<S>>>();
        materials.get(handle).expect("a material").extension.clone()
    }
    let usual = Stripes::default();
    let expected = Stripes {
        softness: 0.25,
        color: LinearRgba::new(0.5, usual.color.green, 0.25, 1.0),
        focus: Focus::sphere(Vec3::new(1.0, 0.0, 2.0), 3.0),
        ..usual
    };
    assert_eq!(style(&app, &stripes), expected);
    assert_eq!(style(&app, &texture).travel, Travel::Periods(0.0));
    let tone = HatchTone::Constant(0.0);
    assert_eq!(style(&app, &hatch), Hatch { tone, ..default() });
    assert_eq!(style(&app, &tensor), Tensor::default(), "there is no limit by default");
    let materials = app.world().resource::<Assets<CellMaterial>>();
    let cells = &materials.get(&cells).expect("a material").extension;
    let border_width = BorderWidth::World(0.0);
    assert_eq!(
        *cells,
        Cells {
            border_width,
            ..default()
        }
    );
}

#[test]
fn a_transform_that_is_none_is_an_error_until_it_is_one() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let nan = Transform::from_scale(Vec3::new(1.0, f32::NAN, 1.0));
    let pattern = (DirectionField::Axis(Dir3::Y), PatternSpace::World, nan);
    let entity = app.world_mut().spawn((Mesh3d(mesh), pattern)).id();
    settle(&mut app);
    let found = state(&app, entity);
    assert!(
        matches!(found, PatternState::Failed(PatternError::SettingNotFinite(_))),
        "{found:?}"
    );
    app.world_mut().entity_mut(entity).insert(Transform::default());
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
}

#[test]
fn smoothing_without_end_is_refused() {
    for pose in [PatternPose::Rest, PatternPose::Live] {
        let mut app = app();
        let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
        let field = DirectionField::PrincipalCurvature {
            direction: default(),
            smoothing: u32::MAX,
        };
        let entity = app.world_mut().spawn((Mesh3d(mesh), field, pose)).id();
        settle(&mut app);
        let found = state(&app, entity);
        assert!(
            matches!(found, PatternState::Failed(PatternError::OutOfRange { .. })),
            "{found:?}"
        );
    }
}

#[test]
fn what_is_taken_away_leaves_no_stale_pattern() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let pattern = (DirectionField::Axis(Dir3::Y), Frequency::Uniform(3.0));
    let entity = app.world_mut().spawn((Mesh3d(mesh.clone()), pattern)).id();
    settle(&mut app);
    app.world_mut().entity_mut(entity).remove::<Mesh3d>();
    update(&mut app);
    assert_eq!(state(&app, entity), PatternState::Preparing);
    assert!(!app.world().entity(entity).contains::<PatternMesh>());
    app.world_mut().entity_mut(entity).insert(Mesh3d(mesh));
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
    app.world_mut().entity_mut(entity).remove::<Frequency>();
    update(&mut app);
    assert_eq!(app.world().get::<Frequency>(entity), Some(&Frequency::default()));
}

/// The material was there before, in use and unchanged.
#[test]
fn a_field_that_comes_after_its_style_is_checked_as_well() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let style = PatternTexture {
        travel: Travel::Periods(0.5),
        ..default()
    };
    let material = add(
        &mut app,
        PatternTextureMaterial {
            extension: style,
            ..default()
        },
    );
    let entity = app.world_mut().spawn((Mesh3d(mesh), MeshMaterial3d(material))).id();
    for _ in 0..10 {
        update(&mut app);
    }
    assert!(app.world().get::<StyleNeeds>(entity).is_none());
    let field = || (DirectionField::Axis(Dir3::Y), Symmetry::Line);
    app.world_mut().entity_mut(entity).insert(field());
    settle(&mut app);
    for _ in 0..3 {
        update(&mut app);
    }
    let found = state(&app, entity);
    assert!(
        matches!(found, PatternState::Failed(PatternError::NeedsTwoWaves(_))),
        "{found:?}"
    );
    app.world_mut().entity_mut(entity).insert(Waves::ORTHOGONAL);
    settle(&mut app);
    let found = state(&app, entity);
    assert!(
        matches!(found, PatternState::Failed(PatternError::NeedsVectorSymmetry(_))),
        "{found:?}"
    );
}

/// For a while the entity has materials of two styles.
#[test]
fn a_style_that_takes_the_place_of_another_is_checked() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let travelling = Stripes {
        phase_speed: 1.0,
        ..default()
    };
    let stripes = add(
        &mut app,
        StripeMaterial {
            extension: travelling,
            ..default()
        },
    );
    let texture = add(&mut app, PatternTextureMaterial::default());
    let field = (DirectionField::Axis(Dir3::Y), Symmetry::Vector);
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh), MeshMaterial3d(stripes), field))
        .id();
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
    app.world_mut().entity_mut(entity).insert(MeshMaterial3d(texture));
    for _ in 0..3 {
        update(&mut app);
    }
    app.world_mut()
        .entity_mut(entity)
        .remove::<MeshMaterial3d<StripeMaterial>>();
    for _ in 0..5 {
        update(&mut app);
    }
    let found = state(&app, entity);
    assert!(
        matches!(found, PatternState::Failed(PatternError::NeedsTwoWaves(_))),
        "{found:?}"
    );
}

/// A tensor field's attributes are those of the mesh, and so are painted directions.
#[test]
fn samples_follow_every_field_that_a_mesh_carries() {
    const DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Diagonal", 0x7e_0001, VertexFormat::Float32x3);
    const OTHERS: MeshVertexAttribute = MeshVertexAttribute::new("Others", 0x7e_0002, VertexFormat::Float32x3);
    let mut app = app();
    let raw = shapes::torus(40, 20, 1.0, 0.4, 0.0, 1);
    let n = raw.positions.len();
    let mesh = to_bevy_mesh(&raw)
        .with_inserted_attribute(DIAGONAL, vec![[1.0_f32, 0.3, 0.1]; n])
        .with_inserted_attribute(OTHERS, vec![[0.0_f32; 3]; n]);
    let mesh = add(&mut app, mesh);
    let tensor = DirectionField::Tensor(TensorField {
        diagonal: DIAGONAL,
        off_diagonal: OTHERS,
        ..default()
    });
    let painted = DirectionField::Smooth(SmoothField {
        align: Alignment::Painted(Painted::Attribute(DIAGONAL)),
        ..default()
    });
    let entities = [tensor, painted].map(|field| {
        let samples = AnisotropicSamples {
            metric: Metric::along(field, 3.0),
            density: Density::Count(100),
            ..default()
        };
        app.world_mut().spawn((Mesh3d(mesh.clone()), samples)).id()
    });
    for _ in 0..2000 {
        update(&mut app);
        let busy = |&entity: &Entity| {
            let state = app.world().get::<SamplingState>(entity);
            matches!(state, Some(SamplingState::Preparing | SamplingState::Sampling(_)))
        };
        if !entities.iter().any(busy) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    for entity in entities {
        let state = app.world().get::<SamplingState>(entity);
        assert_eq!(state, Some(&SamplingState::Ready));
    }
}

/// The longest ellipses work, longer ones are refused by name.
#[test]
fn ellipses_have_a_limit() {
    let mesh = to_bevy_mesh(&shapes::torus(40, 20, 1.0, 0.4, 0.0, 1));
    let graph = SurfaceGraph::from_mesh(&mesh, &default()).expect("a graph");
    let metric = |ratio| {
        let along = Metric::along(
            DirectionField::Axis(Dir3::new(Vec3::new(0.3, 1.0, 0.2)).expect("a direction")),
            ratio,
        );
        surface_metric(&along, &graph, &mesh)
    };
    let longest = metric(Metric::MAX_RATIO).expect("a metric");
    let options = SurfaceSampling {
        density: Density::Count(200),
        ..default()
    };
    let samples = sample_surface(&graph, &longest, &options, &default()).expect("samples");
    assert_eq!(samples.set.len(), 200);
    for ratio in [0.5, 1e4, f32::INFINITY, f32::NAN] {
        let error = metric(ratio).expect_err("a bad ratio");
        assert!(
            matches!(error, PatternError::OutOfRange { what: "ratio", .. }),
            "{error}"
        );
    }
}

#[test]
fn a_tile_is_one_of_the_atlas_whatever_its_range() {
    let patches = |columns, rows, low, high| Patches {
        columns,
        rows,
        low,
        high,
        ..default()
    };
    assert_eq!(patches(3, 2, 0.5, 0.5).tile(0.4), 0);
    assert_eq!(patches(3, 2, 0.5, 0.5).tile(0.5), 5);
    assert_eq!(patches(0, 0, 0.0, 1.0).tile(0.5), 0);
    assert_eq!(patches(3, 1, 0.0, 1.0).tile(f32::NAN), 0);
    assert_eq!(patches(u32::MAX, 2, 0.0, 1.0).tile(0.0), 0);
}
