//! The generated models are closed, even and smooth, their fields are what they claim, and so are the files made of them.

#[path = "../examples/common/mod.rs"]
mod common;

use bevy::{gltf::GltfMesh, mesh::VertexAttributeValues, prelude::*};
use common::{
    aneurysm::Aneurysm,
    creature::{Creature, SKELETON},
    creature_walk::{STRIDE, morph_weights, rotation},
    flag::Flag,
    gltf::{FIELD_ATTRIBUTE, TENSOR_DIAGONAL_ATTRIBUTE, TENSOR_OFFDIAGONAL_ATTRIBUTE},
    headless::{headless_app, update},
    hyperball::Hyperball,
    instrument,
    mesh_file::{RawMesh, smooth_normals},
    molecule::{self, CAFFEINE},
    organs::Organs,
    points,
    vessel_tree::VesselTree,
};
use std::{collections::HashMap, fs, path::Path};

/// Checks that no edge is used twice in one direction, that the surface faces outwards and that it has `holes`: tunnels if
/// it is closed, borders if not. Gives the smallest angle of all triangles and of all but a hundredth, in degrees.
fn check(mesh: &RawMesh, genus: i64, borders: i64) -> [f32; 2] {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let (mut angles, mut volume) = (Vec::new(), 0.0);
    for &triangle in &mesh.triangles {
        let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
        volume += corners[0].dot(corners[1].cross(corners[2]));
        let angle = |i: usize| (corners[(i + 1) % 3] - corners[i]).angle_between(corners[(i + 2) % 3] - corners[i]);
        angles.push(angle(0).min(angle(1)).min(angle(2)).to_degrees());
        for i in 0..3 {
            *edges.entry((triangle[i], triangle[(i + 1) % 3])).or_default() += 1;
        }
    }
    assert!(edges.values().all(|&uses| uses == 1), "an edge of three triangles");
    assert!(volume > 0.0, "inside out");
    let undirected = edges
        .keys()
        .filter(|&&(a, b)| a < b || !edges.contains_key(&(b, a)))
        .count();
    let euler = mesh.positions.len() as i64 - undirected as i64 + mesh.triangles.len() as i64;
    assert_eq!(euler, 2 - 2 * genus - borders);
    angles.sort_by(f32::total_cmp);
    [angles[0], angles[angles.len() / 100]]
}

#[test]
fn surfaces_are_closed_and_even() {
    let tree = VesselTree::default();
    assert!(tree.branches() > 30);
    let organs = Organs::generate(0.03, 5);
    let surfaces = [
        ("vessels", tree.mesh(0.017), 0, 0),
        ("aneurysm", Aneurysm::default().mesh(0.06), 0, 2),
        ("hyperball", Hyperball::default().mesh(0.05), Hyperball::GENUS, 0),
        ("creature", Creature::generate(0.03).mesh, 0, 0),
        ("hull", organs.hull, 0, 0),
        ("tumour", organs.tumour, 0, 0),
        ("portal vein", organs.vessels, 0, 0),
        ("molecule", molecule::surface(&CAFFEINE, 0.25), 0, 0),
    ];
    for (name, mesh, genus, borders) in surfaces {
        let [smallest, most] = check(&mesh, genus, borders);
        assert!(
            smallest > 8.0 && most > 30.0,
            "{name}: angles from {smallest}, 99 % from {most}"
        );
    }
    check(&instrument::needle(20), 0, 0);
    check(&Flag::default().mesh(), 0, 1);
}

