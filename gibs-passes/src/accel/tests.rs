//! Traversals against brute force and against each other, over scenes that are awkward on purpose.
use bytemuck::bytes_of;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};

use super::intersect::{BoxRay, InstanceRay};
use super::wide::{Simd, Tracer};
use super::*;

/// A small generator, so that the tests need no crate for it.
struct Random(u64);

impl Random {
    /// Uniform in -1 .. 1.
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        ((self.0 >> 40) as f32) / (1 << 23) as f32 - 1.0
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

#[derive(Default)]
struct Mesh {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    alpha: bool,
}

impl Mesh {
    fn triangle(&mut self, corners: [Vec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    fn soup(random: &mut Random, count: usize, size: f32) -> Self {
        let mut mesh = Mesh::default();
        for _ in 0..count {
            let at = random.vec3();
            mesh.triangle([at, at + random.vec3() * size, at + random.vec3() * size]);
        }
        mesh
    }

    /// The square -1 .. 1 at height `y`.
    fn square(y: f32) -> Self {
        let corner = |x: f32, z: f32| Vec3::new(x, y, z);
        Mesh {
            positions: vec![
                corner(-1., -1.),
                corner(1., -1.),
                corner(1., 1.),
                corner(-1., 1.),
            ],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            alpha: false,
        }
    }

    fn part(&self) -> MeshPart<'_> {
        MeshPart {
            positions: &self.positions,
            triangles: &self.triangles,
            alpha_test: self.alpha,
            ..MeshPart::default()
        }
    }
}

fn instance(blas: u32, object_to_world: DAffine3) -> InstanceInput {
    InstanceInput {
        blas,
        object_to_world,
        transform_id: 7,
    }
}

/// One bottom level for each mesh.
fn build(meshes: &[Mesh], instances: &[InstanceInput]) -> TwoLevel {
    let parts: Vec<[MeshPart; 1]> = meshes.iter().map(|mesh| [mesh.part()]).collect();
    let blases: Vec<BlasInput> = parts.iter().map(|parts| BlasInput { parts }).collect();
    TwoLevel::build(&blases, instances).expect("valid geometry")
}

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray {
        origin,
        t_min: 0.0,
        direction,
        t_max: f32::INFINITY,
    }
}

/// An alpha test that depends on all that it is given.
fn filter(instance: u32, triangle: u32, u: f32, v: f32) -> bool {
    (instance + triangle).is_multiple_of(3) || u + 0.5 * v > 0.4
}

/// World boxes of the instances, from the leaves of the top level.
fn instance_boxes(tree: &TwoLevel) -> Vec<(u32, Vec3, Vec3)> {
    let (mut boxes, mut pending) = (Vec::new(), vec![0]);
    while let Some(index) = pending.pop() {
        let node = &tree.nodes[index as usize];
        if node.min.cmpgt(node.max).any() {
            continue;
        }
        if node.count == 0 {
            pending.extend([node.first, node.first + 1]);
        } else {
            assert_eq!(node.count, 1);
            boxes.push((node.first, node.min, node.max));
        }
    }
    boxes
}

/// The definition of the closest hit, over all triangles.
fn brute_force(tree: &TwoLevel, boxes: &[(u32, Vec3, Vec3)], ray: &Ray) -> Hit {
    let mut best = Hit::miss(ray.t_max);
    let Some(world) = BoxRay::new(ray.origin, ray.direction) else {
        return best;
    };
    for &(index, min, max) in boxes {
        let placed = &tree.instances[index as usize];
        let Some(near) = world.enter(min, max, ray.t_min) else {
            continue;
        };
        let Some(local) = InstanceRay::new(ray, placed, near) else {
            continue;
        };
        let bottom = &tree.bottoms[tree.bottom_of(index) as usize];
        for triangle in bottom.triangles.clone() {
            let data = &tree.triangles[triangle];
            let triangle = triangle as u32;
            if let Some(hit) = local.hit(data)
                && best.loses_to(hit.t, index, triangle)
                && (!data.needs_alpha_test() || filter(index, triangle, hit.u, hit.v))
            {
                best = Hit {
                    t: hit.t,
                    u: hit.u,
                    v: hit.v,
                    triangle,
                    instance: index,
                };
            }
        }
    }
    best
}

/// All traversals must equal brute force to the bit. Returns the number of hits.
fn agree(tree: &TwoLevel, wide: &Wide, rays: &[Ray]) -> usize {
    let boxes = instance_boxes(tree);
    let (view, wide_view) = (tree.view(), wide.view(tree));
    let mut tracers = [Tracer::new(), Tracer::portable()];
    let mut hits = 0;
    for ray in rays {
        let expected = brute_force(tree, &boxes, ray);
        let found = scalar::closest(&view, ray, filter);
        assert_eq!(
            bytes_of(&found),
            bytes_of(&expected),
            "scalar {ray:?}: {found:?}, not {expected:?}"
        );
        let occluded = !expected.is_miss();
        assert_eq!(
            scalar::any(&view, ray, filter),
            occluded,
            "scalar any {ray:?}"
        );
        for tracer in &mut tracers {
            let simd = tracer.simd();
            let found = tracer.closest(&wide_view, ray, filter);
            assert_eq!(
                bytes_of(&found),
                bytes_of(&expected),
                "{simd:?} {ray:?}: {found:?}, not {expected:?}"
            );
            assert_eq!(
                tracer.any(&wide_view, ray, filter),
                occluded,
                "{simd:?} any {ray:?}"
            );
        }
        hits += usize::from(occluded);
    }
    hits
}

fn agree_fresh(tree: &TwoLevel, rays: &[Ray]) -> usize {
    agree(tree, &Wide::build(tree), rays)
}

fn random_rays(random: &mut Random, count: usize, centre: Vec3, reach: f32) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = centre + random.vec3() * reach;
            let target = centre + random.vec3() * reach * 0.5;
            Ray {
                t_min: if i % 3 == 0 { 0.1 } else { 0.0 },
                t_max: if i % 4 == 0 { 0.7 } else { f32::INFINITY },
                ..ray(origin, target - origin)
            }
        })
        .collect()
}

