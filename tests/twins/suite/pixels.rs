//! What pixels see: an engine's G-buffer, what lies between pixels, and debug views.
use super::declare::{DIVIDED, EXACT, ROUNDED};
use super::inputs::Draw;
use super::surfaces::point;
use gibs_graph::glam::{UVec2, UVec4, Vec2, Vec3, Vec4};
use gibs_passes::data::{Camera, DebugPixel, Gathered, HostGbuffer, SurfacePoint};
use gibs_passes::shared::surface::MISS;
use gibs_passes::shared::{debug, gbuffer, lookup, octahedral, upsample};

/// A camera that looks anywhere.
fn camera(d: &mut Draw) -> Camera {
    let forward = d.direction();
    Camera {
        eye: d.vector(-6, 6),
        width: 1 + d.below(4096),
        right: forward.any_orthonormal_vector() * 0.7,
        height: 1 + d.below(4096),
        up: forward.cross(forward.any_orthonormal_vector()) * 0.4,
        pixel_angle: d.magnitude(-12, -6),
        forward,
        pad: 0,
    }
}
/// A depth and the projection that made it: all four kinds, near and far, of floats and of steps.
fn depth(d: &mut Draw) -> (f32, HostGbuffer) {
    let near = f64::from(d.magnitude(-8, 0));
    let far = [None, Some(near * 1000.0)][d.below(2) as usize];
    let mut host = HostGbuffer::perspective(near, far, d.flag() == 1).expect("planes");
    host.jitter = Vec2::new(d.between(-0.5, 0.5), d.between(-0.5, 0.5));
    host.normals = d.below(3);
    host.depth_step = d.one_of(&[0.0, 1.0 / 16_777_215.0]);
    let distance = near as f32 * d.magnitude(0, 9);
    (host.depth_offset + host.depth_scale / distance, host)
}
twin! {
    view_depth ["gbuffer::gbuffer_view_depth"], (z: f32, host: HostGbuffer) -> f32,
    wgsl "gbuffer_view_depth(z, host)",
    rust gbuffer::view_depth(z, &host),
    draw |d| super::depth(d),
    bound DIVIDED,
}
twin! {
    gbuffer_position ["gbuffer::gbuffer_position"], (at: UVec2, z: f32, camera: Camera, host: HostGbuffer) -> Vec3,
    wgsl "gbuffer_position(at, z, camera, host)",
    rust gbuffer::position(at, z, &camera, &host),
    draw |d| {
        let ((z, host), camera) = (super::depth(d), super::camera(d));
        (UVec2::new(d.below(camera.width), d.below(camera.height)), z, camera, host)
    },
    bound ROUNDED,
}
twin! {
    gbuffer_offset ["gbuffer::gbuffer_offset"], (position: Vec3, z: f32, camera: Camera, host: HostGbuffer) -> f32,
    wgsl "gbuffer_offset(position, z, camera, host)",
    rust gbuffer::offset(position, z, &camera, &host),
    draw |d| { let (z, host) = super::depth(d); (d.vector(-6, 12), z, super::camera(d), host) },
    bound ROUNDED,
}
twin! {
    gbuffer_normal ["gbuffer::gbuffer_normal"], (texel: Vec4, host: HostGbuffer) -> Vec3,
    wgsl "gbuffer_normal(texel, host)",
    rust gbuffer::normal(texel, &host),
    draw |d| {
        let (n, (_, host)) = (d.direction(), super::depth(d));
        let texel = match host.normals {
            gbuffer::NORMALS_UNSIGNED => n * 0.5 + 0.5,
            gbuffer::NORMALS_OCTAHEDRAL => octahedral::encode(n).extend(0.0),
            _ => n * d.one_of(&[1.0, 1.0, 0.3]),
        };
        (d.one_of(&[texel, texel, texel, Vec3::ZERO, Vec3::splat(0.5)]).extend(0.0), host)
    },
    bound ROUNDED,
}
twin! {
    gbuffer_facing ["gbuffer::gbuffer_facing"], (normal: Vec3, seen: Vec3) -> Vec3,
    wgsl "gbuffer_facing(normal, seen)",
    rust gbuffer::facing(normal, seen),
    draw |d| (d.direction(), d.vector(-4, 4)),
    bound ROUNDED,
}
twin! {
    gbuffer_sides ["gbuffer::gbuffer_sides"], (plane: Vec3, given: Vec3, seen: Vec3) -> [[f32; 3]; 2],
    wgsl "let s = gbuffer_sides(plane, given, seen);
        return array<array<f32, 3>, 2>(
            array<f32, 3>(s.geometric.x, s.geometric.y, s.geometric.z),
            array<f32, 3>(s.shading.x, s.shading.y, s.shading.z),
        );",
    rust { let (g, s) = gbuffer::sides(plane, given, seen); [g.to_array(), s.to_array()] },
    draw |d| {
        let given = d.direction();
        let near = (given + 0.8 * d.direction()) * d.magnitude(-10, 4);
        let any = d.vector(-10, 10);
        (d.one_of(&[near, -near, any, Vec3::ZERO]), given, d.vector(-4, 4))
    },
    bound ROUNDED,
}

