//! Cells on meshes that a skin or morph targets pose: they are those of the mesh at rest, and go where it goes.

use super::*;
use bevy::{
    camera::visibility::NoFrustumCulling,
    core_pipeline::prepass::{DepthPrepass, MotionVectorPrepass, NormalPrepass},
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
        skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    },
};

/// What poses the square.
#[derive(Debug, Clone, Copy)]
struct Pose {
    skin: bool,
    morph: bool,
}

const WEIGHT: f32 = 0.8;

/// Where the second joint is; the first stays.
fn second_joint() -> Transform {
    Transform::from_xyz(0.1, 0.25, 0.0).with_rotation(Quat::from_rotation_z(0.6))
}

/// The weight of the second joint.
fn share(p: Vec3) -> f32 {
    (0.5 + 0.5 * p.x).clamp(0.0, 1.0)
}

/// The displacement of the morph target.
fn swelling(p: Vec3) -> Vec3 {
    Vec3::new(0.25 * p.y * p.y, 0.2 * p.x * p.y, 0.3 * p.x)
}

impl Pose {
    /// Where a vertex goes.
    fn posed(self, rest: Vec3) -> Vec3 {
        let p = rest
            + if self.morph {
                WEIGHT * swelling(rest)
            } else {
                Vec3::ZERO
            };
        if self.skin {
            p.lerp(second_joint() * p, share(rest))
        } else {
            p
        }
    }

    fn mesh(self, raw: &mesh_file::RawMesh) -> Mesh {
        let mut mesh = to_bevy_mesh(raw);
        if self.skin {
            let joints = VertexAttributeValues::Uint16x4(vec![[0, 1, 0, 0]; raw.positions.len()]);
            let weights: Vec<[f32; 4]> = raw
                .positions
                .iter()
                .map(|&p| [1.0 - share(p), share(p), 0.0, 0.0])
                .collect();
            mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, joints);
            mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
        }
        if self.morph {
            let target = raw.positions.iter().map(|&p| MorphAttributes {
                position: swelling(p),
                ..default()
            });
            mesh.set_morph_targets(target.collect());
        }
        mesh
    }

    /// A picture of the posed square, drawn by a camera with or without a prepass.
    fn picture<M: Material>(
        self,
        stage: &mut Stage,
        (mesh, set): (&Handle<Mesh>, &SampleSet),
        material: M,
        prepass: bool,
    ) -> Picture {
        // Bevy takes weights over with the mesh, from entities that a camera sees.
        let (camera, target) = stage.camera(LENS);
        if prepass {
            let prepass = (DepthPrepass, NormalPrepass, MotionVectorPrepass);
            stage.app.world_mut().entity_mut(camera).insert(prepass);
        }
        let material = MeshMaterial3d(stage.add(material));
        let parts = (Mesh3d(mesh.clone()), material, set.clone(), NoFrustumCulling);
        let entity = stage.app.world_mut().spawn(parts).id();
        let mut all = vec![camera, entity];
        if self.skin {
            let bind = SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]);
            let inverse_bindposes = stage.add(bind);
            let joints = [Transform::IDENTITY, second_joint()].map(|at| stage.app.world_mut().spawn(at).id());
            all.extend(joints);
            let skin = SkinnedMesh {
                inverse_bindposes,
                joints: joints.to_vec(),
            };
            stage.app.world_mut().entity_mut(entity).insert(skin);
        }
        if self.morph {
            let weights = MeshMorphWeights::Value { weights: vec![WEIGHT] };
            stage.app.world_mut().entity_mut(entity).insert(weights);
        }
        settle(stage);
        stage.settle();
        let picture = stage.read(&target);
        stage.clear(all);
        picture
    }
}

const LENS: Lens = Lens {
    width: 160,
    height: 160,
    from: Vec3::new(0.0, 0.0, 5.0),
    to: Vec3::ZERO,
    orthographic: Some(3.6),
    msaa: Msaa::Off,
    hdr: true,
};

/// The weights of a triangle's corners at a point of the plane z = 0.
fn weights([a, b, c]: [Vec3; 3], p: Vec3) -> Vec3 {
    let area = |a: Vec3, b: Vec3, c: Vec3| (b - a).truncate().perp_dot((c - a).truncate());
    Vec3::new(area(p, b, c), area(a, p, c), area(a, b, p)) / area(a, b, c)
}

#[test]
fn cells_go_with_the_mesh_at_rest() {
    let stage = &mut cell_stage();
    let (set, raw) = on_square(120, FIELDS[1].1, 24);
    for (skin, morph) in [(false, false), (true, false), (false, true), (true, true)] {
        let pose = Pose { skin, morph };
        let mesh = stage.add(pose.mesh(&raw));
        let (seen, unlabelled) = seen_by(|mode| pose.picture(stage, (&mesh, &set), Probe::new(mode), false));
        assert_eq!(unlabelled, 0, "{pose:?}: fragments without a cell");
        assert!(seen.len() > 5_000, "{pose:?}: only {} fragments", seen.len());
        let drawn = CellMaterial {
            base: StandardMaterial::default(),
            extension: Cells {
                debug: CellDebug::Label,
                ..default()
            },
        };
        let drawn = pose.picture(stage, (&mesh, &set), drawn, true);
        drawn.save(&format!("posed {skin} {morph}"));
        let (mut wrong, mut other, mut moved) = (0, 0, 0.0);
        for fragment in &seen {
            let corners = raw.triangles[fragment.triangle].map(|v| raw.positions[v as usize]);
            let share = weights(corners, fragment.position);
            let posed: Vec3 = (0..3).map(|c| share[c] * pose.posed(corners[c])).sum();
            let off = fragment.pixel.as_vec2() + 0.5 - pixel_of(posed);
            assert!(
                off.length() < 0.05,
                "{pose:?}: what is at rest at {} is drawn {off} pixels away",
                fragment.position
            );
            wrong += usize::from(fragment.label != nearest(&set, fragment.position));
            let color = drawn.at(fragment.pixel.x as usize, fragment.pixel.y as usize);
            other += usize::from((255.0 * color.x).round() as usize != fragment.label);
            moved += (posed - fragment.position).length();
        }
        let n = seen.len();
        assert!(wrong * 1000 <= n, "{pose:?}: {wrong} of {n} labels are wrong");
        assert!(
            other * 1000 <= n,
            "{pose:?}: the material draws {other} of {n} otherwise"
        );
        assert_eq!(
            moved / n as f32 > 0.1,
            skin || morph,
            "{pose:?}: moved by {moved} / {n}"
        );
    }
}

/// Where the camera draws a point, in pixels.
fn pixel_of(p: Vec3) -> Vec2 {
    let scale = LENS.width as f32 / LENS.orthographic.unwrap_or(1.0);
    0.5 * LENS.width as f32 + scale * Vec2::new(p.x, -p.y)
}
