//! Every source of directions and frequencies that belongs to the mesh, on a surface that is turned as a whole and on one that
//! is bent, against its twin.

use crate::{
    common::{app, gpu, graph, settle, share_off, update, wave},
    creature::{Creature, Instance, posed_graph},
};
use bevy::{
    asset::RenderAssetUsages,
    math::Mat3A,
    mesh::{MeshVertexAttribute, VertexAttributeValues, VertexFormat},
    prelude::*,
    render::storage::ShaderBuffer,
};
use bevy_field_patterns::{
    field::*,
    prelude::*,
    surface::SurfaceGraph,
    wave::{Pattern, layout::WAVE_BUFFER, pose::deformations, quality, solver::solve_cpu},
};
use std::{f32::consts::FRAC_PI_2, sync::Arc};

const DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Test_Diagonal", 8_822_001, VertexFormat::Float32x3);
const OFF_DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Test_Off", 8_822_002, VertexFormat::Float32x3);

/// All joints turned together.
fn turn(world: &mut World, instance: &Instance, by: Quat) {
    for &joint in &instance.joints {
        let mut transform = world.get_mut::<Transform>(joint).unwrap();
        *transform = Transform::from_rotation(by) * *transform;
    }
}

/// What a source needs of the mesh as it is.
struct Carried<'a> {
    mesh: &'a Mesh,
    rest: &'a SurfaceGraph,
    posed: &'a SurfaceGraph,
    maps: Vec<Mat3>,
}

impl Carried<'_> {
    /// Vectors of the mesh's vertices, carried along.
    fn vectors(&self, given: &[Vec3]) -> Arc<[Vec3]> {
        let carry = |(v, &i): (&Vec3, &u32)| self.maps[i as usize] * *v;
        given.iter().zip(&self.rest.vertex_of).map(carry).collect()
    }
}

/// A field, the symmetry of the comparison, and its twin.
struct Case {
    name: &'static str,
    field: DirectionField,
    symmetry: u32,
    twin: Box<dyn Fn(&Carried) -> Vec<Vec3>>,
}

fn swirl(positions: &[Vec3], angle: f32) -> Arc<[Vec3]> {
    let turn = Quat::from_rotation_x(angle);
    positions
        .iter()
        .map(|p| turn * p.cross(Vec3::Y) + 0.3 * Vec3::Y)
        .collect()
}

