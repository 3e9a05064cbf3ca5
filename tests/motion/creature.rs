//! A torus with three joints and two morph targets, and what Bevy's vertex shader makes of it.

use crate::common::{self, gpu, shapes};
use bevy::{
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
    prelude::*,
};
use bevy_field_patterns::{
    prelude::*,
    surface::SurfaceGraph,
    wave::{Pattern, layout::GEOMETRY_BUFFER},
};

/// The mesh, the joints of each vertex with their weights, and the displacements of each target.
pub struct Creature {
    pub mesh: Handle<Mesh>,
    bindposes: Handle<SkinnedMeshInverseBindposes>,
    inverse: Vec<Mat4>,
    positions: Vec<Vec3>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    targets: Vec<Vec<Vec3>>,
}

/// One of them in the world.
pub struct Instance {
    pub entity: Entity,
    pub root: Entity,
    pub joints: Vec<Entity>,
}

const ALONG: usize = 70;

impl Creature {
    pub fn new(world: &mut World) -> Self {
        Self::of_size(world, ALONG, ALONG / 2)
    }

    pub fn of_size(world: &mut World, along: usize, around: usize) -> Self {
        let raw = shapes::torus(along, around, 1.0, 0.4, 0.2, 5);
        let positions = raw.positions.clone();
        // Joint 0 holds the middle, 1 and 2 the two sides.
        let weights: Vec<[f32; 4]> = positions
            .iter()
            .map(|p| {
                let side = ((p.x.abs() - 0.3) / 0.7).clamp(0.0, 1.0);
                [1.0 - side, side, 0.0, 0.0]
            })
            .collect();
        let joints: Vec<[u16; 4]> = positions
            .iter()
            .map(|p| [0, if p.x > 0.0 { 1 } else { 2 }, 2, 0])
            .collect();
        let grown = |p: &Vec3| Vec3::new(0.3 * p.x * p.y * p.y, 0.2 * p.y, 0.5 * p.z * p.y.abs());
        let waved = |p: &Vec3| Vec3::new(0.0, 0.0, 0.2 * (4.0 * p.x).sin());
        let targets: Vec<Vec<Vec3>> = vec![
            positions.iter().map(grown).collect(),
            positions.iter().map(waved).collect(),
        ];
        let attributes = targets.iter().flatten();
        let attributes = attributes.map(|&d| MorphAttributes::new(d, Vec3::ZERO, Vec3::ZERO));
        let mut mesh = common::mesh_file::to_bevy_mesh(&raw)
            .with_inserted_attribute(
                Mesh::ATTRIBUTE_JOINT_INDEX,
                VertexAttributeValues::Uint16x4(joints.clone()),
            )
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights.clone());
        mesh.set_morph_targets(attributes.collect());
        let bind = [
            Transform::IDENTITY,
            Transform::from_xyz(0.5, 0.0, 0.0).with_rotation(Quat::from_rotation_z(0.7)),
            Transform::from_xyz(-0.5, 0.1, 0.0).with_rotation(Quat::from_rotation_x(-0.4)),
        ];
        let inverse: Vec<Mat4> = bind.iter().map(|bind| bind.to_matrix().inverse()).collect();
        let bindposes = SkinnedMeshInverseBindposes::from(inverse.clone());
        Self {
            mesh: world.resource_mut::<Assets<Mesh>>().add(mesh),
            bindposes: world
                .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
                .add(bindposes),
            inverse,
            positions,
            joints,
            weights,
            targets,
        }
    }

    pub fn skin(&self, joints: &[Entity]) -> SkinnedMesh {
        SkinnedMesh {
            inverse_bindposes: self.bindposes.clone(),
            joints: joints.to_vec(),
        }
    }

    /// A creature under a root at `at`, in a pose; without a pattern.
    pub fn spawn(&self, world: &mut World, at: Transform, pose: f32) -> Instance {
        let root = world.spawn((at, Visibility::default())).id();
        let joints: Vec<Entity> = (0..3)
            .map(|_| world.spawn((Transform::default(), ChildOf(root))).id())
            .collect();
        let weights = MeshMorphWeights::Value { weights: vec![0.0; 2] };
        let skin = self.skin(&joints);
        let mesh = (
            Mesh3d(self.mesh.clone()),
            weights,
            skin,
            Transform::default(),
            ChildOf(root),
        );
        let instance = Instance {
            entity: world.spawn(mesh).id(),
            root,
            joints,
        };
        instance.pose(world, pose);
        instance
    }

    /// Where Bevy's vertex shader puts the mesh's vertices in the world; `skinning.wgsl`, `morph.wgsl`.
    pub fn drawn(&self, world: &World, instance: &Instance) -> Vec<Vec3> {
        let transform = |entity| world.get::<GlobalTransform>(entity).unwrap().to_matrix();
        let Some(MeshMorphWeights::Value { weights }) = world.get::<MeshMorphWeights>(instance.entity) else {
            panic!("no weights");
        };
        let skin = world.get::<SkinnedMesh>(instance.entity);
        let matrices: Option<Vec<Mat4>> = skin.map(|skin| {
            let joints = skin.joints.iter().zip(&self.inverse);
            joints.map(|(&joint, inverse)| transform(joint) * *inverse).collect()
        });
        let own = transform(instance.entity);
        let place = |v: usize| {
            let mut p = self.positions[v];
            for (target, weight) in self.targets.iter().zip(weights) {
                p += *weight * target[v];
            }
            let model = matrices.as_ref().map_or(own, |matrices| {
                (0..4).fold(Mat4::ZERO, |sum, k| {
                    let joint = usize::from(self.joints[v][k]).min(2);
                    sum + matrices[joint] * self.weights[v][k]
                })
            });
            (model * p.extend(1.0)).truncate()
        };
        (0..self.positions.len()).map(place).collect()
    }
}

