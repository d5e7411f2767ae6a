//! What surfels tell others: weights and depth functions; when they go, and where their rays go.
use super::declare::{DIVIDED, EXACT, ROUNDED};
use super::inputs::Draw;
use gibs_graph::glam::{Vec2, Vec3};
use gibs_passes::data::SurfelPose;
use gibs_passes::shared::depth::{Depth, Depths};
use gibs_passes::shared::{depth, hash, lengths, lookup, mark, mixture, plane, recycling};

/// A surfel in the middle, and of a size that a place near it can be within.
fn pose(d: &mut Draw) -> SurfelPose {
    SurfelPose {
        radius: d.magnitude(-8, 4),
        normal: d.direction(),
        mark: mark::of(d.word(), plane::pack(d.direction()), false),
        ..SurfelPose::default()
    }
}

/// From a surfel to a place: within its reach or a little beyond, in its plane or off it, or at its centre.
fn to_place(d: &mut Draw, pose: &SurfelPose) -> Vec3 {
    let across = plane::unpack(pose.mark).normalize();
    let way = match d.below(3) {
        0 => d.direction(),
        _ => (d.direction().cross(across) + across * d.between(-0.3, 0.3)).normalize_or(Vec3::X),
    };
    let share = match d.below(5) {
        0 => d.around(0.02),
        1 => d.around(1.0),
        _ => d.between(0.0, 2.2),
    };
    way * (pose.radius * share)
}

twin! {
    steps ["lookup::lookup_steps"], (texel: u32) -> Vec2,
    wgsl "lookup_steps(texel)",
    rust Vec2::new((texel & 0xffff) as f32, (texel >> 16) as f32),
    draw |d| (d.word(),),
    bound EXACT,
}
twin! {
    moments ["lookup::lookup_moments"], (texel: u32) -> Vec2,
    wgsl "lookup_moments(texel)",
    rust depth::moments(texel),
    draw |d| (d.word(),),
    bound EXACT,
}
twin! {
    is_known ["lookup::lookup_is_known"], (texel: u32) -> u32,
    wgsl "u32(lookup_is_known(texel))",
    rust u32::from(depth::is_known(texel)),
    draw |d| { let any = d.word(); (d.one_of(&[any, any & 0xffff, any | 0xffff, 0, u32::MAX]),) },
    bound EXACT,
}
twin! {
    guess ["lookup::lookup_guess"], (nearest: u32) -> u32,
    wgsl "lookup_guess(nearest)",
    rust depth::guess(nearest),
    draw |d| { let any = d.below(0x1_0000); (d.one_of(&[any, 0, 0x7fff, 0x8000]),) },
    bound EXACT,
}
twin! {
    pack_moments ["lookup::lookup_pack_moments"], (m: Vec2) -> u32,
    wgsl "lookup_pack_moments(m)",
    rust depth::pack_moments(m),
    // Among them the middles between two steps.
    draw |d| {
        let middle = (d.below(65_535) as f32 + 0.5) / 65_535.0;
        let middle = d.around(middle);
        let any = d.unit();
        (Vec2::new(d.one_of(&[middle, any, 1.0, 1.5, -0.5]), d.unit()),)
    },
    bound ROUNDED,
}
twin! {
    rescaled ["lookup::lookup_rescaled"], (texel: u32, shrinks: f32) -> u32,
    wgsl "lookup_rescaled(texel, shrinks, shrinks * shrinks)",
    rust depth::rescaled(texel, shrinks),
    draw |d| (d.word(), d.magnitude(-3, 4)),
    bound ROUNDED,
}
twin! {
    chebyshev ["lookup::lookup_chebyshev"], (m: Vec2, t: f32) -> f32,
    wgsl "lookup_chebyshev(m, t)",
    rust depth::chebyshev(m, t),
    draw |d| {
        let mean = d.unit();
        let spread = d.number(-20, -1).abs();
        let t = d.around(mean).abs();
        let any = d.between(0.0, 2.0);
        (Vec2::new(mean, mean * mean + spread), d.one_of(&[t, any]))
    },
    bound ROUNDED,
}
twin! {
    trust ["lookup::lookup_trust"], (age: u32) -> f32,
    wgsl "lookup_trust(age)",
    rust lookup::trust(age),
    draw |d| (d.word() % 70,),
    bound DIVIDED,
}
twin! {
    nearness ["lookup::lookup_nearness"], (d: Vec3, pose: SurfelPose) -> f32,
    wgsl "lookup_nearness(d, pose)",
    rust lookup::nearness(d, &pose),
    draw |d| { let p = super::pose(d); (super::to_place(d, &p), p) },
    bound ROUNDED,
}
twin! {
    falloff ["lookup::lookup_falloff"], (d: Vec3, pose: SurfelPose) -> f32,
    wgsl "lookup_falloff(d, pose)",
    rust lookup::falloff(d, &pose),
    draw |d| { let p = super::pose(d); (super::to_place(d, &p), p) },
    bound ROUNDED,
}
twin! {
    alignment ["lookup::lookup_alignment"], (normal: Vec3, pose: SurfelPose) -> f32,
    wgsl "lookup_alignment(normal, pose)",
    rust lookup::alignment(normal, &pose),
    draw |d| (d.direction(), super::pose(d)),
    bound ROUNDED,
}
twin! {
    leaning ["lookup::lookup_leaning"], (normal: Vec3, pose: SurfelPose) -> f32,
    wgsl "lookup_leaning(normal, pose)",
    rust lookup::leaning(normal, &pose),
    draw |d| (d.direction(), super::pose(d)),
    bound ROUNDED,
}

