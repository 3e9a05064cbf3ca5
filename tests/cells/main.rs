//! Cells on a GPU (or Mesa's software one): what a fragment sees, what entities own, how materials look.
#![allow(clippy::print_stdout, reason = "what was measured")]
#![allow(unreachable_pub, reason = "modules of one test")]

#[path = "../common/mod.rs"]
mod common;
mod life;
mod looks;
mod probe;
mod sets;
#[path = "../material/stage.rs"]
mod stage;

use bevy::{mesh::MeshTag, prelude::*};
use bevy_field_patterns::{
    cells::{CellArena, CellPlugin, CellState, border, label},
    material::*,
    sampling::SampleSet,
};
use common::{
    mesh_file::{self, to_bevy_mesh},
    shapes,
};
use probe::Probe;
use sets::{FIELDS, nearest, on_square, on_torus};
use stage::{Lens, Picture, Stage};

/// A stage with the plugins of cells.
fn cell_stage() -> Stage {
    let mut stage = Stage::new((
        CellPlugin,
        CellMaterialPlugin,
        MaterialPlugin::<Probe>::default(),
        PatternMaterialPlugin::<Probe>::default(),
    ));
    probe::add_shader(&mut stage.app);
    stage
        .app
        .world_mut()
        .register_required_components::<MeshMaterial3d<Probe>, bevy_field_patterns::cells::DrawCells>();
    stage
}

/// An entity with samples, and the frames that it needs.
fn spawn<M: Material>(stage: &mut Stage, mesh: &Handle<Mesh>, set: &SampleSet, material: &Handle<M>) -> Entity {
    let parts = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), set.clone());
    let entity = stage.app.world_mut().spawn(parts).id();
    settle(stage);
    entity
}

