//! Cells on a GPU (or Mesa's software one): what a fragment sees, what entities own, how materials look.
#![allow(clippy::print_stdout, reason = "what was measured")]
#![allow(unreachable_pub, reason = "modules of one test")]

#[path = "../common/mod.rs"]
mod common;
mod life;
mod looks;
mod posed;
mod probe;
mod sets;
#[path = "../material/stage.rs"]
mod stage;

use bevy::{math::DVec2, mesh::MeshTag, prelude::*};
use bevy_field_patterns::{
    cells::{CellArena, CellPlugin, CellState, border, label, planar_mesh},
    field::DirectionField,
    material::*,
    sampling::{
        Density, Metric, Progress, SampleSet, SamplingState,
        metric::planar_ellipse,
        planar::{PlanarDomain, PlanarSampling, sample_plane},
        surface::{SurfaceSampling, sample_surface},
        surface_metric,
    },
    surface::SurfaceGraph,
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
    pixel: UVec2,
    label: usize,
    evaluations: f32,
    triangle: usize,
    position: Vec3,
    border: f32,
    normal: Vec3,
}

/// What all fragments of an entity saw; the number of those without a cell.
fn probed(stage: &mut Stage, mesh: &Handle<Mesh>, set: &SampleSet, lens: Lens) -> (Vec<Seen>, usize) {
    seen_by(|mode| {
        let material = stage.add(Probe::new(mode));
        let entity = spawn(stage, mesh, set, &material);
        let picture = stage.picture(lens);
        stage.clear([entity]);
        picture
    })
}

/// The same from pictures with a [`Probe`] of each mode.
fn seen_by(draw: impl FnMut(u32) -> Picture) -> (Vec<Seen>, usize) {
    let [labels, positions, depths, normals] = [probe::LABEL, probe::POSITION, probe::DEPTH, probe::NORMAL].map(draw);
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
                pixel: UVec2::new((k % labels.width) as u32, (k / labels.width) as u32),
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

    // And of the crate's own sets.
    let set = sampled_plane(FIELDS[2].1);
    let mesh = stage.add(planar_mesh(&set));
    compare(&mut stage, "sampled vortex 10", &mesh, &set, square_on(256), 5e-4);
    let (set, mesh) = sampled_torus();
    let mesh = stage.add(to_bevy_mesh(&mesh));
    compare(&mut stage, "sampled torus", &mesh, &set, torus_view(320, 240), 2e-3);
}

/// The square as the planar sampler samples it.
fn sampled_plane(field: sets::Field) -> SampleSet {
    let domain = PlanarDomain::Rectangle {
        min: DVec2::NEG_ONE,
        max: DVec2::ONE,
    };
    let metric = |p: DVec2| {
        let (long, ratio) = field(p.as_vec2());
        let root = f64::from(ratio).sqrt();
        planar_ellipse(f64::from(long.to_angle()), root, 1.0 / root)
    };
    let options = PlanarSampling {
        density: Density::Count(1500),
        ..default()
    };
    let samples = sample_plane(&domain, &metric, &options, &Progress::default());
    samples.expect("samples of the square").set()
}

/// A torus as the surface sampler samples it, with ellipses of 1 to 4.
fn sampled_torus() -> (SampleSet, mesh_file::RawMesh) {
    let mesh = shapes::torus(120, 60, 1.0, 0.45, 0.2, 3);
    let graph = SurfaceGraph::from_triangles(&mesh.positions, &mesh.triangles, &default()).expect("a graph");
    let metric = Metric::along(DirectionField::Axis(Dir3::X), 4.0);
    let metric = surface_metric(&metric, &graph, &to_bevy_mesh(&mesh)).expect("a metric");
    let options = SurfaceSampling {
        density: Density::Count(1500),
        ..default()
    };
    let samples = sample_surface(&graph, &metric, &options, &Progress::default());
    (samples.expect("samples of the torus").set, mesh)
}

/// The look at wrong labels finds no more of them than there are, and finds those of a broken set.
#[test]
fn wrong_labels_are_shown() {
    let mut stage = cell_stage();
    let (set, mesh) = on_square(600, FIELDS[1].1, 12);
    let mesh = stage.add(to_bevy_mesh(&mesh));
    let material = stage.add(CellMaterial {
        base: StandardMaterial::default(),
        extension: Cells {
            debug: CellDebug::Check,
            ..default()
        },
    });
    let mut wrong = |set: &SampleSet| {
        let entity = spawn(&mut stage, &mesh, set, &material);
        let picture = stage.picture(square_on(128));
        stage.clear([entity]);
        picture.pixels.iter().filter(|p| p.x > p.y).count() as f32 / picture.pixels.len() as f32
    };
    assert!(wrong(&set) <= 1e-3);
    let mut alone = set;
    alone.neighbors.clear();
    alone.neighbor_offsets.fill(0);
    let wrong = wrong(&alone);
    assert!(wrong > 0.1, "only {wrong} wrong without neighbours");
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