twin! {
    pixel_of ["upsample::upsample_pixel_of"], (texel: UVec2, stride: u32, frame: u32, size: UVec2) -> UVec2,
    wgsl "upsample_pixel_of(texel, stride, frame, size)",
    rust upsample::pixel_of(texel, stride, frame, size),
    draw |d| {
        let size = UVec2::new(1 + d.below(9), 1 + d.below(4096));
        (UVec2::new(d.below(size.x), d.below(size.y)), 1 + d.flag(), d.word(), size)
    },
    bound EXACT,
}
twin! {
    around ["upsample::upsample_around"], (at: UVec2) -> UVec4,
    wgsl "upsample_around(at)",
    rust { let (low, high) = upsample::around(at); UVec4::new(low.x, low.y, high.x, high.y) },
    draw |d| (UVec2::new(d.below(65_536), d.below(65_536)),),
    bound EXACT,
}
twin! {
    block_of ["upsample::upsample_block_of"], (at: UVec2, width: u32) -> u32,
    wgsl "upsample_block_of(at, width)",
    rust upsample::block_of(at, width),
    draw |d| {
        let width = 1 + d.below(65_536);
        (UVec2::new(d.below(width), d.below(65_536)), width)
    },
    bound EXACT,
}
twin! {
    pixel_in ["upsample::upsample_pixel_in"], (block: u32, number: u32, width: u32) -> UVec2,
    wgsl "upsample_pixel_in(block, number, width)",
    rust upsample::pixels_of(block, width)[number as usize],
    draw |d| (d.below(1 << 30), d.below(4), d.below(65_537)),
    bound EXACT,
}
/// Of a picture of 9x7 pixels what each sees, and whether it was selected.
fn picture() -> (Vec<SurfacePoint>, Vec<u32>) {
    let pixel = |i: u32| {
        let mut d = Draw::of(i);
        (d.one_of(&[point(&mut Draw::of(i), None), MISS]), d.flag())
    };
    (0..63).map(pixel).unzip()
}
twin! {
    is_open ["between::between_is_open"], (at: UVec2) -> u32,
    wgsl "camera.width = 9u; camera.height = 7u; return u32(between_is_open(at));",
    rust u32::from(upsample::is_open(points, selected, at, UVec2::new(9, 7))),
    draw |d| (UVec2::new(d.below(11), d.below(9)),),
    bound EXACT,
    uses ["types::Camera"],
    text "var<private> camera: Camera;",
    globals {
        points: SurfacePoint = super::picture().0,
        selected: u32 = super::picture().1,
    },
}
twin! {
    tolerance ["upsample::upsample_tolerance"], (point: SurfacePoint, camera: Camera) -> f32,
    wgsl "upsample_tolerance(point, camera)",
    rust upsample::tolerance(&point, &camera),
    draw |d| (super::point(d, None), super::camera(d)),
    bound ROUNDED,
}
twin! {
    continuous ["upsample::upsample_continuous"], (a: SurfacePoint, b: SurfacePoint, tolerance: f32) -> u32,
    wgsl "u32(upsample_continuous(a, b, tolerance))",
    rust {
        let normals = (octahedral::unpack(a.geometric_normal), octahedral::unpack(a.shading_normal));
        u32::from(upsample::continuous(&a, normals, &b, tolerance))
    },
    draw |d| {
        let a = super::point(d, None);
        (a, super::point(d, Some(&a)), d.one_of(&[0.0, 0.01, 0.1]))
    },
    bound ROUNDED,
}
fn gathered(d: &mut Draw) -> Gathered {
    let weight = d.unit();
    Gathered {
        irradiance: d.light(-10, 10),
        weight: d.one_of(&[weight, 0.0, 1.0]),
        average: d.light(-10, 10),
        confidence: d.unit(),
    }
}
twin! {
    complete ["lookup::lookup_complete"], (g: Gathered) -> Vec3,
    wgsl "lookup_complete(g)",
    rust lookup::complete(&g),
    draw |d| (super::gathered(d),),
    bound ROUNDED,
}
twin! {
    light ["upsample::upsample_light"], (g: Gathered) -> f32,
    wgsl "upsample_light(g)",
    rust upsample::light(&g),
    draw |d| (super::gathered(d),),
    bound ROUNDED,
}
twin! {
    mean_of_four ["upsample::upsample_mean"], (a: Gathered, b: Gathered, c: Gathered, e: Gathered) -> Gathered,
    wgsl "upsample_mean(a, b, c, e)",
    rust upsample::mean([&a, &b, &c, &e]),
    draw |d| (super::gathered(d), super::gathered(d), super::gathered(d), super::gathered(d)),
    bound ROUNDED,
}

twin! {
    debug_nothing ["debug::debug_nothing"], (unused: u32) -> DebugPixel,
    wgsl "debug_nothing()",
    rust { let _ = unused; debug::NOTHING },
    draw |_| (0,),
    bound EXACT,
    cases 64,
}
twin! {
    headlight ["debug::debug_headlight"], (to_eye: Vec3, normal: Vec3) -> f32,
    wgsl "debug_headlight(to_eye, normal)",
    rust debug::headlight(to_eye, normal),
    draw |d| (d.vector(-10, 10), d.direction()),
    bound ROUNDED,
}

twins!(
    view_depth,
    gbuffer_position,
    gbuffer_offset,
    gbuffer_normal,
    gbuffer_facing,
    gbuffer_sides,
    pixel_of,
    around,
    block_of,
    pixel_in,
    is_open,
    tolerance,
    continuous,
    complete,
    light,
    mean_of_four,
    debug_nothing,
    headlight,
);