#[test]
fn meshes_lie_on_their_surfaces_and_fields_along_them() {
    let edge = 0.03;
    let tree = VesselTree::default();
    let mesh = tree.mesh(edge);
    let off = mesh
        .positions
        .iter()
        .map(|&p| tree.distance(p).abs())
        .fold(0.0, f32::max);
    assert!(off < 0.05 * edge, "{off}");
    // The blood flows from the root to the ends: up, by and large, and never against its vessel.
    let mean: Vec3 = mesh.positions.iter().map(|&p| tree.flow(p)).sum::<Vec3>() / mesh.positions.len() as f32;
    assert!(mean.y > 0.4, "{mean}");

    let ball = Hyperball::default();
    let mesh = ball.mesh(0.05);
    let cross = ball.cross_field(&mesh);
    let normals = smooth_normals(&mesh);
    // Neighbours agree up to quarter turns nearly everywhere.
    let agreement = |a: usize, b: usize| {
        let [own, other] = [a, b].map(|v| cross[v].reject_from(normals[a]).normalize());
        let cosine = own.dot(other).abs();
        cosine.max((1.0 - cosine * cosine).max(0.0).sqrt())
    };
    let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let (total, smooth) = sides.fold((0, 0), |(total, smooth), (a, b)| {
        let agree = agreement(a as usize, b as usize) > 20.0_f32.to_radians().cos();
        (total + 1, smooth + usize::from(agree))
    });
    assert!(smooth * 20 > total * 19, "{smooth} of {total} edges");
}

#[test]
fn stress_is_that_of_a_tube_and_grows_on_the_sac() {
    let shape = Aneurysm::default();
    let mesh = shape.mesh(0.06);
    let stress = shape.stress(&mesh);
    let (mut artery, mut dome) = (Vec::new(), 0.0_f32);
    for (p, tensor) in mesh.positions.iter().zip(&stress) {
        let t = tensor.to_mat3();
        // The eigenvalue across the wall is 0, so the other two have this sum and product.
        let sum = tensor.diagonal().element_sum();
        let squares = (t * t).diagonal().element_sum();
        let product = 0.5 * (sum * sum - squares);
        assert!(
            sum > 0.0 && product > 0.0,
            "a wall under pressure is stretched everywhere: {tensor:?}"
        );
        if p.y < 0.6 * shape.arc {
            let spread = (0.25 * sum * sum - product).max(0.0).sqrt();
            artery.push([0.5 * sum - spread, 0.5 * sum + spread]);
        } else if p.y > shape.arc + shape.sac.y {
            dome = dome.max(0.5 * sum);
        }
    }
    // A bent tube has not quite the stress of a straight one.
    let mean = |k: usize| artery.iter().map(|values| values[k]).sum::<f32>() / artery.len() as f32;
    assert!(
        (mean(0) - 1.0).abs() < 0.05 && (mean(1) - 2.0).abs() < 0.05,
        "{} {}",
        mean(0),
        mean(1)
    );
    assert!(
        dome > mean(0) + mean(1),
        "on the sac at least twice the mean of both: {dome}"
    );
}

#[test]
fn creatures_have_whole_weights_and_walk_in_circles() {
    let creature = Creature::generate(0.035);
    for (joints, weights) in creature.joints.iter().zip(&creature.weights) {
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        assert!(weights[0] >= weights[1] && weights[3] >= 0.0);
        assert!(joints.iter().all(|&joint| usize::from(joint) < SKELETON.len()));
    }
    for (i, joint) in SKELETON.iter().enumerate() {
        assert!(joint.parent.is_none_or(|parent| parent < i), "parents come first");
        assert!(rotation(i, 0.3).angle_between(rotation(i, 0.3 + STRIDE)) < 1e-2);
    }
    assert!(morph_weights(0.7).iter().all(|weight| (0.0..=1.0).contains(weight)));
    // Each morph target moves a part of the body and leaves most of it.
    for moves in &creature.morphs {
        let moved = moves.iter().filter(|by| by.length() > 1e-3).count();
        assert!((1..moves.len() / 2).contains(&moved), "{moved}");
    }
}

#[test]
fn caffeine_is_neutral_and_its_oxygens_are_negative() {
    assert!(CAFFEINE.iter().map(|atom| atom.charge).sum::<f32>().abs() < 1e-4);
    let count = |element| CAFFEINE.iter().filter(|atom| atom.element == element).count();
    assert_eq!(['C', 'H', 'N', 'O'].map(count), [8, 10, 4, 2]);
    let mesh = molecule::surface(&CAFFEINE, 0.3);
    let charges = molecule::charges(&CAFFEINE, &mesh.positions);
    for (p, charge) in mesh.positions.iter().zip(charges) {
        let nearest = CAFFEINE.iter().map(|atom| p.distance(atom.position) - atom.radius());
        assert!(nearest.fold(f32::INFINITY, f32::min) > -1e-3, "atoms lie inside");
        assert!((-0.57..=0.71).contains(&charge));
        if p.distance(CAFFEINE[0].position) < 1.55 {
            assert!(charge < -0.3, "{charge} next to an oxygen");
        }
    }
}

