//! What rays hit: points on surfaces and their textures.
use super::declare::{DIVIDED, EXACT, ROUNDED};
use super::inputs::Draw;
use gibs_graph::glam::{UVec2, Vec2, Vec3, Vec4};
use gibs_passes::data::{Corners, Material, NONE, Ray, SurfacePoint};
use gibs_passes::shared::{hash, octahedral, surface, texture};
use gibs_passes::stages::trace_closest;

/// A number from 0 to 1 and beyond, the middles between two of 65536 steps among them.
fn share(d: &mut Draw) -> f32 {
    let middle = (d.below(65_535) as f32 + 0.5) / 65_535.0;
    let middle = d.around(middle);
    let any = d.unit();
    d.one_of(&[middle, any, any, 1.0, 1.5, -0.5])
}
twin! {
    unorm16 ["surface::surface_unorm16"], (x: f32) -> u32,
    wgsl "surface_unorm16(x)",
    rust surface::unorm16(x),
    draw |d| (super::share(d),),
    bound ROUNDED,
}
twin! {
    pack_albedo ["surface::surface_pack_albedo"], (albedo: Vec3, flags: u32) -> UVec2,
    wgsl "surface_pack_albedo(albedo, flags)",
    rust { let (a, b) = surface::pack_albedo(albedo, flags); UVec2::new(a, b) },
    draw |d| (Vec3::new(super::share(d), super::share(d), super::share(d)), d.flag() << 16),
    bound ROUNDED,
}

/// A point on a surface near another one: in its plane, off it by a little, with other normals, of another node.
pub fn point(d: &mut Draw, near: Option<&SurfacePoint>) -> SurfacePoint {
    let drawn = SurfacePoint {
        position: d.vector(-6, 6),
        offset: d.magnitude(-30, -10),
        geometric_normal: octahedral::pack(d.direction()),
        shading_normal: octahedral::pack(d.direction()),
        albedo_rg: d.word(),
        albedo_b_flags: d.word(),
        emission: d.light(-10, 10),
        transform_id: d.one_of(&[0, 0, 0, 1, NONE]),
    };
    let Some(near) = near else { return drawn };
    let normal = octahedral::unpack(near.geometric_normal);
    let tilted = |d: &mut Draw, by: f32| {
        octahedral::pack((normal + by * d.direction()).normalize_or(normal))
    };
    SurfacePoint {
        position: near.position + normal.cross(d.direction()) + normal * d.number(-12, -3),
        geometric_normal: if d.flag() == 0 {
            near.geometric_normal
        } else {
            tilted(d, 0.1)
        },
        shading_normal: if d.once_in(4) {
            near.shading_normal
        } else {
            tilted(d, 0.5)
        },
        ..drawn
    }
}
twin! {
    albedo ["surface::surface_albedo"], (point: SurfacePoint) -> Vec3,
    wgsl "surface_albedo(point)",
    rust surface::albedo(&point),
    draw |d| (super::point(d, None),),
    bound DIVIDED,
}
twin! {
    is_surface ["surface::surface_is_surface"], (point: SurfacePoint) -> u32,
    wgsl "u32(surface_is_surface(point))",
    rust u32::from(surface::is_surface(&point)),
    draw |d| (super::point(d, None),),
    bound EXACT,
}
twin! {
    miss ["surface::surface_miss"], (unused: u32) -> SurfacePoint,
    wgsl "surface_miss()",
    rust { let _ = unused; surface::MISS },
    draw |_| (0,),
    bound EXACT,
    cases 64,
}

