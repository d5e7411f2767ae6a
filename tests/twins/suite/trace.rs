//! Rays against boxes, triangles and the two-level tree.
use super::declare::{DIVIDED, EXACT, ROUNDED};
use super::inputs::Draw;
use super::surfaces::{material, texels};
use gibs_graph::glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use gibs_passes::accel::intersect::{BoxRay, InstanceRay};
use gibs_passes::accel::{AccelView, BlasInput, InstanceInput, MeshPart, TwoLevel, scalar};
use gibs_passes::data::{BvhNode, Corners, Hit, Instance, Material, Ray, Triangle};
use gibs_passes::stages::trace_closest::stops;
use std::sync::OnceLock;

/// Directions with components of any size, zeros of both signs among them.
fn direction(d: &mut Draw) -> Vec3 {
    let (unit, any) = (d.direction(), d.vector(-70, 70));
    d.one_of(&[unit, unit, any])
}

twin! {
    is_sound ["intersect::intersect_is_sound"], (origin: Vec3, direction: Vec3) -> u32,
    wgsl "u32(intersect_is_sound(origin, direction))",
    rust u32::from(BoxRay::new(origin, direction).is_some()),
    draw |d| {
        let far = Vec3::new(d.around(1e18), d.float(), 0.0);
        let near = d.vector(-20, 20);
        (d.one_of(&[near, far]), Vec3::new(d.float(), d.float(), d.float()))
    },
    bound EXACT,
}
twin! {
    inverse ["intersect::intersect_inverse"], (direction: Vec3) -> Vec3,
    wgsl "intersect_inverse(direction)",
    rust BoxRay::new(Vec3::ZERO, direction).map_or(Vec3::ZERO, |ray| ray.inverse),
    draw |d| { let least = d.around(1e-18); let v = super::direction(d); (d.one_of(&[v, v.with_y(least)]),) },
    bound DIVIDED,
}
twin! {
    box_entry ["intersect::intersect_box"],
    (low: Vec3, high: Vec3, origin: Vec3, direction: Vec3, t_min: f32) -> [f32; 2],
    wgsl "let b = intersect_box(low, high, origin, intersect_inverse(direction), t_min);
        return array<f32, 2>(f32(b.x <= b.y), select(0.0, b.x, b.x <= b.y));",
    rust BoxRay::new(origin, direction)
        .and_then(|ray| ray.enter(low, high, t_min))
        .map_or([0.0, 0.0], |near| [1.0, near]),
    // Rays along faces and edges, from within, past corners; boxes that are flat or inverted.
    draw |d| {
        let low = d.vector(-4, 6);
        let size = d.vector(-4, 4);
        let high = low + if d.once_in(8) { size } else { size.abs() };
        let start = d.vector(-4, 7);
        let at = low + (high - low) * Vec3::new(d.unit(), d.unit(), d.unit());
        let origin = d.one_of(&[start, at, low, high, start.with_x(low.x)]);
        let way = (at - origin).normalize_or(Vec3::X);
        let any = super::direction(d);
        (low, high, origin, d.one_of(&[way, way, any]), d.number(-10, 4).abs())
    },
    bound ROUNDED,
    uses ["intersect::intersect_inverse"],
}
twin! {
    triangle_hit ["intersect::intersect_triangle"],
    (triangle: Triangle, origin: Vec3, direction: Vec3, t_min: f32) -> [f32; 3],
    wgsl "let h = intersect_triangle(triangle, origin, direction, intersect_inverse(direction), t_min);
        return array<f32, 3>(h.t, h.u, h.v);",
    rust {
        let ray = BoxRay::new(origin, direction).map(|ray| InstanceRay { ray, t_min, near: 0.0 });
        match ray.and_then(|ray| ray.hit(&triangle)) {
            Some(hit) => [hit.t, hit.u, hit.v],
            None => [-1.0, 0.0, 0.0],
        }
    },
    // Towards corners, edges and the middle, and beside them; along the plane; triangles without area.
    draw |d| {
        let (v0, e1) = (d.vector(-4, 6), d.vector(-4, 4));
        let e2 = match d.below(6) {
            0 => e1 * d.between(-1.0, 1.0),
            _ => d.vector(-4, 4),
        };
        let (u, v) = (d.unit(), d.unit());
        let (u, v) = d.one_of(&[(u, v * (1.0 - u)), (u, v), (u, 0.0), (0.0, v), (u, 1.0 - u), (0.0, 0.0)]);
        let at = v0 + e1 * u + e2 * v;
        let origin = d.vector(-4, 7);
        // Also from a corner, where the distance is zero.
        let origin = d.one_of(&[origin, origin, origin, v0]);
        let any = super::direction(d);
        let way = (at - origin) * d.magnitude(-3, 3);
        let t_min = d.one_of(&[0.0, 0.0, 0.5]);
        (Triangle { v0, e1, e2, ..Triangle::default() }, origin, d.one_of(&[way, way, e1 + e2, any]), t_min)
    },
    bound ROUNDED,
    uses ["intersect::intersect_inverse"],
}
twin! {
    trace_miss ["trace::trace_miss"], (t_max: f32) -> Hit,
    wgsl "trace_miss(t_max)",
    rust Hit::miss(t_max),
    draw |d| (d.magnitude(-20, 128),),
    bound EXACT,
    globals {
        nodes: BvhNode = super::tree().nodes.clone(),
        triangles: Triangle = super::tree().triangles.clone(),
        instances: Instance = super::tree().instances.clone(),
    },
}

