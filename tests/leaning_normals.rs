//! Surfaces whose normals of shading lean away from them, as those between the corners of a coarse mesh do: surfels cover their
//! surface there as anywhere.
mod common;

#[path = "common/wall.rs"]
mod wall;

use common::{all_backends, settings};
use gibs::Renderer;
use gibs::passes::data::SurfacePoint;
use gibs::passes::scene::{Environment, LocalTransform, Scene};
use gibs::passes::shared::plane::OFF;
use gibs::passes::shared::surface;
use glam::{DAffine3, DQuat, DVec3, Vec3, Vec4};
use std::f64::consts::PI;

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

/// A square whose normals lean by 40 degrees: of the rays about those a ninth go below it, and meet nothing there. So under a sky of 1
/// E is pi, and if it shines by 1 itself in the dark, nothing. What goes below by no more than [`OFF`] may meet the square from above:
/// `2 sin(40 deg) / pi` of the lobe for each radian, 0.7 %, and a third of that for chance and for light that comes back to it. Rays that all began above it
/// would have 6 % too little, and a ninth of pi.
#[test]
fn rays_that_go_below_a_surface_do_not_meet_it() {
    let lean = 40.0f32.to_radians();
    let bound = 4.0 / 3.0 * PI * f64::from(2.0 * lean.sin() / std::f32::consts::PI * OFF);
    for backend in all_backends() {
        let name = backend.name();
        for (sky, emission) in [(1.0, 0.0), (0.0, 1.0)] {
            let (mut scene, mut view) = wall::wall_from_above(1.0);
            scene.nodes[0].meshes = vec![0];
            let floor = &mut scene.meshes[0];
            floor.normals = vec![Vec3::new(0.0, lean.sin(), lean.cos()); floor.positions.len()];
            scene.materials[0].emission = Vec3::splat(emission);
            view.environment = Environment::Constant(Vec3::splat(sky));
            let size = [48, 27];
            let settings = settings(4_000);
            let mut renderer = Renderer::new(backend.as_ref(), &scene, &view, size, &settings, 0)
                .unwrap_or_else(|e| panic!("{name}: {e}"));
            (0..32).for_each(|_| renderer.frame().expect("a frame"));
            let found: Vec<Vec4> = renderer.output("irradiance").expect("an output");
            let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
            let seen = found.iter().zip(&points);
            let seen: Vec<f64> = seen
                .filter(|(_, point)| surface::is_surface(point))
                .map(|(e, _)| f64::from(e.x))
                .collect();
            let mean = seen.iter().sum::<f64>() / seen.len() as f64;
            let exact = PI * f64::from(sky);
            println!("{name}: {mean:.4} of {exact:.4}, within {bound:.4}");
            assert!((mean - exact).abs() <= bound, "{name}: {mean}, not {exact}");
        }
    }
}
