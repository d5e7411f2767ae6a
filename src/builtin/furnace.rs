//! The furnace: a closed room in which the answer is known.
use super::assemble::{Assembly, view};
use super::shapes::cuboid;
use crate::view::View;
use gibs_passes::scene::{Material, Scene};
use glam::Vec3;

/// A closed cube of 2 m, seen from inside, whose walls all reflect the share `albedo` and emit the radiance `emission`.
///
/// By the rendering equation every wall then leaves the radiance `emission / (1 - albedo)` in every direction, and the
/// irradiance is that times pi. `albedo` must be at least 0 and below 1: at 1 the light never ends.
pub fn furnace(albedo: f32, emission: f32) -> (Scene, View) {
    let mut a = Assembly::new("furnace");
    let wall = a.material(Material {
        name: "wall".to_owned(),
        base_color: Vec3::splat(albedo),
        emission: Vec3::splat(emission),
        ..Material::default()
    });
    let mut room = cuboid(Vec3::NEG_ONE, Vec3::ONE);
    room.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    room.normals.iter_mut().for_each(|n| *n = -*n);
    a.draw("room", wall, &room);
    // From near one corner towards the opposite one.
    (
        a.scene,
        view([-0.8, 0.7, 0.85], [0.6, -0.4, -0.7], 80.0, [512, 512]),
    )
}
