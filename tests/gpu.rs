//! The plugin on a device: the solver against its CPU twin, the life of patterns, the shared memory.

mod common;

use bevy::{mesh::VertexAttributeValues, prelude::*};
use bevy_field_patterns::{
    field::Principal,
    prelude::*,
    wave::{
        Pattern, PatternArena, SolverCounters,
        layout::{FLAG_READY, FLAG_VECTOR},
        quality,
        solver::{ColdStart, LocalRule, solve_cpu},
    },
};
use common::{add_mesh, app, app_with, graph, settle, shapes, update, wave};
use std::sync::Arc;

fn curvature() -> DirectionField {
    DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing: 10,
    }
}

/// The largest distance between the phasors of the device and those of the twin, on the same directions.
fn distance_to_twin(gpu: &SolverSettings, cpu: &SolverSettings, symmetry: Symmetry) -> f32 {
    let mut app = app_with(gpu.clone());
    let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh), curvature(), symmetry, Frequency::Uniform(6.0)))
        .id();
    settle(&mut app);
    let (d, f, z) = wave(&app, entity);
    let twin = solve_cpu(&graph(&app, entity), &d, &f, symmetry, cpu).phasors;
    z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn every_pass_agrees_with_its_twin() {
    let hierarchy = |level_sweeps| ColdStart::Hierarchy { level_sweeps };
    let none = SolverSettings {
        cold_start: hierarchy(0),
        soft_sweeps: 0,
        plain_sweeps: 0,
        ..default()
    };
    let local = LocalRule {
        max_sweeps: 3,
        epsilon: 0.0,
        ..default()
    };
    let cases = [
        ("edges, alignment, coarsening, rotation", none.clone()),
        (
            "sweeps on the levels",
            SolverSettings {
                cold_start: hierarchy(2),
                ..none.clone()
            },
        ),
        (
            "soft sweeps",
            SolverSettings {
                soft_sweeps: 2,
                ..none.clone()
            },
        ),
        (
            "plain sweeps",
            SolverSettings {
                plain_sweeps: 2,
                ..none.clone()
            },
        ),
        (
            "local rule",
            SolverSettings {
                cold_start: ColdStart::Local(local),
                ..none.clone()
            },
        ),
    ];
    for symmetry in [Symmetry::Line, Symmetry::Vector] {
        for (name, settings) in &cases {
            let distance = distance_to_twin(settings, settings, symmetry);
            assert!(distance < 2e-3, "{name}, {symmetry:?}: {distance}");
        }
    }
    // The comparison can fail: one sweep more shows.
    let more = SolverSettings {
        plain_sweeps: 3,
        ..none.clone()
    };
    let distance = distance_to_twin(&cases[3].1, &more, Symmetry::Line);
    assert!(distance > 2e-2, "{distance}");
}

#[test]
fn axis_is_projected_on_the_device_as_by_the_twin() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let axis = Dir3::new(Vec3::new(0.2, 1.0, -0.3)).unwrap();
    let spawn = (
        Mesh3d(mesh),
        DirectionField::Axis(axis),
        FieldTurn(0.4),
        Frequency::Uniform(3.0),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let graph = graph(&app, entity);
    let (d, f, _) = wave(&app, entity);
    assert!(f.iter().all(|&f| f == 3.0));
    for (d, &n) in d.iter().zip(&graph.normals) {
        let twin =
            bevy_field_patterns::field::turn_tangent(bevy_field_patterns::field::project_tangent(*axis, n), n, 0.4);
        assert!(d.distance(twin) < 1e-5, "{d} {twin}");
    }
}

