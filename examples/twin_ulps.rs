//! How far apart the two languages are: every function that exists in WGSL and in Rust, over many inputs, on every GPU backend.
//!
//! ```sh
//! cargo run --release --example twin_ulps
//! ```
//!
//! Prints the tables of `docs/twins.md`. Nothing is asserted; `tests/twins` does that, with the same functions and inputs.
#[allow(dead_code, reason = "wrong twins are for the tests")]
#[path = "../tests/twins/suite/mod.rs"]
mod suite;

use gibs::backends::{self, Choice};
use gibs::graph::BackendError;

fn main() -> Result<(), BackendError> {
    let oracle = backends::open(Choice::Cpu)?;
    let gpus = [Choice::Wgpu, Choice::Vulkan];
    let found: Vec<_> = gpus
        .iter()
        .map(|&choice| (choice.to_string(), backends::open(choice).ok()))
        .collect();
    print!("{}", suite::table::report(oracle.as_ref(), &found));
    Ok(())
}