fn cases(world: &mut World, positions: &[Vec3]) -> Vec<Case> {
    let tensor = TensorField {
        diagonal: DIAGONAL,
        off_diagonal: OFF_DIAGONAL,
        ..default()
    };
    let snapshots: Arc<[Snapshot]> = [(0.0, 0.0), (1.0, 0.8)]
        .map(|(time, angle)| Snapshot {
            time,
            vectors: swirl(positions, angle),
        })
        .into();
    let given = swirl(positions, 0.4);
    let words: Vec<Vec4> = given.iter().map(|v| v.extend(0.0)).collect();
    let buffer = ShaderBuffer::new(bytemuck::cast_slice(&words), RenderAssetUsages::default());
    let buffer = FieldBuffer {
        buffer: world.resource_mut::<Assets<ShaderBuffer>>().add(buffer),
        live: false,
    };
    let smooth = |ring, smoothing| SmoothField {
        ring,
        smoothing,
        align: Alignment::Painted(Painted::Vertices(swirl(positions, 0.2))),
        ..default()
    };
    let mut cases = vec![
        Case {
            name: "tensor",
            field: DirectionField::Tensor(tensor.clone()),
            symmetry: 2,
            twin: Box::new(move |carried| {
                let tensors = tensors(&tensor, carried.rest, carried.mesh).unwrap().into_iter();
                let maps = carried.maps.iter().map(|&map| Mat3A::from(map));
                let tensors: Vec<_> = tensors.zip(maps).map(|(tensor, map)| tensor.carried(map)).collect();
                tensor_directions(&tensors, Eigenvector::Major, 0.0, carried.posed).0
            }),
        },
        Case {
            name: "snapshots",
            field: DirectionField::Snapshots(snapshots.clone()),
            symmetry: 2,
            twin: Box::new(move |carried| {
                let carry = |snapshot: &Snapshot| Snapshot {
                    time: snapshot.time,
                    vectors: carried.vectors(&snapshot.vectors),
                };
                let snapshots: Vec<Snapshot> = snapshots.iter().map(carry).collect();
                snapshot_directions(&snapshots, 0.3, Symmetry::Line, 0.0, carried.posed).unwrap()
            }),
        },
        Case {
            name: "buffer",
            field: DirectionField::Buffer(buffer),
            symmetry: 2,
            twin: Box::new(move |carried| {
                let field = DirectionField::Vertices(carried.vectors(&given));
                directions(&field, Symmetry::Line, 0.0, carried.posed, carried.mesh).unwrap()
            }),
        },
    ];
    for (name, ring, kind) in [
        ("smooth lines", FieldRing::Two, Smoothing::Intrinsic),
        ("smooth crosses", FieldRing::Four, Smoothing::Extrinsic),
    ] {
        let field = smooth(ring, kind);
        let twin = {
            let field = field.clone();
            move |carried: &Carried| {
                let constraints = smooth_constraints(&field, carried.rest, carried.mesh).unwrap();
                let constraints: Vec<Vec4> = constraints
                    .iter()
                    .zip(&carried.maps)
                    .map(|(c, &map)| (map * c.truncate()).extend(c.w))
                    .collect();
                smooth_directions(&field, &constraints, 0.0, carried.posed)
            }
        };
        cases.push(Case {
            name,
            field: DirectionField::Smooth(field),
            symmetry: if ring == FieldRing::Two { 2 } else { 4 },
            twin: Box::new(twin),
        });
    }
    cases
}

/// A creature whose mesh has tensors, and the positions of its vertices.
fn creature(app: &mut App) -> (Creature, Vec<Vec3>) {
    let creature = Creature::new(app.world_mut());
    let mut meshes = app.world_mut().resource_mut::<Assets<Mesh>>();
    let mut mesh = meshes.get_mut(&creature.mesh).unwrap();
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("no positions");
    };
    let positions: Vec<Vec3> = positions.iter().map(|&p| p.into()).collect();
    let list = |of: fn(Vec3) -> Vec3| positions.iter().map(|&p| of(p).to_array()).collect::<Vec<_>>();
    mesh.insert_attribute(DIAGONAL, list(|p| Vec3::new(2.0 + p.x, 1.0 - p.y * p.z, 3.0 * p.z)));
    mesh.insert_attribute(OFF_DIAGONAL, list(|p| Vec3::new(p.x * p.y, 0.5, p.z - p.x)));
    (creature, positions)
}

fn frequencies_of(positions: &[Vec3]) -> Vec<f32> {
    positions.iter().map(|p| 4.0 + p.x).collect()
}