/// Three meshes in a rotated, a mirrored, a squeezed, a sheared and an overlapping instance.
fn instanced_scene(random: &mut Random) -> TwoLevel {
    let mut meshes = vec![
        Mesh::soup(random, 150, 0.5),
        Mesh::soup(random, 40, 2.0),
        Mesh::soup(random, 3, 1.0),
    ];
    meshes[1].alpha = true;
    let turn = DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(1.1);
    let at = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    let shear = DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.8, 1.0, 0.0),
        DVec3::new(0.0, -0.4, 1.0),
    );
    let placements = [
        instance(0, DAffine3::IDENTITY),
        instance(
            0,
            DAffine3::from_rotation_translation(turn, DVec3::new(1.5, 0.2, -0.3)),
        ),
        instance(
            1,
            DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * at(0.5, 0.0, 0.0),
        ),
        instance(
            2,
            DAffine3::from_scale(DVec3::new(3.0, 1e-3, 2.0)) * DAffine3::from_quat(turn),
        ),
        instance(1, at(-1.0, 1.0, 0.0) * DAffine3::from_mat3(shear)),
        instance(0, DAffine3::IDENTITY),
    ];
    build(&meshes, &placements)
}

#[test]
fn device_structs_have_the_layout_of_shaders() {
    use std::mem::{offset_of, size_of};
    assert_eq!((size_of::<BvhNode>(), offset_of!(BvhNode, max)), (32, 16));
    assert_eq!(
        (
            size_of::<Triangle>(),
            offset_of!(Triangle, e1),
            offset_of!(Triangle, e2)
        ),
        (48, 16, 32)
    );
    assert_eq!(
        (size_of::<Instance>(), offset_of!(Instance, root)),
        (112, 96)
    );
    assert_eq!((size_of::<Ray>(), offset_of!(Ray, direction)), (32, 16));
    assert_eq!(size_of::<Hit>(), 20);
    assert_eq!((size_of::<WideNode>(), size_of::<WidePacket>()), (256, 320));
}

