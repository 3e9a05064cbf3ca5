//! Stripes and other patterns that follow a tangent field on any triangle mesh, in real time, as a Bevy plugin.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_field_patterns::prelude::*;
//!
//! fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut stripes: ResMut<Assets<StripeMaterial>>) {
//!     commands.spawn((
//!         Mesh3d(meshes.add(Torus::default())),
//!         MeshMaterial3d(stripes.add(StripeMaterial::default())),
//!         DirectionField::Axis(Dir3::Y),
//!         Frequency::Uniform(12.0),
//!     ));
//! }
//!
//! App::new().add_plugins((DefaultPlugins, FieldPatternsPlugin)).add_systems(Startup, setup).run();
//! ```
//!
//! An entity holds *state*: a mesh, what the pattern follows ([`DirectionField`](field::DirectionField)) and how dense it
//! is ([`Frequency`](field::Frequency)). A material holds *style* and can be shared by any number of entities. What the
//! plugin knows of a pattern is in its [`PatternState`](wave::PatternState).
//!
//! # The way of the data
//!
//! | room | from | to |
//! |---|---|---|
//! | [`surface`] | a mesh | a graph of welded vertices, its colours and its hierarchy |
//! | [`field`] | the graph and the user's components | a direction d and a frequency f per vertex |
//! | [`wave`] | graph, d, f | a phasor z per vertex, whose phase Φ grows along d by 2πf per unit length |
//! | [`sampling`] | a metric per point | samples, their ellipses and neighbours |
//! | [`cells`] | a sample set | the same on the GPU |
//! | [`material`] | z or cells, and a style | pixels |
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | unit length | of the mesh's own space, unless [`PatternSpace::World`](field::PatternSpace) |
//! | symmetry | `Line`: d and -d are the same (curvature, tensors); `Vector`: they differ (flow, an axis) |
//! | frequency f | stripes (periods) per unit length |
//! | phase Φ, phasor z | z = cis Φ; its modulus tells how sure it is |
//! | sweep | one update of every vertex, colour class by colour class |
//! | energy | weighted mean over the edges of 1 - cos of the phase they are off by: 0 is perfect, 1 random |
//! | metric M | symmetric and positive definite; d² = vᵀMv; its unit ball is the ellipse of one sample |
//! | sample, cell | a point with its metric; the region of points that are nearer to it, in its metric, than to others in theirs |
//! | branch | a triangle around which the phase winds: a stripe begins or ends there |
//!
//! # Sources
//!
//! C. Lichtenberg, N. Smit, C. Hansen, K. Lawonn, *Real-Time Field Aligned Stripe Patterns*, Computers & Graphics, 2018,
//! doi:10.1016/j.cag.2018.04.008. Equation numbers in the documentation of fields and waves are its own.
//!
//! A. Kratz, D. Baum, I. Hotz, *Anisotropic Sampling of Planar and Two-Manifold Domains for Texture Generation and Glyph
//! Distribution*, IEEE Transactions on Visualization and Computer Graphics, 2013, doi:10.1109/TVCG.2013.83. Equation numbers
//! in the documentation of samples and cells are its own.

use bevy::app::{PluginGroup, PluginGroupBuilder};

mod arena;
pub mod cells;
pub mod diagnostics;
pub mod error;
pub mod field;
pub mod material;
mod parallel;
pub mod sampling;
pub mod scene;
pub mod surface;
pub mod wave;

/// What most programs need.
pub mod prelude {
    #[doc(no_inline)]
    pub use crate::{
        FieldPatternsPlugin,
        cells::{CellState, SampleValues, planar_mesh},
        error::PatternError,
        field::{
            Alignment, DirectionField, Eigenvector, Falloff, FieldBuffer, FieldRing, FieldTime, FieldTurn, Frequency,
            Painted, PatternScalars, PatternSpace, Principal, ScalarSource, Sense, SmoothField, Smoothing, Snapshot,
            Symmetry, TensorField, Vortex, VortexCores, VortexField,
        },
        material::{
            BorderWidth, CellDebug, CellFill, CellMaterial, CellMaterial2d, CellShape, CellTexture, Cells, ColorMap,
            DebugStyle, Focus, FocusShape, FocusSource, Patches, PatternDrive, PatternMaterialPlugin, PatternTexture,
            PatternTextureMaterial, Profile, ScalarChannel, ScalarColor, StripeMaterial, StripeWaves, Stripes,
            TextureFade, TextureHeight, TileChoice, Travel,
        },
        material::{
            ChromaDepth, DashAlong, DistanceFrom, Eigenvalue, Hatch, HatchHand, HatchMaterial, HatchOutline,
            HatchStrokes, HatchTone, StrokeSpacing, Tensor, TensorMaterial, ToneSource,
        },
        sampling::{
            AnisotropicSamples, Density, Importance, Metric, MetricSource, SampleSet, SamplesFailed, SamplesReady,
            SamplingState, SpaceFunction, planar::PlanarDomain, surface::SurfaceMethod,
        },
        scene::{PatternScene, PatternScenePart, StyledScene},
        wave::{
            CarriesPattern, CreaseLine, CreasePhase, PatternFailed, PatternMesh, PatternReady, PatternState,
            RestartPattern, SolverSettings, Waves, pose::PatternPose,
        },
    };
}

/// Everything: waves, samples and cells, the materials that draw them, and scenes of patterned meshes.
#[derive(Debug, Default, Clone, Copy)]
pub struct FieldPatternsPlugin;

impl PluginGroup for FieldPatternsPlugin {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(wave::WavePlugin)
            .add(material::StripeMaterialPlugin)
            .add(material::PatternTexturePlugin)
            .add(material::HatchMaterialPlugin)
            .add(material::TensorMaterialPlugin)
            .add(sampling::SamplingPlugin)
            .add(cells::CellPlugin)
            .add(material::CellMaterialPlugin)
            .add(diagnostics::PatternDiagnosticsPlugin)
            .add(scene::PatternScenePlugin)
    }
}

/// The programs of the README compile.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
