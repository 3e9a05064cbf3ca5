//! Writes a mesh with fields, skin, morph targets and an animation as a binary glTF 2.0 file.
//!
//! In: a [`Model`]. Out: the bytes of a `.glb` file: one mesh, `NORMAL` and custom attributes as `VEC3` of floats, indices
//! as short as they can be, weights as normalised 16-bit integers. A skin's joints are nodes whose axes are the scene's.

use bevy::prelude::*;
use serde_json::{Value, json};

use super::mesh_file::RawMesh;

const FLOAT: u32 = 5126;
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;

/// One value per vertex and its name.
pub type Attribute<'a> = (&'a str, &'a [Vec3]);

/// What a file holds.
#[derive(Default)]
pub struct Model<'a> {
    pub name: &'a str,
    pub mesh: Option<&'a RawMesh>,
    pub normals: &'a [Vec3],
    /// Of the material.
    pub color: LinearRgba,
    /// Names begin with an underscore.
    pub attributes: &'a [Attribute<'a>],
    /// Displacements of positions and of normals.
    pub morphs: &'a [(&'a str, &'a [Vec3], &'a [Vec3])],
    pub skin: Option<Skin<'a>>,
}

/// Joints and the motion of joints and morph targets.
pub struct Skin<'a> {
    /// Name, parent (which comes first) and position in the parent's axes.
    pub joints: &'a [(&'a str, Option<usize>, Vec3)],
    pub inverse_bindposes: &'a [Mat4],
    pub indices: &'a [[u16; 4]],
    pub weights: &'a [[f32; 4]],
    /// Key frames' times in seconds.
    pub times: &'a [f32],
    /// A rotation per joint and key frame.
    pub rotations: &'a [Vec<Quat>],
    /// The first joint's position per key frame.
    pub positions: &'a [Vec3],
    /// A weight per morph target and key frame.
    pub morphs: &'a [Vec<f32>],
}

/// The file being written.
#[derive(Default)]
struct Writer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Writer {
    /// Appends one accessor with a view of its own; gives its index.
    fn push(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.accessors.push(json!({
            "bufferView": self.views.len(), "componentType": component, "count": count, "type": kind,
        }));
        self.views.push(view);
        self.accessors.len() - 1
    }

    /// Per vertex; the format wants the bounds of positions.
    fn vectors(&mut self, vectors: &[Vec3]) -> usize {
        let index = self.push("VEC3", FLOAT, vectors.len(), bytemuck::cast_slice(vectors), Some(34962));
        let min = vectors.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let max = vectors.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
        self.accessors[index]["min"] = json!(min.to_array());
        self.accessors[index]["max"] = json!(max.to_array());
        index
    }

    fn floats(&mut self, kind: &str, per_element: usize, floats: &[f32]) -> usize {
        self.push(
            kind,
            FLOAT,
            floats.len() / per_element,
            bytemuck::cast_slice(floats),
            None,
        )
    }

    fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let indices = triangles.as_flattened();
        if let Ok(_fits) = u16::try_from(vertices) {
            let short: Vec<u16> = indices.iter().map(|&index| index as u16).collect();
            self.push(
                "SCALAR",
                UNSIGNED_SHORT,
                short.len(),
                bytemuck::cast_slice(&short),
                Some(34963),
            )
        } else {
            self.push(
                "SCALAR",
                UNSIGNED_INT,
                indices.len(),
                bytemuck::cast_slice(indices),
                Some(34963),
            )
        }
    }

    /// Joints and weights of the vertices.
    fn influences(&mut self, skin: &Skin) -> [usize; 2] {
        let joints: Vec<u8> = skin.indices.as_flattened().iter().map(|&joint| joint as u8).collect();
        let weights: Vec<u16> = skin
            .weights
            .iter()
            .flat_map(|weights| {
                let mut parts = weights.map(|weight| (weight * 65535.0).round() as u16);
                // The first is the largest: it takes what rounding left over.
                parts[0] = 65535 - parts[1..].iter().sum::<u16>();
                parts
            })
            .collect();
        let count = skin.indices.len();
        let joints = self.push("VEC4", UNSIGNED_BYTE, count, &joints, Some(34962));
        let weights = self.push(
            "VEC4",
            UNSIGNED_SHORT,
            count,
            bytemuck::cast_slice(&weights),
            Some(34962),
        );
        self.accessors[weights]["normalized"] = json!(true);
        [joints, weights]
    }

    /// The motion of the nodes from 1 on, which are the joints, and of node 0, which has the mesh and the first joint below it.
    fn animation(&mut self, skin: &Skin) -> Value {
        let times = self.floats("SCALAR", 1, skin.times);
        let (first, last) = (skin.times.first(), skin.times.last());
        self.accessors[times]["min"] = json!([first]);
        self.accessors[times]["max"] = json!([last]);
        let mut outputs: Vec<(usize, usize, &str)> = Vec::new();
        for (joint, rotations) in skin.rotations.iter().enumerate() {
            let floats: Vec<f32> = rotations.iter().flat_map(|rotation| rotation.to_array()).collect();
            outputs.push((joint + 1, self.floats("VEC4", 4, &floats), "rotation"));
        }
        let positions: Vec<f32> = skin.positions.iter().flat_map(Vec3::to_array).collect();
        outputs.push((1, self.floats("VEC3", 3, &positions), "translation"));
        if !skin.morphs.is_empty() {
            outputs.push((0, self.floats("SCALAR", 1, &skin.morphs.concat()), "weights"));
        }
        let channels: Vec<Value> = outputs
            .iter()
            .enumerate()
            .map(|(sampler, (node, _, path))| json!({ "sampler": sampler, "target": { "node": node, "path": path } }))
            .collect();
        let samplers: Vec<Value> = outputs
            .iter()
            .map(|(_, output, _)| json!({ "input": times, "output": output }))
            .collect();
        json!([{ "name": "walk", "channels": channels, "samplers": samplers }])
    }
}

