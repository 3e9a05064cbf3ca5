//! Measures what surfaces that move cost: a skinned and morphed mesh of 70,000 vertices that is posed in every frame, with
//! several fields and one wave or two, and a mesh of 20,000 vertices whose positions are edited in every frame. Prints one JSON
//! object on stdout.
//!
//! ```sh
//! cargo run --release --example motion_time [NAME]
//! ```
//!
//! With a name (`edited`, or part of a field's) only that is measured. Times are medians, in milliseconds. `pose` (positions
//! and normals), `field`, `edges` and `sweeps` (all of a frame) are GPU times of passes; `frame` is a whole update of the app
//! until the device has done its work, without a camera. `processor` is the mean time that a frame takes of all processors
//! together, which other programs disturb less than the others; Linux only.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a command line tool")]

mod common;

use bevy::{
    mesh::{
        MeshVertexAttribute, VertexAttributeValues, VertexFormat,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
    render::{RenderApp, diagnostic::RenderDiagnosticsPlugin, renderer::RenderAdapterInfo},
};
use bevy_field_patterns::{diagnostics::QualityReport, prelude::*};
use common::{
    gpu, headless,
    mesh_file::{RawMesh, to_bevy_mesh},
    shapes,
};
use serde_json::{Value, json};
use std::{process::ExitCode, sync::Arc, time::Instant};

/// Frames of which each time is the median.
const FRAMES: u32 = 15;
const JOINTS: usize = 24;

fn main() -> ExitCode {
    match measure() {
        Ok(figures) => {
            println!("{figures:#}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn measure() -> Result<Value, String> {
    let mut app = headless::headless_app(UVec2::splat(16))?;
    app.add_plugins((FieldPatternsPlugin, RenderDiagnosticsPlugin))
        .insert_resource(QualityReport(false));
    headless::wait_until_ready(&mut app)?;
    let wanted = std::env::args().nth(1).unwrap_or_default();
    let raw = shapes::knot(1000, 70);
    let mut posed = serde_json::Map::new();
    for (name, field) in fields(&raw) {
        for (count, waves) in [(1, Waves::Single), (2, Waves::ORTHOGONAL)] {
            if name.contains(&wanted) {
                let figures = measure_posed(&mut app, &raw, field.clone(), waves)?;
                posed.insert(format!("{name}, waves: {count}"), figures);
            }
        }
    }
    let adapter = app
        .sub_app(RenderApp)
        .world()
        .resource::<RenderAdapterInfo>()
        .name
        .clone();
    let mut figures = json!({ "adapter": adapter, "vertices": raw.positions.len(), "posed": posed });
    if "edited".contains(&wanted) {
        let sheet = shapes::plane(141, 0.2, 1);
        figures["edited"] = json!({
            "vertices": sheet.positions.len(),
            "plain": measure_edited(&mut app, &sheet, None)?,
            "rest": measure_edited(&mut app, &sheet, Some(PatternPose::Rest))?,
            "live": measure_edited(&mut app, &sheet, Some(PatternPose::Live))?,
        });
    }
    Ok(figures)
}

const DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("Diagonal", 0x7e57_0001, VertexFormat::Float32x3);
const OFF_DIAGONAL: MeshVertexAttribute = MeshVertexAttribute::new("OffDiagonal", 0x7e57_0002, VertexFormat::Float32x3);

fn fields(raw: &RawMesh) -> Vec<(&'static str, DirectionField)> {
    let around: Arc<[Vec3]> = raw.positions.iter().map(|p| Vec3::new(-p.y, p.x, 0.3)).collect();
    let along: Arc<[Vec3]> = raw.positions.iter().map(|p| Vec3::new(p.z, 0.3, p.x)).collect();
    let snapshot = |time, vectors: &Arc<[Vec3]>| Snapshot {
        time,
        vectors: vectors.clone(),
    };
    let curvature = |smoothing| DirectionField::PrincipalCurvature {
        direction: default(),
        smoothing,
    };
    let tensor = TensorField {
        diagonal: DIAGONAL,
        off_diagonal: OFF_DIAGONAL,
        ..default()
    };
    vec![
        ("axis", DirectionField::Axis(Dir3::Z)),
        ("vectors", DirectionField::Vertices(around.clone())),
        (
            "snapshots",
            DirectionField::Snapshots(Arc::from([snapshot(0.0, &around), snapshot(1.0, &along)])),
        ),
        ("vortices", DirectionField::Vortices(default())),
        ("tensor", DirectionField::Tensor(tensor)),
        ("curvature 0", curvature(0)),
        ("curvature 10", curvature(10)),
        ("curvature 30", curvature(30)),
        ("smooth", DirectionField::Smooth(default())),
    ]
}

/// Time of all processors that the program has used, in milliseconds.
fn processor_ms() -> Option<f64> {
    // The fields after the name count ticks of 10 ms: those of the program, and of the kernel for it.
    let line = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut fields = line.rsplit_once(')')?.1.split_whitespace().skip(11);
    let ticks: [f64; 2] = [fields.next()?.parse().ok()?, fields.next()?.parse().ok()?];
    Some(10.0 * (ticks[0] + ticks[1]))
}

/// An update until the device is idle, in milliseconds.
fn frame(app: &mut App) -> Result<f64, String> {
    let begin = Instant::now();
    headless::update(app)?;
    gpu::wait(app);
    Ok(1e3 * begin.elapsed().as_secs_f64())
}

fn settle(app: &mut App, entity: Entity) -> Result<(), String> {
    let begin = Instant::now();
    loop {
        frame(app)?;
        match app.world().get::<PatternState>(entity) {
            Some(PatternState::Converged) => return Ok(()),
            Some(PatternState::Failed(error)) => return Err(error.to_string()),
            _ if begin.elapsed().as_secs() > 300 => return Err("the pattern was not solved within 300 s".into()),
            _ => std::thread::sleep(std::time::Duration::from_millis(1)),
        }
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// A mesh with joints around a circle and two morph targets.
fn rigged(raw: &RawMesh) -> Mesh {
    let place = |p: &Vec3| (p.y.atan2(p.x) / std::f32::consts::TAU).rem_euclid(1.0) * JOINTS as f32;
    let joints = raw.positions.iter().map(|p| {
        let first = place(p).floor() as usize;
        [0, 1, 2, 3].map(|k| ((first + k) % JOINTS) as u16)
    });
    let weights = raw.positions.iter().map(|p| {
        let t = place(p).fract();
        [0.5 * (1.0 - t), 0.5, 0.5 * t, 0.0]
    });
    let stresses = |axis: Vec3| {
        let stress = move |p: &Vec3| (Vec3::splat(0.3) + (2.0 * *p + axis).map(f32::sin)).to_array();
        raw.positions.iter().map(stress).collect::<Vec<[f32; 3]>>()
    };
    let mut mesh = to_bevy_mesh(raw)
        .with_inserted_attribute(DIAGONAL, stresses(Vec3::X))
        .with_inserted_attribute(OFF_DIAGONAL, stresses(Vec3::Y))
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_JOINT_INDEX,
            VertexAttributeValues::Uint16x4(joints.collect()),
        )
        .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights.collect::<Vec<[f32; 4]>>());
    let target = |axis: Vec3| move |p: &Vec3| MorphAttributes::new(axis * p.length(), Vec3::ZERO, Vec3::ZERO);
    let targets = raw.positions.iter().map(target(0.2 * Vec3::X));
    mesh.set_morph_targets(targets.chain(raw.positions.iter().map(target(0.1 * Vec3::Z))).collect());
    mesh
}

fn measure_posed(app: &mut App, raw: &RawMesh, field: DirectionField, waves: Waves) -> Result<Value, String> {
    let world = app.world_mut();
    let mesh = world.resource_mut::<Assets<Mesh>>().add(rigged(raw));
    let bindposes = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; JOINTS]);
    let inverse_bindposes = world
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(bindposes);
    let joints: Vec<Entity> = (0..JOINTS).map(|_| world.spawn(Transform::default()).id()).collect();
    let skin = SkinnedMesh {
        inverse_bindposes,
        joints: joints.clone(),
    };
    let cores: Vec<Entity> = (0..4)
        .map(|_| world.spawn((Vortex::default(), Transform::default())).id())
        .collect();
    let pattern = (
        field,
        FieldTime(0.0),
        Frequency::Uniform(20.0),
        waves,
        PatternPose::Live,
    );
    let entity = world.spawn((Mesh3d(mesh), skin, pattern, Transform::default())).id();
    let pose = |app: &mut App, time: f32| {
        for (n, &core) in cores.iter().enumerate() {
            let angle = time + 1.5 * n as f32;
            let at = Vec3::new(angle.cos(), angle.sin(), 0.2);
            app.world_mut().entity_mut(core).insert(Transform::from_translation(at));
        }
        for (n, &joint) in joints.iter().enumerate() {
            let swing = 0.1 * (time + n as f32).sin();
            let bent = Transform::from_xyz(0.0, 0.0, swing).with_rotation(Quat::from_rotation_x(swing));
            app.world_mut().entity_mut(joint).insert(bent);
        }
        let weights = vec![0.5 * time.sin(), 0.5 * time.cos()];
        app.world_mut()
            .entity_mut(entity)
            .insert((MeshMorphWeights::Value { weights }, FieldTime(time % 1.0)));
    };
    pose(app, 0.0);
    settle(app, entity)?;
    let idle = median((0..FRAMES).map(|_| frame(app)).collect::<Result<_, _>>()?);
    let stages = ["pattern_pose", "pattern_field", "pattern_edges", "pattern_sweeps"];
    let mut times = [const { Vec::new() }; 5];
    let before = processor_ms();
    for n in 0..=FRAMES {
        pose(app, 0.05 * n as f32);
        let whole = frame(app)?;
        // Bevy tells of a frame's GPU times in a later one.
        if n > 0 {
            for (stage, times) in stages.iter().zip(&mut times) {
                times.extend(gpu::stage_ms(app, stage));
            }
            times[4].push(whole);
        }
    }
    let processor = before
        .zip(processor_ms())
        .map(|(before, after)| (after - before) / f64::from(FRAMES + 1));
    let [pose, field, edges, sweeps, whole] = times.map(median);
    for other in joints.into_iter().chain(cores).chain([entity]) {
        app.world_mut().despawn(other);
    }
    Ok(json!({
        "pose": pose, "field": field, "edges": edges, "sweeps": sweeps, "idle_frame": idle, "frame": whole,
        "processor": processor,
    }))
}

/// Frames in which all positions of a sheet change: with a pattern that is posed so, or with none.
fn measure_edited(app: &mut App, sheet: &RawMesh, pose: Option<PatternPose>) -> Result<Value, String> {
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(to_bevy_mesh(sheet));
    let mut entity = app.world_mut().spawn((Mesh3d(mesh.clone()), Transform::default()));
    let entity = match pose {
        Some(pose) => entity
            .insert((DirectionField::Axis(Dir3::X), Frequency::Uniform(10.0), pose))
            .id(),
        None => entity.id(),
    };
    match pose {
        Some(_) => settle(app, entity)?,
        None => frame(app).map(drop)?,
    }
    let idle = median((0..FRAMES).map(|_| frame(app)).collect::<Result<_, _>>()?);
    let mut times = Vec::new();
    let before = processor_ms();
    for n in 0..=FRAMES {
        let wave = |p: &Vec3| [p.x, p.y, 0.2 * (p.x + 1.0) * (4.0 * p.x - 0.1 * n as f32).sin()];
        let positions: Vec<[f32; 3]> = sheet.positions.iter().map(wave).collect();
        if let Some(mut mesh) = app.world_mut().resource_mut::<Assets<Mesh>>().get_mut(&mesh) {
            mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
        }
        let whole = frame(app)?;
        if n > 0 {
            times.push(whole);
        }
    }
    let processor = before
        .zip(processor_ms())
        .map(|(before, after)| (after - before) / f64::from(FRAMES + 1));
    app.world_mut().despawn(entity);
    frame(app)?;
    let most = times.iter().copied().fold(0.0, f64::max);
    Ok(json!({ "idle_frame": idle, "frame": median(times), "longest_frame": most, "processor": processor }))
}
