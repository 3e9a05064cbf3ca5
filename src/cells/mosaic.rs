//! The colours of an image under samples.

use super::SampleValues;
use crate::{error::PatternError, sampling::SampleSet, surface::triangle_soup};
use bevy::{mesh::VertexAttributeValues, prelude::*};

impl SampleValues {
    /// The colour of an image at each sample: the stones of a mosaic. Places outside the image take its nearest edge.
    ///
    /// `uvs` are [`planar_uvs`](super::planar_uvs) or [`mesh_uvs`]. `None`, where the image has no texels in the main
    /// world or a format that cannot be read there (Bevy's `Image::get_color_at`).
    pub fn from_image(image: &Image, uvs: impl IntoIterator<Item = Vec2>) -> Option<Self> {
        let size = image.size();
        let texel = |uv: f32, texels: u32| ((uv * texels as f32) as u32).min(texels.saturating_sub(1));
        let color = |uv: Vec2| {
            let color = image.get_color_at(texel(uv.x, size.x), texel(uv.y, size.y)).ok()?;
            Some(color.to_linear())
        };
        uvs.into_iter().map(color).collect::<Option<Vec<_>>>().map(Self)
    }
}

/// The UV of a mesh under each sample of a set on its surface.
///
/// # Errors
/// [`MissingAttribute`](PatternError::MissingAttribute) and [`AttributeFormat`](PatternError::AttributeFormat) where the
/// mesh has no `Mesh::ATTRIBUTE_UV_0`, [`SampleLists`](PatternError::SampleLists) and
/// [`SampleIndex`](PatternError::SampleIndex) where the set is another mesh's, and those of [`triangle_soup`].
pub fn mesh_uvs(set: &SampleSet, mesh: &Mesh) -> Result<Vec<Vec2>, PatternError> {
    let soup = triangle_soup(mesh)?;
    let name = || Mesh::ATTRIBUTE_UV_0.name.to_owned();
    let uvs = match mesh.try_attribute(Mesh::ATTRIBUTE_UV_0) {
        Ok(VertexAttributeValues::Float32x2(uvs)) => uvs,
        Ok(other) => {
            return Err(PatternError::AttributeFormat {
                name: name(),
                found: format!("{:?}", bevy::mesh::VertexFormat::from(other)),
                expected: "Float32x2",
            });
        }
        Err(_) => return Err(PatternError::MissingAttribute(name())),
    };
    for (what, found) in [
        ("triangles", set.triangles.len()),
        ("barycentrics", set.barycentrics.len()),
    ] {
        if found != set.len() {
            let expected = set.len();
            return Err(PatternError::SampleLists { what, found, expected });
        }
    }
    let under = |(&triangle, weights): (&u32, &Vec3)| match soup.triangles.get(triangle as usize) {
        Some(corners) => Ok((0..3).map(|c| Vec2::from(uvs[corners[c] as usize]) * weights[c]).sum()),
        None => Err(PatternError::SampleIndex {
            what: "triangle",
            index: triangle,
            samples: set.len(),
        }),
    };
    set.triangles.iter().zip(&set.barycentrics).map(under).collect()
}
