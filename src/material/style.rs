//! What all styles of waves have in common.
//!
//! In: materials that extend [`StandardMaterial`] by a [`WaveStyle`]. Out: what a style asks of an entity's pattern, told to
//! the solver as [`StyleNeeds`], and bases that may discard where a style cuts out, drawn forward where it needs the light.

use super::{
    Focus, FocusSource, PatternMaterialPlugin, binding::need_positions, focus_source::carry_focus, numbers::put_right,
};
use crate::{field::DirectionField, wave::StyleNeeds};
use bevy::{
    asset::AssetEventSystems,
    material::OpaqueRendererMethod,
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension},
    platform::collections::HashMap,
    prelude::*,
    reflect::Reflectable,
    render::render_resource::{RenderPipelineDescriptor, SpecializedMeshPipelineError},
};
use std::{fmt::Debug, marker::PhantomData};

/// A style that is drawn by `pattern_material.wgsl` and `pattern_prepass.wgsl`.
pub(super) trait WaveStyle: MaterialExtension + Reflectable + FromReflect + Default + Debug + PartialEq {
    /// Where the style applies.
    fn focus(&self) -> &Focus;
    fn focus_mut(&mut self) -> &mut Focus;
    /// What the style asks of a pattern.
    fn needs(&self) -> StyleNeeds;
    /// Whether the style discards fragments.
    fn is_cutout(&self) -> bool;
    /// Whether the style is drawn after the lighting.
    fn needs_light(&self) -> bool {
        false
    }
}

/// A [`StandardMaterial`] with a style of waves.
pub type Styled<S> = ExtendedMaterial<StandardMaterial, S>;

/// A style that a [`StyledScene`](crate::scene::StyledScene) can give to its meshes and a [`FocusSource`] can limit.
pub trait SceneStyle: MaterialExtension + Reflectable + FromReflect + Default + Debug + PartialEq {
    /// Where the style applies.
    fn focus(&self) -> &Focus;
    /// Where the style applies, to be changed.
    fn focus_mut(&mut self) -> &mut Focus;
}

impl<S: WaveStyle> SceneStyle for S {
    fn focus(&self) -> &Focus {
        WaveStyle::focus(self)
    }

    fn focus_mut(&mut self) -> &mut Focus {
        WaveStyle::focus_mut(self)
    }
}

