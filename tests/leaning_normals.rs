//! Surfaces whose normals of shading lean away from them, as those between the corners of a coarse mesh do: surfels cover their
//! surface there as anywhere.
mod common;

#[path = "common/wall.rs"]
mod wall;

use common::{all_backends, settings};
use gibs::Renderer;
use gibs::passes::scene::{LocalTransform, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3, Vec4};

/// Ten metres of floor from above, whose normals lean by so much, beside a lamp; a metre has ten pixels. How many surfels there
/// are after 32 frames, and what share of the picture they cover by less than a half.
fn surfels_and_holes(renderer: &mut Renderer) -> (u32, f64) {
    for _ in 0..32 {
        renderer.frame().expect("a frame");
    }
    let live = renderer.counters().expect("counters").live;
    let found: Vec<Vec4> = renderer.output("irradiance").expect("an output");
    let holes = found.iter().filter(|pixel| pixel.w < 0.5).count();
    (live, holes as f64 / found.len() as f64)
}

/// The same surfaces, as a node has them that stretches them fifty times along two axes, mirrors and turns them.
fn place(scene: &mut Scene) {
    let turned = DQuat::from_axis_angle(DVec3::new(0.48, -0.6, 0.64), 1.0);
    let matrix = DAffine3::from_scale_rotation_translation(
        DVec3::new(-50.0, 50.0, 1.0),
        turned,
        DVec3::new(3.0, -2.0, 1.0),
    );
    let inverse = matrix.inverse();
    for mesh in &mut scene.meshes {
        for position in &mut mesh.positions {
            *position = inverse.transform_point3(position.as_dvec3()).as_vec3();
        }
        for normal in &mut mesh.normals {
            let local = matrix.matrix3.transpose() * normal.as_dvec3();
            *normal = local.normalize().as_vec3();
        }
        // Seen from the front still.
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    scene.nodes[0].local = LocalTransform::Affine(matrix);
}

/// With normals that lean by 20 and by 40 degrees there are as many surfels as with upright ones, of the same size. Discs across
/// their normals would leave the floor after a fraction of their radius; the floor would pass for a wall that rises beside them;
/// and their rays would find it close by: with all three there are three times as many. So it is in the space of a node that stretches,
/// mirrors and turns it, too.
#[test]
fn surfels_are_as_many_as_on_upright_normals() {
    for backend in all_backends() {
        let name = backend.name();
        let found = [(0.0f32, false), (20.0, false), (40.0, false), (40.0, true)];
        let found = found.map(|(degrees, is_placed)| {
            let (mut scene, view) = wall::wall_from_above(1.0);
            let leaning = Vec3::new(0.0, degrees.to_radians().sin(), degrees.to_radians().cos());
            let floor = &mut scene.meshes[0];
            floor.normals = vec![leaning; floor.positions.len()];
            if is_placed {
                place(&mut scene);
            }
            let mut renderer = Renderer::new(
                backend.as_ref(),
                &scene,
                &view,
                [96, 54],
                &settings(4_000),
                0,
            )
            .unwrap_or_else(|e| panic!("{name}: {e}"));
            surfels_and_holes(&mut renderer)
        });
        println!("{name}: {found:?}");
        let [(upright, _), leaning @ ..] = found;
        for (live, holes) in leaning {
            // Where the first ones are is chance: 868 have a standard deviation of 29, were each one's its own.
            let apart = f64::from(live.abs_diff(upright)) / f64::from(upright);
            assert!(apart < 0.1, "{name}: {live} surfels, upright {upright}");
            assert!(holes < 0.002, "{name}: {holes}");
        }
    }
}
