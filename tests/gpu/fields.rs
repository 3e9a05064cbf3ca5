//! Every source of directions against its twin on the CPU.

use crate::common::{self, add_mesh, app, graph, settle, shapes, share_off, update, wave};
use bevy::{
    mesh::{MeshVertexAttribute, VertexFormat},
    prelude::*,
};
use bevy_field_patterns::{
    field::*,
    prelude::*,
    surface::SurfaceGraph,
    wave::{Pattern, SolverCounters, layout::WAVE_BUFFER},
};
use std::sync::Arc;

const DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Test_Diagonal", 8_822_001, VertexFormat::Float32x3);
const OFF_DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Test_Off", 8_822_002, VertexFormat::Float32x3);

pub(crate) fn torus() -> common::mesh_file::RawMesh {
    shapes::torus(70, 36, 1.0, 0.4, 0.25, 5)
}

/// A place that is shifted, turned and scaled differently along its axes.
fn place() -> Transform {
    Transform::from_xyz(1.0, -2.0, 0.5)
        .with_rotation(Quat::from_euler(EulerRot::XYZ, 0.3, 0.8, -0.4))
        .with_scale(Vec3::new(1.5, 2.0, 1.0))
}

/// The graph of an entity in the space of its pattern.
fn graph_in(app: &App, entity: Entity, space: PatternSpace) -> SurfaceGraph {
    let mut graph = graph(app, entity);
    if space == PatternSpace::World {
        let linear = place().compute_affine().matrix3;
        let cofactors = linear.inverse().transpose();
        graph.positions.iter_mut().for_each(|p| *p = linear * *p);
        graph.normals.iter_mut().for_each(|n| *n = (cofactors * *n).normalize());
    }
    graph
}

pub(crate) fn near(app: &App, entity: Entity, twin: &[Vec3], symmetry: u32) {
    let graph = graph(app, entity);
    let off = share_off(&wave(app, entity).0, twin, &graph, symmetry);
    assert!(off < 2e-3, "{off}");
}

pub(crate) fn spawn(app: &mut App, raw: &common::mesh_file::RawMesh, bundle: impl Bundle) -> Entity {
    let mesh = add_mesh(app, raw);
    app.world_mut()
        .spawn((Mesh3d(mesh), Frequency::Uniform(3.0), place(), bundle))
        .id()
}

#[test]
fn vortices_flow_as_the_twin_says() {
    for space in [PatternSpace::Mesh, PatternSpace::World] {
        let mut app = app();
        let vortices = [
            Vortex {
                strength: 2.0,
                radius: 0.5,
                ..default()
            },
            Vortex {
                sense: Sense::Clockwise,
                falloff: Falloff::Gaussian,
                radius: 0.8,
                ..default()
            },
        ];
        let places = [Vec3::new(2.2, -1.5, 0.0), Vec3::new(0.5, -3.0, 1.0)];
        let cores: Vec<Entity> = vortices
            .iter()
            .zip(places)
            .map(|(&vortex, at)| app.world_mut().spawn((vortex, Transform::from_translation(at))).id())
            .collect();
        let base = Vec3::new(0.0, 0.4, 0.1);
        let field = |cores| DirectionField::Vortices(VortexField { base, cores });
        let spawned = (field(VortexCores::All), FieldTurn(0.3), space);
        let entity = spawn(&mut app, &torus(), spawned);
        settle(&mut app);
        let graph = graph_in(&app, entity, space);
        let affine = place().compute_affine();
        let twin = |places: &[Vec3]| {
            let cores: Vec<VortexCore> = vortices
                .iter()
                .zip(places)
                .map(|(vortex, &at)| match space {
                    PatternSpace::Mesh => {
                        let scale = affine.matrix3.determinant().cbrt().recip();
                        VortexCore::new(vortex, affine.inverse().transform_point3(at), scale).unwrap()
                    }
                    PatternSpace::World => VortexCore::new(vortex, at - place().translation, 1.0).unwrap(),
                })
                .collect();
            vortex_directions(&cores, base, 0.3, &graph)
        };
        near(&app, entity, &twin(&places), 1);
        // The comparison can fail: a core elsewhere shows, until it is there.
        let moved = [places[0], Vec3::new(1.5, -3.0, 0.2)];
        let off = share_off(&wave(&app, entity).0, &twin(&moved), &graph, 1);
        assert!(off > 0.1, "{off}");
        let core = Transform::from_translation(moved[1]);
        app.world_mut().entity_mut(cores[1]).insert(core);
        update(&mut app);
        near(&app, entity, &twin(&moved), 1);
        // One core of the two.
        let one = field(VortexCores::These(vec![cores[0]]));
        app.world_mut().entity_mut(entity).insert(one);
        update(&mut app);
        near(&app, entity, &twin(&moved[..1]), 1);
        // A core that goes is an error, and one that comes back mends it.
        app.world_mut().entity_mut(cores[0]).remove::<Vortex>();
        update(&mut app);
        let state = app.world().get::<PatternState>(entity).unwrap();
        assert!(
            matches!(state, PatternState::Failed(PatternError::MissingEntity { .. })),
            "{state:?}"
        );
        app.world_mut().entity_mut(cores[0]).insert(Vortex {
            radius: f32::NAN,
            ..vortices[0]
        });
        update(&mut app);
        let state = app.world().get::<PatternState>(entity).unwrap();
        assert!(
            matches!(state, PatternState::Failed(PatternError::OutOfRange { .. })),
            "{state:?}"
        );
        app.world_mut().entity_mut(cores[0]).insert(vortices[0]);
        settle(&mut app);
        near(&app, entity, &twin(&moved[..1]), 1);
    }
}

