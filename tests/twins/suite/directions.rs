//! Vectors, affine maps, octahedral maps and directions over the hemisphere.
use super::declare::{EXACT, ROUNDED};
use gibs_graph::glam::{UVec2, Vec2, Vec3, Vec4};
use gibs_passes::accel::intersect::transform_vector;
use gibs_passes::shared::{octahedral, sampling};
use gibs_passes::stages::resolve_hits::{leveled, map_point, map_transposed};

twin! {
    dot ["vector::vector_dot"], (a: Vec3, b: Vec3) -> f32,
    wgsl "vector_dot(a, b)",
    rust a.dot(b),
    draw |d| (d.vector(-20, 20), d.vector(-20, 20)),
    bound ROUNDED,
}
twin! {
    cross ["vector::vector_cross"], (a: Vec3, b: Vec3) -> Vec3,
    wgsl "vector_cross(a, b)",
    rust a.cross(b),
    draw |d| (d.vector(-20, 20), d.vector(-20, 20)),
    bound ROUNDED,
}
twin! {
    length ["vector::vector_length"], (v: Vec3) -> f32,
    wgsl "vector_length(v)",
    rust v.length(),
    draw |d| (d.vector(-70, 63),),
    bound ROUNDED,
}
twin! {
    normalize ["vector::vector_normalize"], (v: Vec3) -> Vec3,
    wgsl "vector_normalize(v)",
    rust v.normalize(),
    draw |d| {
        let v = d.vector(-60, 60);
        (if v == Vec3::ZERO { Vec3::NEG_Y } else { v },)
    },
    bound ROUNDED,
}
twin! {
    leveled ["vector::vector_leveled"], (v: Vec3) -> Vec3,
    wgsl "vector_leveled(v)",
    rust leveled(v),
    draw |d| (Vec3::new(d.signed(-126, 127), d.signed(-126, 127), d.signed(-126, 127)),),
    bound EXACT,
}
twin! {
    max_element ["vector::vector_max_element"], (v: Vec3) -> f32,
    wgsl "vector_max_element(v)",
    rust v.max_element(),
    draw |d| (Vec3::new(d.signed(-126, 128), d.signed(-126, 128), d.signed(-126, 128)),),
    bound EXACT,
}

/// Rows of a map that scales by so much at most.
fn rows(d: &mut super::inputs::Draw) -> [Vec4; 3] {
    std::array::from_fn(|_| d.vector(-10, 4).extend(d.number(-10, 12)))
}
twin! {
    affine_point ["affine::affine_map_point"], (rows: [Vec4; 3], p: Vec3) -> Vec3,
    wgsl "affine_map_point(rows, p)",
    rust map_point(&rows, p),
    draw |d| (super::rows(d), d.vector(-10, 12)),
    bound ROUNDED,
}
twin! {
    affine_vector ["affine::affine_map_vector"], (rows: [Vec4; 3], v: Vec3) -> Vec3,
    wgsl "affine_map_vector(rows, v)",
    rust transform_vector(&rows, v),
    draw |d| (super::rows(d), d.vector(-10, 12)),
    bound ROUNDED,
}
twin! {
    affine_transposed ["affine::affine_map_transposed"], (rows: [Vec4; 3], v: Vec3) -> Vec3,
    wgsl "affine_map_transposed(rows, v)",
    rust map_transposed(&rows, v),
    draw |d| (super::rows(d), d.vector(-10, 12)),
    bound ROUNDED,
}

