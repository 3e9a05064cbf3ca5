//! Simplification of the refined mesh (quadric error metrics, by meshopt): how samples get triangles between them.
//!
//! In: a [`FineMesh`], and vertices to keep or a number to keep. Out: triangles between vertices of the mesh, all of them on
//! the surface. Needs the crate's feature `meshopt`.

use super::mesh::FineMesh;
#[cfg(not(feature = "meshopt"))]
use crate::error::PatternError;
#[cfg(feature = "meshopt")]
use crate::{error::PatternError, sampling::surface::mesh::NONE};

/// Triangles between the vertices to `keep`, given as indices into that list. What simplification cannot remove besides
/// (some vertices of thin handles) is joined to a neighbour that is kept.
#[cfg(feature = "meshopt")]
pub(super) fn triangles_between(mesh: &FineMesh, keep: &[u32]) -> Result<Vec<[u32; 3]>, PatternError> {
    let mut names = vec![NONE; mesh.len()];
    for (name, &v) in keep.iter().enumerate() {
        names[v as usize] = name as u32;
    }
    let locks: Vec<bool> = names.iter().map(|&name| name != NONE).collect();
    let triangles = simplified(mesh, &locks, 0);
    // Joins the vertices that are left, ring by ring.
    loop {
        let joined: Vec<(u32, u32)> = triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)])
            .filter(|&(a, b)| names[a as usize] == NONE && names[b as usize] != NONE)
            .map(|(a, b)| (a, names[b as usize]))
            .collect();
        if joined.is_empty() {
            break;
        }
        for (vertex, name) in joined.into_iter().rev() {
            names[vertex as usize] = name;
        }
    }
    let renamed = triangles.into_iter().map(|t| t.map(|v| names[v as usize]));
    Ok(renamed
        .filter(|&[a, b, c]| a != b && b != c && c != a && a.max(b).max(c) != NONE)
        .collect())
}

/// About `vertices` vertices of the mesh that keep its shape, and the triangles between them, as indices into that list.
#[cfg(feature = "meshopt")]
pub(super) fn coarse_mesh(mesh: &FineMesh, vertices: usize) -> Result<(Vec<u32>, Vec<[u32; 3]>), PatternError> {
    // A closed surface has twice as many triangles as vertices.
    let triangles = simplified(mesh, &vec![false; mesh.len()], 2 * vertices);
    let mut names = vec![NONE; mesh.len()];
    let mut kept = Vec::new();
    let renamed = triangles.iter().map(|triangle| {
        triangle.map(|v| {
            if names[v as usize] == NONE {
                names[v as usize] = kept.len() as u32;
                kept.push(v);
            }
            names[v as usize]
        })
    });
    let renamed = renamed.collect();
    Ok((kept, renamed))
}

#[cfg(feature = "meshopt")]
fn simplified(mesh: &FineMesh, locks: &[bool], triangles: usize) -> Vec<[u32; 3]> {
    let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|p| p.to_array()).collect();
    let options = meshopt::SimplifyOptions::None;
    let indices = mesh.triangles.as_flattened();
    let left = meshopt::simplify_with_locks_decoder(indices, &positions, locks, 3 * triangles, f32::MAX, options, None);
    left.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect()
}

/// The feature is off.
#[cfg(not(feature = "meshopt"))]
pub(super) fn triangles_between(_: &FineMesh, _: &[u32]) -> Result<Vec<[u32; 3]>, PatternError> {
    Err(PatternError::MissingFeature("meshopt"))
}

/// The feature is off.
#[cfg(not(feature = "meshopt"))]
pub(super) fn coarse_mesh(_: &FineMesh, _: usize) -> Result<(Vec<u32>, Vec<[u32; 3]>), PatternError> {
    Err(PatternError::MissingFeature("meshopt"))
}