#[test]
fn soups_of_every_size_agree() {
    let (mut random, mut hits) = (Random(1), 0);
    for count in [1, 2, 3, 4, 5, 8, 9, 17, 64, 300] {
        let tree = build(
            &[Mesh::soup(&mut random, count, 0.8)],
            &[instance(0, DAffine3::IDENTITY)],
        );
        let rays = random_rays(&mut random, 400, Vec3::ZERO, 2.0);
        hits += agree_fresh(&tree, &rays);
    }
    assert!(hits > 500, "{hits} hits are too few to prove anything");
}

#[test]
fn instances_agree() {
    let mut random = Random(2);
    let tree = instanced_scene(&mut random);
    assert_eq!(tree.instances[2].flags, Instance::MIRRORED);
    assert_eq!(tree.instances[1].flags, 0);
    let rays = random_rays(&mut random, 3000, Vec3::ZERO, 3.0);
    assert!(agree_fresh(&tree, &rays) > 1000);
}

/// Intersection in `f64` without boxes: `(t, margin)`, the margin being the smallest barycentric weight.
fn exact(a: DVec3, b: DVec3, c: DVec3, ray: &Ray) -> (f64, f64) {
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let p = d.cross(e2);
    let det = e1.dot(p);
    let s = o - a;
    let (u, v) = (s.dot(p) / det, d.dot(s.cross(e1)) / det);
    (e2.dot(s.cross(e1)) / det, u.min(v).min(1.0 - u - v))
}

#[test]
fn hits_are_those_of_exact_geometry() {
    let mut random = Random(3);
    let mesh = Mesh::soup(&mut random, 60, 0.9);
    let place = DAffine3::from_scale_rotation_translation(
        DVec3::new(2.0, -0.5, 1.5),
        DQuat::from_rotation_z(0.4),
        DVec3::new(3.0, -2.0, 5.0),
    );
    let tree = build(std::slice::from_ref(&mesh), &[instance(0, place)]);
    let world: Vec<DVec3> = mesh
        .positions
        .iter()
        .map(|p| place.transform_point3(p.as_dvec3()))
        .collect();
    let mut compared = 0;
    for ray in random_rays(&mut random, 3000, Vec3::new(3.0, -2.0, 5.0), 3.0) {
        let corner = |i: u32| world[i as usize];
        let hits = mesh
            .triangles
            .iter()
            .map(|t| exact(corner(t[0]), corner(t[1]), corner(t[2]), &ray));
        let (mut nearest, mut clear) = (f64::INFINITY, true);
        for (t, margin) in hits {
            // Within rounding of an edge or of an end of the interval either answer is right.
            clear &= margin.abs() > 1e-4;
            clear &=
                (t - f64::from(ray.t_min)).abs() > 1e-4 && (t - f64::from(ray.t_max)).abs() > 1e-4;
            if margin > 0.0 && t > f64::from(ray.t_min) && t <= f64::from(ray.t_max) {
                nearest = nearest.min(t);
            }
        }
        if clear {
            let hit = scalar::closest(&tree.view(), &ray, filter);
            assert_eq!(hit.is_miss(), nearest.is_infinite(), "{ray:?}");
            // Grazing triangles lose digits; 2e-4 is a thousand roundings.
            assert!(
                hit.is_miss() || (f64::from(hit.t) - nearest).abs() < 2e-4,
                "{hit:?} {nearest}"
            );
            compared += 1;
        }
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn axis_parallel_rays_agree_and_hit() {
    let mut cube = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let corner = |a: f32, b: f32| {
                let mut p = Vec3::splat(side);
                p[(axis + 1) % 3] = a;
                p[(axis + 2) % 3] = b;
                p
            };
            cube.triangle([corner(-1., -1.), corner(1., -1.), corner(1., 1.)]);
            cube.triangle([corner(-1., -1.), corner(1., 1.), corner(-1., 1.)]);
        }
    }
    let tree = build(&[cube], &[instance(0, DAffine3::IDENTITY)]);
    let mut rays = Vec::new();
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let mut direction = Vec3::splat(0.0).copysign(Vec3::splat(sign));
            direction[axis] = sign;
            // On faces, edges, corners, diagonals and inside, from inside, from a face and from outside.
            for (a, b) in [
                (0.0, 0.0),
                (1.0, 0.3),
                (-1.0, 1.0),
                (0.5, 0.5),
                (0.25, -0.75),
                (2.0, 0.0),
            ] {
                for depth in [-3.0, -1.0, 0.0, 1.0] {
                    let mut origin = Vec3::splat(depth * sign);
                    origin[(axis + 1) % 3] = a;
                    origin[(axis + 2) % 3] = b;
                    rays.push(ray(origin, direction));
                }
            }
        }
    }
    agree_fresh(&tree, &rays);
    let through = ray(Vec3::new(0.25, -0.75, -3.0), Vec3::Z);
    let hit = scalar::closest(&tree.view(), &through, filter);
    assert_eq!(hit.t, 2.0, "a plane at -1 seen from -3");
}