#[test]
fn fields_are_carried_as_their_twins_say() {
    let mut app = app();
    let (creature, positions) = creature(&mut app);
    let given = frequencies_of(&positions);
    let buffer = ShaderBuffer::new(bytemuck::cast_slice(&given), RenderAssetUsages::default());
    let buffer = app.world_mut().resource_mut::<Assets<ShaderBuffer>>().add(buffer);
    for case in cases(app.world_mut(), &positions) {
        for rigid in [true, false] {
            let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.0);
            let frequency = Frequency::Buffer(FieldBuffer {
                buffer: buffer.clone(),
                live: false,
            });
            let pattern = (
                case.field.clone(),
                Symmetry::Line,
                FieldTime(0.3),
                frequency,
                PatternPose::Live,
            );
            app.world_mut().entity_mut(instance.entity).insert(pattern);
            settle(&mut app);
            let (before, ..) = wave(&app, instance.entity);
            // A quarter turn and more is no motion to follow, but everything is solved anew.
            let by = Quat::from_rotation_x(FRAC_PI_2) * Quat::from_rotation_y(0.6);
            if rigid {
                turn(app.world_mut(), &instance, by);
            } else {
                instance.pose(app.world_mut(), 1.0);
            }
            settle(&mut app);
            let (d, f, _) = wave(&app, instance.entity);
            let (rest, posed) = (graph(&app, instance.entity), posed_graph(&app, instance.entity));
            let mesh = app.world().resource::<Assets<Mesh>>().get(&creature.mesh).unwrap();
            let mut carried = Carried {
                mesh,
                rest: &rest,
                posed: &posed,
                maps: deformations(&rest, &posed),
            };
            let name = (case.name, rigid);
            let off = share_off(&d, &(case.twin)(&carried), &posed, case.symmetry);
            // What is smoothed has come to rest nearly, but not at the same place.
            let allowed = if case.name.starts_with("smooth") { 0.02 } else { 2e-3 };
            assert!(off < allowed, "{name:?}: {off}");
            assert!(
                d.iter().zip(&posed.normals).all(|(d, n)| d.dot(*n).abs() < 1e-4),
                "{name:?}"
            );
            let stayed = share_off(&d, &before, &posed, case.symmetry);
            assert!(stayed > 0.3, "{name:?}: the surface has moved: {stayed}");
            // The comparison can fail.
            carried.maps.fill(Mat3::IDENTITY);
            let off = share_off(&d, &(case.twin)(&carried), &posed, case.symmetry);
            assert!(off > 0.2, "{name:?}: {off}");
            let ids = rest.first_vertices();
            assert!(f.iter().zip(&ids).all(|(f, &id)| *f == given[id as usize]), "{name:?}");
            app.world_mut().despawn(instance.root);
            update(&mut app);
        }
    }
}

/// The lines that smoothing continues from, read back.
fn lines_of(app: &App, entity: Entity) -> Vec<Vec3> {
    let record = *app.world().get::<Pattern>(entity).unwrap().record();
    let (first, len) = (8 * u64::from(record.smooth_base), 16 * u64::from(record.vertices));
    let words = gpu::read::<f32>(app, &WAVE_BUFFER, first, len).unwrap();
    words
        .as_chunks::<4>()
        .0
        .iter()
        .map(|l| Vec3::new(l[0], l[1], l[2]))
        .collect()
}

#[test]
fn smoothed_curvature_follows_and_comes_to_rest_as_if_from_nothing() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.0);
    let entity = instance.entity;
    for direction in [Principal::Major, Principal::Minor] {
        let field = DirectionField::PrincipalCurvature {
            direction,
            smoothing: 30,
        };
        let pattern = (field.clone(), Frequency::Uniform(3.0), PatternPose::Live);
        app.world_mut().entity_mut(entity).insert(pattern);
        instance.pose(app.world_mut(), 0.0);
        settle(&mut app);
        let empty = Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, default());
        let whole = |app: &App| directions(&field, Symmetry::Line, 0.0, &posed_graph(app, entity), &empty).unwrap();
        for step in 1..=12 {
            let before = lines_of(&app, entity);
            instance.pose(app.world_mut(), 0.05 * step as f32);
            update(&mut app);
            let posed = posed_graph(&app, entity);
            let twin = follow_principal_lines(&posed, 30, &before);
            let lines = lines_of(&app, entity);
            let off = lines
                .iter()
                .zip(&twin)
                .map(|(a, b)| a.distance(*b).min(a.distance(-*b)));
            let off = off.filter(|&off| off > 0.01).count() as f32 / lines.len() as f32;
            assert!(off < 0.01, "{direction:?}, step {step}: {off}");
            // Lines that are followed are near to those that are made from nothing.
            let (d, ..) = wave(&app, entity);
            let mut angles: Vec<f32> = d.iter().zip(&whole(&app)).map(|(a, b)| a.cross(*b).length()).collect();
            angles.sort_unstable_by(f32::total_cmp);
            let [middle, most] = [angles.len() / 2, angles.len() * 9 / 10].map(|n| angles[n]);
            assert!(
                middle < 0.05 && most < 0.3,
                "{direction:?}, step {step}: {middle} {most}"
            );
        }
        settle(&mut app);
        let (d, ..) = wave(&app, entity);
        let off = share_off(&d, &whole(&app), &posed_graph(&app, entity), 2);
        assert!(off < 5e-3, "{direction:?}: {off}");
    }
}