#[test]
fn scans_are_spread_by_area() {
    let sphere = common::shapes::icosphere(4, 1.0);
    let cloud = points::scan(&sphere, 8000, 0.01, 1);
    let half = cloud.iter().filter(|point| point.position.y > 0.0).count();
    assert!((3800..4200).contains(&half), "{half}");
    let off = cloud
        .iter()
        .map(|point| (point.position.length() - 1.0).powi(2))
        .sum::<f32>()
        / 8000.0;
    assert!((0.008..0.012).contains(&off.sqrt()), "{}", off.sqrt());
    assert!(cloud.iter().all(|point| point.normal.dot(point.position) > 0.9));
}

#[test]
fn files_carry_their_fields() {
    let mut app = headless_app(UVec2::splat(16)).expect("a device");
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models");
    let tensor = [TENSOR_DIAGONAL_ATTRIBUTE, TENSOR_OFFDIAGONAL_ATTRIBUTE];
    let files = [
        ("aneurysm", &tensor[..], 0, 2),
        ("vessels", &[FIELD_ATTRIBUTE][..], 0, 0),
        ("hyperball", &[FIELD_ATTRIBUTE][..], Hyperball::GENUS, 0),
        ("creature", &[FIELD_ATTRIBUTE][..], 0, 0),
    ];
    for (name, attributes, genus, borders) in files {
        let size = fs::metadata(folder.join(name).with_extension("glb"))
            .expect("a file")
            .len();
        assert!(size < 1_000_000, "{name}: {size} bytes");
        let handle: Handle<Gltf> = app.world().resource::<AssetServer>().load(format!("models/{name}.glb"));
        while !app
            .world()
            .resource::<AssetServer>()
            .is_loaded_with_dependencies(&handle)
        {
            update(&mut app).expect("a frame");
            let state = app.world().resource::<AssetServer>().load_state(&handle);
            assert!(!state.is_failed(), "{name}: {state:?}");
        }
        let world = app.world();
        let file = world.resource::<Assets<Gltf>>().get(&handle).expect("a scene");
        let parts = world
            .resource::<Assets<GltfMesh>>()
            .get(&file.meshes[0])
            .expect("a mesh");
        let mesh = world
            .resource::<Assets<Mesh>>()
            .get(&parts.primitives[0].mesh)
            .expect("a primitive");
        let vectors = |attribute| match mesh.attribute(attribute) {
            Some(VertexAttributeValues::Float32x3(vectors)) => vectors.iter().copied().map(Vec3::from_array).collect(),
            other => panic!("{name}: {other:?}"),
        };
        let raw = RawMesh {
            positions: vectors(Mesh::ATTRIBUTE_POSITION),
            triangles: mesh
                .indices()
                .expect("indices")
                .iter()
                .map(|i| i as u32)
                .collect::<Vec<_>>()
                .as_chunks()
                .0
                .to_vec(),
        };
        let [smallest, most] = check(&raw, genus, borders);
        assert!(
            smallest > 8.0 && most > 30.0,
            "{name}: angles from {smallest}, 99 % from {most}"
        );
        for attribute in attributes {
            let values: Vec<Vec3> = vectors(*attribute);
            assert_eq!(values.len(), raw.positions.len());
            assert!(values.iter().any(|value| value.length() > 0.5), "{name}");
        }
        let is_creature = name == "creature";
        assert_eq!(mesh.has_morph_targets(), is_creature);
        assert_eq!(mesh.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT).is_some(), is_creature);
        assert_eq!(
            (file.skins.len(), file.animations.len()),
            if is_creature { (1, 1) } else { (0, 0) }
        );
    }
}
