//! Wide surfaces have the scalar ones' bits.
use super::super::Avx2;
use super::resolve_hits;
use crate::data::{Corners, Hit, Instance, Material, NONE, Ray, SurfacePoint, Triangle};
use crate::shared::hash::{hash2, unit};
use crate::shared::{octahedral, surface, texture};
use crate::stages::resolve_hits::{Scene, resolve_each};
use bytemuck::Zeroable;
use glam::{Affine3A, Quat, Vec2, Vec3, Vec4};
use std::ops::Range;

const TRIANGLES: u32 = 300;
const INSTANCES: u32 = 24;
const MATERIALS: u32 = 40;
const HITS: u32 = 20_000;

fn random(i: u32, k: u32) -> f32 {
    unit(hash2(i, k)) * 2.0 - 1.0
}

fn vector(i: u32, k: u32) -> Vec3 {
    Vec3::new(random(i, k), random(i, k + 1), random(i, k + 2))
}

fn direction(i: u32, k: u32) -> Vec3 {
    vector(i, k).try_normalize().unwrap_or(Vec3::Z)
}

/// What a [`Scene`] borrows.
struct Owned {
    triangles: Vec<Triangle>,
    instances: Vec<Instance>,
    corners: Vec<Corners>,
    materials: Vec<Material>,
    texels: Vec<u32>,
}

impl Owned {
    fn scene(&self) -> Scene<'_> {
        Scene {
            triangles: &self.triangles,
            instances: &self.instances,
            corners: &self.corners,
            materials: &self.materials,
            texels: &self.texels,
        }
    }
}

/// Every eleventh triangle is a line, every 23rd a point.
fn triangle(i: u32) -> Triangle {
    let (e1, e2) = (vector(i, 3) * 2.0, vector(i, 6));
    Triangle {
        v0: vector(i, 0) * 20.0,
        // Vertices are in another order than triangles.
        primitive: (i * 7 + 3) % TRIANGLES,
        e1: if i % 23 == 5 { Vec3::ZERO } else { e1 },
        material_flags: (hash2(i, 9) % MATERIALS) | ((i & 1) * Triangle::ALPHA_TEST),
        e2: match (i % 11, i % 23) {
            (_, 5) => Vec3::ZERO,
            (3, _) => e1 * 0.5,
            _ => e2,
        },
        transform_id: if i.is_multiple_of(3) { NONE } else { i },
    }
}

/// Normals are on either side of the face, a few cancel each other; every fourth triangle has none.
fn corner(i: u32) -> Corners {
    let n = direction(i, 10);
    Corners {
        normals: match i % 9 {
            4 => [n, -n, -n].map(octahedral::pack),
            5 => [0, 0xffff, 0xffff_0000],
            _ => [
                n,
                direction(i, 13),
                (n + direction(i, 16) * 0.2).normalize(),
            ]
            .map(octahedral::pack),
        },
        smooth: u32::from(i % 4 != 1),
        uvs: [0, 1, 2].map(|k| {
            let uv = Vec2::new(random(i, 20 + 2 * k), random(i, 21 + 2 * k));
            match i % 17 {
                // Texel borders and centres of all pictures.
                2 => (uv * 4.0).round() / 2.0,
                // So far that no coordinate between whole numbers is left.
                3 => uv * 1e10,
                4 => uv * 1e30,
                5 => Vec2::new(f32::INFINITY, uv.y),
                6 => Vec2::splat(1.0 + k as f32),
                _ => uv * 3.0,
            }
        }),
    }
}

/// Every third instance is mirrored, one is far away, one is squeezed flat.
fn instance(i: u32) -> Instance {
    let mut scale = vector(i, 30).abs() + 0.1;
    if i.is_multiple_of(3) {
        scale.y = -scale.y;
    }
    let rotation = Quat::from_axis_angle(direction(i, 33), random(i, 36) * 3.0);
    let translation = vector(i, 37) * if i == 7 { 1e7 } else { 50.0 };
    let map = Affine3A::from_scale_rotation_translation(scale, rotation, translation);
    let rows = |map: Affine3A| {
        let m = map.matrix3.transpose();
        let t = map.translation;
        [
            Vec4::new(m.x_axis.x, m.x_axis.y, m.x_axis.z, t.x),
            Vec4::new(m.y_axis.x, m.y_axis.y, m.y_axis.z, t.y),
            Vec4::new(m.z_axis.x, m.z_axis.y, m.z_axis.z, t.z),
        ]
    };
    let mut world_to_object = rows(map.inverse());
    if i == 8 {
        world_to_object[2] = Vec4::ZERO;
    }
    Instance {
        world_to_object,
        object_to_world: rows(map),
        transform_id: 1000 + i,
        flags: i % 3 / 2,
        ..Instance::default()
    }
}

