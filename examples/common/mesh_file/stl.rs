//! STL, ASCII and binary: a soup of triangles in, welded vertices out. Normals and attributes are passed over.
//!
//! Binary: 80 bytes of title, the number of triangles (u32), then per triangle a normal, three corners (f32) and two
//! bytes of attributes; little-endian.

use std::collections::HashMap;

use bevy::prelude::*;

use super::{Problem, RawMesh, three_floats};

const HEADER: usize = 84;
const RECORD: usize = 50;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Problem> {
    if is_ascii(bytes) {
        parse_ascii(&String::from_utf8_lossy(bytes))
    } else {
        parse_binary(bytes)
    }
}

/// Titles of binary files may begin with `solid` too, so that a size that fits its count speaks for binary.
fn is_ascii(bytes: &[u8]) -> bool {
    let fits_binary = count(bytes).is_some_and(|n| bytes.len() == HEADER + RECORD * n);
    let text = String::from_utf8_lossy(bytes);
    !fits_binary && text.trim_start().starts_with("solid") && (text.contains("facet") || text.contains("endsolid"))
}

/// The number of triangles that a binary file promises.
fn count(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.first_chunk()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

fn parse_binary(bytes: &[u8]) -> Result<RawMesh, Problem> {
    let cut = || Problem::Truncated(format!("{} bytes are too few for a binary STL header", bytes.len()));
    let promised = count(bytes).ok_or_else(cut)?;
    let (records, _) = bytes[HEADER..].as_chunks::<RECORD>();
    if records.len() < promised {
        return Err(Problem::Truncated(format!(
            "{} of {promised} triangles are there",
            records.len()
        )));
    }
    let mut soup = Welder::default();
    for record in &records[..promised] {
        let (floats, _) = record.as_chunks::<4>();
        let number = |i: usize| f32::from_le_bytes(floats[i]);
        soup.push([3, 6, 9].map(|i| Vec3::new(number(i), number(i + 1), number(i + 2))));
    }
    Ok(soup.mesh)
}

fn parse_ascii(text: &str) -> Result<RawMesh, Problem> {
    let mut soup = Welder::default();
    let mut corners = Vec::with_capacity(3);
    let mut ended = false;
    for (number, line) in text.lines().enumerate().map(|(i, line)| (i + 1, line.trim())) {
        let malformed = |what: &str| Problem::Malformed(format!("line {number}: {what}: {line}"));
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vertex") => {
                corners.push(three_floats(&mut words).ok_or_else(|| malformed("a vertex needs three numbers"))?);
            }
            Some("endloop") => {
                let triangle = <[Vec3; 3]>::try_from(corners.as_slice());
                soup.push(triangle.map_err(|_| malformed("a facet needs three vertices"))?);
                corners.clear();
            }
            Some("solid") => ended = false,
            Some("endsolid") => ended = true,
            _ => {}
        }
    }
    if ended && corners.is_empty() {
        Ok(soup.mesh)
    } else {
        Err(Problem::Truncated(format!(
            "`endsolid` is missing after {} triangles",
            soup.mesh.triangles.len()
        )))
    }
}

/// Gives corners at exactly the same position one vertex, in order of first appearance.
#[derive(Default)]
struct Welder {
    mesh: RawMesh,
    vertices: HashMap<[u32; 3], u32>,
}

impl Welder {
    fn push(&mut self, triangle: [Vec3; 3]) {
        let corners = triangle.map(|position| {
            // + 0.0 makes -0 and 0 the same bits.
            let key = (position + 0.0).to_array().map(f32::to_bits);
            *self.vertices.entry(key).or_insert_with(|| {
                self.mesh.positions.push(position);
                self.mesh.positions.len() as u32 - 1
            })
        });
        self.mesh.triangles.push(corners);
    }
}
