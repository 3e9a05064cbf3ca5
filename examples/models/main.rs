//! The models that the examples use: shows one, or writes those with fields as GLB files.
//!
//! ```sh
//! cargo run --example models -- creature
//! cargo run --example models -- aneurysm --stripes --screenshot aneurysm.png
//! cargo run --example models -- --write assets/models
//! ```
#![allow(unreachable_pub, reason = "modules of one program")]

#[path = "../common/mod.rs"]
mod common;
mod write;

use bevy::{mesh::skinning::SkinnedMeshInverseBindposes, prelude::*};
use bevy_field_patterns::prelude::*;
use clap::{Parser, ValueEnum};
use common::{
    aneurysm::Aneurysm,
    args::{OutputArgs, refuse, run},
    creature::Creature,
    creature_walk,
    flag::Flag,
    hyperball::Hyperball,
    instrument,
    mesh_file::{RawMesh, to_bevy_mesh},
    molecule,
    organs::Organs,
    scene::Subject,
    vessel_tree::VesselTree,
};
use std::{path::PathBuf, process::ExitCode};

/// Shows a generated model or writes them all.
#[derive(Parser)]
struct Cli {
    /// Which one to show
    #[arg(value_enum, default_value = "creature")]
    model: Model,
    /// Draw stripes along its field
    #[arg(long)]
    stripes: bool,
    /// Write the models that carry fields into this folder instead
    #[arg(long, value_name = "FOLDER")]
    write: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

#[derive(ValueEnum, Clone, Copy, PartialEq)]
enum Model {
    Aneurysm,
    Creature,
    Flag,
    Hyperball,
    Molecule,
    Needle,
    Organs,
    Vessels,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    if let Some(folder) = &cli.write {
        return match write::write_all(folder) {
            Ok(()) => ExitCode::SUCCESS,
            Err(message) => refuse(&message),
        };
    }
    let (model, stripes) = (cli.model, cli.stripes);
    run("Models", &cli.output, |app| {
        app.add_plugins(FieldPatternsPlugin)
            .add_systems(Startup, move |looks: Looks| show(model, stripes, looks))
            .add_systems(Update, creature_walk::walk);
        Ok(())
    })
}

/// What things are made of.
#[derive(bevy::ecs::system::SystemParam)]
struct Looks<'w, 's> {
    commands: Commands<'w, 's>,
    meshes: ResMut<'w, Assets<Mesh>>,
    stripes: ResMut<'w, Assets<StripeMaterial>>,
    bindposes: ResMut<'w, Assets<SkinnedMeshInverseBindposes>>,
}

fn show(model: Model, stripes: bool, mut looks: Looks) {
    let field = |field: Vec<Vec3>| DirectionField::Vertices(field.into());
    let parts: Vec<(RawMesh, DirectionField)> = match model {
        Model::Aneurysm => {
            let shape = Aneurysm::default();
            let mesh = shape.mesh(0.04);
            let stress = shape.stress(&mesh);
            let major = mesh
                .positions
                .iter()
                .zip(&stress)
                .map(|(_, tensor)| largest(tensor))
                .collect();
            vec![(mesh, field(major))]
        }
        Model::Creature => return show_creature(stripes, &mut looks),
        Model::Flag => vec![(Flag::default().mesh(), DirectionField::Axis(Dir3::X))],
        Model::Hyperball => {
            let shape = Hyperball::default();
            let mesh = shape.mesh(0.03);
            let cross = shape.cross_field(&mesh);
            vec![(mesh, field(cross))]
        }
        Model::Molecule => vec![(
            molecule::surface(&molecule::CAFFEINE, 0.15),
            DirectionField::Axis(Dir3::X),
        )],
        Model::Needle => vec![(instrument::needle(20), DirectionField::Axis(Dir3::Y))],
        Model::Organs => {
            let organs = Organs::generate(0.035, 5);
            let parts = [organs.hull, organs.tumour, organs.vessels];
            let apart = |i: usize, mut mesh: RawMesh| {
                mesh.positions.iter_mut().for_each(|p| p.z += 1.2 * i as f32);
                (mesh, DirectionField::Axis(Dir3::Y))
            };
            parts.into_iter().enumerate().map(|(i, mesh)| apart(i, mesh)).collect()
        }
        Model::Vessels => {
            let tree = VesselTree::default();
            let mesh = tree.mesh(0.016);
            let flow = mesh.positions.iter().map(|&p| tree.flow(p)).collect();
            vec![(mesh, field(flow))]
        }
    };
    for (raw, field) in parts {
        let material = material(&mut looks.stripes);
        let entity = (
            Subject,
            Mesh3d(looks.meshes.add(to_bevy_mesh(&raw))),
            MeshMaterial3d(material),
        );
        let entity = looks.commands.spawn(entity).id();
        if stripes {
            looks.commands.entity(entity).insert((field, Frequency::Uniform(12.0)));
        }
    }
}

fn show_creature(stripes: bool, looks: &mut Looks) {
    let creature = Creature::generate(0.025);
    let mesh = looks.meshes.add(creature_walk::to_skinned_mesh(&creature));
    let bindposes = looks.bindposes.add(creature_walk::inverse_bindposes());
    let entity = creature_walk::spawn(&mut looks.commands, mesh, bindposes, Transform::default());
    let material = material(&mut looks.stripes);
    looks
        .commands
        .entity(entity)
        .insert((Subject, MeshMaterial3d(material)));
    if stripes {
        let field = DirectionField::Vertices(creature.along.into());
        looks.commands.entity(entity).insert((field, Frequency::Uniform(9.0)));
    }
}

fn material(materials: &mut Assets<StripeMaterial>) -> Handle<StripeMaterial> {
    materials.add(StripeMaterial {
        base: StandardMaterial {
            base_color: Color::srgb(0.85, 0.80, 0.72),
            double_sided: true,
            cull_mode: None,
            ..default()
        },
        extension: default(),
    })
}

/// The eigenvector of the largest eigenvalue, by powers of the tensor.
fn largest(tensor: &glam_matrix_extras::SymmetricMat3) -> Vec3 {
    let matrix = tensor.to_mat3();
    (0..40).fold(Vec3::new(0.48, 0.64, 0.6), |v, _| (matrix * v).normalize_or(v))
}
