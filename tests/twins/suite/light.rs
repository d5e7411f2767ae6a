//! Where light comes from: emitters, the sky, and rays to them.
use super::declare::{EXACT, ROUNDED};
use super::inputs::Draw;
use gibs_graph::glam::{Vec2, Vec3, Vec4};
use gibs_passes::data::{Emitter, Frame};
use gibs_passes::shared::mixture::{self, Drawn};
use gibs_passes::shared::{emitter, environment, hash};
use gibs_passes::stages::reference_emitters;

/// An emissive triangle: of ordinary shape, thin, small, or without area.
fn triangle(d: &mut Draw) -> Emitter {
    let e1 = d.vector(-6, 4);
    let e2 = match d.below(5) {
        0 => e1 * d.between(-2.0, 2.0),
        1 => e1 + d.vector(-12, -8),
        _ => d.vector(-6, 4),
    };
    Emitter {
        v0: d.vector(-4, 6),
        e1,
        flags: d.below(4),
        e2,
        radiance: d.light(-10, 20),
        ..Emitter::default()
    }
}

twin! {
    sky_share ["emitter::emitter_sky_share"], (frame: Frame) -> f32,
    wgsl "emitter_sky_share(frame)",
    rust emitter::sky_share(&frame),
    draw |d| (Frame { sky_sampled: d.flag(), emitter_power: d.number(-20, 20).abs(), ..Frame::default() },),
    bound EXACT,
}
twin! {
    triangle_point ["emitter::emitter_triangle_point"], (a: f32, b: f32) -> Vec2,
    wgsl "emitter_triangle_point(a, b)",
    rust { let (u, v) = emitter::triangle_point(a, b); Vec2::new(u, v) },
    draw |d| (d.unit(), d.unit()),
    bound ROUNDED,
}
twin! {
    facing ["emitter::emitter_facing"], (chosen: Emitter, direction: Vec3) -> f32,
    wgsl "emitter_facing(chosen, direction)",
    rust emitter::facing(&chosen, direction),
    draw |d| (super::triangle(d), d.direction()),
    bound ROUNDED,
}
twin! {
    radiance ["emitter::emitter_radiance"], (chosen: Emitter, direction: Vec3) -> Vec3,
    wgsl "emitter_radiance(chosen, direction)",
    rust emitter::radiance(&chosen, direction),
    draw |d| (super::triangle(d), d.direction()),
    bound ROUNDED,
}
twin! {
    density ["emitter::emitter_density"], (frame: Frame, radiance: Vec3, cosine: f32, distance: f32) -> f32,
    wgsl "emitter_density(frame, radiance, cosine, distance)",
    rust emitter::density(&frame, radiance, cosine, distance),
    draw |d| {
        let frame = Frame { emitter_power: d.number(-10, 20).abs(), ..Frame::default() };
        (frame, d.light(-10, 20), d.between(-0.2, 1.0), d.magnitude(-10, 10))
    },
    bound ROUNDED,
}

/// Maps of this side, each texel with its own number.
const SIDE: u32 = 32;
fn map() -> Vec<Vec4> {
    (0..SIDE * SIDE)
        .map(|i| Vec3::splat(i as f32).extend(hash::unit(hash::pcg(i))))
        .collect()
}
twin! {
    sky_texel ["environment::environment_texel"], (direction: Vec3, side: u32) -> Vec4,
    wgsl "environment_texel(side, direction)",
    rust environment::texel(environment, side, direction),
    draw |d| (d.direction(), d.one_of(&[1, 2, 31, 32])),
    bound ROUNDED,
    globals { environment: Vec4 = super::map() },
}
twin! {
    sky_radiance ["sky::sky_radiance"], (direction: Vec3, side: u32) -> Vec3,
    wgsl "sky_radiance(side, direction)",
    rust environment::radiance(environment, side, direction),
    draw |d| (d.direction(), d.one_of(&[1, 2, 31, 32])),
    bound ROUNDED,
    features ["environment"],
    globals { environment: Vec4 = super::map() },
}
twin! {
    sky_unbound [], (direction: Vec3) -> Vec3,
    wgsl "sky_radiance(1u, direction)",
    rust environment::radiance(&[], 1, direction),
    draw |d| (d.direction(),),
    bound EXACT,
    uses ["sky::sky_radiance"],
    cases 64,
}
twin! {
    sky_direction ["environment::environment_direction"], (side: u32, x: u32, y: u32, uv: Vec2) -> Vec3,
    wgsl "environment_direction(side, x, y, uv.x, uv.y)",
    rust environment::direction(side, x, y, uv.x, uv.y),
    draw |d| {
        let side = d.one_of(&[1, 2, 64, 1024]);
        let corner = Vec2::new(d.one_of(&[0.0, 0.5]), d.one_of(&[0.0, 0.5]));
        let any = d.units();
        (side, d.below(side), d.below(side), d.one_of(&[corner, any, any]))
    },
    bound ROUNDED,
    globals { environment: Vec4 = super::map() },
}
twin! {
    solid_angle ["environment::environment_solid_angle_per_area"], (direction: Vec3) -> f32,
    wgsl "environment_solid_angle_per_area(direction)",
    rust environment::solid_angle_per_area(direction),
    draw |d| (d.direction(),),
    bound ROUNDED,
    globals { environment: Vec4 = super::map() },
}