#[test]
fn a_surface_does_not_hit_its_own_rays() {
    let tree = build(
        &[Mesh::square(0.0), Mesh::square(2.0)],
        &[
            instance(0, DAffine3::IDENTITY),
            instance(1, DAffine3::IDENTITY),
        ],
    );
    let mut random = Random(4);
    let rays: Vec<Ray> = (0..500)
        .map(|_| {
            let (p, d) = (random.vec3(), random.vec3());
            ray(
                Vec3::new(p.x, 0.0, p.z),
                Vec3::new(0.2 * d.x, d.y.abs() + 0.01, 0.2 * d.z),
            )
        })
        .collect();
    agree_fresh(&tree, &rays);
    for ray in &rays {
        let hit = scalar::closest(&tree.view(), ray, filter);
        assert_ne!(
            hit.instance, 0,
            "{ray:?} starts at t = 0, which does not count"
        );
    }
}

#[test]
fn degenerate_triangles_are_never_hit() {
    let mut mesh = Mesh::default();
    let p = Vec3::new(0.3, 0.1, -0.2);
    mesh.triangle([p, p, p]);
    mesh.triangle([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
    mesh.triangle([Vec3::ZERO, Vec3::Y, Vec3::ZERO]);
    let tree = build(&[mesh], &[instance(0, DAffine3::IDENTITY)]);
    let mut rays = vec![
        ray(Vec3::new(0.5, 1.0, 0.0), Vec3::NEG_Y),
        ray(Vec3::new(-1.0, 0.0, 0.0), Vec3::X),
        ray(p - Vec3::Z, Vec3::Z),
    ];
    rays.push(ray(Vec3::new(0.5, 0.0, 0.0), Vec3::ONE));
    assert_eq!(agree_fresh(&tree, &rays), 0);
}

#[test]
fn absurd_rays_hit_nothing_and_end() {
    let mut random = Random(10);
    let tree = instanced_scene(&mut random);
    let down = ray(Vec3::new(0.1, 3.0, 0.1), Vec3::NEG_Y);
    let mut rays = vec![ray(Vec3::ZERO, Vec3::ZERO)];
    rays.push(Ray {
        t_min: f32::NAN,
        ..down
    });
    rays.push(Ray {
        t_max: f32::NAN,
        ..down
    });
    rays.push(Ray {
        t_max: -1.0,
        ..down
    });
    rays.push(Ray {
        t_min: 5.0,
        t_max: 2.0,
        ..down
    });
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, f32::MAX] {
        for axis in 0..3 {
            let mut vector = Vec3::new(0.1, -0.2, 0.3);
            vector[axis] = bad;
            rays.push(ray(vector, Vec3::new(1.0, 2.0, -0.0)));
            rays.push(ray(vector, Vec3::ZERO));
            if !bad.is_finite() {
                rays.push(ray(Vec3::splat(0.1), vector));
            }
        }
    }
    assert_eq!(agree_fresh(&tree, &rays), 0);
    // Directions of any finite length are usable, if the triangle test does not overflow.
    for length in [1e-12, 1e12] {
        let scaled = random_rays(&mut random, 200, Vec3::ZERO, 3.0);
        let scaled: Vec<Ray> = scaled
            .iter()
            .map(|r| ray(r.origin, r.direction * length))
            .collect();
        assert!(agree_fresh(&tree, &scaled) > 50, "length {length}");
    }
}

#[test]
fn empty_scenes_miss() {
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let far = DAffine3::from_translation(DVec3::splat(1e30));
    let broken = DAffine3::from_translation(DVec3::splat(f64::NAN));
    let solid = [Mesh::square(0.0), Mesh::default()];
    let rays = [
        ray(Vec3::new(0.1, 1.0, 0.2), Vec3::NEG_Y),
        ray(Vec3::ZERO, Vec3::X),
    ];
    assert_eq!(agree_fresh(&build(&[], &[]), &rays), 0);
    assert_eq!(agree_fresh(&build(&solid, &[]), &rays), 0);
    let all_out = [
        instance(0, flat),
        instance(1, DAffine3::IDENTITY),
        instance(0, far),
        instance(0, broken),
    ];
    let tree = build(&solid, &all_out);
    let reasons = [
        LeftOut::Singular,
        LeftOut::Empty,
        LeftOut::OutOfRange,
        LeftOut::OutOfRange,
    ];
    let expected: Vec<(u32, LeftOut)> = (0..4).zip(reasons).collect();
    assert_eq!(tree.stats.left_out, expected);
    assert!(tree.instances.iter().all(|i| i.flags == Instance::LEFT_OUT));
    assert_eq!(agree_fresh(&tree, &rays), 0);
    let some_out = [
        instance(0, flat),
        instance(1, DAffine3::IDENTITY),
        instance(0, DAffine3::IDENTITY),
    ];
    let tree = build(&solid, &some_out);
    assert_eq!(agree_fresh(&tree, &rays), 1);
    assert_eq!(scalar::closest(&tree.view(), &rays[0], filter).instance, 2);
}

#[test]
fn of_equal_distances_the_smallest_index_wins() {
    let mut mesh = Mesh::default();
    for _ in 0..20 {
        mesh.triangle([
            Vec3::new(-1., 0., -1.),
            Vec3::new(1., 0., -1.),
            Vec3::new(0., 0., 1.),
        ]);
    }
    let same = [instance(0, DAffine3::IDENTITY); 11];
    let tree = build(&[mesh], &same);
    let down = ray(Vec3::new(0.1, 1.0, 0.1), Vec3::NEG_Y);
    let at_end = Ray { t_max: 1.0, ..down };
    let short = Ray {
        t_max: 0.999_999_9,
        ..down
    };
    assert_eq!(
        agree_fresh(&tree, &[down, at_end, short]),
        2,
        "t_max itself counts"
    );
    let hit = scalar::closest(&tree.view(), &down, filter);
    assert_eq!((hit.instance, hit.triangle, hit.t), (0, 0, 1.0));
}

#[test]
fn huge_coordinates_agree() {
    let mut random = Random(5);
    for scale in [1e-6, 1e6, 1e9, 0.9e12] {
        let mut mesh = Mesh::soup(&mut random, 60, 0.7);
        mesh.positions
            .iter_mut()
            .for_each(|p| *p = (*p * scale * 0.4).clamp(Vec3::splat(-scale), Vec3::splat(scale)));
        let tree = build(&[mesh], &[instance(0, DAffine3::IDENTITY)]);
        let rays = random_rays(&mut random, 500, Vec3::ZERO, scale);
        assert!(agree_fresh(&tree, &rays) > 20, "scale {scale}");
    }
    // Far from the origin, and rays from far away, where rounding is as large as the triangles.
    let place = DAffine3::from_translation(DVec3::new(1e7, -3e6, 2e7));
    let tree = build(
        &[Mesh::soup(&mut random, 200, 0.7)],
        &[instance(0, place), instance(0, DAffine3::IDENTITY)],
    );
    let mut rays = random_rays(&mut random, 500, Vec3::new(1e7, -3e6, 2e7), 4.0);
    rays.extend(
        random_rays(&mut random, 500, Vec3::ZERO, 2.0)
            .iter()
            .map(|r| Ray {
                origin: r.origin - r.direction * 1e5,
                ..*r
            }),
    );
    agree_fresh(&tree, &rays);
}

#[test]
fn a_closed_sphere_lets_no_ray_out() {
    const RINGS: u32 = 24;
    const SEGMENTS: u32 = 48;
    let mut mesh = Mesh::default();
    for ring in 0..=RINGS {
        for segment in 0..SEGMENTS {
            let (theta, phi) = (
                std::f32::consts::PI * ring as f32 / RINGS as f32,
                std::f32::consts::TAU * segment as f32 / SEGMENTS as f32,
            );
            let (s, c) = theta.sin_cos();
            mesh.positions
                .push(Vec3::new(s * phi.cos(), c, s * phi.sin()) * 5.0);
        }
    }
    for ring in 0..RINGS {
        for segment in 0..SEGMENTS {
            let next = (segment + 1) % SEGMENTS;
            let (a, b) = (ring * SEGMENTS, (ring + 1) * SEGMENTS);
            mesh.triangles.push([a + segment, b + segment, b + next]);
            mesh.triangles.push([a + segment, b + next, a + next]);
        }
    }
    let turned = DAffine3::from_rotation_translation(
        DQuat::from_rotation_x(0.3),
        DVec3::new(20.0, 5.0, -9.0),
    );
    let tree = build(&[mesh], &[instance(0, turned)]);
    let wide = Wide::build(&tree);
    let (mut random, mut tracer) = (Random(6), Tracer::new());
    for _ in 0..20_000 {
        let out = ray(
            Vec3::new(20.0, 5.0, -9.0) + random.vec3() * 2.0,
            random.vec3(),
        );
        assert!(
            !tracer.closest(&wide.view(&tree), &out, filter).is_miss(),
            "{out:?}"
        );
    }
}

#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let mut random = Random(7);
    let meshes = [
        Mesh::soup(&mut random, 12_000, 0.05),
        Mesh::soup(&mut random, 10, 0.5),
        Mesh::soup(&mut random, 3_000, 0.5),
    ];
    let placements: Vec<InstanceInput> = (0..40)
        .map(|i| {
            instance(
                i % 3,
                DAffine3::from_translation(random.vec3().as_dvec3() * 9.0),
            )
        })
        .collect();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| {
            let tree = build(&meshes, &placements);
            let wide = Wide::build(&tree);
            (tree, wide)
        })
    };
    let ((a, wide_a), (b, wide_b)) = (with(1), with(2));
    assert!(bytemuck::cast_slice::<_, u8>(&a.nodes) == bytemuck::cast_slice::<_, u8>(&b.nodes));
    assert!(
        bytemuck::cast_slice::<_, u8>(&a.triangles) == bytemuck::cast_slice::<_, u8>(&b.triangles)
    );
    assert!(a.triangle_source == b.triangle_source && a.stats == b.stats);
    assert!(
        bytemuck::cast_slice::<_, u8>(&wide_a.nodes)
            == bytemuck::cast_slice::<_, u8>(&wide_b.nodes)
    );
    assert!(
        bytemuck::cast_slice::<_, u8>(&wide_a.packets)
            == bytemuck::cast_slice::<_, u8>(&wide_b.packets)
    );
}