/// Lines keep the sign that their phasor refers to while the axis turns right round.
#[test]
fn a_turning_line_field_keeps_its_signs() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let field = |frame: u32| DirectionField::Axis(Quat::from_rotation_z((frame as f32 * 6.0).to_radians()) * Dir3::Y);
    let spawn = (Mesh3d(mesh), field(0), Symmetry::Line, Frequency::Uniform(4.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let (mut last, f, _) = wave(&app, entity);
    for frame in 1..=30 {
        app.world_mut().entity_mut(entity).insert(field(frame));
        update(&mut app);
        let (d, _, _) = wave(&app, entity);
        let reversed = d.iter().zip(&last).filter(|(d, last)| d.dot(**last) < 0.0).count();
        assert_eq!(reversed, 0, "frame {frame}");
        last = d;
    }
    settle(&mut app);
    let graph = graph(&app, entity);
    let (d, _, z) = wave(&app, entity);
    let q = quality(&graph, &d, &f, &z, Symmetry::Line);
    assert!(q.energy < 0.05, "{q:?}");
}

/// The pattern of old directions is that of the old symmetry, for as long as new ones are being computed.
#[test]
fn a_symmetry_changes_together_with_its_directions() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::torus(140, 72, 1.0, 0.4, 0.25, 5));
    let curvature = DirectionField::PrincipalCurvature {
        direction: Principal::Major,
        smoothing: 2000,
    };
    let spawn = (Mesh3d(mesh), curvature, Symmetry::Line, Frequency::Uniform(6.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let (before, ..) = wave(&app, entity);
    app.world_mut()
        .entity_mut(entity)
        .insert((Symmetry::Vector, FieldTurn(0.8)));
    let mut waited = 0;
    loop {
        update(&mut app);
        let is_vector = app.world().get::<Pattern>(entity).unwrap().record().flags & FLAG_VECTOR != 0;
        let (now, ..) = wave(&app, entity);
        let turned = now.iter().zip(&before).all(|(d, old)| d.dot(*old) < 0.9);
        assert_eq!(is_vector, turned, "after {waited} frames");
        if turned {
            break;
        }
        waited += 1;
        assert!(waited < 10_000);
        assert_eq!(app.world().get::<PatternState>(entity), Some(&PatternState::Solving));
    }
    assert!(waited > 0, "the computation is too fast to see anything");
    settle(&mut app);
    let (d, f, z) = wave(&app, entity);
    let twin = solve_cpu(&graph(&app, entity), &d, &f, Symmetry::Vector, &default()).phasors;
    let worst = z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(worst < 1e-2, "{worst}");
}

/// The device knows the signs of a line field that it has followed; directions of the processor take them over.
#[test]
fn directions_after_an_axis_keep_its_signs() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let axis = |step: u32| Quat::from_rotation_z((step as f32 * 17.0).to_radians()) * Dir3::Y;
    let spawn = (
        Mesh3d(mesh),
        DirectionField::Axis(axis(0)),
        Symmetry::Line,
        Frequency::Uniform(4.0),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    for step in 1..=10 {
        app.world_mut()
            .entity_mut(entity)
            .insert(DirectionField::Axis(axis(step)));
        update(&mut app);
    }
    settle(&mut app);
    let (before, ..) = wave(&app, entity);
    let graph = graph(&app, entity);
    // The axis has come past many normals, where its projections have the other sign by now.
    let projected = |v: u32| bevy_field_patterns::field::project_tangent(*axis(10), graph.normals[v as usize]);
    let given: Vec<Vec3> = graph.vertex_of.iter().map(|&v| projected(v)).collect();
    let reversed = |d: &[Vec3]| d.iter().zip(&before).filter(|(d, old)| d.dot(**old) < 0.0).count();
    let as_given: Vec<Vec3> = (0..graph.len() as u32).map(projected).collect();
    assert!(reversed(&as_given) > 20, "the test shows nothing");
    app.world_mut()
        .entity_mut(entity)
        .insert(DirectionField::Tangents(given.into()));
    update(&mut app);
    let (now, ..) = wave(&app, entity);
    assert_eq!(reversed(&now), 0);
    assert!(now.iter().zip(&before).all(|(d, old)| d.distance(*old) < 1e-4));
}

#[test]
fn nonsense_settings_are_put_right() {
    let nonsense = SolverSettings {
        omega: f32::NAN,
        softness: f32::INFINITY,
        soft_sweeps: u32::MAX,
        plain_sweeps: u32::MAX,
        warm_sweeps: 0,
        cold_start: ColdStart::Hierarchy { level_sweeps: u32::MAX },
    };
    let limit = SolverSettings::MAX_SWEEPS;
    let expected = SolverSettings {
        omega: SolverSettings::default().omega,
        softness: SolverSettings::default().softness,
        soft_sweeps: limit,
        plain_sweeps: limit,
        warm_sweeps: 1,
        cold_start: ColdStart::Hierarchy { level_sweeps: limit },
    };
    assert_eq!(nonsense.valid(), expected);
    assert_eq!(expected.valid(), expected);
    let Err(PatternError::OutOfRange { what, .. }) = nonsense.check() else {
        panic!("{:?}", nonsense.check());
    };
    assert!(what.contains("sweeps"), "{what}");
    assert_eq!(expected.check(), Ok(()));
    let rule = |momentum, epsilon, max_sweeps| SolverSettings {
        cold_start: ColdStart::Local(LocalRule {
            momentum,
            epsilon,
            max_sweeps,
            skip_last_third: false,
        }),
        ..default()
    };
    assert_eq!(rule(f32::NAN, f32::NAN, u32::MAX).valid(), rule(0.2, 1e-3, limit));
    assert_eq!(rule(-1.0, -1.0, 0).valid(), rule(0.0, 0.0, 1));

    let mut app = app_with(SolverSettings {
        soft_sweeps: 20,
        ..nonsense
    });
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let spawn = (Mesh3d(mesh), DirectionField::Axis(Dir3::Y), Frequency::Uniform(2.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let is_good = |app: &App| {
        let (d, f, z) = wave(app, entity);
        let q = quality(&graph(app, entity), &d, &f, &z, Symmetry::Vector);
        z.iter().all(|z| z.is_finite()) && q.energy < 0.05
    };
    assert!(is_good(&app));
    assert_eq!(app.world().resource::<SolverCounters>().sweeps(), 20 + limit);
    // Settings may go wrong at any time.
    app.insert_resource(SolverSettings {
        omega: f32::NEG_INFINITY,
        warm_sweeps: u32::MAX,
        ..default()
    });
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(2.5));
    settle(&mut app);
    assert!(is_good(&app));
}

/// While a buffer is away, frames wait; then each is done after the one before it, as if none had waited.
#[test]
fn frames_that_had_to_wait_are_done_in_order() {
    use bevy::render::{RenderApp, render_asset::RenderAssets, storage::GpuShaderBuffer};
    use bevy_field_patterns::wave::layout::WAVE_BUFFER;
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let axis = |degrees: f32| DirectionField::Axis(Quat::from_rotation_z(degrees.to_radians()) * Dir3::Y);
    let spawn = (Mesh3d(mesh), axis(0.0), Symmetry::Line, Frequency::Uniform(3.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let (start, ..) = wave(&app, entity);
    fn buffers(app: &mut App) -> Mut<'_, RenderAssets<GpuShaderBuffer>> {
        app.sub_app_mut(RenderApp).world_mut().resource_mut()
    }
    let take = |app: &mut App| buffers(app).remove(&WAVE_BUFFER).expect("a buffer");
    let give_back = |app: &mut App, buffer| buffers(app).insert(&WAVE_BUFFER, buffer);

    let buffer = take(&mut app);
    for degrees in [60.0, 120.0, 180.0] {
        app.world_mut().entity_mut(entity).insert(axis(degrees));
        update(&mut app);
    }
    give_back(&mut app, buffer);
    settle(&mut app);
    let (turned, f, z) = wave(&app, entity);
    // A line that has been followed through half a turn has the other sign now, but where the axis is nearly normal.
    let reversed = turned
        .iter()
        .zip(&start)
        .filter(|(d, old)| d.dot(**old) < -0.99)
        .count();
    assert!(reversed > turned.len() / 2, "{reversed} of {}", turned.len());
    let q = quality(&graph(&app, entity), &turned, &f, &z, Symmetry::Line);
    assert!(q.energy < 0.05, "{q:?}");

    // If it takes too long, what has waited is given up and everything begins anew.
    let buffer = take(&mut app);
    for frame in 0..400 {
        app.world_mut().entity_mut(entity).insert(axis(frame as f32));
        update(&mut app);
    }
    give_back(&mut app, buffer);
    app.world_mut().entity_mut(entity).insert(axis(30.0));
    update(&mut app);
    settle(&mut app);
    let graph = graph(&app, entity);
    let (d, f, z) = wave(&app, entity);
    let twin = Quat::from_rotation_z(30.0_f32.to_radians()) * Vec3::Y;
    let along = |(d, &n): (&Vec3, &Vec3)| d.dot(bevy_field_patterns::field::project_tangent(twin, n)).abs() > 0.999;
    assert!(d.iter().zip(&graph.normals).all(along));
    let q = quality(&graph, &d, &f, &z, Symmetry::Line);
    assert!(q.energy < 0.05, "{q:?}");
}

#[test]
fn sleeps_when_nothing_changes_and_wakes_when_something_does() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let spawn = (Mesh3d(mesh), DirectionField::Axis(Dir3::Y), Frequency::Uniform(3.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let dispatches = |app: &App| app.world().resource::<SolverCounters>().dispatches();
    assert!(dispatches(&app) > 0);
    for _ in 0..3 {
        update(&mut app);
        assert_eq!(dispatches(&app), 0);
    }
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(3.1));
    update(&mut app);
    assert!(dispatches(&app) > 0);
    assert_eq!(
        app.world().resource::<SolverCounters>().sweeps(),
        SolverSettings::default().warm_sweeps
    );
    assert_eq!(app.world().get::<PatternState>(entity), Some(&PatternState::Solving));
    settle(&mut app);
    update(&mut app);
    assert_eq!(dispatches(&app), 0);
    // Writing the same value again is a change; that the material or the transform changes is none.
    app.world_mut()
        .entity_mut(entity)
        .insert(Transform::from_xyz(1.0, 2.0, 3.0));
    update(&mut app);
    assert_eq!(dispatches(&app), 0);
}

#[test]
fn dispatches_do_not_grow_with_entities() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let axis = |app: &mut App, frame: u32| {
        let mut fields = app.world_mut().query::<&mut DirectionField>();
        for (n, mut field) in fields.iter_mut(app.world_mut()).enumerate() {
            let angle = 0.02 * frame as f32 + n as f32;
            *field = DirectionField::Axis(Quat::from_rotation_z(angle) * Dir3::Y);
        }
    };
    let spawn = |app: &mut App| {
        let mesh = Mesh3d(mesh.clone());
        app.world_mut()
            .spawn((mesh, DirectionField::Axis(Dir3::Y), Frequency::Uniform(2.0)));
    };
    let frame = |app: &mut App| {
        settle(app);
        axis(app, 1);
        update(app);
        app.world().resource::<SolverCounters>().dispatches()
    };
    spawn(&mut app);
    let one = frame(&mut app);
    (1..300).for_each(|_| spawn(&mut app));
    let many = frame(&mut app);
    assert!(one > 0);
    assert_eq!(one, many);
}

#[test]
fn three_hundred_entities_come_and_go() {
    let mut app = app();
    let meshes: Vec<_> = [2, 3].map(|n| add_mesh(&mut app, &shapes::icosphere(n, 1.0))).into();
    let mut random = 12345u32;
    let mut next = |n: usize| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as usize % n
    };
    let mut alive: Vec<Entity> = Vec::new();
    let mut after_first = None;
    for round in 0..3 {
        while alive.len() < 300 {
            let axis = Dir3::new(Vec3::new(next(9) as f32 - 4.0, 1.0, next(9) as f32 - 4.0)).unwrap();
            let mesh = Mesh3d(meshes[next(2)].clone());
            alive.push(
                app.world_mut()
                    .spawn((mesh, DirectionField::Axis(axis), Frequency::Uniform(2.0)))
                    .id(),
            );
        }
        settle(&mut app);
        // No two patterns share memory.
        let mut ranges: Vec<(u32, u32)> = Vec::new();
        let mut patterns = app.world_mut().query::<&Pattern>();
        for pattern in patterns.iter(app.world()) {
            let record = pattern.record();
            ranges.push((record.field_base, record.delta_base));
        }
        assert_eq!(ranges.len(), 300);
        ranges.sort_unstable();
        assert!(ranges.windows(2).all(|pair| pair[0].1 <= pair[1].0));
        // And each is what a lone one is.
        for _ in 0..5 {
            let entity = alive[next(300)];
            let (d, f, z) = wave(&app, entity);
            let twin = solve_cpu(&graph(&app, entity), &d, &f, Symmetry::Vector, &default()).phasors;
            let worst = z.iter().zip(&twin).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            assert!(worst < 1e-2, "round {round}: {worst}");
        }
        let allocated = app.world().resource::<PatternArena>().memory().allocated;
        assert!(*after_first.get_or_insert(allocated) * 2 >= allocated, "memory leaks");
        for _ in 0..200 {
            let entity = alive.swap_remove(next(alive.len()));
            app.world_mut().despawn(entity);
        }
    }
    let before = app.world().resource::<PatternArena>().memory().used;
    alive.drain(..).for_each(|entity| {
        app.world_mut().despawn(entity);
    });
    drop(meshes);
    update(&mut app);
    update(&mut app);
    update(&mut app);
    let memory = app.world().resource::<PatternArena>().memory();
    assert!(before > 0 && memory.used == 0, "{memory:?}");
}

#[test]
fn growth_keeps_phases() {
    let mut app = app();
    let small = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    let large = add_mesh(&mut app, &shapes::icosphere(6, 1.0));
    let axis = || (DirectionField::Axis(Dir3::Y), Frequency::Uniform(3.0));
    let first = app.world_mut().spawn((Mesh3d(small), axis())).id();
    settle(&mut app);
    let (_, _, before) = wave(&app, first);
    let allocated = app.world().resource::<PatternArena>().memory().allocated;
    app.world_mut().spawn((Mesh3d(large), axis()));
    settle(&mut app);
    assert!(app.world().resource::<PatternArena>().memory().allocated > allocated);
    let (_, _, after) = wave(&app, first);
    assert_eq!(before, after);
}

#[test]
fn changed_positions_keep_the_graph_and_changed_indices_do_not() {
    let mut app = app();
    let raw = shapes::icosphere(3, 1.0);
    let mesh = add_mesh(&mut app, &raw);
    let spawn = (
        Mesh3d(mesh.clone()),
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(3.0),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let before = graph(&app, entity);
    let record = *app.world().get::<Pattern>(entity).unwrap().record();
    {
        let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
        let mut mesh = meshes.get_mut(&mesh).unwrap();
        let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) else {
            panic!("no positions");
        };
        positions.iter_mut().for_each(|p| p[1] *= 2.0);
    }
    for _ in 0..4 {
        update(&mut app);
    }
    settle(&mut app);
    let after = graph(&app, entity);
    assert_eq!(before.levels, after.levels);
    assert!((after.positions[0].y - 2.0 * before.positions[0].y).abs() < 1e-6);
    assert_eq!(
        app.world().get::<Pattern>(entity).unwrap().record().field_base,
        record.field_base
    );
    let (d, f, z) = wave(&app, entity);
    let q = quality(&after, &d, &f, &z, Symmetry::Vector);
    assert!(q.energy < 0.02, "{q:?}");

    *app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh).unwrap() =
        common::mesh_file::to_bevy_mesh(&shapes::icosphere(2, 1.0));
    for _ in 0..4 {
        update(&mut app);
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    settle(&mut app);
    assert_eq!(graph(&app, entity).len(), shapes::icosphere(2, 1.0).positions.len());
}

#[test]
fn bad_input_is_an_error_on_the_entity_and_good_input_mends_it() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let axis = DirectionField::Axis(Dir3::Y);
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), axis.clone(), Frequency::Uniform(-1.0)))
        .id();
    let short = DirectionField::Vertices(Arc::from(vec![Vec3::X; 3]));
    let other = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), short, Frequency::Uniform(1.0)))
        .id();
    let tagged = app.world_mut().spawn((Mesh3d(mesh), axis, bevy::mesh::MeshTag(7))).id();
    let points = Mesh::new(bevy::mesh::PrimitiveTopology::PointList, default());
    let points = app.world_mut().resource_mut::<Assets<Mesh>>().add(points);
    let points = app.world_mut().spawn((Mesh3d(points), DirectionField::default())).id();
    settle(&mut app);
    let state = |app: &App, entity| app.world().get::<PatternState>(entity).unwrap().clone();
    assert_eq!(
        state(&app, entity),
        PatternState::Failed(PatternError::NegativeFrequency(-1.0))
    );
    let PatternState::Failed(PatternError::WrongLength { found: 3, .. }) = state(&app, other) else {
        panic!("{:?}", state(&app, other));
    };
    assert_eq!(state(&app, tagged), PatternState::Failed(PatternError::MeshTagTaken));
    let PatternState::Failed(PatternError::Topology(_)) = state(&app, points) else {
        panic!("{:?}", state(&app, points));
    };
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(f32::NAN));
    update(&mut app);
    assert!(matches!(
        state(&app, entity),
        PatternState::Failed(PatternError::NotFinite { .. })
    ));
    app.world_mut().entity_mut(entity).insert(Frequency::Uniform(2.0));
    settle(&mut app);
    assert_eq!(state(&app, entity), PatternState::Converged);
}

