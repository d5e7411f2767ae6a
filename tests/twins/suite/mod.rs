//! Functions that exist in WGSL and in Rust, run side by side. What `tests/twins` holds to its bounds, and what
//! `examples/twin_ulps.rs` makes a table of.
#[macro_use]
mod macros;
pub mod declare;
mod directions;
mod estimator;
mod gather;
mod grid;
mod guides;
pub mod inputs;
mod lanes;
mod light;
pub mod listing;
mod numbers;
mod pixels;
pub mod run;
mod surfaces;
mod surfels;
pub mod table;
mod trace;
pub mod wrong;

/// Every twin, by family.
pub fn families() -> Vec<(&'static str, Vec<declare::Twin>)> {
    vec![
        ("numbers", numbers::all()),
        ("directions", directions::all()),
        ("grid", grid::all()),
        ("estimator", estimator::all()),
        ("surfels", surfels::all()),
        ("guides", guides::all()),
        ("gather", gather::all()),
        ("light", light::all()),
        ("surfaces", surfaces::all()),
        ("pixels", pixels::all()),
        ("trace", trace::all()),
        ("lanes", lanes::all()),
    ]
}