#[test]
fn moved_instances_equal_a_fresh_tree() {
    let mut random = Random(8);
    let meshes = [
        Mesh::soup(&mut random, 30, 0.5),
        Mesh::soup(&mut random, 9, 0.5),
    ];
    let mut inputs: Vec<InstanceInput> = (0..30)
        .map(|i| instance(i % 2, DAffine3::IDENTITY))
        .collect();
    let mut tree = build(&meshes, &inputs);
    let mut wide = Wide::build(&tree);
    for visible in [30, 3, 1, 0, 2] {
        let moved: Vec<DAffine3> = (0..30)
            .map(|i| {
                let scale = if i < visible { 1.0 } else { 0.0 };
                DAffine3::from_translation(random.vec3().as_dvec3() * 4.0)
                    * DAffine3::from_scale(DVec3::splat(scale))
            })
            .collect();
        tree.rebuild_top(&moved).expect("same number");
        wide.update_top(&tree);
        assert_eq!(tree.stats.left_out.len(), 30 - visible);
        for (input, transform) in inputs.iter_mut().zip(&moved) {
            input.object_to_world = *transform;
        }
        let rays = random_rays(&mut random, 300, Vec3::ZERO, 5.0);
        assert_eq!(
            agree(&tree, &wide, &rays),
            agree_fresh(&build(&meshes, &inputs), &rays)
        );
    }
    let error = tree.rebuild_top(&[DAffine3::IDENTITY]).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("1 given, but the tree was built from 30"),
        "{error}"
    );
}

