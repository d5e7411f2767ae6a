//! A small room with a blended pane and a grid that is cut out of a texture.
use super::assemble::{Assembly, view};
use super::shapes::{Shape, bevelled, shell, sphere};
use crate::view::View;
use gibs_passes::scene::{AlphaMode, Material, Scene, Texture};
use glam::{Vec2, Vec3};

/// A room of 4 x 2.6 x 4 m under a ceiling panel; a tinted pane stands in it, and a metal grid.
pub(super) fn glass() -> (Scene, View) {
    let mut a = Assembly::new("glass");
    let white = a.paint("white", [0.76, 0.75, 0.72]);
    let yellow = a.paint("yellow", [0.72, 0.52, 0.10]);
    let violet = a.paint("violet", [0.34, 0.16, 0.52]);
    let light = a.glow("ceiling panel", 0.7, [14.0, 13.0, 12.0]);

    let inner = [Vec3::new(-2.0, 0.0, -2.0), Vec3::new(2.0, 2.6, 2.0)];
    let outer = [Vec3::new(-2.3, -0.3, -2.3), Vec3::new(2.3, 2.9, 2.3)];
    let (outside, inside) = shell(inner, outer, None);
    a.draw("outside", white, &outside);
    for (face, paint) in inside
        .iter()
        .zip([violet, yellow, white, white, white, white])
    {
        a.draw("room", paint, face);
    }
    let mut panel = Shape::default();
    let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    panel.polygon(&corners.map(|[x, z]| Vec3::new(x, 2.59, z)));
    a.draw("ceiling panel", light, &panel);
    a.draw("ball", yellow, &sphere(0.35, 32).at(0.9, 0.35, -1.0));
    let block = bevelled(
        Vec3::new(-1.3, -0.01, -1.5),
        Vec3::new(-0.6, 1.2, -0.9),
        0.015,
    );
    a.draw("block", white, &block);

    let pane = a.material(Material {
        name: "pane".to_owned(),
        base_color: Vec3::new(0.18, 0.62, 0.45),
        alpha: 0.3,
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        ..Material::default()
    });
    a.draw("pane", pane, &upright([-1.6, 0.05], [0.15, 1.9], 0.1));

    let pattern = a.texture(grid_texture(), [0.12, 0.12]);
    let grid = a.material(Material {
        name: "grid".to_owned(),
        base_color: Vec3::splat(0.55),
        base_color_texture: Some(pattern),
        alpha_mode: AlphaMode::Mask(0.5),
        double_sided: true,
        ..Material::default()
    });
    a.draw("grid", grid, &upright([0.3, 1.7], [0.02, 1.46], -0.2));
    let mut view = view([0.3, 1.5, 1.9], [0.0, 0.9, -1.0], 65.0, [640, 480]);
    view.exposure = 0.7;
    (a.scene, view)
}

/// A rectangle that faces +z. Texture coordinates begin at its upper left corner.
fn upright(x: [f32; 2], y: [f32; 2], z: f32) -> Shape {
    let mut shape = Shape::default();
    shape.polygon(
        &[[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]].map(|[x, y]| Vec3::new(x, y, z)),
    );
    let origin = Vec2::new(x[0], -y[1]);
    shape.uvs.iter_mut().for_each(|uv| *uv -= origin);
    shape
}

/// One mesh of the grid: a square hole with bars around it.
fn grid_texture() -> Texture {
    const SIZE: u32 = 64;
    const BAR: u32 = 9;
    let is_bar = |i: u32| !(BAR..SIZE - BAR).contains(&i);
    let texel = |i: u32| {
        let solid = is_bar(i % SIZE) || is_bar(i / SIZE);
        [255, 255, 255, if solid { 255 } else { 0 }]
    };
    let texels = (0..SIZE * SIZE).map(texel).collect();
    Texture {
        name: "grid".to_owned(),
        width: SIZE,
        height: SIZE,
        texels,
    }
}
