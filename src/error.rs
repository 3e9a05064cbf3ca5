//! What can go wrong with a user's data, said so that the user can mend it.

use bevy::prelude::*;
use thiserror::Error;

/// Why a pattern cannot be prepared, solved or drawn.
///
/// It is set on the entity's `PatternState` and logged once; the entity is drawn with its base material meanwhile.
#[derive(Error, Debug, Clone, PartialEq, Reflect)]
#[non_exhaustive]
pub enum PatternError {
    /// The mesh has no `Mesh::ATTRIBUTE_POSITION` of format `Float32x3`.
    #[error("the mesh has no vertex positions (Float32x3); give it Mesh::ATTRIBUTE_POSITION")]
    NoPositions,
    /// The mesh has no triangle with an area.
    #[error("the mesh has no triangles; a pattern needs at least one triangle with an area")]
    NoTriangles,
    /// A point cloud is too small to be a surface.
    #[error("the point cloud has {0} points at different places; a pattern needs at least three")]
    TooFewPoints(usize),
    /// The mesh is a list of lines, or one of points where triangles are needed.
    #[error("the mesh's topology is {0}; use a triangle list or a triangle strip (for waves, a point list will do)")]
    Topology(String),
    /// The mesh's data lives in the render world only.
    #[error("the mesh's data was already moved to the GPU; load it with RenderAssetUsages::MAIN_WORLD | RENDER_WORLD")]
    MeshDataTaken,
    /// A position, direction or frequency is NaN or infinite.
    #[error("{what} {index} is not finite")]
    NotFinite {
        /// What kind of value: "position of vertex", "direction of vertex", "frequency of vertex".
        what: &'static str,
        /// The index of the first such value.
        index: usize,
    },
    /// A setting, of which there is one, is NaN or infinite.
    #[error("{0} is not finite")]
    SettingNotFinite(&'static str),
    /// An index points behind the last vertex.
    #[error("triangle index {index} is out of range: the mesh has {vertices} vertices")]
    IndexOutOfRange {
        /// The offending index.
        index: u32,
        /// Number of the mesh's vertices.
        vertices: usize,
    },
    /// The mesh lacks the attribute that the field or the frequency names.
    #[error("the mesh has no vertex attribute `{0}`")]
    MissingAttribute(String),
    /// The attribute has another format than the one needed.
    #[error("the vertex attribute `{name}` has format {found}, but {expected} is needed")]
    AttributeFormat {
        /// The attribute's name.
        name: String,
        /// The format it has.
        found: String,
        /// The format needed.
        expected: &'static str,
    },
    /// A list of per-vertex values has the wrong length.
    #[error("{what}: {found} values were given, but {expected} are needed, one per vertex of the mesh")]
    WrongLength {
        /// What the list is: "directions", "frequencies".
        what: &'static str,
        /// Length of the list.
        found: usize,
        /// Length needed.
        expected: usize,
    },
    /// The frequency is negative.
    #[error("the frequency {0} is negative; frequencies are stripes per unit length, 0 or more")]
    NegativeFrequency(f32),
    /// The GPU offers less than a pattern needs.
    #[error("the GPU's limit {limit} is {found}, but patterns need {needed}")]
    GpuLimit {
        /// Name of the limit, as in `wgpu::Limits`.
        limit: &'static str,
        /// What the device offers.
        found: u64,
        /// What is needed.
        needed: u64,
    },
    /// A shader of the solver does not compile on this device.
    #[error("a compute pipeline of the solver failed: {0}")]
    Pipeline(String),
    /// The entity carries a `MeshTag` that the plugin did not set.
    #[error("the entity has a MeshTag of its own; patterns need the tag, remove it")]
    MeshTagTaken,
    /// The style needs a vector field.
    #[error("{0} needs Symmetry::Vector: on a line field d and -d are the same, and only sin \u{3a6} is defined")]
    NeedsVectorSymmetry(&'static str),
    /// The style needs two waves.
    #[error("{0} needs two waves; give the entity Waves::Orthogonal or Waves::Cross")]
    NeedsTwoWaves(&'static str),
    /// The style draws one wave of a cross field.
    #[error("{0} is one of two waves, but those of Waves::Cross cannot be told apart; draw StripeWaves::Both")]
    NeedsBothWaves(&'static str),
    /// The entity is a point cloud, whose points have no triangles to take normals from.
    #[error("a point cloud cannot be posed; give it PatternPose::Rest")]
    LiveCloud,
    /// A metric has an eigenvalue that is not above zero.
    #[error("{what} {index} is not positive definite; d² = vᵀMv must be above 0 for every direction v")]
    NotPositive {
        /// What kind of metric: "metric of vertex", "metric at sample".
        what: &'static str,
        /// The index of the first such metric.
        index: usize,
    },
    /// An option is outside its range.
    #[error("{what} is {value}, but must be {expected}")]
    OutOfRange {
        /// Name of the option.
        what: &'static str,
        /// Its value.
        value: f32,
        /// Its range in words.
        expected: &'static str,
    },
    /// The planar domain cannot be sampled.
    #[error("the domain cannot be sampled: {0}")]
    Domain(&'static str),
    /// An image cannot be read.
    #[error("the image cannot be read on the CPU: {0}")]
    Image(String),
    /// The crate was built without a feature that an option needs.
    #[error("this needs the feature `{0}` of bevy_field_patterns; enable it in Cargo.toml")]
    MissingFeature(&'static str),
    /// The work was stopped by its owner.
    #[error("the sampling was cancelled")]
    Cancelled,
    /// A list of a sample set or of its values has the wrong length.
    #[error(
        "{found} {what} were given, but {expected} are needed; a set is drawn on the mesh that it was sampled from"
    )]
    SampleLists {
        /// What the list holds: "normals", "seeds of triangles".
        what: &'static str,
        /// Length of the list.
        found: usize,
        /// Length needed.
        expected: usize,
    },
    /// An index of a sample set points behind the last sample.
    #[error("{what} {index} is out of range: the set has {samples} samples")]
    SampleIndex {
        /// What the index is: "neighbour", "seed".
        what: &'static str,
        /// The offending index.
        index: u32,
        /// Number of samples.
        samples: usize,
    },
    /// The field or the frequency depends on more than a mesh.
    #[error("this source depends on more than a mesh; for the CPU use bevy_field_patterns::field::{0}")]
    NotOfMesh(&'static str),
    /// An entity that an input names is gone or lacks something.
    #[error("{what} names the entity {entity}, which does not exist or has no {lacks}")]
    MissingEntity {
        /// The input: "`Frequency::DistanceTo`".
        what: &'static str,
        /// The entity.
        entity: Entity,
        /// What it should have: "`GlobalTransform`".
        lacks: &'static str,
    },
    /// A pattern cannot be carried.
    #[error("CarriesPattern: {0}")]
    Carried(&'static str),
    /// There are no scalars to follow.
    #[error("{0} needs scalars; give the entity DirectionField::Tensor or PatternScalars")]
    NoScalars(&'static str),
    /// The snapshots of a field are no sequence.
    #[error("DirectionField::Snapshots: {0}")]
    Snapshots(&'static str),
    /// A user's buffer has the wrong size.
    #[error("the buffer of {what} has {found} bytes, but {needed} are needed, one value per vertex of the mesh")]
    BufferSize {
        /// What it is for: "`DirectionField::Buffer`".
        what: &'static str,
        /// Its size.
        found: u64,
        /// The size needed.
        needed: u64,
    },
    /// A user's buffer cannot be copied.
    #[error("the buffer of {0} cannot be copied; create it with BufferUsages::COPY_SRC")]
    BufferUsage(&'static str),
    /// The entity carries a field and samples, but can be drawn with one pattern only.
    #[error("the entity has a DirectionField and a SampleSet; draw waves and cells on two entities with the same mesh")]
    TwoPatterns,
    /// There is nothing to draw cells on.
    #[error("the entity has cells to draw, but no mesh; give it a Mesh3d, or a Mesh2d for a planar set")]
    NoMesh,
}
