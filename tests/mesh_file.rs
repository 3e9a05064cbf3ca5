//! The examples' mesh and field files: every format and every way to be wrong.
#![allow(unreachable_pub, reason = "modules shared with the examples")]

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

use bevy::prelude::*;
use mesh_file::{RawMesh, read, read_field, to_bevy_mesh};

#[path = "../examples/common/mesh_file/mod.rs"]
mod mesh_file;

/// Writes a file of its own per test; the ending tells the format.
fn file(name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, bytes).unwrap();
    path
}

/// A unit square as a quad, a triangle on it, and a vertex (number 2) that no face uses.
fn roof() -> RawMesh {
    let positions = [
        [0., 0., 0.],
        [1., 0., 0.],
        [9., 9., 9.],
        [1., 1., 0.],
        [0., 1., 0.],
        [0.5, 0.5, 0.25],
    ];
    RawMesh {
        positions: positions.map(Vec3::from_array).to_vec(),
        triangles: vec![[0, 1, 3], [0, 3, 4], [1, 3, 5]],
    }
}

const ROOF_POLYGONS: [&[u8]; 2] = [&[0, 1, 3, 4], &[1, 3, 5]];

#[test]
fn obj_keeps_the_list_of_the_file() {
    let text = "# caf\u{e9}\r\no first\nv 0 0 0\nv 1 0 0 1.0\nv 9 9 9\nvn 0 0 1\nvt 0 0\ng a b\nusemtl none\n\
                f 1//1 2//1 4//1 5//1 # ahead of its vertices\no second\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\ns off\n\
                v .5 5e-1 \\\n 0.25\nl 1 2\nf -5/1/1 -3/1/1 -1/1/1\n";
    // Bytes above 127 that are not UTF-8 may stand in a comment.
    let latin1: Vec<u8> = text.chars().map(|c| c as u8).collect();
    assert_eq!(read(file("roof.obj", latin1)).unwrap(), roof());
}

#[test]
fn obj_agrees_with_tobj_on_every_corner() {
    let mut text = String::from("o a\n");
    for i in 0..60 {
        let (sin, cos) = (i as f32).sin_cos();
        text += &format!("v {cos} {sin} {}\n", i as f32 / 7.0);
        if i % 7 == 6 {
            text += &format!(
                "o object{i}\nf -1 -3 -2 {} {}\nf {} {} {}\n",
                i - 4,
                i - 5,
                i,
                i - 2,
                i - 3
            );
        }
    }
    let path = file("tobj.obj", &text);
    let ours = read(&path).unwrap();
    let options = tobj::LoadOptions {
        triangulate: true,
        ..default()
    };
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Ok(default())).unwrap();
    let theirs = models.iter().flat_map(|model| {
        let corner = |&i: &u32| Vec3::from_slice(&model.mesh.positions[3 * i as usize..]);
        model.mesh.indices.iter().map(corner).collect::<Vec<_>>()
    });
    let ours: Vec<Vec3> = ours
        .triangles
        .as_flattened()
        .iter()
        .map(|&i| ours.positions[i as usize])
        .collect();
    assert_eq!(ours, theirs.collect::<Vec<_>>());
    assert!(models.len() > 3, "several objects were to be compared");
}

/// The roof as PLY with an element and properties that mean nothing to us, coordinates as double, short indices.
fn ply(format: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {format} 1.0\ncomment made for a test\nelement vertex 6\nproperty double x\nproperty uchar red\n\
         property double y\nproperty double z\nelement edge 1\nproperty int vertex1\nproperty float weight\n\
         element face 2\nproperty uchar flags\nproperty list ushort short vertex_index\nproperty list uchar float uv\n\
         end_header\n"
    );
    let mut out = header.into_bytes();
    let mut put = |text: String, little: &[u8]| match format {
        "ascii" => out.extend((text + " ").into_bytes()),
        "binary_little_endian" => out.extend(little),
        _ => out.extend(little.iter().rev()),
    };
    let end_line = |put: &mut dyn FnMut(String, &[u8])| put("\n".into(), &[]);
    for p in roof().positions {
        let [x, y, z] = p.as_dvec3().to_array();
        put(x.to_string(), &x.to_le_bytes());
        put("200".into(), &[200]);
        put(y.to_string(), &y.to_le_bytes());
        put(z.to_string(), &z.to_le_bytes());
        end_line(&mut put);
    }
    put("3".into(), &3_i32.to_le_bytes());
    put("0.5".into(), &0.5_f32.to_le_bytes());
    end_line(&mut put);
    for polygon in ROOF_POLYGONS {
        put("7".into(), &[7]);
        put(polygon.len().to_string(), &(polygon.len() as u16).to_le_bytes());
        for &corner in polygon {
            put(corner.to_string(), &i16::from(corner).to_le_bytes());
        }
        put("1".into(), &[1]);
        put("0.25".into(), &0.25_f32.to_le_bytes());
        end_line(&mut put);
    }
    out
}

