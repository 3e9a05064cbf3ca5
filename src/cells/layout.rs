//! How a sample set lies in the GPU's shared buffers; the same words as `layout.wgsl`.
//!
//! | buffer | element | what it holds |
//! |---|---|---|
//! | cells | `u32` | records of entities; per set the ring of each sample (CSR) and the seeds of each triangle |
//! | sites | `vec4<f32>` | three per sample: [`Site`]; and one per sample that has a value |

use crate::arena::Arena;
use bevy::{asset::uuid_handle, prelude::*, render::storage::ShaderBuffer};
use bytemuck::{Pod, Zeroable};
use glam_matrix_extras::SymmetricMat3;

/// The buffer of records, rings and seeds, `array<u32>`. Bind it to a material as storage 100.
pub const CELL_BUFFER: Handle<ShaderBuffer> = uuid_handle!("6f0bd2b0-3f0e-4f3c-9a53-0f4a35b60f06");
/// The buffer of sites and values, `array<vec4<f32>>`. Bind it to a material as storage 101.
pub const SITE_BUFFER: Handle<ShaderBuffer> = uuid_handle!("6f0bd2b0-3f0e-4f3c-9a53-0f4a35b60f07");

/// The samples have values ([`SampleValues`](super::SampleValues)).
pub const FLAG_VALUES: u32 = 1;
/// A record's check word is this exclusive-or its own offset. A tag that is somebody else's finds no record.
pub const CHECK: u32 = 0x5A3C_E117;

/// Who owns which part of the shared buffers of sample sets.
pub type CellArena = Arena<Pool>;

/// The shared buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pool {
    /// Records, rings and seeds.
    Cells,
    /// Sites and values.
    Sites,
}

impl crate::arena::Pool for Pool {
    const ALL: &'static [Self] = &[Self::Cells, Self::Sites];

    fn index(self) -> usize {
        self as usize
    }

    fn handle(self) -> Handle<ShaderBuffer> {
        match self {
            Self::Cells => CELL_BUFFER,
            Self::Sites => SITE_BUFFER,
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Cells => "pattern_cells",
            Self::Sites => "pattern_sites",
        }
    }

    fn element(self) -> u64 {
        match self {
            Self::Cells => 4,
            Self::Sites => 16,
        }
    }
}

/// What the GPU knows of one entity's samples. The entity's `MeshTag` is the record's word offset in the cell buffer; 0 is
/// a record of zeros and means "no cells".
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct CellRecord {
    /// Number of samples; 0: nothing is drawn.
    pub samples: u32,
    /// Number of drawn triangles.
    pub triangles: u32,
    /// `FLAG_*`.
    pub flags: u32,
    /// [`CHECK`] ^ the record's own offset.
    pub check: u32,
    /// `sites[site_base + 3 i ..]` is the [`Site`] of sample i.
    pub site_base: u32,
    /// `cells[offset_base + i] .. cells[offset_base + i + 1]` are the entries of sample i's ring.
    pub offset_base: u32,
    /// `cells[neighbor_base + k]` is a sample of a ring.
    pub neighbor_base: u32,
    /// `cells[seed_base + 3 t + c]` is the sample nearest to corner c of triangle t.
    pub seed_base: u32,
    /// `sites[value_base + i]` is the value of sample i, linear RGBA; where [`FLAG_VALUES`] is set.
    pub value_base: u32,
    /// Mean radius of the samples' ellipses \[length\].
    pub radius: f32,
    /// Unused.
    pub pad: [u32; 2],
    /// Mean of the values, linear RGBA.
    pub mean_value: [f32; 4],
}

/// A sample as the fragment shader needs it (Eq. 11 corrected): the rows of M^(1/2), of which the third, along the normal,
/// is k (major x minor).
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Site {
    /// Position \[length\].
    pub position: [f32; 3],
    /// (λ₁ λ₂)^(-1/4), which is the mean radius √(r₁ r₂) of the ellipse \[length\].
    pub k: f32,
    /// √λ₁ e₁ along the long axis \[1/length\].
    pub major: [f32; 3],
    /// Unused.
    pub pad: f32,
    /// √λ₂ e₂ along the short axis \[1/length\].
    pub minor: [f32; 3],
    /// Unused.
    pub pad_2: f32,
}

impl Site {
    /// The site of a sample: the eigenvectors of its metric in the tangent plane.
    ///
    /// The long axis points to +x of the mesh's space, or to +y where it has no x, so that the textures of neighbours lie
    /// alike. A round sample has its first axis along x.
    pub fn new(position: Vec3, normal: Vec3, metric: SymmetricMat3) -> Self {
        let towards = if normal.x.abs() < 0.9 { Vec3::X } else { Vec3::Y };
        let s = towards
            .reject_from_normalized(normal)
            .normalize_or(normal.any_orthonormal_vector());
        let t = normal.cross(s);
        // The product of two eigenvalues is not within single precision where radii are beyond 1e9.
        let metric = metric.as_symmetric_dmat3();
        let [u, v] = [s, t].map(Vec3::as_dvec3);
        let (a, b, c) = (u.dot(metric * u), u.dot(metric * v), v.dot(metric * v));
        let (mean, half, radius) = (0.5 * (a + c), 0.5 * (a - c), (0.5 * (a - c)).hypot(b));
        // The angle of the large eigenvalue is atan2(b, half) / 2; the long axis is orthogonal to it.
        let round = radius <= 1e-6 * mean;
        let angle = if round { 0.0 } else { 0.5 * (-b).atan2(-half) };
        let mut e1 = s * angle.cos() as f32 + t * angle.sin() as f32;
        if e1.dot(towards) < 0.0 {
            e1 = -e1;
        }
        let large = mean + radius;
        // As the product of the eigenvalues over the large one: exact for long ellipses too.
        let small = ((a * c - b * b) / large).max(large * 1e-12);
        let k = (small * large).powf(-0.25);
        Self {
            position: position.to_array(),
            k: k as f32,
            major: (e1 * small.sqrt() as f32).to_array(),
            pad: 0.0,
            minor: (normal.cross(e1) * large.sqrt() as f32).to_array(),
            pad_2: 0.0,
        }
    }

    /// M^(1/2) (x - p): the point as seen by the sample, whose ellipse is the unit ball.
    pub fn metric_offset(&self, x: Vec3) -> Vec3 {
        let (major, minor) = (Vec3::from(self.major), Vec3::from(self.minor));
        let r = x - Vec3::from(self.position);
        Vec3::new(major.dot(r), minor.dot(r), self.k * major.cross(minor).dot(r))
    }

    /// M (x - p): half the gradient of the squared distance, from the metric offset.
    pub fn gradient(&self, offset: Vec3) -> Vec3 {
        let (major, minor) = (Vec3::from(self.major), Vec3::from(self.minor));
        major * offset.x + minor * offset.y + self.k * major.cross(minor) * offset.z
    }
}
