//! Stanford PLY, ASCII and binary: bytes in, positions (`vertex`: `x`, `y`, `z` of any scalar type) and polygons
//! (`face`: a list named `vertex_indices` or `vertex_index`) out; other elements and properties are passed over.

use std::io::ErrorKind;

use bevy::prelude::*;
use ply_rs_bw::{
    parser::{ParseError, Parser, Reader},
    ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType},
};

use super::{Problem, RawMesh, push_polygon};

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Problem> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(problem)?;
    let (mut vertices, mut polygons) = (Vec::<Vertex>::new(), Vec::<Polygon>::new());
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                check_coordinates(element)?;
                vertices = Parser::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(problem)?;
            }
            "face" => {
                polygons = Parser::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(problem)?;
            }
            _ => {
                let skipped = Parser::<Skipped>::new().read_payload_for_element(&mut reader, element, &header);
                skipped.map_err(problem)?;
            }
        }
    }
    Ok(RawMesh {
        positions: vertices.iter().map(|vertex| vertex.0).collect(),
        triangles: triangulate(&polygons, vertices.len())?,
    })
}

/// Says which coordinate is missing, rather than to leave it 0 in silence.
fn check_coordinates(vertex: &ElementDef) -> Result<(), Problem> {
    let is_scalar = |name| {
        vertex
            .properties
            .get(name)
            .is_some_and(|property| matches!(property.data_type, PropertyType::Scalar(_)))
    };
    match ["x", "y", "z"].into_iter().find(|name| !is_scalar(*name)) {
        Some(name) => Err(Problem::Malformed(format!("its vertices have no coordinate `{name}`"))),
        None => Ok(()),
    }
}

fn triangulate(polygons: &[Polygon], vertices: usize) -> Result<Vec<[u32; 3]>, Problem> {
    let mut triangles = Vec::with_capacity(polygons.len());
    for (polygon, face) in polygons.iter().zip(1..) {
        if polygon.0.len() < 3 {
            return Err(Problem::Malformed(format!(
                "face {face} has {} corners; 3 are needed",
                polygon.0.len()
            )));
        }
        if let Some(&index) = polygon.0.iter().find(|&&index| index as usize >= vertices) {
            return Err(Problem::IndexOutOfRange {
                face,
                index: index.into(),
                vertices,
            });
        }
        push_polygon(&mut triangles, &polygon.0);
    }
    Ok(triangles)
}

/// The parser's messages run over several lines and quote the whole element; the first line is what a user needs.
fn problem(error: ParseError) -> Problem {
    let message = error.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
    match error.kind() {
        ErrorKind::UnexpectedEof => Problem::Truncated(message),
        _ => Problem::Malformed(message),
    }
}

struct Vertex(Vec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(Vec3::ZERO)
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let (coordinate, Some(value)) = (name, property.to_f32_lossy()) else {
            return PropertyAccessResult::Ignored;
        };
        match coordinate {
            "x" => self.0.x = value,
            "y" => self.0.y = value,
            "z" => self.0.z = value,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

struct Polygon(Vec<u32>);

impl PropertyAccess for Polygon {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        // `None` for a scalar, a list of floating point numbers or a negative index.
        match property.to_u32_list() {
            Some(corners) => self.0 = corners,
            None => return PropertyAccessResult::UnsupportedType,
        }
        PropertyAccessResult::Set
    }
}

/// An element that is read only to get past it.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
