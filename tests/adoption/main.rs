//! What an engine changes between frames costs no surfel that could be kept.
#[path = "../common/mod.rs"]
mod common;

mod harness;
mod kept;
mod origin;
mod refused;
mod room;
mod schedule;