#[test]
fn removing_the_field_gives_the_mesh_back() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh.clone()), DirectionField::Axis(Dir3::Y)))
        .id();
    settle(&mut app);
    assert_ne!(app.world().get::<Mesh3d>(entity).unwrap().0, mesh);
    assert_eq!(app.world().get::<PatternMesh>(entity).unwrap().source, mesh);
    app.world_mut().entity_mut(entity).remove::<DirectionField>();
    update(&mut app);
    let entity = app.world().entity(entity);
    assert_eq!(entity.get::<Mesh3d>().unwrap().0, mesh);
    assert!(!entity.contains::<Pattern>() && !entity.contains::<bevy::mesh::MeshTag>());
}

#[test]
fn world_space_counts_stripes_per_unit_of_the_world() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
    let spawn = (
        Mesh3d(mesh),
        DirectionField::Axis(Dir3::Y),
        Frequency::Uniform(3.0),
        PatternSpace::World,
        Transform::from_scale(Vec3::new(2.0, 3.0, 2.0)),
    );
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    let mut scaled = graph(&app, entity);
    scaled.positions.iter_mut().for_each(|p| *p *= Vec3::new(2.0, 3.0, 2.0));
    let (d, f, z) = wave(&app, entity);
    let in_world = quality(&scaled, &d, &f, &z, Symmetry::Vector);
    let in_mesh = quality(&graph(&app, entity), &d, &f, &z, Symmetry::Vector);
    assert!(
        in_world.energy < 0.05 && in_mesh.energy > 3.0 * in_world.energy,
        "{in_world:?} {in_mesh:?}"
    );
}

