//! What the examples share, so that each of them shows one use of the crate and little else:
//! a command line ([`args`]), glTF files ([`gltf`]), rendering without a window ([`headless`]), mesh files ([`mesh_file`]),
//! waiting for patterns ([`patterns`]), a camera with lights ([`scene`]) or for the plane ([`flat`]), meshes made by formula ([`shapes`]) and a blood vessel with its flow ([`vessel`]).
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
