//! What the examples share, so that each of them shows one use of the crate and little else.
//!
//! | | |
//! |---|---|
//! | to run | a command line ([`args`]), a time that stops for a picture ([`clock`]), rendering without a window ([`headless`]), waiting for patterns ([`patterns`]), what the device did ([`gpu`]) |
//! | to look | a camera with lights ([`scene`]), or for the plane ([`flat`]) |
//! | files | meshes ([`mesh_file`]), glTF with fields ([`gltf`]), and writing it ([`glb`]) |
//! | by formula | [`shapes`], a [`vessel`] with its flow, a [`flag`], an [`instrument`] |
//! | solids and their surfaces | [`implicit`], [`isosurface`], and with them a [`vessel_tree`], an [`aneurysm`], a [`hyperball`], [`organs`], a [`molecule`], a [`creature`] with its walk ([`creature_walk`]); [`points`] scanned from any of them |
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each example compiles this module for itself and uses a part of it"
)]

pub mod aneurysm;
pub mod args;
pub mod clock;
pub mod creature;
pub mod creature_walk;
pub mod flag;
pub mod flat;
pub mod glb;
pub mod gltf;
pub mod gpu;
pub mod headless;
pub mod hyperball;
pub mod implicit;
pub mod instrument;
pub mod isosurface;
pub mod mesh_file;
pub mod molecule;
pub mod organs;
pub mod patterns;
pub mod points;
pub mod scene;
pub mod shapes;
pub mod vessel;
pub mod vessel_tree;