#[test]
fn smoothed_fields_follow_as_the_twin_says() {
    let mut app = app();
    let (creature, positions) = creature(&mut app);
    for case in cases(app.world_mut(), &positions) {
        let DirectionField::Smooth(field) = &case.field else {
            continue;
        };
        let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.0);
        let entity = instance.entity;
        let pattern = (case.field.clone(), Frequency::Uniform(3.0), PatternPose::Live);
        app.world_mut().entity_mut(entity).insert(pattern);
        settle(&mut app);
        let rest = graph(&app, entity);
        let mesh = app.world().resource::<Assets<Mesh>>().get(&creature.mesh).unwrap();
        let constraints = smooth_constraints(field, &rest, mesh).unwrap();
        for step in 1..=3 {
            let before = lines_of(&app, entity);
            instance.pose(app.world_mut(), 0.1 * step as f32);
            update(&mut app);
            let posed = posed_graph(&app, entity);
            let maps = deformations(&rest, &posed);
            let carried = constraints.iter().zip(&maps);
            let carried: Vec<Vec4> = carried.map(|(c, &map)| (map * c.truncate()).extend(c.w)).collect();
            let twin = |sweeps| follow_smooth_directions(field, &carried, &before, sweeps, 0.0, &posed);
            let (d, ..) = wave(&app, entity);
            let off = share_off(&d, &twin(4), &posed, case.symmetry);
            assert!(off < 5e-3, "{}, step {step}: {off}", case.name);
            let off = share_off(&d, &twin(0), &posed, case.symmetry);
            assert!(off > 5e-3, "{}: the comparison can fail: {off}", case.name);
        }
        app.world_mut().despawn(instance.root);
        update(&mut app);
    }
}

/// The energy of a pattern over that of one that is solved anew.
fn energy_ratio(app: &App, entity: Entity) -> f64 {
    let (d, f, z) = wave(app, entity);
    let posed = posed_graph(app, entity);
    let cold = solve_cpu(&posed, &d, &f, Symmetry::Vector, &default()).phasors;
    let [energy, best] = [&z, &cold].map(|z| quality(&posed, &d, &f, z, Symmetry::Vector).energy);
    energy / best
}

/// What moves little is followed well, what jumps is solved anew in the same frame.
#[test]
fn patterns_are_good_after_jumps() {
    let mut app = app();
    let creature = Creature::new(app.world_mut());
    for (pose, jumps) in [(0.3, false), (0.5, false), (1.0, true), (3.0, true)] {
        let instance = creature.spawn(app.world_mut(), Transform::IDENTITY, 0.0);
        let pattern = (
            DirectionField::Axis(Dir3::Y),
            Frequency::Uniform(6.0),
            PatternPose::Live,
        );
        app.world_mut().entity_mut(instance.entity).insert(pattern);
        settle(&mut app);
        instance.pose(app.world_mut(), pose);
        update(&mut app);
        let at_once = energy_ratio(&app, instance.entity);
        settle(&mut app);
        let after = energy_ratio(&app, instance.entity);
        assert_eq!(at_once < 1.05, jumps, "{pose}: {at_once}");
        assert!(after < 1.2, "{pose}: {after}");
        app.world_mut().despawn(instance.root);
        update(&mut app);
    }
}