#[test]
fn diagnostics_tell_energy_and_branches() {
    use bevy::{
        diagnostic::DiagnosticsStore,
        render::{RenderApp, diagnostic::RenderDiagnosticsPlugin, renderer::RenderDevice, settings::WgpuFeatures},
    };
    use bevy_field_patterns::diagnostics::{BRANCHES, ENERGY, MEMORY, SWEEPS};
    let mut app = common::headless::headless_app(UVec2::splat(16)).unwrap();
    app.add_plugins((FieldPatternsPlugin, RenderDiagnosticsPlugin));
    common::headless::wait_until_ready(&mut app).unwrap();
    let mesh = add_mesh(&mut app, &shapes::torus(70, 36, 1.0, 0.4, 0.25, 5));
    let spawn = (Mesh3d(mesh), DirectionField::Axis(Dir3::Y), Frequency::Uniform(8.0));
    let entity = app.world_mut().spawn(spawn).id();
    settle(&mut app);
    assert_eq!(
        app.world().resource::<SolverCounters>().sweeps(),
        14,
        "the frame that solves"
    );
    // Values arrive a few frames late, while the pattern sleeps.
    for _ in 0..8 {
        update(&mut app);
        common::gpu::wait(&app);
    }
    let (d, f, z) = wave(&app, entity);
    let q = quality(&graph(&app, entity), &d, &f, &z, Symmetry::Vector);
    let (energy, branches, sweeps, memory) = (ENERGY, BRANCHES, SWEEPS, MEMORY);
    let value = |path| {
        app.world()
            .resource::<DiagnosticsStore>()
            .get(path)
            .and_then(|d| d.value())
    };
    assert_eq!(value(&sweeps), Some(0.0));
    assert!(value(&memory).is_some_and(|bytes| bytes > 0.0));
    let device = app.sub_app(RenderApp).world().resource::<RenderDevice>();
    if !device.features().contains(WgpuFeatures::TIMESTAMP_QUERY) {
        assert_eq!(value(&energy), None);
        return;
    }
    let reported = value(&energy).expect("an energy");
    assert!((reported - q.energy).abs() < 1e-3 * q.energy, "{reported} {q:?}");
    assert!(
        (value(&branches).expect("branches") - q.branches as f64).abs() < 0.5,
        "{q:?}"
    );
}