/// Runs until no cells are being prepared.
fn settle(stage: &mut Stage) {
    for _ in 0..1000 {
        stage.app.update();
        let mut states = stage.app.world_mut().query::<&CellState>();
        if !states
            .iter(stage.app.world())
            .any(|state| *state == CellState::Preparing)
        {
            stage.app.update();
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("cells did not settle");
}

fn state(stage: &Stage, entity: Entity) -> CellState {
    stage.app.world().get::<CellState>(entity).expect("a state").clone()
}

/// Bytes that sample sets own.
fn used(stage: &Stage) -> u64 {
    stage.app.world().resource::<CellArena>().memory().used
}

/// A view that the square of size 2 fills.
fn square_on(width: u32) -> Lens {
    Lens {
        width,
        height: width,
        orthographic: Some(2.0),
        ..default()
    }
}

fn torus_view(width: u32, height: u32) -> Lens {
    Lens {
        width,
        height,
        from: Vec3::new(0.6, -1.9, 2.3),
        ..default()
    }
}

/// A picture of the square of size 2 by a 2D camera.
fn picture_2d(stage: &mut Stage, width: u32) -> Picture {
    use bevy::{
        camera::{Hdr, RenderTarget, ScalingMode},
        core_pipeline::tonemapping::{DebandDither, Tonemapping},
        render::render_resource::{TextureFormat, TextureUsages},
    };
    let mut image = Image::new_target_texture(width, width, TextureFormat::Rgba16Float, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = stage.add(image);
    let projection = OrthographicProjection {
        scaling_mode: ScalingMode::FixedVertical { viewport_height: 2.0 },
        ..OrthographicProjection::default_2d()
    };
    let camera = (
        Camera2d,
        RenderTarget::Image(target.clone().into()),
        Projection::Orthographic(projection),
        Tonemapping::None,
        DebandDither::Disabled,
        Msaa::Off,
        Hdr,
    );
    let camera = stage.app.world_mut().spawn(camera).id();
    stage.settle();
    let picture = stage.read(&target);
    stage.clear([camera]);
    picture
}

/// What a fragment saw.
struct Seen {
    label: usize,
    evaluations: f32,
    triangle: usize,
    position: Vec3,
    border: f32,
    normal: Vec3,
}

/// What all fragments of an entity saw; the number of those without a cell.
fn probed(stage: &mut Stage, mesh: &Handle<Mesh>, set: &SampleSet, lens: Lens) -> (Vec<Seen>, usize) {
    let pictures = [probe::LABEL, probe::POSITION, probe::DEPTH, probe::NORMAL].map(|mode| {
        let material = stage.add(Probe::new(mode));
        let entity = spawn(stage, mesh, set, &material);
        let picture = stage.picture(lens);
        stage.clear([entity]);
        picture
    });
    let [labels, positions, depths, normals] = pictures;
    let unlabelled = labels.pixels.iter().filter(|p| p.x == -2.0).count();
    let seen = (0..labels.pixels.len())
        .filter(|&k| labels.pixels[k].w == 0.5)
        .map(|k| {
            let (l, p, d, n) = (
                labels.pixels[k],
                positions.pixels[k],
                depths.pixels[k],
                normals.pixels[k],
            );
            Seen {
                label: l.x as usize,
                evaluations: l.y,
                triangle: l.z as usize + 2048 * n.x as usize,
                position: Vec3::new(
                    probe::joined(p.x, p.y),
                    probe::joined(p.z, p.w),
                    probe::joined(d.x, d.y),
                ),
                border: probe::joined(d.z, d.w),
                normal: Vec3::new(n.y, n.z, n.w),
            }
        })
        .collect();
    (seen, unlabelled)
}

/// The descent finds the nearest of all samples, in a plane and on a surface, with few evaluations; its CPU twin too.
#[test]
fn labels_are_those_of_brute_force() {
    let mut stage = cell_stage();
    // Samples have integers that halves can hold.
    for (k, allowed) in [1e-4, 1e-4, 5e-4].into_iter().enumerate() {
        let (name, field) = FIELDS[k];
        let (set, mesh) = on_square(600, field, 96);
        let mesh = stage.add(to_bevy_mesh(&mesh));
        compare(&mut stage, name, &mesh, &set, square_on(256), allowed);
    }
    let (set, mesh) = on_torus(400, 5);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    compare(&mut stage, "torus", &mesh, &set, torus_view(320, 240), 2e-3);
}

fn compare(stage: &mut Stage, name: &str, mesh: &Handle<Mesh>, set: &SampleSet, lens: Lens, allowed: f64) {
    let (seen, unlabelled) = probed(stage, mesh, set, lens);
    assert_eq!(unlabelled, 0, "{name}: fragments without a cell");
    assert!(seen.len() > 20_000, "{name}: only {} fragments", seen.len());
    let (mut wrong, mut apart, mut strange, mut worst, mut evaluations) = (0, 0, 0, 0.0_f32, 0.0);
    for fragment in &seen {
        let truth = nearest(set, fragment.position);
        // Two samples as near as the read-back can tell are both right.
        let tie = |a: usize, b: usize| {
            let [a, b] = [a, b].map(|i| set.distance_squared(i, fragment.position));
            (a - b).abs() < 1e-4 * (1.0 + a)
        };
        wrong += usize::from(fragment.label != truth && !tie(fragment.label, truth));
        let twin = label(set, fragment.triangle, fragment.position).expect("a label");
        apart += usize::from(fragment.label != twin && !tie(fragment.label, twin));
        evaluations += f64::from(fragment.evaluations);
        if fragment.label == twin && fragment.border < 1.8 {
            let expected = border(set, twin, fragment.position, fragment.normal.normalize());
            worst = worst.max((fragment.border - expected).abs());
        }
        // The comparison can fail: seeds alone are not enough.
        strange += usize::from(nearest(set, fragment.position) != set.seeds[fragment.triangle][0] as usize);
    }
    let share = |n: usize| n as f64 / seen.len() as f64;
    println!(
        "{name}: wrong {:.1e}, first seed wrong {:.3}, twin apart {:.1e}, border off by {worst:.1e}, {:.2} evaluations",
        share(wrong),
        share(strange),
        share(apart),
        evaluations / seen.len() as f64
    );
    assert!(
        share(wrong) <= allowed,
        "{name}: {wrong} of {} fragments are wrong",
        seen.len()
    );
    assert!(share(strange) > 0.05, "{name}: the comparison cannot fail");
    assert_eq!(apart, 0, "{name}: the twin disagrees");
    assert!(worst < 2e-3, "{name}: the border is off by {worst}");
    assert!(evaluations / seen.len() as f64 <= 10.0, "{name}: too many evaluations");
}