/// Pictures from one texel to 33 x 7 at the end of the table, and materials of each kind that use them.
fn materials(with_textures: bool) -> (Vec<Material>, Vec<u32>) {
    let sizes = [[1, 1], [2, 3], [33, 7], [16, 16], [1, 9]];
    let mut texels = texture::srgb_table().to_vec();
    let firsts = sizes.map(|[width, height]: [u32; 2]| {
        let first = texels.len() as u32;
        texels.extend((0..width * height).map(|i| hash2(i, first)));
        first
    });
    let material = |i: u32| {
        let picture = |k: u32| {
            let which = (hash2(i, 40 + k) % sizes.len() as u32) as usize;
            let [width, height] = sizes[which];
            (firsts[which], width | (height << 16))
        };
        let sampler = |k: u32| {
            let bits = hash2(i, 50 + k);
            let nearest = ((bits >> 16) % 3 / 2) * texture::NEAREST;
            (bits % 3) | (((bits >> 8) % 3) << 2) | nearest
        };
        let (base, emission) = (picture(0), picture(1));
        let shining = vector(i, 60).abs() * 5.0;
        let has = |k: u32, n: u32, first| {
            if with_textures && !hash2(i, 70 + k).is_multiple_of(n) {
                first
            } else {
                NONE
            }
        };
        let row = |k: u32| match i % 3 {
            0 => [Vec3::X, Vec3::Y][k as usize & 1],
            _ => vector(i, 80 + 3 * k) * 2.0,
        };
        Material {
            base_color: vector(i, 63).abs() * 1.2,
            alpha: 0.5,
            emission: if i.is_multiple_of(2) {
                shining
            } else {
                Vec3::ZERO
            },
            flags: (i % 3) | (i / 3 % 2 * texture::DOUBLE_SIDED),
            base_u: row(0),
            base_texels: has(0, 4, base.0),
            base_v: row(1),
            base_size: base.1,
            emission_u: row(2),
            emission_texels: if i % 8 == 6 {
                has(1, 8, emission.0)
            } else {
                NONE
            },
            emission_v: row(3),
            emission_size: emission.1,
            base_sampler: sampler(0),
            emission_sampler: sampler(1),
            ..Material::default()
        }
    };
    let materials = (0..MATERIALS).map(material).collect();
    if !with_textures {
        texels.clear();
    }
    (materials, texels)
}

fn owned(with_textures: bool) -> Owned {
    let (materials, texels) = materials(with_textures);
    Owned {
        triangles: (0..TRIANGLES).map(triangle).collect(),
        instances: (0..INSTANCES).map(instance).collect(),
        corners: (0..TRIANGLES).map(corner).collect(),
        materials,
        texels,
    }
}

/// A run of hits on few things, then one of misses, then some of each; corners and edges among them.
fn hit(i: u32) -> Hit {
    if i / 200 % 5 == 3 || (i / 200 % 5 == 4 && hash2(i, 90) & 1 != 0) {
        return Hit::miss(7.0);
    }
    let few = if (i / 200).is_multiple_of(5) {
        i / 16
    } else {
        i
    };
    let (u, v) = (unit(hash2(i, 91)), unit(hash2(i, 92)));
    let (u, v) = match i % 20 {
        0 => (0.0, 0.0),
        1 => (1.0, 0.0),
        2 => (0.5, 0.5),
        _ if u + v > 1.0 => (1.0 - u, 1.0 - v),
        _ => (u, v),
    };
    Hit {
        t: 1.0,
        u,
        v,
        triangle: hash2(few, 93) % TRIANGLES,
        instance: hash2(few, 94) % INSTANCES,
    }
}

