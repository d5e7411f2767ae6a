//! Which functions there are in `shaders/modules`, and which of them have no twin of their own here.
use std::collections::BTreeSet;

/// Every function of every module, as `module::function`.
pub fn functions() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (module, text) in gibs_shaders::MODULES {
        for line in text.lines() {
            // A comment may stand behind a declaration, never before it on its line.
            let Some(rest) = line.trim_start().strip_prefix("fn ") else {
                continue;
            };
            let name = rest.split('(').next().unwrap_or(rest).trim();
            found.insert(format!("{module}::{name}"));
        }
    }
    found
}

/// Functions without a twin of their own, each with the function that is tested in its place. They are parts that their Rust
/// module keeps to itself, or writes out where it needs them: that function calls them, and its inputs reach their branches.
pub const PARTS: &[(&str, &str)] = &[
    ("bounds::bounds_step", "bounds::bounds_place"),
    ("depth::depth_texel", "depth::depth_moments"),
    (
        "environment::environment_at",
        "environment::environment_texel",
    ),
    (
        "estimator::estimator_recency",
        "estimator::estimator_update",
    ),
    (
        "estimator::estimator_significance",
        "estimator::estimator_to_forget",
    ),
    ("grid::grid_high", "grid::grid_span"),
    ("grid::grid_index", "grid::grid_cell"),
    ("grid::grid_low", "grid::grid_span"),
    ("grid::grid_slice", "grid::grid_cell"),
    ("grid::grid_turned", "grid::grid_span"),
    ("guide::guide_block", "guide::guide_draw"),
    ("guide::guide_corner", "guide::guide_draw"),
    ("guide::guide_first", "guide::guide_texel"),
    ("guide::guide_index", "guide::guide_texel_of"),
    ("guide::guide_line", "guide::guide_draw"),
    ("guide::guide_lobe", "guide::guide_probability"),
    ("guide::guide_mass", "guide::guide_total"),
    ("guide::guide_tag", "guide::guide_rays"),
    ("guide::guide_texels", "guide::guide_density"),
    ("guide::guide_walk", "guide::guide_draw"),
    (
        "octahedral::octahedral_fold",
        "octahedral::octahedral_encode",
    ),
    (
        "octahedral::octahedral_sign",
        "octahedral::octahedral_encode",
    ),
    ("sharing::sharing_first_bits", "sharing::sharing_pack"),
    (
        "sharing::sharing_from_first_bits",
        "sharing::sharing_unpack",
    ),
    ("texture::texture_fold", "texture::texture_sample"),
    ("texture::texture_linear", "texture::texture_sample"),
    ("texture::texture_mapped", "texture::texture_base_color"),
    ("texture::texture_texel", "texture::texture_sample"),
    ("texture::texture_wrap", "texture::texture_sample"),
    // The other body of the traversal, which `tests/ray_queries.rs` holds against this one.
    ("trace_query::trace_query_hit", "trace::trace_walk"),
    ("trace_query::trace_walk", "trace::trace_walk"),
];