twin! {
    octahedral_encode ["octahedral::octahedral_encode"], (n: Vec3) -> Vec2,
    wgsl "octahedral_encode(n)",
    rust octahedral::encode(n),
    draw |d| (d.direction(),),
    bound ROUNDED,
}
/// A point of the square `[-1, 1]^2`: its corners, edges, middle and the diagonals where it folds.
fn square(d: &mut super::inputs::Draw) -> Vec2 {
    let x = match d.below(4) {
        0 => d.one_of(&[-1.0, -0.0, 0.0, 0.5, 1.0]),
        _ => d.between(-1.0, 1.0),
    };
    let fold = d.around(1.0 - x.abs()).clamp(-1.0, 1.0);
    let any = d.between(-1.0, 1.0);
    let y = d.one_of(&[fold, -fold, any, any, 0.0, -0.0]);
    if d.flag() == 0 {
        Vec2::new(x, y)
    } else {
        Vec2::new(y, x)
    }
}
twin! {
    octahedral_decode ["octahedral::octahedral_decode"], (p: Vec2) -> Vec3,
    wgsl "octahedral_decode(p)",
    rust octahedral::decode(p),
    draw |d| (super::square(d),),
    bound ROUNDED,
}
twin! {
    octahedral_pack ["octahedral::octahedral_pack"], (n: Vec3) -> u32,
    wgsl "octahedral_pack(n)",
    rust octahedral::pack(n),
    draw |d| (d.direction(),),
    bound ROUNDED,
}
twin! {
    octahedral_unpack ["octahedral::octahedral_unpack"], (bits: u32) -> Vec3,
    wgsl "octahedral_unpack(bits)",
    rust octahedral::unpack(bits),
    draw |d| {
        let mut half = || d.one_of(&[0, 1, 0x7fff, 0x8000, 0xfffe, 0xffff]);
        let edge = half() | half() << 16;
        let any = d.bits();
        (d.one_of(&[edge, any, any]),)
    },
    bound ROUNDED,
}
twin! {
    hemisphere_encode ["octahedral::octahedral_hemisphere_encode"], (v: Vec3) -> Vec2,
    wgsl "octahedral_hemisphere_encode(v)",
    rust octahedral::hemisphere_encode(v),
    draw |d| (d.upward() * (d.word() % 16).min(1) as f32,),
    bound ROUNDED,
}
twin! {
    hemisphere_decode ["octahedral::octahedral_hemisphere_decode"], (uv: Vec2) -> Vec3,
    wgsl "octahedral_hemisphere_decode(uv)",
    rust octahedral::hemisphere_decode(uv),
    draw |d| (super::square(d).abs(),),
    bound ROUNDED,
}

twin! {
    basis ["sampling::sampling_basis"], (n: Vec3) -> [[f32; 3]; 2],
    wgsl "let b = sampling_basis(n);
        return array<array<f32, 3>, 2>(
            array<f32, 3>(b.tangent.x, b.tangent.y, b.tangent.z),
            array<f32, 3>(b.bitangent.x, b.bitangent.y, b.bitangent.z),
        );",
    rust { let (t, b) = sampling::basis(n); [t.to_array(), b.to_array()] },
    draw |d| (d.direction(),),
    bound ROUNDED,
}
twin! {
    to_world ["sampling::sampling_to_world"], (local: Vec3, n: Vec3) -> Vec3,
    wgsl "sampling_to_world(local, n)",
    rust sampling::to_world(local, n),
    draw |d| (d.direction(), d.direction()),
    bound ROUNDED,
}
twin! {
    to_local ["sampling::sampling_to_local"], (world: Vec3, n: Vec3) -> Vec3,
    wgsl "sampling_to_local(world, n)",
    rust sampling::to_local(world, n),
    draw |d| (d.direction(), d.direction()),
    bound ROUNDED,
}
twin! {
    cosine_hemisphere ["sampling::sampling_cosine_hemisphere"], (u: f32, v: f32) -> Vec3,
    wgsl "sampling_cosine_hemisphere(u, v)",
    rust sampling::cosine_hemisphere(u, v),
    draw |d| (d.unit(), d.unit()),
    bound ROUNDED,
}
twin! {
    r2 ["sampling::sampling_r2"], (index: u32, shift: UVec2) -> Vec2,
    wgsl "sampling_r2(index, shift)",
    rust { let (x, y) = sampling::r2(index, (shift.x, shift.y)); Vec2::new(x, y) },
    draw |d| (d.word(), UVec2::new(d.word(), d.word())),
    bound EXACT,
}
twin! {
    ray_start ["sampling::sampling_start"], (position: Vec3, n: Vec3, offset: f32, below: f32, direction: Vec3) -> Vec3,
    wgsl "sampling_start(position, n, offset, below, direction)",
    rust sampling::start(position, n, offset, below, direction),
    draw |d| (d.vector(-10, 14), d.direction(), d.magnitude(-40, 0), d.one_of(&[0.0, 0.5]), d.direction()),
    bound ROUNDED,
}

twins!(
    dot,
    cross,
    length,
    normalize,
    leveled,
    max_element,
    affine_point,
    affine_vector,
    affine_transposed,
    octahedral_encode,
    octahedral_decode,
    octahedral_pack,
    octahedral_unpack,
    hemisphere_encode,
    hemisphere_decode,
    basis,
    to_world,
    to_local,
    cosine_hemisphere,
    r2,
    ray_start,
);