/// A smooth tensor at p.
fn tensor(p: Vec3) -> SymmetricTensor {
    SymmetricTensor {
        diagonal: Vec3::new(2.0 + p.x, 1.0 - p.y * p.z, 3.0 * p.z),
        off_diagonal: Vec3::new(p.x * p.y, 0.5, p.z - p.x),
    }
}

#[test]
fn tensors_give_eigenvectors_and_eigenvalues_as_the_twin_says() {
    let raw = torus();
    let mesh = |app: &mut App| {
        let mut mesh = common::mesh_file::to_bevy_mesh(&raw);
        let tensors: Vec<_> = raw.positions.iter().map(|&p| tensor(p)).collect();
        let list = |of: fn(&SymmetricTensor) -> Vec3| tensors.iter().map(|t| of(t).to_array()).collect::<Vec<_>>();
        mesh.insert_attribute(DIAGONAL, list(|t| t.diagonal));
        mesh.insert_attribute(OFF_DIAGONAL, list(|t| t.off_diagonal));
        app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
    };
    for space in [PatternSpace::Mesh, PatternSpace::World] {
        let mut app = app();
        let field = |eigenvector| {
            DirectionField::Tensor(TensorField {
                diagonal: DIAGONAL,
                off_diagonal: OFF_DIAGONAL,
                eigenvector,
            })
        };
        let handle = mesh(&mut app);
        let spawned = (Mesh3d(handle), field(Eigenvector::Major), space, place());
        let entity = app.world_mut().spawn(spawned).id();
        settle(&mut app);
        let graph = graph_in(&app, entity, space);
        let linear = place().compute_affine().matrix3;
        let tensors: Vec<_> = common::graph(&app, entity)
            .positions
            .iter()
            .map(|&p| tensor(p))
            .collect();
        let tensors: Vec<_> = match space {
            PatternSpace::Mesh => tensors,
            PatternSpace::World => tensors.iter().map(|t| t.carried(linear)).collect(),
        };
        let (major, values) = tensor_directions(&tensors, Eigenvector::Major, 0.0, &graph);
        let (medium, _) = tensor_directions(&tensors, Eigenvector::Medium, 0.0, &graph);
        let off = share_off(&wave(&app, entity).0, &major, &graph, 2);
        assert!(off < 2e-3, "{off}");
        let off = share_off(&wave(&app, entity).0, &medium, &graph, 2);
        assert!(off > 0.2, "the comparison can fail: {off}");
        let scalars = scalars_of(&app, entity);
        let worst = scalars
            .iter()
            .zip(&values)
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max);
        assert!(worst < 1e-4, "{worst}");
        app.world_mut().entity_mut(entity).insert(field(Eigenvector::Medium));
        settle(&mut app);
        let off = share_off(&wave(&app, entity).0, &medium, &graph, 2);
        assert!(off < 2e-3, "{off}");
    }
}