/// The table of sRGB bytes, and after it a picture of 5x3 texels and one of 1x1.
pub fn texels() -> Vec<u32> {
    texture::srgb_table()
        .into_iter()
        .chain((0..16).map(hash::pcg))
        .collect()
}
/// Any material over those pictures.
pub fn material(d: &mut Draw) -> Material {
    let any = |d: &mut Draw| {
        d.one_of(&[
            (256, 5 | 3 << 16),
            (256, 5 | 3 << 16),
            (271, 1 | 1 << 16),
            (NONE, 0),
        ])
    };
    let (base, emission) = (any(d), any(d));
    Material {
        base_color: d.light(-4, 1),
        alpha: d.unit(),
        emission: d.light(-10, 10),
        flags: d.below(8),
        base_u: d.vector(-2, 3),
        base_texels: base.0,
        base_v: d.vector(-2, 3),
        base_size: base.1,
        emission_u: d.vector(-2, 3),
        emission_texels: emission.0,
        emission_v: d.vector(-2, 3),
        emission_size: emission.1,
        cutoff: d.unit(),
        base_sampler: d.below(32),
        emission_sampler: d.below(32),
        pad: 0,
    }
}
fn materials() -> Vec<Material> {
    (0..256).map(|i| material(&mut Draw::of(i))).collect()
}
/// Texture coordinates: on texels' edges and middles, within the picture, far outside.
fn uv(d: &mut Draw) -> Vec2 {
    let one = |d: &mut Draw| {
        let edge = (d.below(61) as f32 - 30.0) / 10.0;
        let edge = d.around(edge);
        let (near, far) = (d.between(-2.0, 3.0), d.number(-10, 12));
        d.one_of(&[edge, near, near, far])
    };
    Vec2::new(one(d), one(d))
}
twin! {
    texture_sample ["texture::texture_sample"], (wrapping: u32, uv: Vec2) -> Vec4,
    wgsl "texture_sample(256u, 5u | (3u << 16u), wrapping, uv)",
    rust texture::sample(texels, 256, 5 | 3 << 16, wrapping, uv),
    draw |d| (d.below(32), super::uv(d)),
    bound ROUNDED,
    features ["texels"],
    globals { materials: Material = super::materials(), texels: u32 = super::texels() },
}
twin! {
    uv_at ["texture::texture_uv_at"], (uvs: [Vec2; 3], u: f32, v: f32) -> Vec2,
    wgsl "texture_uv_at(uvs, u, v)",
    rust trace_closest::uv_at(&Corners { uvs, ..Corners::default() }, u, v),
    draw |d| {
        let uvs = [super::uv(d), super::uv(d), super::uv(d)];
        let u = d.unit();
        (uvs, u, d.unit() * (1.0 - u))
    },
    bound ROUNDED,
    globals { materials: Material = super::materials() },
}
twin! {
    base_color ["texture::texture_base_color"], (index: u32, uv: Vec2) -> Vec4,
    wgsl "texture_base_color(index, uv)",
    rust texture::base_color(&materials[index as usize], texels, uv),
    draw |d| (d.below(256), super::uv(d)),
    bound ROUNDED,
    features ["texels"],
    globals { materials: Material = super::materials(), texels: u32 = super::texels() },
}
twin! {
    emission ["texture::texture_emission"], (index: u32, uv: Vec2) -> Vec3,
    wgsl "texture_emission(index, uv)",
    rust texture::emission(&materials[index as usize], texels, uv),
    draw |d| (d.below(256), super::uv(d)),
    bound ROUNDED,
    features ["texels"],
    globals { materials: Material = super::materials(), texels: u32 = super::texels() },
}
twin! {
    is_sampled ["texture::texture_is_sampled_emitter"], (index: u32) -> u32,
    wgsl "u32(texture_is_sampled_emitter(index))",
    rust u32::from(texture::is_sampled_emitter(&materials[index as usize])),
    draw |d| (d.below(256),),
    bound EXACT,
    features ["texels"],
    globals { materials: Material = super::materials(), texels: u32 = super::texels() },
}
twin! {
    stops ["texture::texture_stops"], (index: u32, uv: Vec2, ray: Ray, triangle: u32) -> u32,
    wgsl "u32(texture_stops(index, uv, ray, triangle))",
    rust u32::from(texture::stops(&materials[index as usize], texels, uv, &ray, triangle)),
    draw |d| {
        let (origin, direction) = (d.vector(-6, 6), d.direction());
        let ray = Ray { origin, t_min: d.one_of(&[0.0, 0.0, -0.0]), direction, t_max: f32::MAX };
        (d.below(256), super::uv(d), ray, d.word())
    },
    bound ROUNDED,
    features ["texels"],
    globals { materials: Material = super::materials(), texels: u32 = super::texels() },
}

twins!(
    unorm16,
    pack_albedo,
    albedo,
    is_surface,
    miss,
    texture_sample,
    uv_at,
    base_color,
    emission,
    is_sampled,
    stops,
);