#[test]
fn a_mesh_and_a_field_that_change_in_every_frame_are_seen_to() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(4, 1.0));
    let spawn = (
        Mesh3d(mesh.clone()),
        curvature(),
        Frequency::Uniform(3.0),
        PatternSpace::World,
    );
    let entity = app.world_mut().spawn(spawn).id();
    let mut frames = 0;
    let is_drawn = |app: &App| {
        let pattern = app.world().get::<Pattern>(entity);
        pattern.is_some_and(|pattern| pattern.record().flags & FLAG_READY != 0)
    };
    while !is_drawn(&app) {
        frames += 1;
        assert!(frames < 1000, "no pattern after {frames} frames");
        let turned = Transform::from_rotation(Quat::from_rotation_y(0.01 * frames as f32));
        app.world_mut().entity_mut(entity).insert(turned);
        {
            let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
            let mut mesh = meshes.get_mut(&mesh).unwrap();
            if let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute_mut(Mesh::ATTRIBUTE_POSITION) {
                positions.iter_mut().for_each(|p| p[1] *= 1.001);
            }
        }
        update(&mut app);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

#[test]
fn a_cloned_pattern_is_a_pattern_of_its_own() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(2, 1.0));
    let entity = app
        .world_mut()
        .spawn((Mesh3d(mesh), DirectionField::Axis(Dir3::Y)))
        .id();
    settle(&mut app);
    let clone = app.world_mut().entity_mut(entity).clone_and_spawn();
    update(&mut app);
    settle(&mut app);
    let record = |app: &App, entity| *app.world().get::<Pattern>(entity).expect("a pattern").record();
    assert_eq!(app.world().get::<PatternState>(clone), Some(&PatternState::Converged));
    assert_ne!(record(&app, entity).field_base, record(&app, clone).field_base);
    assert_eq!(graph(&app, entity).len(), graph(&app, clone).len());
}

#[test]
fn a_mesh_that_is_kept_keeps_no_gpu_memory() {
    let mut app = app();
    let mesh = add_mesh(&mut app, &shapes::icosphere(3, 1.0));
    for _ in 0..2 {
        let spawn = (Mesh3d(mesh.clone()), DirectionField::Axis(Dir3::Y));
        let entity = app.world_mut().spawn(spawn).id();
        settle(&mut app);
        assert!(app.world().resource::<PatternArena>().memory().used > 0);
        app.world_mut().despawn(entity);
        update(&mut app);
        update(&mut app);
        assert_eq!(app.world().resource::<PatternArena>().memory().used, 0);
    }
}
