//! Scenes and brute force for the tests of the acceleration structure.
mod hits;
mod trees;

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
