//! Random and hostile input for everything that reads outside data, and random graphs on every backend.
//!
//! Whatever the input, the answer is a value or an error: never a panic, never an allocation that the input's size does not
//! bear out, never an endless loop. `docs/fuzzing.md` says how to run it for long.
#![cfg(feature = "cpu")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../bad_input/file.rs"]
#[allow(dead_code, reason = "the other tests use all of it")]
mod file;

mod archive;
mod captures;
mod edits;
mod gltf;
mod gltf_seed;
mod graph_cases;
mod graph_pool;
mod graph_stages;
mod graph_stages_mixed;
mod graph_steps;
mod graphs;
mod images;
mod replays;
mod settings;
mod texts;
mod watch;
mod wgsl;
mod wgsl_valid;
