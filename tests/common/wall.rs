//! A wall that is thinner than a pixel, with light on one side.
use gibs::passes::data::SurfacePoint;
use gibs::passes::scene::{Environment, Material, Mesh, Node, Scene};
use gibs::passes::shared::surface;
use gibs::view::View;
use gibs::{Renderer, builtin};
use glam::{DVec3, Vec3, Vec4};

/// A mesh of rectangles in planes of constant z, front side up the axis: (least x, y, largest x, y, z).
pub fn planes(rectangles: &[[f32; 5]], material: u32) -> Mesh {
    let mut mesh = Mesh {
        material,
        ..Mesh::default()
    };
    for &[x0, y0, x1, y1, z] in rectangles {
        let first = mesh.positions.len() as u32;
        let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        mesh.positions
            .extend(corners.map(|[x, y]| Vec3::new(x, y, z)));
        mesh.triangles
            .extend([[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i: u32| first + i)));
    }
    mesh
}

/// A scene of three meshes in one node, of a grey material and one that shines, the brighter by `scale`.
pub fn lit(meshes: Vec<Mesh>, scale: f32) -> Scene {
    Scene {
        nodes: vec![Node {
            meshes: vec![0, 1, 2],
            ..Node::default()
        }],
        meshes,
        materials: vec![
            Material {
                base_color: Vec3::splat(0.5),
                ..Material::default()
            },
            Material {
                emission: Vec3::splat(10.0) * scale,
                ..Material::default()
            },
        ],
        ..Scene::default()
    }
}

/// Ten metres of floor from above, and a wall of a millimetre along the middle of the picture, between two pixels: nothing
/// of it is seen. To its right a lamp, which is lower than the wall, so that no light reaches the floor to its left. All light times `scale`.
pub fn wall_from_above(scale: f32) -> (Scene, View) {
    let mut wall = Mesh::default();
    let side = |x: f32, flip: bool| {
        let corners = [[x, -5.0, 0.0], [x, 5.0, 0.0], [x, 5.0, 3.0], [x, -5.0, 3.0]];
        let triangles = [[0, 1, 2], [0, 2, 3]];
        let turned = triangles.map(|[a, b, c]| if flip { [a, c, b] } else { [a, b, c] });
        (corners.map(Vec3::from), turned)
    };
    for (positions, triangles) in [side(0.0005, false), side(-0.0005, true)] {
        let first = wall.positions.len() as u32;
        wall.positions.extend(positions);
        wall.triangles
            .extend(triangles.map(|t| t.map(|i: u32| first + i)));
    }
    let mut lamp = planes(&[[2.0, -2.0, 3.0, 2.0, 2.5]], 1);
    lamp.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let meshes = vec![planes(&[[-5.0, -5.0, 5.0, 5.0, 0.0]], 0), wall, lamp];
    let scene = lit(meshes, scale);
    let mut view = builtin::furnace(0.5, 1.0).1;
    view.environment = Environment::Constant(Vec3::ZERO);
    view.camera.target = DVec3::ZERO;
    view.camera.up = DVec3::Y;
    view.camera.position = DVec3::new(0.0, 0.0, 8.0);
    // Ten metres of floor are the width of the picture.
    view.camera.vfov = 2.0 * (5.0 * 9.0 / 16.0 / 8.0f64).atan();
    (scene, view)
}

/// What the floor of [`wall_from_above`] has on its dark side, in the last frame, over what it has on its lit one, which is more
/// than `least`, W/m^2.
#[allow(dead_code, reason = "not all tests with this wall light it")]
pub fn leaked(renderer: &mut Renderer, least: f64) -> f64 {
    let floor = -renderer.gi().scene().origin.z as f32;
    let points: Vec<SurfacePoint> = renderer.output("points").expect("points");
    let irradiance: Vec<Vec4> = renderer.output("irradiance").expect("irradiance");
    let mean = |right: bool| {
        let (mut count, mut sum) = (0.0, 0.0);
        for (p, e) in points.iter().zip(&irradiance) {
            let is_floor = surface::is_surface(p) && (p.position.z - floor).abs() < 0.01;
            if is_floor && (p.position.x > 0.0) == right {
                count += 1.0;
                sum += f64::from(e.x);
            }
        }
        assert!(count > 8000.0, "{count} pixels");
        sum / count
    };
    let (dark, bright) = (mean(false), mean(true));
    assert!(bright > least, "{bright} W/m^2 on the lit side");
    dark / bright
}