/// What kernels keep of a drawn ray.
fn words(drawn: &Drawn) -> [f32; 6] {
    let [x, y, z] = drawn.direction.to_array();
    [x, y, z, drawn.t_max, drawn.cosine, drawn.density]
}
/// The same in WGSL.
macro_rules! drawn {
    ($expression:literal) => {
        concat!(
            "let r = ",
            $expression,
            "; return array<f32, 6>(r.direction.x, r.direction.y, r.direction.z, r.t_max, r.cosine, r.density);"
        )
    };
}
twin! {
    over_the_lobe ["draw::draw_over_the_lobe"], (normal: Vec3, uv: Vec2, emitters: u32) -> [f32; 6],
    wgsl drawn!("draw_over_the_lobe(normal, uv, emitters != 0u)"),
    rust super::words(&mixture::over_the_lobe(normal, (uv.x, uv.y), emitters != 0)),
    draw |d| (d.direction(), d.units(), d.flag()),
    bound ROUNDED,
}

/// Emitters with rising probability, some of them without any.
fn emitters() -> Vec<Emitter> {
    let mut sum = 0.0;
    let of = |i: u32| {
        sum += if i.is_multiple_of(5) { 0.0 } else { 1.0 / 32.0 };
        Emitter {
            cumulative: f32::min(sum, 1.0),
            ..triangle(&mut Draw::of(i))
        }
    };
    (0..40).map(of).collect()
}
twin! {
    find_emitter ["draw::draw_find_emitter"], (x: f32) -> u32,
    wgsl "draw_find_emitter(x)",
    rust reference_emitters::find(emitters.len() as u32, x, |k| emitters[k as usize].cumulative),
    draw |d| { let at = d.below(33) as f32 / 32.0; let x = d.around(at); let any = d.unit(); (d.one_of(&[x, any]),) },
    bound EXACT,
    features ["emitters"],
    globals { emitters: Emitter = super::emitters() },
}
twin! {
    to_emitter ["draw::draw_to_emitter"], (position: Vec3, normal: Vec3, uv: Vec2, seed: u32) -> [f32; 6],
    wgsl drawn!("draw_to_emitter(position, normal, uv, seed)"),
    rust super::words(&mixture::to_emitter(emitters, position, normal, (uv.x, uv.y), seed)),
    draw |d| (d.vector(-4, 6), d.direction(), d.units(), d.word()),
    bound ROUNDED,
    features ["emitters"],
    globals { emitters: Emitter = super::emitters() },
}
twin! {
    draw_ray ["draw::draw_ray"],
    (position: Vec3, normal: Vec3, uv: Vec2, seed: u32, at_emitter: u32) -> [f32; 6],
    wgsl drawn!("draw_ray(position, normal, uv, seed, at_emitter != 0u)"),
    rust super::words(&match at_emitter {
        0 => mixture::over_the_lobe(normal, (uv.x, uv.y), true),
        _ => mixture::to_emitter(emitters, position, normal, (uv.x, uv.y), seed),
    }),
    draw |d| (d.vector(-4, 6), d.direction(), d.units(), d.word(), d.flag()),
    bound ROUNDED,
    features ["emitters"],
    globals { emitters: Emitter = super::emitters() },
}
twin! {
    direct_light ["direct::direct_irradiance"], (i: u32) -> Vec3,
    wgsl "direct_irradiance(i)",
    rust direct[i as usize].truncate(),
    draw |d| (d.below(1024),),
    bound EXACT,
    features ["direct"],
    globals { direct: Vec4 = super::map() },
}

twins!(
    sky_share,
    triangle_point,
    facing,
    radiance,
    density,
    sky_texel,
    sky_radiance,
    sky_unbound,
    sky_direction,
    solid_angle,
    over_the_lobe,
    find_emitter,
    to_emitter,
    draw_ray,
    direct_light,
);
