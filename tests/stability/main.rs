//! Numerical stability: what is far, small, large, bright, dark, thin, flat, singular, full or long-lived, against closed forms
//! and bounds that each test derives. docs/stability.md lists the cases with what they measured.
//!
//! With `GIBS_STABILITY_PICTURES` naming a folder, each case that renders writes its picture of error there.
#[path = "../common/mod.rs"]
mod common;

mod build;
mod measure;
mod pictures;

mod capacities;
mod estimator;
mod far_away;
mod finite;
mod frame_counter;
mod inside;
mod light_powers;
mod lights_on_surfaces;
mod lives;
mod node_scales;
mod nothing;
mod number_ranges;
mod scene_scale;
mod small_lamps;
mod thin_walls;
mod triangles;
mod white_walls;
