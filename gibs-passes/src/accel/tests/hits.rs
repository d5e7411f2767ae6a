//! Traversals against brute force and against exact geometry, over scenes that are awkward on purpose.
use super::*;

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
fn this_test_covers_avx2_where_there_is_any() {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("popcnt")
    {
        assert_eq!(Tracer::new().simd(), Simd::Avx2);
    }
    assert_eq!(Tracer::portable().simd(), Simd::Portable);
}