#[test]
fn ply_in_all_three_encodings() {
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        assert_eq!(
            read(file(&format!("{format}.ply"), ply(format))).unwrap(),
            roof(),
            "{format}"
        );
    }
}

/// Two triangles of a square; corners (1, 0, 0) and (0, 1, 0) are shared, once as -0.
const SOUP: [[[f32; 3]; 3]; 2] = [
    [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]],
    [[1., 0., -0.], [1., 1., 0.], [0., 1., 0.]],
];

fn welded() -> RawMesh {
    let positions = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]];
    RawMesh {
        positions: positions.map(Vec3::from_array).to_vec(),
        triangles: vec![[0, 1, 2], [1, 3, 2]],
    }
}

fn binary_stl(title: &str) -> Vec<u8> {
    let mut out = title.as_bytes().to_vec();
    out.resize(80, 0);
    out.extend(2_u32.to_le_bytes());
    for triangle in SOUP {
        let normal = [0., 0., 1.];
        out.extend(
            [[normal].as_slice(), &triangle]
                .concat()
                .as_flattened()
                .iter()
                .flat_map(|c: &f32| c.to_le_bytes()),
        );
        out.extend([0xff, 0xff]);
    }
    out
}

fn ascii_stl() -> String {
    let facets = SOUP.map(|triangle| {
        let corners = triangle
            .map(|[x, y, z]| format!("      vertex {x:e} {y} {z}\n"))
            .concat();
        format!("  facet normal 0 0 1\n    outer loop\n{corners}    endloop\n  endfacet\n")
    });
    format!("solid a square\n{}endsolid a square\n", facets.concat())
}

#[test]
fn stl_is_welded_in_order_of_first_appearance() {
    assert_eq!(read(file("ascii.stl", ascii_stl())).unwrap(), welded());
    assert_eq!(read(file("binary.STL", binary_stl("a square"))).unwrap(), welded());
    // Titles may begin like an ASCII file, with its words even.
    assert_eq!(
        read(file("solid.stl", binary_stl("solid facet endsolid"))).unwrap(),
        welded()
    );
}

#[test]
fn every_error_is_one_line_that_names_the_file() {
    let ply = |vertex: &str, face: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{vertex}\n{face}\n"
        )
    };
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("kind.xyz", vec![], "unknown kind"),
        ("no_ending", vec![], "unknown kind"),
        ("model.glb", vec![], "AssetServer"),
        ("empty.obj", vec![], "no triangles"),
        ("points.obj", b"v 0 0 0\nv 1 0 0\nl 1 2\n".into(), "no triangles"),
        (
            "short.obj",
            b"v 0 0 0\nv 1 0\n".into(),
            "line 2: a vertex needs three numbers: v 1 0",
        ),
        ("word.obj", b"v 0 0 zero\n".into(), "line 1"),
        (
            "digon.obj",
            b"v 0 0 0\nv 1 0 0\nf 1 2\n".into(),
            "line 3: a face needs three",
        ),
        ("index.obj", b"v 0 0 0\nf a b c\n".into(), "line 2"),
        (
            "zero.obj",
            b"v 0 0 0\nf 0 1 1\n".into(),
            "face 1 names vertex 0, but the file has 1",
        ),
        (
            "beyond.obj",
            b"v 0 0 0\nf 1 1 1\nf 1 2 1\n".into(),
            "face 2 names vertex 2, but the file has 1",
        ),
        (
            "huge.obj",
            b"v 0 0 0\nf 1 1 4294967297\n".into(),
            "names vertex 4294967297",
        ),
        ("back.obj", b"v 0 0 0\nf -1 -1 -2\n".into(), "face 1 names vertex"),
        (
            "nan.obj",
            b"v 0 0 0\nv 0 nan 0\nf 1 1 1\n".into(),
            "vertex 2 is not finite",
        ),
        ("large.obj", b"v 1e39 0 0\nf 1 1 1\n".into(), "vertex 1 is not finite"),
        ("no.ply", b"pla\n".into(), ""),
        ("header.ply", b"ply\nformat ascii 1.0\nelement vertex 1\n".into(), ""),
        ("cut.ply", ply("0 0 0", "").into(), ""),
        ("word.ply", ply("0 0 zero", "3 0 0 0").into(), ""),
        (
            "beyond.ply",
            ply("0 0 0", "3 0 0 1").into(),
            "face 1 names vertex 1, but the file has 1",
        ),
        ("negative.ply", ply("0 0 0", "3 0 0 -1").into(), ""),
        ("digon.ply", ply("0 0 0", "2 0 0").into(), "face 1 has 2 corners"),
        (
            "flat.ply",
            ply("0 0 0", "3 0 0 0").replace("float z", "float w").into(),
            "no coordinate `z`",
        ),
        (
            "points.ply",
            ply("0 0 0", "").replace("face 1", "face 0").into(),
            "no triangles",
        ),
        ("empty.stl", vec![], "cut short: 0 bytes"),
        ("cut.stl", binary_stl("a")[..150].into(), "cut short: 1 of 2 triangles"),
        (
            "cut_ascii.stl",
            ascii_stl().replace("endsolid", "").into(),
            "cut short: `endsolid`",
        ),
        (
            "corners.stl",
            ascii_stl().replacen("vertex", "normal", 1).into(),
            "line 7: a facet needs three vertices",
        ),
        ("none.stl", b"solid a\nendsolid a\n".into(), "no triangles"),
        ("nan.stl", ascii_stl().replace("1e0", "nan").into(), "is not finite"),
    ];
    for (name, bytes, expected) in cases {
        let message = read(file(name, bytes)).expect_err(name).to_string();
        assert!(
            message.contains(name) && message.contains(expected),
            "{name}: {message}"
        );
        assert!(
            !message.contains('\n') && message.len() < 400,
            "{name} is not one line: {message}"
        );
    }
    let missing = read("/nowhere/at/all.obj").expect_err("missing").to_string();
    assert!(missing.starts_with("/nowhere/at/all.obj: cannot be read"), "{missing}");
}