fn ray(i: u32) -> Ray {
    Ray {
        direction: direction(i, 95),
        t_max: 1e30,
        ..Ray::default()
    }
}

type Resolve = fn(&Scene<'_>, &[Ray], &[Hit], Range<usize>, &mut dyn FnMut(usize, SurfacePoint));

/// All points of a range, each set once.
fn resolved(resolve: Resolve, scene: &Scene<'_>, range: Range<usize>) -> Vec<SurfacePoint> {
    let hits: Vec<Hit> = (0..HITS).map(hit).collect();
    let rays: Vec<Ray> = (0..HITS).map(ray).collect();
    let mut points = vec![SurfacePoint::zeroed(); HITS as usize];
    let mut set = vec![false; HITS as usize];
    resolve(scene, &rays, &hits, range.clone(), &mut |i, point| {
        assert!(range.contains(&i) && !set[i], "{i} is set again");
        set[i] = true;
        points[i] = point;
    });
    assert!(set[range.clone()].iter().all(|&set| set));
    points[range].to_vec()
}

fn wide(scene: &Scene<'_>, range: Range<usize>) -> Vec<SurfacePoint> {
    resolved(
        |scene, rays, hits, range, set| resolve_hits(scene, rays, hits, range, set),
        scene,
        range,
    )
}

fn each(scene: &Scene<'_>, range: Range<usize>) -> Vec<SurfacePoint> {
    resolved(
        |scene, rays, hits, range, set| resolve_each(scene, rays, hits, range, set),
        scene,
        range,
    )
}

/// Of every kind there are so many that a difference would show: see the counts.
#[test]
fn wide_surfaces_are_the_scalar_ones() {
    if Avx2::detect().is_none() {
        eprintln!("not run: this processor has no AVX2");
        return;
    }
    for with_textures in [true, false] {
        let owned = owned(with_textures);
        let all = 0..HITS as usize;
        let (expected, found) = (each(&owned.scene(), all.clone()), wide(&owned.scene(), all));
        for (i, (expected, found)) in expected.iter().zip(&found).enumerate() {
            assert_eq!(
                bytemuck::bytes_of(expected),
                bytemuck::bytes_of(found),
                "hit {i}: {expected:?} and {found:?}"
            );
        }
        let count = |what: &dyn Fn(&SurfacePoint) -> bool| {
            found.iter().filter(|&point| what(point)).count()
        };
        let misses = count(&|p| !surface::is_surface(p));
        let bent = count(&|p| p.geometric_normal != p.shading_normal);
        let emitters = count(&|p| p.albedo_b_flags & surface::EMITTER != 0);
        let shining = count(&|p| p.emission != Vec3::ZERO);
        let colors: std::collections::HashSet<u32> = found.iter().map(|p| p.albedo_rg).collect();
        assert!(misses > 4000 && bent > 5000 && emitters > 500 && shining > 1000);
        assert_eq!(
            colors.len() > 3000,
            with_textures,
            "{} colours",
            colors.len()
        );
    }
}

/// Ranges that no eight and no batch fits, and empty ones.
#[test]
fn ranges_need_not_be_whole_batches() {
    let owned = owned(true);
    for (start, count) in [
        (0, 0),
        (0, 1),
        (5, 7),
        (190, 64),
        (3, 65),
        (590, 77),
        (600, 64),
    ] {
        let range = start..start + count;
        let (expected, found) = (
            each(&owned.scene(), range.clone()),
            wide(&owned.scene(), range.clone()),
        );
        assert_eq!(
            bytemuck::cast_slice::<_, u8>(&expected),
            bytemuck::cast_slice::<_, u8>(&found),
            "{range:?}"
        );
    }
}

/// A material whose texels end too early is caught, not read.
#[test]
#[should_panic(expected = "texels")]
fn texels_beyond_the_end_are_not_read() {
    if Avx2::detect().is_none() {
        panic!("no texels are looked up eight at a time: this processor has no AVX2");
    }
    let mut owned = owned(true);
    owned.texels.truncate(texture::LUT + 1);
    wide(&owned.scene(), 0..64);
}