/// Depth functions of any side: open, closed, of one wall, of noise.
pub fn depths() -> Vec<u32> {
    let texel = |i: u32, t: u32| match i % 4 {
        0 => u32::MAX,
        1 => hash::hash2(i, t),
        2 => (1 + i % 9) * 0x0100_1000,
        _ => (0x4000 + hash::hash2(i, t) % 0x4000) | (0x1000 + hash::hash2(t, i) % 0x4000) << 16,
    };
    (0..64)
        .flat_map(|i| (0..64).map(move |t| texel(i, t)))
        .collect()
}

fn side(d: &mut Draw) -> u32 {
    2 + d.below(7)
}

fn depth_of(texels: &[u32], surfel: u32, side: u32) -> Depth<'_> {
    let depths = Depths::new(texels, side);
    depths.get(surfel as usize).expect("a depth function")
}
twin! {
    depth_moments ["depth::depth_moments"], (surfel: u32, local: Vec3, side: u32) -> Vec2,
    wgsl "settings.depth_side = side; return depth_moments(surfel, local);",
    rust depth::depth_moments(super::depth_of(depths, surfel, side), local),
    draw |d| (d.below(64), d.upward(), super::side(d)),
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text "var<private> settings: SurfelSettings;",
    globals { depths: u32 = super::depths() },
}
twin! {
    depth_visibility ["depth::depth_visibility"], (surfel: u32, pose: SurfelPose, d: Vec3, side: u32) -> f32,
    wgsl "settings.depth_side = side; return depth_visibility(surfel, pose, d);",
    rust depth::visibility(super::depth_of(depths, surfel, side), &pose, d),
    draw |d| { let p = super::pose(d); (d.below(64), p, super::to_place(d, &p), super::side(d)) },
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text "var<private> settings: SurfelSettings;",
    globals { depths: u32 = super::depths() },
}
twin! {
    depth_openness ["depth::depth_openness"], (surfel: u32, pose: SurfelPose, d: Vec3, side: u32) -> f32,
    wgsl "settings.depth_side = side; return depth_openness(surfel, pose, d);",
    rust depth::openness(super::depth_of(depths, surfel, side), &pose, d),
    draw |d| { let p = super::pose(d); (d.below(64), p, super::to_place(d, &p), super::side(d)) },
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text "var<private> settings: SurfelSettings;",
    globals { depths: u32 = super::depths() },
}
twin! {
    depth_visibility_within ["depth::depth_visibility_within"], (most: f32, surfel: u32, pose: SurfelPose, d: Vec3, side: u32) -> f32,
    wgsl "settings.depth_side = side; return depth_visibility_within(most, surfel, pose, d);",
    rust depth::visibility_within(most, super::depth_of(depths, surfel, side), &pose, d),
    draw |d| { let p = super::pose(d); ([0.3, 1.0, f32::MAX][d.below(3) as usize], d.below(64), p, super::to_place(d, &p), super::side(d)) },
    bound ROUNDED,
    uses ["types::SurfelSettings"],
    text "var<private> settings: SurfelSettings;",
    globals { depths: u32 = super::depths() },
}