/// The bytes of the file.
pub fn write(model: &Model) -> Vec<u8> {
    let mut writer = Writer::default();
    let (positions, triangles) = model
        .mesh
        .map_or((&[][..], &[][..]), |mesh| (&mesh.positions, &mesh.triangles));
    let mut attributes = json!({ "POSITION": writer.vectors(positions), "NORMAL": writer.vectors(model.normals) });
    for (name, values) in model.attributes {
        attributes[*name] = json!(writer.vectors(values));
    }
    let mut primitive = json!({ "material": 0, "indices": writer.indices(triangles, positions.len()) });
    if !model.morphs.is_empty() {
        let targets: Vec<Value> = model
            .morphs
            .iter()
            .map(|(_, moves, turns)| json!({ "POSITION": writer.vectors(moves), "NORMAL": writer.vectors(turns) }))
            .collect();
        primitive["targets"] = json!(targets);
    }
    let mut root = json!({ "name": model.name, "mesh": 0 });
    let mut file = json!({ "asset": { "version": "2.0", "generator": "bevy_field_patterns" }, "scene": 0 });
    let mut nodes = Vec::new();
    if let Some(skin) = &model.skin {
        let [joints, weights] = writer.influences(skin);
        (attributes["JOINTS_0"], attributes["WEIGHTS_0"]) = (json!(joints), json!(weights));
        let matrices: Vec<f32> = skin.inverse_bindposes.iter().flat_map(Mat4::to_cols_array).collect();
        let bindposes = writer.floats("MAT4", 16, &matrices);
        (root["skin"], root["children"]) = (json!(0), json!([1]));
        let all: Vec<usize> = (1..=skin.joints.len()).collect();
        file["skins"] = json!([{ "joints": all, "inverseBindMatrices": bindposes, "skeleton": 1 }]);
        file["animations"] = writer.animation(skin);
        for (i, (name, _, position)) in skin.joints.iter().enumerate() {
            let children: Vec<usize> = (0..skin.joints.len())
                .filter(|&j| skin.joints[j].1 == Some(i))
                .map(|j| j + 1)
                .collect();
            let mut node = json!({ "name": name, "translation": position.to_array() });
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            nodes.push(node);
        }
    }
    primitive["attributes"] = attributes;
    let names: Vec<&str> = model.morphs.iter().map(|(name, ..)| *name).collect();
    let mut mesh = json!({ "name": model.name, "primitives": [primitive] });
    if !names.is_empty() {
        mesh["extras"] = json!({ "targetNames": names });
        mesh["weights"] = json!(vec![0.0; names.len()]);
    }
    nodes.insert(0, root);
    file["scenes"] = json!([{ "name": model.name, "nodes": [0] }]);
    file["materials"] = json!([{
        "doubleSided": true,
        "pbrMetallicRoughness": {
            "baseColorFactor": model.color.to_f32_array(), "metallicFactor": 0.0, "roughnessFactor": 0.6,
        },
    }]);
    (file["nodes"], file["meshes"]) = (json!(nodes), json!([mesh]));
    (file["bufferViews"], file["accessors"]) = (json!(writer.views), json!(writer.accessors));
    file["buffers"] = json!([{ "byteLength": writer.bytes.len() }]);
    pack(file.to_string().into_bytes(), writer.bytes)
}

/// The header, and the chunks with their lengths; the first is padded with spaces.
fn pack(mut text: Vec<u8>, bytes: Vec<u8>) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |value: usize| (value as u32).to_le_bytes();
    let mut file = b"glTF".to_vec();
    file.extend(word(2));
    file.extend(word(12 + 8 + text.len() + 8 + bytes.len()));
    file.extend(word(text.len()));
    file.extend(b"JSON");
    file.extend(text);
    file.extend(word(bytes.len()));
    file.extend(b"BIN\0");
    file.extend(bytes);
    file
}
