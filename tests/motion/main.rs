//! Surfaces that move: vertices posed on the device against what Bevy draws, and all that follows from them.
#![allow(unreachable_pub, reason = "modules of one test")]

#[path = "../common/mod.rs"]
mod common;
mod creature;
mod edited;
mod fields;
mod life;
mod pictures;
mod probe;
#[path = "../material/stage.rs"]
mod stage;
mod twins;
