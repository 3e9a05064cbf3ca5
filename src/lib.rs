//! Real-time field-aligned patterns on any triangle mesh, as a Bevy plugin.

pub mod error;
pub mod field;
pub mod material;
pub mod surface;
pub mod wave;
