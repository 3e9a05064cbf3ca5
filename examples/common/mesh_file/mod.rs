//! Reads triangle meshes and per-vertex fields from files.
//!
//! In: an OBJ, PLY or STL file. Out: a [`RawMesh`] in the file's *own* vertex list and order, so that a list with one
//! value per vertex of the file (a curvature direction computed elsewhere, say) fits it. Asset loaders do not give
//! that: they split vertices at seams and drop unused ones. Polygons become fans around their first corner.
//! Every failure is a [`MeshFileError`] of one line; no file makes these readers panic.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

use bevy::{
    asset::RenderAssetUsages,
    mesh::{Indices, Mesh, PrimitiveTopology},
    prelude::*,
};
use thiserror::Error;

mod obj;
mod ply;
mod stl;

/// A triangle mesh as its file lists it: positions in the file's order (used by a face or not), then corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RawMesh {
    /// One position per vertex of the file, finite, in the file's unit of length.
    pub positions: Vec<Vec3>,
    /// Three indices into `positions` per triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A file that cannot be read, and why.
#[derive(Error, Debug)]
#[error("{}: {problem}", path.display())]
pub struct MeshFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: Problem,
}

/// What is wrong with a mesh or field file.
#[derive(Error, Debug)]
pub enum Problem {
    /// The file is missing, is a folder, may not be read…
    #[error("cannot be read: {0}")]
    Io(#[from] io::Error),
    /// The file name's ending is none that is known.
    #[error("unknown kind of mesh file; known are .obj, .ply, .stl")]
    UnknownKind,
    /// glTF carries materials, skins and node transforms that a [`RawMesh`] has no place for.
    #[error("glTF is read by Bevy's AssetServer, not by this reader; convert it to .obj, .ply or .stl")]
    Gltf,
    /// The file ends before what its header promises.
    #[error("the file is cut short: {0}")]
    Truncated(String),
    /// A line or a record does not follow the format.
    #[error("{0}")]
    Malformed(String),
    /// A face names a vertex that the file does not have.
    #[error("face {face} names vertex {index}, but the file has {vertices} vertices")]
    IndexOutOfRange {
        /// Which face, counted from 1.
        face: usize,
        /// The index as it stands in the file.
        index: i64,
        /// How many vertices there are to name.
        vertices: usize,
    },
    /// The file holds points or lines only, or nothing.
    #[error("there are no triangles in it")]
    NoTriangles,
    /// A coordinate is NaN, infinite or beyond the range of `f32`.
    #[error("{what} {number} is not finite")]
    NotFinite {
        /// "vertex" or "line".
        what: &'static str,
        /// Which one, counted from 1.
        number: usize,
    },
    /// A field file has another number of lines than the mesh has vertices.
    #[error("it holds {found} directions, but the mesh file has {expected} vertices")]
    FieldLength {
        /// Lines with values.
        found: usize,
        /// Vertices of the mesh file.
        expected: usize,
    },
}

/// Reads the mesh in `path`; the ending of the name tells its format.
///
/// * `.obj`: polygons, negative indices, several objects and groups (one common list of vertices, as in the file).
/// * `.ply`: ASCII and binary of both byte orders, any scalar and list types.
/// * `.stl`: ASCII and binary; corners at exactly the same position become one vertex, in order of first appearance.
///
/// # Errors
///
/// See [`Problem`].
pub fn read(path: impl AsRef<Path>) -> Result<RawMesh, MeshFileError> {
    let path = path.as_ref();
    parse(path).map_err(|problem| MeshFileError {
        path: path.to_owned(),
        problem,
    })
}

fn parse(path: &Path) -> Result<RawMesh, Problem> {
    let kind = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    let reader = match kind.as_str() {
        "obj" => obj::parse,
        "ply" => ply::parse,
        "stl" => stl::parse,
        "gltf" | "glb" => return Err(Problem::Gltf),
        _ => return Err(Problem::UnknownKind),
    };
    let mesh = reader(&fs::read(path)?)?;
    if mesh.triangles.is_empty() {
        return Err(Problem::NoTriangles);
    }
    match mesh.positions.iter().position(|p| !p.is_finite()) {
        Some(vertex) => Err(Problem::NotFinite {
            what: "vertex",
            number: vertex + 1,
        }),
        None => Ok(mesh),
    }
}

/// Reads one direction per vertex: lines `x y z`, in the order of the mesh file's `expected` vertices.
///
/// Blank lines and lines that begin with `#` do not count. The directions are given back as they stand: of any length,
/// tangent or not.
///
/// # Errors
///
/// A line that is not three finite numbers; another number of lines than `expected`.
pub fn read_field(path: impl AsRef<Path>, expected: usize) -> Result<Vec<Vec3>, MeshFileError> {
    Ok(read_rows(path, expected)?.into_iter().map(Vec3::from_array).collect())
}

/// Reads a row of `N` numbers per vertex, as [`read_field`] does.
///
/// # Errors
///
/// A line that is not `N` finite numbers; another number of lines than `expected`.
pub fn read_rows<const N: usize>(path: impl AsRef<Path>, expected: usize) -> Result<Vec<[f32; N]>, MeshFileError> {
    let path = path.as_ref();
    parse_rows(path, expected).map_err(|problem| MeshFileError {
        path: path.to_owned(),
        problem,
    })
}

fn parse_rows<const N: usize>(path: &Path, expected: usize) -> Result<Vec<[f32; N]>, Problem> {
    let text = fs::read(path)?;
    let mut rows = Vec::with_capacity(expected);
    for (number, line) in String::from_utf8_lossy(&text)
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
    {
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let numbers: Option<Vec<f32>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
        let row = numbers.and_then(|numbers| <[f32; N]>::try_from(numbers).ok());
        let row = row.ok_or_else(|| Problem::Malformed(format!("line {number} is not {N} numbers: {line}")))?;
        if row.iter().any(|number| !number.is_finite()) {
            return Err(Problem::NotFinite { what: "line", number });
        }
        rows.push(row);
    }
    if rows.len() == expected {
        Ok(rows)
    } else {
        Err(Problem::FieldLength {
            found: rows.len(),
            expected,
        })
    }
}

/// A Bevy mesh with the same vertices in the same order, 32-bit indices and smooth normals.
pub fn to_bevy_mesh(raw: &RawMesh) -> Mesh {
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, raw.positions.clone())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, smooth_normals(raw))
        .with_inserted_indices(Indices::U32(raw.triangles.as_flattened().to_vec()))
}

