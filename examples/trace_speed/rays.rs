//! The rays that are timed: incoherent, as a path tracer's second segment is.
use gibs::passes::accel::{AccelView, Hit, Ray, wide};
use gibs::passes::device::DeviceScene;
use gibs::passes::shared::hash::{hash3, unit};
use gibs::passes::shared::sampling;
use gibs::view::View;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// Candidates of camera rays, in multiples of the rays wanted, before giving up on a view that sees little.
const ROUNDS: u32 = 16;

/// Distance from a surface at which its rays begin, as a share of the scene's extent; also their `t_min`.
const START: f32 = 1e-5;

/// `count` diffuse rays in random order: each camera ray goes through a random place of the picture, and from where
/// it hits first a ray leaves with density `cos / pi`. Fewer, if the camera sees next to nothing.
pub fn diffuse(scene: &DeviceScene, view: &View, count: u32) -> Vec<Ray> {
    let mut rays = Vec::new();
    for round in 0..ROUNDS {
        let candidates = round * count..(round + 1) * count;
        rays.par_extend(
            candidates
                .into_par_iter()
                .filter_map(|i| bounce(scene, view, i)),
        );
        if rays.len() >= count as usize {
            break;
        }
    }
    rays.truncate(count as usize);
    rays
}

fn bounce(scene: &DeviceScene, view: &View, index: u32) -> Option<Ray> {
    let random = |dimension| unit(hash3(index, dimension, 0));
    let [right, up, forward] = view.camera.axes().map(|axis| axis.as_vec3());
    let [width, height] = view.resolution.map(|side| side as f32);
    let half = (view.camera.vfov as f32 / 2.0).tan();
    let across = right * ((2.0 * random(0) - 1.0) * half * width / height);
    let direction = (forward + across + up * ((2.0 * random(1) - 1.0) * half)).normalize();
    let origin = (view.camera.position - scene.origin).as_vec3();
    let seen = Ray {
        origin,
        t_min: 0.0,
        direction,
        t_max: f32::INFINITY,
    };
    let hit = wide::Tracer::new().closest(&scene.wide.view(&scene.tree), &seen, |_, _, _, _| true);
    if hit.is_miss() {
        return None;
    }
    let start = START * scene.extent();
    let normal = normal(&scene.tree.view(), &hit)?;
    let normal = if normal.dot(direction) > 0.0 {
        -normal
    } else {
        normal
    };
    let leaves = sampling::cosine_hemisphere(random(2), random(3));
    Some(Ray {
        origin: origin + direction * hit.t + normal * start,
        t_min: start,
        direction: sampling::to_world(leaves, normal),
        t_max: f32::INFINITY,
    })
}

/// Geometric normal in the world, unless the triangle has no area.
fn normal(view: &AccelView, hit: &Hit) -> Option<Vec3> {
    let triangle = &view.triangles[hit.triangle as usize];
    let rows = &view.instances[hit.instance as usize].object_to_world;
    let to_world = |edge: Vec3| Vec3::from(rows.map(|row: Vec4| row.truncate().dot(edge)));
    to_world(triangle.e1)
        .cross(to_world(triangle.e2))
        .try_normalize()
}
