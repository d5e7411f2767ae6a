//! The guides of surfels.
use super::declare::{EXACT, ROUNDED};
use super::inputs::Draw;
use gibs_graph::glam::{Vec2, Vec3};
use gibs_passes::shared::guide::{self, Guide, Guides};
use gibs_passes::shared::hash;

/// Guides of each size.
const GUIDES: u32 = 64;

/// A common multiple of the words of all sizes, 2, 5, 10 and 17: where the guides of each begin at a multiple of it, that is a whole
/// number of guides away from the first word.
const STEP: usize = 170;

/// Guides of every size, the smallest first: dark, of one texel, even, and of noise.
fn guides() -> Vec<u32> {
    let mut all = Vec::new();
    for side in [2, 4, 6, 8] {
        all.resize(first_word(side), 0);
        all.extend((0..GUIDES).flat_map(|i| words(side, i)));
    }
    all
}

/// The words of a guide; the last one's are zero.
fn words(side: u32, i: u32) -> Vec<u32> {
    let texels = side * side;
    let luminance = |t: u32| match i % 4 {
        0 => 1.0,
        1 => f32::from(u8::from(t == i % texels)),
        2 => hash::unit(hash::hash2(i, t)),
        _ => hash::unit(hash::hash2(i, t)).powi(4),
    };
    let luminances: Vec<f32> = (0..texels).map(luminance).collect();
    // Just enough rays, or any number.
    let rays = match i % 8 < 4 {
        true => hash::pcg(i) % 400,
        false => guide::LEAST_RAYS,
    };
    match i == GUIDES - 1 {
        true => vec![0; guide::words(side)],
        false => guide::pack(&luminances, i, rays, |_| 0.5)[..guide::words(side)].to_vec(),
    }
}

fn first_word(side: u32) -> usize {
    let smaller = (2..side).step_by(2);
    let sizes = smaller.map(|side| guide::words(side) * GUIDES as usize);
    sizes.map(|size| size.next_multiple_of(STEP)).sum()
}

fn side(d: &mut Draw) -> u32 {
    2 * (1 + d.below(4))
}

/// A guide of a size, by its index from the first of that.
fn guide_of(guides: &[u32], surfel: u32, side: u32) -> Guide<'_> {
    let guides = Guides::new(&guides[first_word(side)..], side);
    guides.get(surfel as usize).expect("a guide")
}

/// Sets the size, and gives the index under which the shader finds a guide of it. [`GUIDES`] and [`STEP`] are in it as numbers.
const PLACE: &str = "
var<private> settings: SurfelSettings;
fn place(surfel: u32, side: u32) -> u32 {
    settings.guide_side = side;
    var first = 0u;
    for (var smaller = 2u; smaller < side; smaller += 2u) {
        first += (64u * (1u + smaller * smaller / 4u) + 169u) / 170u * 170u;
    }
    return first / (1u + side * side / 4u) + surfel;
}";

twin! {
    guide_texel ["guide::guide_texel"], (surfel: u32, index: u32, side: u32) -> u32,
    wgsl "return guide_texel(place(surfel, side), index);",
    rust super::guide_of(guides, surfel, side).texel(index),
    draw |d| { let s = super::side(d); (d.below(64), d.below(s * s), s) },
    bound EXACT,
    uses ["types::SurfelSettings"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}
twin! {
    guide_rays ["guide::guide_rays"], (surfel: u32, identity: u32, side: u32) -> u32,
    wgsl "return guide_rays(place(surfel, side), identity);",
    rust super::guide_of(guides, surfel, side).rays(identity),
    draw |d| { let s = d.below(64); (s, d.one_of(&[s, s + 64, s + 1]), super::side(d)) },
    bound EXACT,
    uses ["types::SurfelSettings"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}
twin! {
    guide_total ["guide::guide_total"], (surfel: u32, side: u32) -> f32,
    wgsl "return guide_total(place(surfel, side));",
    rust super::guide_of(guides, surfel, side).total(),
    draw |d| (d.below(64), super::side(d)),
    bound EXACT,
    uses ["types::SurfelSettings"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}
twin! {
    guide_share ["guide::guide_share"], (surfel: u32, identity: u32, side: u32) -> f32,
    wgsl "let slot = place(surfel, side); return guide_share(slot, identity, guide_total(slot));",
    rust {
        let g = super::guide_of(guides, surfel, side);
        g.share(identity, g.total())
    },
    draw |d| { let s = d.below(64); (s, d.one_of(&[s, s, s, s + 1]), super::side(d)) },
    bound ROUNDED,
    uses ["types::SurfelSettings", "guide::guide_total"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}
twin! {
    guide_probability ["guide::guide_probability"], (surfel: u32, share: f32, index: u32, side: u32) -> f32,
    wgsl "let slot = place(surfel, side); return guide_probability(slot, max(guide_total(slot), 0.01), share, index);",
    rust {
        let g = super::guide_of(guides, surfel, side);
        g.probability(g.total().max(0.01), share, index)
    },
    draw |d| { let s = super::side(d); (d.below(64), d.one_of(&[0.0, 0.5, 0.1]), d.below(s * s), s) },
    bound ROUNDED,
    uses ["types::SurfelSettings", "guide::guide_total"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}
twin! {
    guide_texel_of ["guide::guide_texel_of"], (local: Vec3, side: u32) -> u32,
    wgsl "settings.guide_side = side; return guide_texel_of(local);",
    rust super::guide_of(guides, 0, side).texel_of(local),
    draw |d| (d.direction(), super::side(d)),
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}
twin! {
    guide_density ["guide::guide_density"], (surfel: u32, local: Vec3, side: u32) -> f32,
    wgsl "let slot = place(surfel, side); return guide_density(slot, max(guide_total(slot), 0.01), local);",
    rust {
        let g = super::guide_of(guides, surfel, side);
        g.density(g.total().max(0.01), local)
    },
    draw |d| (d.below(64), d.upward(), super::side(d)),
    bound ROUNDED,
    uses ["types::SurfelSettings", "guide::guide_total"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}
twin! {
    guide_draw ["guide::guide_draw"], (surfel: u32, uv: Vec2, side: u32) -> Vec3,
    wgsl "return guide_draw(place(surfel, side), uv);",
    rust super::guide_of(guides, surfel, side).draw((uv.x, uv.y)),
    draw |d| (d.below(64), d.units(), super::side(d)),
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text super::PLACE,
    globals { guides: u32 = super::guides() },
}

twins!(
    guide_texel,
    guide_rays,
    guide_total,
    guide_share,
    guide_probability,
    guide_texel_of,
    guide_density,
    guide_draw,
);