/// Normals weighted by the angles of the corners; +y at a vertex without a face of some area.
///
/// `Mesh::compute_smooth_normals` takes the corners of triangles with sides below about 0.02 for degenerate, which
/// leaves a fine mesh without normals. This does not depend on the unit of length.
pub fn smooth_normals(raw: &RawMesh) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; raw.positions.len()];
    for &triangle in &raw.triangles {
        let corners = triangle.map(|vertex| raw.positions[vertex as usize]);
        for i in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(i + k) % 3]);
            if let (Some(ab), Some(ac)) = ((b - a).try_normalize(), (c - a).try_normalize()) {
                let normal = ab.cross(ac);
                normals[triangle[i] as usize] += normal.normalize_or_zero() * normal.length().atan2(ab.dot(ac));
            }
        }
    }
    normals.into_iter().map(|normal| normal.normalize_or(Vec3::Y)).collect()
}

/// The next three words as numbers; `None` when one is missing or is no number.
fn three_floats<'a>(words: &mut impl Iterator<Item = &'a str>) -> Option<Vec3> {
    let mut float = || words.next()?.parse().ok();
    Some(Vec3::new(float()?, float()?, float()?))
}

/// Appends a polygon as a fan around its first corner.
fn push_polygon(triangles: &mut Vec<[u32; 3]>, corners: &[u32]) {
    if let [first, rest @ ..] = corners {
        triangles.extend(rest.array_windows().map(|&[a, b]| [*first, a, b]));
    }
}