#[test]
fn a_file_cut_anywhere_is_an_error_or_a_smaller_mesh_but_no_panic() {
    let binary = [
        ("cut_le.ply", ply("binary_little_endian")),
        ("cut_be.ply", ply("binary_big_endian")),
    ];
    for (name, whole) in binary.into_iter().chain([("cut_b.stl", binary_stl("solid cut"))]) {
        for length in 0..whole.len() {
            assert!(read(file(name, &whole[..length])).is_err(), "{name} of {length} bytes");
        }
    }
    for (name, whole) in [("cut_a.ply", ply("ascii")), ("cut_a.stl", ascii_stl().into())] {
        for length in 0..whole.len() {
            if let Ok(mesh) = read(file(name, &whole[..length])) {
                assert!(mesh.triangles.len() <= 3);
            }
        }
    }
}

#[test]
fn a_field_has_one_direction_per_vertex() {
    let text = "# x y z\n1 0 0\n\n  0.6\t-8e-1 0 \r\n";
    let path = file("field.txt", text);
    assert_eq!(read_field(&path, 2).unwrap(), [Vec3::X, Vec3::new(0.6, -0.8, 0.0)]);
    let error = |text: &str, expected| {
        read_field(file("bad_field.txt", text), expected)
            .expect_err(text)
            .to_string()
    };
    assert!(error(text, 3).ends_with("it holds 2 directions, but the mesh file has 3 vertices"));
    assert!(error("1 0 0\n1 0\n", 2).ends_with("line 2 is not 3 numbers: 1 0"));
    assert!(error("1 0 0 0\n", 1).contains("line 1"));
    assert!(error("1 inf 0\n", 1).ends_with("line 1 is not finite"));
    assert!(read_field("/nowhere/field.txt", 1).is_err());
}

#[test]
fn normals_do_not_depend_on_the_unit_of_length() {
    // A tetrahedron: its smooth normals point from the centre to the corners, whatever its size.
    let directions = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]].map(Vec3::from_array);
    for size in [1e-6_f32, 1.0, 1e6] {
        let raw = RawMesh {
            positions: directions
                .map(|direction| direction * size)
                .into_iter()
                .chain([Vec3::ZERO])
                .collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2], [0, 0, 1]],
        };
        let mesh = to_bevy_mesh(&raw);
        let normals = mesh
            .attribute(Mesh::ATTRIBUTE_NORMAL)
            .and_then(|values| values.as_float3())
            .unwrap();
        for (normal, direction) in normals.iter().zip(directions) {
            assert!(
                Vec3::from(*normal).distance(direction.normalize()) < 1e-5,
                "{size}: {normal:?}"
            );
        }
        assert_eq!(
            normals[4],
            [0., 1., 0.],
            "a vertex without faces has a normal that can be normalised"
        );
    }
    let used: HashSet<u32> = roof().triangles.into_flattened().into_iter().collect();
    assert!(!used.contains(&2), "the roof is to have an unused vertex");
}