/// Adds shader definitions to a fragment shader, those that are true, over a mesh that can be drawn.
pub(super) fn select_variant(
    descriptor: &mut RenderPipelineDescriptor,
    layout: &MeshVertexBufferLayoutRef,
    variants: &[(bool, &'static str)],
) -> Result<(), SpecializedMeshPipelineError> {
    need_positions(layout)?;
    if let Some(fragment) = &mut descriptor.fragment {
        let selected = variants.iter().filter(|variant| variant.0);
        fragment.shader_defs.extend(selected.map(|variant| variant.1.into()));
    }
    Ok(())
}

/// Carries the needs of a style to entities, and keeps its buffers and its masks up to date.
pub(super) struct WaveStylePlugin<S>(PhantomData<S>);

impl<S> Default for WaveStylePlugin<S> {
    fn default() -> Self {
        Self(PhantomData)
    }
}

impl<S: WaveStyle> Plugin for WaveStylePlugin<S> {
    fn build(&self, app: &mut App) {
        app.add_plugins(PatternMaterialPlugin::<Styled<S>>::default())
            .register_type::<FocusSource<S>>()
            .add_systems(
                PostUpdate,
                (
                    carry_focus::<S>
                        .after(TransformSystems::Propagate)
                        .before(AssetEventSystems),
                    (
                        put_right(|m: &Styled<S>| &m.extension, |m| &mut m.extension),
                        fit_bases::<S>,
                    )
                        .after(AssetEventSystems),
                ),
            )
            .add_systems(Last, declare_needs::<S>)
            .add_observer(withdraw_needs::<S>);
    }
}

/// What a base was before its style changed it.
#[derive(Default, Clone, Copy)]
struct Before {
    masked: bool,
    method: Option<OpaqueRendererMethod>,
}

/// A cut-out needs a base that may discard, or Bevy draws shadows and prepasses without looking at the material: an opaque
/// base gets a mask. Only the forward renderer knows the light while it draws a material. Both for as long as it is needed.
fn fit_bases<S: WaveStyle>(
    mut changes: MessageReader<AssetEvent<Styled<S>>>,
    mut materials: ResMut<Assets<Styled<S>>>,
    mut changed: Local<HashMap<AssetId<Styled<S>>, Before>>,
) {
    for change in changes.read() {
        let id = match *change {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => id,
            AssetEvent::Removed { id } => {
                changed.remove(&id);
                continue;
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => continue,
        };
        let Some(material) = materials.get(id) else { continue };
        let before = changed.remove(&id).unwrap_or_default();
        let (base, style) = (&material.base, &material.extension);
        let (mode, masked) = mask(base.alpha_mode, style.is_cutout(), before.masked);
        let (method, replaced) = forward(base.opaque_render_method, style.needs_light(), before.method);
        if masked || replaced.is_some() {
            let method = replaced;
            changed.insert(id, Before { masked, method });
        }
        if (mode, method) != (base.alpha_mode, base.opaque_render_method)
            && let Some(mut material) = materials.get_mut(id)
        {
            material.base.alpha_mode = mode;
            material.base.opaque_render_method = method;
        }
    }
}

/// The mode to have, and whether it is a mask of ours. Another mode than the mask is the user's own.
fn mask(mode: AlphaMode, wanted: bool, ours: bool) -> (AlphaMode, bool) {
    const MASK: AlphaMode = AlphaMode::Mask(0.5);
    match (wanted, mode) {
        (true, AlphaMode::Opaque) => (MASK, true),
        (true, mode) if mode == MASK => (MASK, ours),
        (false, mode) if mode == MASK && ours => (AlphaMode::Opaque, false),
        (_, mode) => (mode, false),
    }
}

/// The method to have, and the one it replaces.
fn forward(
    method: OpaqueRendererMethod,
    wanted: bool,
    replaced: Option<OpaqueRendererMethod>,
) -> (OpaqueRendererMethod, Option<OpaqueRendererMethod>) {
    match (wanted, method) {
        (true, OpaqueRendererMethod::Forward) => (method, replaced),
        (true, _) => (OpaqueRendererMethod::Forward, Some(method)),
        (false, OpaqueRendererMethod::Forward) => (replaced.unwrap_or(method), None),
        (false, _) => (method, None),
    }
}

/// What a material asked for goes with it.
fn withdraw_needs<S: WaveStyle>(event: On<Remove, MeshMaterial3d<Styled<S>>>, mut commands: Commands) {
    if let Ok(mut entity) = commands.get_entity(event.entity) {
        entity.try_remove::<StyleNeeds>();
    }
}

/// Tells the solver which entities carry a style that their pattern cannot have.
fn declare_needs<S: WaveStyle>(
    changes: MessageReader<AssetEvent<Styled<S>>>,
    entities: Query<(Entity, Ref<MeshMaterial3d<Styled<S>>>, Option<&StyleNeeds>), With<DirectionField>>,
    materials: Res<Assets<Styled<S>>>,
    mut commands: Commands,
) {
    let any_material_changed = !changes.is_empty();
    for (entity, material, declared) in &entities {
        // What is not declared may be new here, or have been withdrawn with the material of another style.
        if declared.is_some() && !any_material_changed && !material.is_changed() {
            continue;
        }
        let material = materials.get(&material.0);
        let needs = material.map_or_else(StyleNeeds::default, |material| material.extension.needs());
        if needs == declared.copied().unwrap_or_default() {
            continue;
        }
        if needs == StyleNeeds::default() {
            commands.entity(entity).try_remove::<StyleNeeds>();
        } else {
            commands.entity(entity).try_insert(needs);
        }
    }
}
