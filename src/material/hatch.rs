//! `HatchMaterial`: a surface drawn with strokes.
//!
//! In: [`Hatch`], the style (where a tone comes from, how strokes are made of it, ink and paper). Out: uniforms and the
//! three shared buffers for `hatch.wgsl`, which makes a tone of light, of a scalar or of a distance, strokes of the tone
//! (`hatch_strokes.wgsl`), and lines where the surface turns out of sight (`hatch_outline.wgsl`).

use super::{
    DistanceFrom, Focus, FocusShape, Hatch, HatchTone, ToneSource,
    binding::{bind_as, pattern_shaders},
    focus::FocusUniform,
    hatch_options::{apart, carry_tone},
    pattern_prepass_fragment_shader,
    style::{WaveStyle, WaveStylePlugin, select_variant},
};
use crate::wave::{
    StyleNeeds,
    layout::{GEOMETRY_BUFFER, SURFACE_BUFFER, WAVE_BUFFER},
};
use bevy::{
    asset::{AssetEventSystems, embedded_asset},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline, MaterialPlugin},
    prelude::*,
    render::{
        render_resource::{AsBindGroup, RenderPipelineDescriptor, ShaderType, SpecializedMeshPipelineError},
        storage::ShaderBuffer,
    },
};

/// [`StandardMaterial`] drawn with strokes along the entity's wave: those of a darker tone contain those of a lighter one,
/// and so do those seen from near. Entities without a pattern, or whose pattern is not solved yet, show the base.
///
/// Works in forward and deferred rendering, in shadow maps and in the depth, normal and motion vector prepasses, with
/// skins, morph targets and fog.
pub type HatchMaterial = ExtendedMaterial<StandardMaterial, Hatch>;

/// Draws [`HatchMaterial`].
#[derive(Debug, Clone, Copy, Default)]
pub struct HatchMaterialPlugin;

impl Plugin for HatchMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins((
            MaterialPlugin::<HatchMaterial>::default(),
            WaveStylePlugin::<Hatch>::default(),
        ))
        .register_type::<Hatch>()
        .register_type::<ToneSource>()
        .register_asset_reflect::<HatchMaterial>()
        .add_systems(
            PostUpdate,
            carry_tone.after(TransformSystems::Propagate).before(AssetEventSystems),
        );
        embedded_asset!(app, "hatch.wgsl");
    }
}

/// `struct Hatch` of `hatch_style.wgsl`.
#[derive(ShaderType, Debug, Clone, Default)]
struct HatchUniform {
    ink: Vec4,
    paper: Vec4,
    tone: Vec4,
    origin: Vec4,
    strokes: Vec4,
    hand: Vec4,
    outline: Vec4,
    chroma: Vec4,
    focus: FocusUniform,
    source: u32,
    filter_width: f32,
}

/// What the shaders bind.
#[derive(AsBindGroup, Clone)]
struct HatchBinding {
    #[storage(100, read_only, visibility(fragment))]
    surface: Handle<ShaderBuffer>,
    #[storage(101, read_only, visibility(fragment))]
    geometry: Handle<ShaderBuffer>,
    #[storage(102, read_only, visibility(fragment))]
    waves: Handle<ShaderBuffer>,
    #[uniform(103, visibility(fragment))]
    style: HatchUniform,
}

impl Hatch {
    fn binding(&self) -> HatchBinding {
        // A bound of `clamp` must be a number.
        let lightest = self.lightest.max(0.0).clamp(0.0, 1.0);
        let shares = match self.tone {
            HatchTone::Constant(share) => Vec2::splat(share.clamp(0.0, 1.0)),
            _ => Vec2::new(lightest, self.darkest.clamp(lightest, 1.0)),
        };
        let range = self.tone.range();
        let origin = match self.tone {
            HatchTone::Distance {
                from: DistanceFrom::Point(point),
                ..
            } => point,
            _ => Vec3::ZERO,
        };
        let (strokes, hand, outline, chroma) = (&self.strokes, &self.hand, &self.outline, &self.chroma_depth);
        let unit = |value: f32| value.clamp(0.0, 1.0);
        let depths = apart(chroma.near, chroma.far);
        let style = HatchUniform {
            ink: self.ink.to_vec4(),
            paper: self.paper.to_vec4(),
            tone: Vec4::new(range.x, range.y, shares.x, shares.y),
            origin: origin.extend(unit(hand.ink)),
            strokes: Vec4::new(
                strokes.width.clamp(0.01, 1.0),
                unit(strokes.density),
                strokes.spacing.pixels(),
                unit(strokes.cross_from),
            ),
            hand: Vec4::new(
                unit(hand.width),
                unit(hand.length),
                hand.wobble.clamp(0.0, 0.25),
                unit(strokes.softness),
            ),
            outline: Vec4::new(
                outline.width.max(0.0),
                outline.dash.max(0.0),
                unit(outline.gap),
                outline.along as u32 as f32,
            ),
            chroma: Vec4::new(depths.x, depths.y, unit(chroma.ink), unit(chroma.paper)),
            focus: self.focus.uniform(),
            source: self.tone.source(),
            filter_width: if self.anti_aliasing { 1.0 } else { 0.0 },
        };
        HatchBinding {
            surface: SURFACE_BUFFER,
            geometry: GEOMETRY_BUFFER,
            waves: WAVE_BUFFER,
            style,
        }
    }
}

/// Settings that select a variant of the shaders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct HatchKey {
    light: bool,
    lit: bool,
    cutout: bool,
    outline: bool,
}

impl Hatch {
    fn key(&self) -> HatchKey {
        let light = matches!(self.tone, HatchTone::Light { .. });
        HatchKey {
            light,
            lit: light || self.paper.alpha < 1.0 || self.focus.shape != FocusShape::Everywhere,
            cutout: self.cutout,
            outline: self.outline.width > 0.0,
        }
    }
}

bind_as!(Hatch => HatchBinding, HatchKey, "hatch");

impl WaveStyle for Hatch {
    fn focus(&self) -> &Focus {
        &self.focus
    }

    fn focus_mut(&mut self) -> &mut Focus {
        &mut self.focus
    }

    fn needs(&self) -> StyleNeeds {
        StyleNeeds::default()
    }

    fn is_cutout(&self) -> bool {
        self.cutout
    }

    fn needs_light(&self) -> bool {
        matches!(self.tone, HatchTone::Light { .. })
    }
}

impl MaterialExtension for Hatch {
    pattern_shaders!(super::embedded("hatch.wgsl"), pattern_prepass_fragment_shader());

    fn specialize(
        _: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let HatchKey {
            light,
            lit,
            cutout,
            outline,
        } = key.bind_group_data;
        let variants = [
            (true, "PATTERN_HATCH"),
            (cutout, "PATTERN_CUTOUT"),
            (light, "HATCH_LIGHT"),
            (lit, "HATCH_LIT"),
            (outline, "HATCH_OUTLINE"),
        ];
        select_variant(descriptor, layout, &variants)
    }
}
