//! Wavefront OBJ: bytes in, positions and faces out; everything else in the file is passed over.
//!
//! Written by hand because `tobj` splits a file into models and numbers each model's vertices by their first use in a
//! face, so that neither the file's order nor its unused vertices survive.

use super::{Problem, RawMesh, push_polygon, three_floats};

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Problem> {
    let mut mesh = RawMesh::default();
    let mut faces = Faces::default();
    // A backslash at the end of a line continues it. Comments may be in any encoding.
    let text = String::from_utf8_lossy(bytes)
        .replace("\\\r\n", " ")
        .replace("\\\n", " ");
    for (number, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => mesh
                .positions
                .push(three_floats(&mut words).ok_or_else(|| malformed(number, line, "a vertex needs three numbers"))?),
            Some("f") => faces
                .push(words, mesh.positions.len())
                .ok_or_else(|| malformed(number, line, "a face needs three or more vertex indices"))?,
            _ => {}
        }
    }
    mesh.triangles = faces.triangulate(mesh.positions.len())?;
    Ok(mesh)
}

fn malformed(number: usize, line: &str, needs: &str) -> Problem {
    Problem::Malformed(format!("line {}: {needs}: {}", number + 1, line.trim()))
}

/// Polygons with indices from 0, not yet checked: a face may stand before the vertices that it names.
#[derive(Default)]
struct Faces {
    corners: Vec<i64>,
    ends: Vec<usize>,
}

impl Faces {
    /// Takes the corners `v`, `v/vt`, `v//vn`, `v/vt/vn` of one face; negative indices count back from the last vertex.
    fn push<'a>(&mut self, words: impl Iterator<Item = &'a str>, vertices: usize) -> Option<()> {
        let begin = self.corners.len();
        for word in words {
            let index: i64 = word.split('/').next()?.parse().ok()?;
            // 0 is no index in OBJ; as -1 it is found out of range below.
            self.corners.push(if index < 0 {
                (vertices as i64).checked_add(index)?
            } else {
                index - 1
            });
        }
        self.ends.push(self.corners.len());
        (self.corners.len() - begin >= 3).then_some(())
    }

    fn triangulate(&self, vertices: usize) -> Result<Vec<[u32; 3]>, Problem> {
        let mut triangles = Vec::with_capacity(self.ends.len());
        let mut polygon = Vec::new();
        let mut begin = 0;
        for (face, &end) in self.ends.iter().enumerate() {
            polygon.clear();
            for &corner in &self.corners[begin..end] {
                let index = u32::try_from(corner).ok().filter(|&i| (i as usize) < vertices);
                let out_of_range = || Problem::IndexOutOfRange {
                    face: face + 1,
                    index: corner + 1,
                    vertices,
                };
                polygon.push(index.ok_or_else(out_of_range)?);
            }
            push_polygon(&mut triangles, &polygon);
            begin = end;
        }
        Ok(triangles)
    }
}
