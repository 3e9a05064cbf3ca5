//! What the examples share, so that each of them shows one use of the crate and little else:
//! a command line ([`args`]), glTF files ([`gltf`]), rendering without a window ([`headless`]), mesh files ([`mesh_file`]),
//! waiting for patterns ([`patterns`]), a camera with lights ([`scene`]) or for the plane ([`flat`]), meshes made by formula ([`shapes`]) and a blood vessel with its flow ([`vessel`]).
#![allow(
    dead_code,
    unreachable_pub,
    reason = "each example compiles this module for itself and uses a part of it"
)]

pub mod args;
pub mod flat;
pub mod gltf;
pub mod gpu;
pub mod headless;
pub mod mesh_file;
pub mod patterns;
pub mod scene;
pub mod shapes;
pub mod vessel;
