//! The cross-check kit: what it passes, and that it fails on everything that it should fail on.
#[path = "../common/mod.rs"]
mod common;

mod agree;
mod captures;
mod harness;
mod program;
mod replays;
mod reports;
mod sabotage;
mod undecided;