impl Instance {
    /// Bends the joints and sets the weights by a number; 0 is the rest.
    pub fn pose(&self, world: &mut World, pose: f32) {
        let joints = [
            Transform::from_xyz(0.0, 0.1 * pose, 0.0),
            Transform::from_xyz(0.5 + 0.2 * pose, 0.3 * pose, 0.0)
                .with_rotation(Quat::from_rotation_z(0.7 + 0.6 * pose))
                .with_scale(Vec3::splat(1.0 + 0.3 * pose)),
            Transform::from_xyz(-0.5, 0.1, 0.2 * pose)
                .with_rotation(Quat::from_rotation_x(-0.4) * Quat::from_rotation_y(0.9 * pose)),
        ];
        for (&joint, transform) in self.joints.iter().zip(joints) {
            world.entity_mut(joint).insert(transform);
        }
        let weights = vec![0.6 * pose, 0.4 * pose];
        world
            .entity_mut(self.entity)
            .insert(MeshMorphWeights::Value { weights });
    }
}

/// Positions, areas and normals that a pattern is solved on, read back.
pub fn geometry(app: &App, entity: Entity) -> (Vec<Vec3>, Vec<f32>, Vec<Vec3>) {
    let record = *app.world().get::<Pattern>(entity).expect("a pattern").record();
    let (first, len) = (16 * u64::from(record.geometry_base), 32 * u64::from(record.vertices));
    let words = gpu::read::<f32>(app, &GEOMETRY_BUFFER, first, len).expect("the geometry buffer");
    let vertices = words.as_chunks::<8>().0;
    (
        vertices.iter().map(|v| Vec3::new(v[0], v[1], v[2])).collect(),
        vertices.iter().map(|v| v[3]).collect(),
        vertices.iter().map(|v| Vec3::new(v[4], v[5], v[6])).collect(),
    )
}

/// The graph of an entity with the positions that it has on the device, the rest computed anew.
pub fn posed_graph(app: &App, entity: Entity) -> SurfaceGraph {
    let mut graph = common::graph(app, entity);
    let (positions, ..) = geometry(app, entity);
    let of_mesh: Vec<Vec3> = graph.vertex_of.iter().map(|&v| positions[v as usize]).collect();
    graph.update_positions(&of_mesh).expect("finite positions");
    graph
}

pub fn state(app: &App, entity: Entity) -> PatternState {
    app.world().get::<PatternState>(entity).expect("a state").clone()
}
