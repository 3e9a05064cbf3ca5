//! Numbers of styles that are none.
//!
//! In: styles that were added or changed. Out: the same, where a setting that is NaN, or infinite though its default is
//! not, has its default, or 0 if it has none. What was wrong is said in the log.

use bevy::{
    prelude::*,
    reflect::{GetPath, ReflectRef, TypePath},
};

/// Puts styles right, in materials that hold them; to be run after Bevy knows which materials have changed, and before they
/// are extracted.
pub(super) fn put_right<M: Asset, S: Reflect + TypePath + Default>(
    style: fn(&M) -> &S,
    style_mut: fn(&mut M) -> &mut S,
) -> impl FnMut(MessageReader<AssetEvent<M>>, ResMut<Assets<M>>) {
    move |mut changes, mut materials| {
        for change in changes.read() {
            let (AssetEvent::Added { id } | AssetEvent::Modified { id }) = *change else {
                continue;
            };
            let wrong = materials
                .get(id)
                .map_or_else(Vec::new, |material| wrong_numbers(style(material)));
            if wrong.is_empty() {
                continue;
            }
            let Some(mut material) = materials.get_mut(id) else {
                continue;
            };
            for Wrong { path, instead } in wrong {
                error!(
                    "{}{path} is not a number; {instead} is used instead",
                    S::short_type_path()
                );
                if let Ok(number) = style_mut(&mut material).path_mut::<f32>(path.as_str()) {
                    *number = instead;
                }
            }
        }
    }
}

/// A setting by its path, such as `.drive.bump`, and the number to have instead.
struct Wrong {
    path: String,
    instead: f32,
}

fn wrong_numbers<S: Reflect + Default>(style: &S) -> Vec<Wrong> {
    let mut wrong = Vec::new();
    collect(style, Some(&S::default()), &mut String::new(), &mut wrong);
    wrong
}

/// What is wrong within a value, whose default is `usual` and whose path is `path`.
fn collect(value: &dyn PartialReflect, usual: Option<&dyn PartialReflect>, path: &mut String, wrong: &mut Vec<Wrong>) {
    if let Some(&number) = value.try_downcast_ref::<f32>() {
        let usual = usual.and_then(|usual| usual.try_downcast_ref::<f32>()).copied();
        if number.is_nan() || number.is_infinite() && usual.is_some_and(f32::is_finite) {
            let (path, instead) = (path.clone(), usual.unwrap_or(0.0));
            wrong.push(Wrong { path, instead });
        }
        return;
    }
    let usual = usual.map(PartialReflect::reflect_ref);
    for (step, part, usual) in parts(value.reflect_ref(), usual) {
        let length = path.len();
        path.push_str(&step);
        collect(part, usual, path, wrong);
        path.truncate(length);
    }
}

/// The parts of a value, each by its step in a path and with the part of the default that corresponds to it.
fn parts<'a>(
    value: ReflectRef<'a>,
    usual: Option<ReflectRef<'a>>,
) -> Vec<(String, &'a dyn PartialReflect, Option<&'a dyn PartialReflect>)> {
    let part = |step: String, part: Option<&'a dyn PartialReflect>, usual| part.map(|part| (step, part, usual));
    match (value, usual) {
        (ReflectRef::Struct(value), usual) => {
            let usual = |name: &str| match &usual {
                Some(ReflectRef::Struct(usual)) => usual.field(name),
                _ => None,
            };
            let names = (0..value.field_len()).filter_map(|k| value.name_at(k));
            names
                .filter_map(|name| part(format!(".{name}"), value.field(name), usual(name)))
                .collect()
        }
        (ReflectRef::Enum(value), usual) => {
            let usual = |k| match &usual {
                Some(ReflectRef::Enum(usual)) if usual.variant_name() == value.variant_name() => usual.field_at(k),
                _ => None,
            };
            let step = |k| {
                value
                    .name_at(k)
                    .map_or_else(|| format!(".{k}"), |name| format!(".{name}"))
            };
            (0..value.field_len())
                .filter_map(|k| part(step(k), value.field_at(k), usual(k)))
                .collect()
        }
        (ReflectRef::TupleStruct(value), _) => (0..value.field_len())
            .filter_map(|k| part(format!(".{k}"), value.field(k), None))
            .collect(),
        (ReflectRef::List(value), _) => (0..value.len())
            .filter_map(|k| part(format!("[{k}]"), value.get(k), None))
            .collect(),
        _ => Vec::new(),
    }
}