twin! {
    identity ["mark::mark_identity"], (mark: u32) -> u32,
    wgsl "mark_identity(mark)",
    rust mark::identity(mark),
    draw |d| (d.word(),),
    bound EXACT,
}
twin! {
    is_open ["mark::mark_is_open"], (mark: u32) -> u32,
    wgsl "u32(mark_is_open(mark))",
    rust u32::from(mark::is_open(mark)),
    draw |d| (d.word(),),
    bound EXACT,
}
twin! {
    mark_of ["mark::mark_of"], (identity: u32, plane: u32, open: u32) -> u32,
    wgsl "mark_of(identity, plane, open != 0u)",
    rust mark::of(identity, plane, open != 0),
    draw |d| (d.word(), d.word(), d.flag()),
    bound EXACT,
}
twin! {
    plane_pack ["plane::plane_pack"], (normal: Vec3) -> u32,
    wgsl "plane_pack(normal)",
    rust plane::pack(normal),
    draw |d| (d.direction(),),
    bound ROUNDED,
}
twin! {
    plane_unpack ["plane::plane_unpack"], (bits: u32) -> Vec3,
    wgsl "plane_unpack(bits)",
    rust plane::unpack(bits),
    draw |d| (d.word(),),
    bound EXACT,
}
twin! {
    lengths_pack ["lengths::lengths_pack"], (up: f32, down: f32) -> u32,
    wgsl "lengths_pack(up, down)",
    rust lengths::pack(up, down),
    draw |d| (d.magnitude(-60, 60), d.magnitude(-60, 60)),
    bound EXACT,
}
twin! {
    lengths_up ["lengths::lengths_up"], (word: u32) -> f32,
    wgsl "lengths_up(word)",
    rust lengths::up(word),
    draw |d| { let word = lengths::pack(d.magnitude(-60, 60), d.magnitude(-60, 60)); (word,) },
    bound EXACT,
}
twin! {
    lengths_down ["lengths::lengths_down"], (word: u32) -> f32,
    wgsl "lengths_down(word)",
    rust lengths::down(word),
    draw |d| { let word = lengths::pack(d.magnitude(-60, 60), d.magnitude(-60, 60)); (word,) },
    bound EXACT,
}
twin! {
    one_more ["recycling::recycling_one_more"], (unseen: u32) -> u32,
    wgsl "recycling_one_more(unseen)",
    rust recycling::one_more(unseen),
    draw |d| {
        let unseen = d.word();
        (d.one_of(&[unseen, 0, recycling::CHOSEN - 2, recycling::CHOSEN - 1]),)
    },
    bound EXACT,
}
twin! {
    looks ["recycling::recycling_looks"], (identity: u32, frame: u32) -> u32,
    wgsl "u32(recycling_looks(identity, frame))",
    rust u32::from(recycling::looks(identity, frame)),
    draw |d| (d.word(), d.word()),
    bound EXACT,
}
twin! {
    chance ["recycling::recycling_chance"], (used: f32, unseen: u32, distance: f32, others: f32) -> f32,
    wgsl "recycling_chance(used, unseen, distance, others)",
    rust recycling::chance(used, unseen, distance, others),
    draw |d| {
        let unseen = d.below(20);
        let used = d.around(0.5).clamp(0.0, 1.0);
        let share = d.unit();
        (
            d.one_of(&[used, share, 1.0]),
            d.one_of(&[unseen, 1000, recycling::CHOSEN - 1]),
            d.number(-10, 30).abs(),
            d.number(-6, 6).abs(),
        )
    },
    bound ROUNDED,
}

twin! {
    goes_to_emitter ["mixture::mixture_goes_to_emitter"], (index: u32, shift: u32) -> u32,
    wgsl "u32(mixture_goes_to_emitter(index, shift))",
    rust u32::from(mixture::goes_to_emitter(index, shift)),
    // Also the places about the threshold.
    draw |d| {
        let index = d.word();
        let place = 1_431_655_808u32.wrapping_add(d.below(512)).wrapping_sub(256);
        let any = d.word();
        (index, d.one_of(&[any, place.wrapping_sub(index.wrapping_mul(0x9e37_79b9))]))
    },
    bound EXACT,
}
twin! {
    lobe_density ["mixture::mixture_lobe_density"], (cosine: f32, emitters: u32) -> f32,
    wgsl "mixture_lobe_density(cosine, emitters != 0u)",
    rust mixture::lobe_density(cosine, emitters != 0),
    draw |d| { let c = d.unit(); (d.one_of(&[c, c, -c, 1.0]), d.flag()) },
    bound EXACT,
}
twin! {
    guided_density ["mixture::mixture_guided_density"], (cosine: f32, of_guide: f32, guided: f32, emitters: u32) -> f32,
    wgsl "mixture_guided_density(cosine, of_guide, guided, emitters != 0u)",
    rust mixture::guided_density(cosine, of_guide, guided, emitters != 0),
    draw |d| (d.unit(), d.number(-20, 6).abs(), 0.5 * d.unit(), d.flag()),
    bound ROUNDED,
}
twin! {
    follow_guide ["mixture::mixture_follow_guide"], (u: f32, guided: f32) -> [f32; 2],
    wgsl "let c = mixture_follow_guide(u, guided); return array<f32, 2>(f32(c.guided), c.left);",
    rust { let (guided, left) = mixture::follow_guide(u, guided); [f32::from(u8::from(guided)), left] },
    draw |d| {
        let guided = 0.5 * d.unit();
        let near = d.around(guided).clamp(0.0, hash::ALMOST_ONE);
        let any = d.unit();
        (d.one_of(&[near, any]), guided)
    },
    bound DIVIDED,
}
twin! {
    mixture_weight ["mixture::mixture_weight"], (cosine: f32, lobe: f32, emitter: f32) -> f32,
    wgsl "mixture_weight(cosine, lobe, emitter)",
    rust mixture::weight(cosine, lobe, emitter),
    draw |d| (d.between(-0.2, 1.0), d.number(-20, 0).abs(), d.number(-20, 20).abs()),
    bound ROUNDED,
}

twins!(
    steps,
    moments,
    is_known,
    guess,
    pack_moments,
    rescaled,
    chebyshev,
    trust,
    nearness,
    falloff,
    alignment,
    leaning,
    depth_moments,
    depth_visibility,
    depth_openness,
    depth_visibility_within,
    identity,
    is_open,
    mark_of,
    plane_pack,
    plane_unpack,
    lengths_pack,
    lengths_up,
    lengths_down,
    one_more,
    looks,
    chance,
    goes_to_emitter,
    lobe_density,
    guided_density,
    follow_guide,
    mixture_weight,
);