#[test]
fn refitted_meshes_agree() {
    let mut random = Random(9);
    let meshes = [Mesh::soup(&mut random, 200, 0.4), Mesh::square(0.0)];
    let inputs = [
        instance(0, DAffine3::IDENTITY),
        instance(1, DAffine3::IDENTITY),
    ];
    let mut tree = build(&meshes, &inputs);
    let mut wide = Wide::build(&tree);
    let mut bent = Mesh {
        triangles: meshes[0].triangles.clone(),
        ..Mesh::default()
    };
    bent.positions = meshes[0]
        .positions
        .iter()
        .map(|p| *p * 1.5 + Vec3::X * p.y * p.y)
        .collect();
    let before = tree.triangles.clone();
    tree.refit_bottom(0, &[bent.part()])
        .expect("same triangles");
    tree.rebuild_top(&inputs.map(|i| i.object_to_world))
        .expect("same number");
    wide.refit_bottom(&tree, 0);
    wide.update_top(&tree);
    assert!(
        bytemuck::cast_slice::<_, u8>(&before) != bytemuck::cast_slice::<_, u8>(&tree.triangles)
    );
    let rays = random_rays(&mut random, 1000, Vec3::ZERO, 3.0);
    assert!(agree(&tree, &wide, &rays) > 300);
    // The same closest distances as a tree built from the moved mesh; indices differ with the order of leaves.
    let fresh = build(&[bent, Mesh::square(0.0)], &inputs);
    for ray in &rays {
        let all = |_: u32, _: u32, _: f32, _: f32| true;
        let (a, b) = (
            scalar::closest(&tree.view(), ray, all),
            scalar::closest(&fresh.view(), ray, all),
        );
        assert_eq!(a.t, b.t);
    }
}

