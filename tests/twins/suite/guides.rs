//! The guides of surfels.
use super::declare::{EXACT, ROUNDED};
use gibs_graph::glam::{Vec2, Vec3};
use gibs_passes::data::SurfelGuide;
use gibs_passes::shared::{guide, hash};

/// Guides: dark, of one texel, even, and of noise.
fn guides() -> Vec<SurfelGuide> {
    let guide = |i: u32| {
        let luminances = std::array::from_fn(|t| match i % 4 {
            0 => 1.0,
            1 => f32::from(u8::from(t as u32 == i % 36)),
            2 => hash::unit(hash::hash2(i, t as u32)),
            _ => hash::unit(hash::hash2(i, t as u32)).powi(4),
        });
        // Just enough rays, or any number.
        let rays = if i % 8 < 4 {
            hash::pcg(i) % 400
        } else {
            guide::LEAST_RAYS
        };
        guide::pack(&luminances, i, rays, |_| 0.5)
    };
    (0..64)
        .map(|i| {
            if i == 63 {
                SurfelGuide::default()
            } else {
                guide(i)
            }
        })
        .collect()
}
twin! {
    guide_texel ["guide::guide_texel"], (surfel: u32, index: u32) -> u32,
    wgsl "guide_texel(surfel, index)",
    rust guide::texel(&guides[surfel as usize], index),
    draw |d| (d.below(64), d.below(36)),
    bound EXACT,
    globals { guides: SurfelGuide = super::guides() },
}
twin! {
    guide_rays ["guide::guide_rays"], (surfel: u32, identity: u32) -> u32,
    wgsl "guide_rays(surfel, identity)",
    rust guide::rays(&guides[surfel as usize], identity),
    draw |d| { let s = d.below(64); (s, d.one_of(&[s, s + 64, s + 1])) },
    bound EXACT,
    globals { guides: SurfelGuide = super::guides() },
}
twin! {
    guide_total ["guide::guide_total"], (surfel: u32) -> f32,
    wgsl "guide_total(surfel)",
    rust guide::total(&guides[surfel as usize]),
    draw |d| (d.below(64),),
    bound EXACT,
    globals { guides: SurfelGuide = super::guides() },
}
twin! {
    guide_share ["guide::guide_share"], (surfel: u32, identity: u32) -> f32,
    wgsl "guide_share(surfel, identity, guide_total(surfel))",
    rust guide::share(&guides[surfel as usize], identity, guide::total(&guides[surfel as usize])),
    draw |d| { let s = d.below(64); (s, d.one_of(&[s, s, s, s + 1])) },
    bound ROUNDED,
    uses ["guide::guide_total"],
    globals { guides: SurfelGuide = super::guides() },
}
twin! {
    guide_probability ["guide::guide_probability"], (surfel: u32, share: f32, index: u32) -> f32,
    wgsl "guide_probability(surfel, max(guide_total(surfel), 0.01), share, index)",
    rust {
        let g = &guides[surfel as usize];
        guide::probability(g, guide::total(g).max(0.01), share, index)
    },
    draw |d| (d.below(64), d.one_of(&[0.0, 0.5, 0.1]), d.below(36)),
    bound ROUNDED,
    uses ["guide::guide_total"],
    globals { guides: SurfelGuide = super::guides() },
}
twin! {
    guide_texel_of ["guide::guide_texel_of"], (local: Vec3) -> u32,
    wgsl "guide_texel_of(local)",
    rust guide::texel_of(local),
    draw |d| (d.direction(),),
    bound ROUNDED,
    globals { guides: SurfelGuide = super::guides() },
}
twin! {
    guide_density ["guide::guide_density"], (surfel: u32, local: Vec3) -> f32,
    wgsl "guide_density(surfel, max(guide_total(surfel), 0.01), local)",
    rust {
        let g = &guides[surfel as usize];
        guide::density(g, guide::total(g).max(0.01), local)
    },
    draw |d| (d.below(64), d.upward()),
    bound ROUNDED,
    uses ["guide::guide_total"],
    globals { guides: SurfelGuide = super::guides() },
}
twin! {
    guide_draw ["guide::guide_draw"], (surfel: u32, uv: Vec2) -> Vec3,
    wgsl "guide_draw(surfel, uv)",
    rust guide::draw(&guides[surfel as usize], (uv.x, uv.y)),
    draw |d| (d.below(64), d.units()),
    bound ROUNDED,
    globals { guides: SurfelGuide = super::guides() },
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
