//! What a pattern's style asks of the [`StandardMaterial`] under it.
//!
//! In: materials that change. Out: their bases, with a mask where the style cuts holes and drawn forward where the style
//! needs the light; as they were, as soon as it does not any more.

use bevy::{
    material::OpaqueRendererMethod,
    pbr::{ExtendedMaterial, MaterialExtension},
    platform::collections::HashMap,
    prelude::*,
};

/// A style that asks something of its base.
pub(super) trait PatternExtension: MaterialExtension {
    /// Bevy draws shadows and prepasses of an opaque base without looking at the material: it needs a mask.
    fn cuts_out(&self) -> bool;

    /// The style is drawn after the lighting.
    fn needs_forward(&self) -> bool {
        false
    }
}

/// What a base was before.
#[derive(Default, Clone, Copy)]
pub(super) struct Before {
    masked: bool,
    method: Option<OpaqueRendererMethod>,
}

const MASK: AlphaMode = AlphaMode::Mask(0.5);

pub(super) fn fit_base<E: PatternExtension>(
    mut changes: MessageReader<AssetEvent<ExtendedMaterial<StandardMaterial, E>>>,
    mut materials: ResMut<Assets<ExtendedMaterial<StandardMaterial, E>>>,
    mut fitted: Local<HashMap<AssetId<ExtendedMaterial<StandardMaterial, E>>, Before>>,
) {
    for change in changes.read() {
        let id = match *change {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => id,
            AssetEvent::Removed { id } => {
                fitted.remove(&id);
                continue;
            }
            AssetEvent::Unused { .. } | AssetEvent::LoadedWithDependencies { .. } => continue,
        };
        let Some(material) = materials.get(id) else { continue };
        let before = fitted.get(&id).copied().unwrap_or_default();
        let (alpha_mode, masked) = mask(material.base.alpha_mode, material.extension.cuts_out(), before.masked);
        let (method, replaced) = forward(
            material.base.opaque_render_method,
            material.extension.needs_forward(),
            before.method,
        );
        if masked || replaced.is_some() {
            let method = replaced;
            fitted.insert(id, Before { masked, method });
        } else {
            fitted.remove(&id);
        }
        if (alpha_mode != material.base.alpha_mode || method != material.base.opaque_render_method)
            && let Some(mut material) = materials.get_mut(id)
        {
            material.base.alpha_mode = alpha_mode;
            material.base.opaque_render_method = method;
        }
    }
}

/// The mode to have, and whether the mask is ours. Another mode than the mask is the user's own.
fn mask(mode: AlphaMode, wanted: bool, ours: bool) -> (AlphaMode, bool) {
    match (wanted, mode) {
        (true, AlphaMode::Opaque) => (MASK, true),
        (true, mode) if mode == MASK => (MASK, ours),
        (_, mode) if ours && mode == MASK => (AlphaMode::Opaque, false),
        (_, mode) => (mode, false),
    }
}

/// The method to have, and the one it replaces.
fn forward(
    method: OpaqueRendererMethod,
    wanted: bool,
    replaced: Option<OpaqueRendererMethod>,
) -> (OpaqueRendererMethod, Option<OpaqueRendererMethod>) {
    match (wanted, method, replaced) {
        (true, OpaqueRendererMethod::Forward, replaced) => (OpaqueRendererMethod::Forward, replaced),
        (true, method, _) => (OpaqueRendererMethod::Forward, Some(method)),
        (false, OpaqueRendererMethod::Forward, Some(method)) => (method, None),
        (false, method, _) => (method, None),
    }
}