#[test]
fn triangles_remember_where_they_came_from() {
    let (a, mut b) = (Mesh::square(0.0), Mesh::square(1.0));
    b.alpha = true;
    let ids = [40, 41];
    let parts = [
        a.part(),
        MeshPart {
            material: 5,
            first_primitive: 100,
            transform_ids: &ids,
            ..b.part()
        },
    ];
    let tree = TwoLevel::build(&[BlasInput { parts: &parts }], &[]).expect("valid");
    for (triangle, &(part, index)) in tree.triangles.iter().zip(&tree.triangle_source) {
        let expected = if part == 0 {
            (index, 0, 0, false)
        } else {
            (100 + index, 40 + index, 5, true)
        };
        let found = (
            triangle.primitive,
            triangle.transform_id,
            triangle.material(),
            triangle.needs_alpha_test(),
        );
        assert_eq!(found, expected);
        let source = &parts[part as usize];
        let corners = source.triangles[index as usize].map(|i| source.positions[i as usize]);
        assert_eq!(
            [
                triangle.v0,
                triangle.v0 + triangle.e1,
                triangle.v0 + triangle.e2
            ],
            corners
        );
    }
}

#[test]
fn wrong_geometry_is_an_error() {
    let check = |change: fn(&mut Mesh), message: &str| {
        let mut mesh = Mesh::square(0.0);
        change(&mut mesh);
        let parts = [mesh.part()];
        let error = TwoLevel::build(&[BlasInput { parts: &parts }], &[]).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    };
    check(
        |mesh| mesh.triangles[1][2] = 9,
        "vertex index 9 is out of range",
    );
    check(
        |mesh| mesh.positions[2].y = f32::NAN,
        "not a finite position",
    );
    check(|mesh| mesh.positions[2].y = 1e13, "not a finite position");
    let missing = TwoLevel::build(&[], &[instance(0, DAffine3::IDENTITY)]).unwrap_err();
    assert!(
        missing
            .to_string()
            .contains("names bottom level 0, of which there are 0"),
        "{missing}"
    );
    let mut tree = build(&[Mesh::square(0.0)], &[]);
    assert!(tree.refit_bottom(0, &[]).is_err());
    assert!(tree.refit_bottom(1, &[]).is_err());
}

#[test]
fn this_test_covers_avx2_where_there_is_any() {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi2")
    {
        assert_eq!(Tracer::new().simd(), Simd::Avx2);
    }
    assert_eq!(Tracer::portable().simd(), Simd::Portable);
}
