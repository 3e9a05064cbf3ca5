//! What all styles of waves have in common.
//!
//! In: materials that extend [`StandardMaterial`] by a [`WaveStyle`]. Out: what a style asks of an entity's pattern, told to
//! the solver as [`StyleNeeds`], and bases that may discard where a style cuts out.

use super::PatternMaterialPlugin;
use crate::{field::DirectionField, wave::StyleNeeds};
use bevy::{
    asset::AssetEventSystems,
    pbr::{ExtendedMaterial, MaterialExtension},
    platform::collections::HashSet,
    prelude::*,
    render::render_resource::RenderPipelineDescriptor,
};
use std::marker::PhantomData;

/// A style that is drawn by `pattern_material.wgsl` and `pattern_prepass.wgsl`.
pub(super) trait WaveStyle: MaterialExtension {
    /// What the style asks of a pattern.
    fn needs(&self) -> StyleNeeds;
    /// Whether the style discards fragments.
    fn is_cutout(&self) -> bool;
}

type Styled<S> = ExtendedMaterial<StandardMaterial, S>;

/// Adds shader definitions to a fragment shader, those that are true.
pub(super) fn select_variant(descriptor: &mut RenderPipelineDescriptor, variants: &[(bool, &'static str)]) {
    if let Some(fragment) = &mut descriptor.fragment {
        let selected = variants.iter().filter(|variant| variant.0);
        fragment.shader_defs.extend(selected.map(|variant| variant.1.into()));
    }
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
            .add_systems(PostUpdate, mask_cutouts::<S>.after(AssetEventSystems))
            .add_systems(Last, declare_needs::<S>)
            .add_observer(withdraw_needs::<S>);
    }
}

/// A cut-out needs a base that may discard, or Bevy draws shadows and prepasses without looking at the material. An opaque
/// base gets a mask for as long as it is cut out.
fn mask_cutouts<S: WaveStyle>(
    mut changes: MessageReader<AssetEvent<Styled<S>>>,
    mut materials: ResMut<Assets<Styled<S>>>,
    mut masked: Local<HashSet<AssetId<Styled<S>>>>,
) {
    const MASK: AlphaMode = AlphaMode::Mask(0.5);
    for change in changes.read() {
        let id = match *change {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => id,
            AssetEvent::Removed { id } => {
                masked.remove(&id);
                continue;
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => continue,
        };
        let Some(material) = materials.get(id) else { continue };
        let mode = material.base.alpha_mode;
        let wanted = match (material.extension.is_cutout(), mode) {
            (true, AlphaMode::Opaque) => {
                masked.insert(id);
                MASK
            }
            (true, mode) if mode == MASK => MASK,
            // Another mode than the mask is the user's own.
            (_, mode) => match masked.remove(&id) {
                true if mode == MASK => AlphaMode::Opaque,
                _ => mode,
            },
        };
        if wanted != mode
            && let Some(mut material) = materials.get_mut(id)
        {
            material.base.alpha_mode = wanted;
        }
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
        if !any_material_changed && !material.is_changed() {
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