/// Triangles of a bottom level.
const TRIANGLES: u32 = 60;

/// A heap of small triangles and a sheet with the alpha test, each placed several times.
fn tree() -> &'static TwoLevel {
    static TREE: OnceLock<TwoLevel> = OnceLock::new();
    TREE.get_or_init(|| {
        let mut d = Draw::of(1);
        let mut position = |i: u32| {
            let middle = Vec3::new((i / 3 % 5) as f32, (i / 15) as f32, 2.0) * 0.5 - 1.0;
            middle
                + Vec3::new(
                    d.between(-0.4, 0.4),
                    d.between(-0.4, 0.4),
                    d.between(-0.4, 0.4),
                )
        };
        let positions: Vec<Vec3> = (0..3 * TRIANGLES).map(&mut position).collect();
        let triangles: Vec<[u32; 3]> = (0..TRIANGLES)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect();
        let part = |material, alpha_test| MeshPart {
            positions: &positions,
            triangles: &triangles,
            material,
            alpha_test,
            ..MeshPart::default()
        };
        let parts = [[part(0, false)], [part(1, true)], [part(2, true)]];
        let levels = parts.each_ref().map(|parts| BlasInput { parts });
        let instance = |i: u32| {
            let turn = DQuat::from_euler(Default::default(), f64::from(i), 0.3, 0.1);
            let place = DVec3::new(f64::from(i % 3), f64::from(i / 3), 0.5) * 1.5;
            let scale = DVec3::new(
                1.0,
                1.0 + 0.1 * f64::from(i),
                if i % 4 == 3 { -1.0 } else { 1.0 },
            );
            let object_to_world = DAffine3::from_scale_rotation_translation(scale, turn, place);
            InstanceInput {
                blas: i % 3,
                object_to_world,
                transform_id: i,
            }
        };
        let instances: Vec<_> = (0..9).map(instance).collect();
        TwoLevel::build(&levels, &instances).expect("triangles")
    })
}
fn corners() -> Vec<Corners> {
    let mut d = Draw::of(2);
    let mut uv = || Vec2::new(d.between(-1.0, 2.0), d.between(-1.0, 2.0));
    let mut of = |_| Corners {
        uvs: [uv(), uv(), uv()],
        ..Corners::default()
    };
    (0..TRIANGLES).map(&mut of).collect()
}
/// One that is cut out and one that is blended; the tree's other triangles are not asked.
fn materials() -> Vec<Material> {
    let with = |flags, case| Material {
        flags,
        base_texels: 256,
        base_size: 5 | 3 << 16,
        alpha: 1.0,
        cutoff: 0.5,
        ..material(&mut Draw::of(case))
    };
    vec![with(0, 1), with(1, 2), with(2, 3)]
}
/// From anywhere about the tree: towards a corner of a triangle, or past all.
fn ray(d: &mut Draw) -> Ray {
    let tree = tree();
    let instance = &tree.instances[d.below(9) as usize];
    let first = instance.first_triangle + d.below(TRIANGLES);
    let t = &tree.triangles[first as usize];
    let (u, v) = (d.unit(), d.unit());
    let local = t.v0
        + d.one_of(&[
            Vec3::ZERO,
            t.e1,
            t.e2,
            t.e1 * (u * (1.0 - v)) + t.e2 * (u * v),
        ]);
    let row = |k: usize| instance.object_to_world[k];
    let at = Vec3::from_array(std::array::from_fn(|k| {
        row(k).truncate().dot(local) + row(k).w
    }));
    let origin = d.vector(-3, 4);
    let way = (at - origin) * d.magnitude(-3, 3);
    let any = direction(d);
    Ray {
        origin,
        t_min: d.one_of(&[0.0, 0.0, 0.1]),
        direction: d.one_of(&[way, way, way, any]),
        t_max: d.one_of(&[f32::MAX, f32::MAX, 1.0]),
    }
}
twin! {
    closest_hit ["trace::trace_walk", "trace::trace_stops"], (ray: Ray) -> Hit,
    wgsl "trace_walk(ray, false)",
    rust {
        let view = AccelView { nodes, triangles, instances };
        scalar::closest(&view, &ray, stops(&ray, triangles, corners, materials, texels))
    },
    draw |d| (super::ray(d),),
    bound ROUNDED,
    features ["materials", "corners", "texels"],
    globals {
        nodes: BvhNode = super::tree().nodes.clone(),
        triangles: Triangle = super::tree().triangles.clone(),
        instances: Instance = super::tree().instances.clone(),
        materials: Material = super::materials(),
        corners: Corners = super::corners(),
        texels: u32 = super::texels(),
    },
}
twin! {
    any_hit ["trace::trace_walk"], (ray: Ray) -> u32,
    wgsl "u32(trace_walk(ray, true).instance != NONE)",
    rust {
        let view = AccelView { nodes, triangles, instances };
        u32::from(scalar::any(&view, &ray, |_, _, _, _| true))
    },
    draw |d| (super::ray(d),),
    bound ROUNDED,
    uses ["types::NONE"],
    globals {
        nodes: BvhNode = super::tree().nodes.clone(),
        triangles: Triangle = super::tree().triangles.clone(),
        instances: Instance = super::tree().instances.clone(),
    },
}

twins!(
    is_sound,
    inverse,
    box_entry,
    triangle_hit,
    trace_miss,
    closest_hit,
    any_hit
);