/// An attribute that is written again in every frame is followed, and nothing is built anew or moved for it.
#[test]
fn attributes_are_followed_while_they_change() {
    let raw = torus();
    let mut app = app();
    let vectors = |frame: f32| -> Vec<[f32; 3]> {
        let turn = Quat::from_rotation_z(0.1 * frame);
        raw.positions.iter().map(|p| (turn * *p + Vec3::Z).to_array()).collect()
    };
    let mut mesh = common::mesh_file::to_bevy_mesh(&raw);
    mesh.insert_attribute(DIAGONAL, vectors(0.0));
    let handle = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let field = DirectionField::Attribute(DIAGONAL);
    let spawned = (
        Mesh3d(handle.clone()),
        field.clone(),
        Symmetry::Vector,
        Frequency::Uniform(3.0),
    );
    let entity = app.world_mut().spawn(spawned).id();
    let other = (
        Mesh3d(handle.clone()),
        DirectionField::default(),
        Frequency::Uniform(3.0),
    );
    let other = app.world_mut().spawn(other).id();
    settle(&mut app);
    let of = |app: &App, entity| {
        (
            app.world().get::<PatternMesh>(entity).unwrap().clone(),
            graph(app, entity),
        )
    };
    let before = of(&app, entity);
    for frame in 1..6 {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        meshes
            .get_mut(&handle)
            .unwrap()
            .insert_attribute(DIAGONAL, vectors(frame as f32));
        // The frame that hears of it, and the one that follows it.
        update(&mut app);
        update(&mut app);
        let mesh = app.world().resource::<Assets<Mesh>>().get(&handle).unwrap();
        let twin = directions(&field, Symmetry::Vector, 0.0, &before.1, mesh).unwrap();
        near(&app, entity, &twin, 1);
        assert!(before == of(&app, entity));
        assert_eq!(app.world().get::<PatternState>(other), Some(&PatternState::Converged));
    }
}

/// The scalars of an entity, read back.
fn scalars_of(app: &App, entity: Entity) -> Vec<Vec2> {
    let record = *app.world().get::<Pattern>(entity).expect("a pattern").record();
    assert_ne!(record.scalar_base, 0);
    let (first, len) = (8 * u64::from(record.scalar_base), 8 * u64::from(record.vertices));
    let values = common::gpu::read::<f32>(app, &WAVE_BUFFER, first, len).expect("the wave buffer");
    values.chunks_exact(2).map(|s| Vec2::new(s[0], s[1])).collect()
}

#[test]
fn scalars_of_a_component_take_the_place_of_eigenvalues_and_solve_nothing() {
    let mut app = app();
    let raw = torus();
    let list = |factor: f32| PatternScalars {
        first: ScalarSource::Vertices(raw.positions.iter().map(|p| factor * p.x).collect()),
        second: ScalarSource::None,
    };
    let entity = spawn(&mut app, &raw, (DirectionField::Axis(Dir3::Y), list(1.0)));
    settle(&mut app);
    update(&mut app);
    for factor in [1.0, -2.0] {
        app.world_mut().entity_mut(entity).insert(list(factor));
        update(&mut app);
        assert_eq!(app.world().resource::<SolverCounters>().dispatches(), 0);
        for (scalars, p) in scalars_of(&app, entity).iter().zip(&graph(&app, entity).positions) {
            assert_eq!(*scalars, Vec2::new(factor * p.x, 0.0));
        }
    }
    app.world_mut().entity_mut(entity).insert(PatternScalars {
        second: ScalarSource::Vertices(Arc::from(vec![1.0; 3])),
        ..default()
    });
    update(&mut app);
    let state = app.world().get::<PatternState>(entity).unwrap();
    assert!(
        matches!(state, PatternState::Failed(PatternError::WrongLength { .. })),
        "{state:?}"
    );
    app.world_mut().entity_mut(entity).remove::<PatternScalars>();
    settle(&mut app);
    assert_eq!(app.world().get::<Pattern>(entity).unwrap().record().scalar_base, 0);
    assert_eq!(app.world().get::<PatternState>(entity), Some(&PatternState::Converged));
}

#[test]
fn fields_are_smoothed_as_the_twin_says() {
    let raw = shapes::icosphere(4, 1.0);
    let painted: Arc<[Vec3]> = raw
        .positions
        .iter()
        .map(|p| {
            if p.x.abs() > 0.9 {
                4.0 * Vec3::new(0.0, p.z, 1.0)
            } else {
                Vec3::ZERO
            }
        })
        .collect();
    let mut app = app();
    let field = |ring, smoothing, steps, quarter_turn| SmoothField {
        ring,
        smoothing,
        align: Alignment::Painted(Painted::Vertices(painted.clone())),
        weight: 2.0,
        steps,
        quarter_turn,
    };
    // One of them is smoothed more often, in the same dispatches.
    let fields = [
        field(FieldRing::Two, Smoothing::Intrinsic, 3, false),
        field(FieldRing::Two, Smoothing::Extrinsic, 3, true),
        field(FieldRing::Four, Smoothing::Intrinsic, 3, false),
        field(FieldRing::Four, Smoothing::Extrinsic, 6, false),
    ];
    let entities: Vec<Entity> = fields
        .iter()
        .map(|field| spawn(&mut app, &raw, DirectionField::Smooth(field.clone())))
        .collect();
    settle(&mut app);
    for (field, &entity) in fields.iter().zip(&entities) {
        let graph = graph(&app, entity);
        let symmetry = if field.ring == FieldRing::Two { 2 } else { 4 };
        let twin = |field: &SmoothField| {
            let constraints = smooth_constraints(field, &graph, &common::mesh_file::to_bevy_mesh(&raw)).unwrap();
            smooth_directions(field, &constraints, 0.0, &graph)
        };
        let (d, ..) = wave(&app, entity);
        let off = share_off(&d, &twin(field), &graph, symmetry);
        assert!(off < 5e-3, "{field:?}: {off}");
        let free = SmoothField {
            weight: 0.0,
            ..field.clone()
        };
        let off = share_off(&d, &twin(&free), &graph, symmetry);
        assert!(off > 0.5, "the comparison can fail: {off}");
    }
    // Nothing is smoothed again for another frequency.
    let before = app.world().resource::<SolverCounters>().dispatches();
    app.world_mut().entity_mut(entities[3]).insert(Frequency::Uniform(3.1));
    update(&mut app);
    let after = app.world().resource::<SolverCounters>().dispatches();
    assert!(after > 0 && after < 40, "{before} {after}");
}

#[test]
fn snapshots_are_blended_as_the_twin_says() {
    let raw = torus();
    let swirl = |angle: f32| -> Arc<[Vec3]> {
        let turn = Quat::from_rotation_x(angle);
        raw.positions
            .iter()
            .map(|p| (1.0 + angle) * (turn * p.cross(Vec3::Y)) + 0.2 * Vec3::Y)
            .collect()
    };
    let snapshots: Arc<[Snapshot]> = [(0.0, 0.0), (1.0, 0.5), (3.0, 1.6)]
        .map(|(time, angle)| Snapshot {
            time,
            vectors: swirl(angle),
        })
        .into();
    for symmetry in [Symmetry::Vector, Symmetry::Line] {
        let mut app = app();
        let spawned = (DirectionField::Snapshots(snapshots.clone()), symmetry, FieldTime(0.25));
        let entity = spawn(&mut app, &raw, spawned);
        settle(&mut app);
        let graph = graph(&app, entity);
        let twin = |time| snapshot_directions(&snapshots, time, symmetry, 0.0, &graph).unwrap();
        let lines = if symmetry == Symmetry::Line { 2 } else { 1 };
        let (mut last, mut shown) = (twin(0.25), 0.25);
        near(&app, entity, &last, lines);
        for time in [0.9, 1.0, 1.7, 2.9, 3.0, 8.0, 0.5, -1.0, 2.0] {
            app.world_mut().entity_mut(entity).insert(FieldTime(time));
            update(&mut app);
            near(&app, entity, &twin(time), lines);
            let off = share_off(&twin(time), &last, &graph, lines);
            let far = (time.clamp(0.0, 3.0) - shown).abs() > 0.4;
            assert!(!far || off > 0.2, "the comparison can fail at {time}: {off}");
            (last, shown) = (twin(time), time.clamp(0.0, 3.0));
        }
        settle(&mut app);
        app.world_mut().entity_mut(entity).insert(FieldTime(f32::NAN));
        update(&mut app);
        let state = app.world().get::<PatternState>(entity).unwrap();
        assert!(
            matches!(state, PatternState::Failed(PatternError::SettingNotFinite(_))),
            "{state:?}"
        );
    }
}
