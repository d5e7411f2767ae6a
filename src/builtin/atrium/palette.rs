//! Materials of the courtyard, with textures made by noise.
use crate::builtin::assemble::Assembly;
use crate::builtin::noise::{chance, cloud};
use gibs_passes::scene::{Material, Texture};
use glam::{FloatExt, Vec3};

/// Indices of the materials.
pub(super) struct Palette {
    pub plaster: u32,
    pub whitewash: u32,
    pub stone: u32,
    pub pavement: u32,
    pub brick_floor: u32,
    pub roof_tiles: u32,
    pub wood: u32,
    pub dark_wood: u32,
    pub iron: u32,
    pub glaze: u32,
    pub water: u32,
    pub terracotta: u32,
    pub soil: u32,
    pub leaves: u32,
    pub orange: u32,
    /// Red, green and blue, with coordinates that run over the unit square once.
    pub cloths: [u32; 3],
}

/// Side of the square textures in texels.
const SIZE: u32 = 512;

pub(super) fn palette(a: &mut Assembly) -> Palette {
    let wall = |name, seed, strength| {
        paint(name, [SIZE, SIZE], move |u, v| {
            let stain = cloud(u, v, 3, 5, seed) - 0.5;
            let grain = cloud(u, v, 96, 2, seed + 50) - 0.5;
            Vec3::splat(1.0 - strength + strength * (1.2 * stain + 0.5 * grain))
        })
    };
    let plaster = a.textured(wall("plaster", 1, 0.16), [4.0, 4.0], [0.86, 0.70, 0.49]);
    let whitewash = a.textured(wall("whitewash", 2, 0.10), [4.0, 4.0], [0.86, 0.81, 0.72]);
    let stone = a.textured(wall("stone", 3, 0.22), [1.5, 1.5], [0.66, 0.62, 0.55]);
    let pavement = a.textured(
        paint("pavement", [SIZE, SIZE], pavement),
        [4.8, 4.8],
        [1.0; 3],
    );
    let brick_floor = a.textured(
        paint("brick floor", [SIZE, SIZE], herringbone),
        [1.28, 1.28],
        [1.0; 3],
    );
    let roof_tiles = a.textured(wall("roof tiles", 4, 0.35), [1.1, 1.1], [0.62, 0.27, 0.15]);
    let wood = a.textured(
        paint("wood", [SIZE / 2, SIZE / 2], boards),
        [1.2, 1.2],
        [1.0; 3],
    );
    let cloths = [
        ("red cloth", [0.62, 0.05, 0.045]),
        ("green cloth", [0.05, 0.30, 0.09]),
        ("blue cloth", [0.05, 0.13, 0.48]),
    ]
    .map(|(name, color)| {
        let texture = paint(name, [128, 256], move |u, v| {
            banner(Vec3::from_array(color), u, v)
        });
        a.textured(texture, [1.0, 1.0], [1.0; 3])
    });
    Palette {
        plaster,
        whitewash,
        stone,
        pavement,
        brick_floor,
        roof_tiles,
        wood,
        dark_wood: a.paint("dark wood", [0.16, 0.085, 0.045]),
        iron: a.paint("iron", [0.07, 0.07, 0.075]),
        glaze: a.paint("blue glaze", [0.08, 0.17, 0.38]),
        water: a.paint("water", [0.06, 0.20, 0.22]),
        terracotta: a.paint("terracotta", [0.55, 0.24, 0.13]),
        soil: a.paint("soil", [0.09, 0.06, 0.04]),
        leaves: a.material(Material {
            name: "leaves".to_owned(),
            base_color: Vec3::new(0.09, 0.24, 0.05),
            double_sided: true,
            ..Material::default()
        }),
        orange: a.paint("orange", [0.85, 0.36, 0.04]),
        cloths,
    }
}

/// Renders a texture from linear colour as a function of (u, v), v downwards.
fn paint(name: &str, [width, height]: [u32; 2], color: impl Fn(f32, f32) -> Vec3) -> Texture {
    let texel = |i: u32| {
        let u = ((i % width) as f32 + 0.5) / width as f32;
        let v = ((i / width) as f32 + 0.5) / height as f32;
        let [r, g, b] = color(u, v).to_array().map(to_srgb);
        [r, g, b, 255]
    };
    Texture {
        name: name.to_owned(),
        width,
        height,
        texels: (0..width * height).map(texel).collect(),
    }
}

/// The sRGB transfer function (IEC 61966-2-1), rounded to 8 bits.
fn to_srgb(linear: f32) -> u8 {
    let v = linear.clamp(0.0, 1.0);
    let encoded = if v <= 0.003_130_8 {
        12.92 * v
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    };
    (encoded * 255.0).round() as u8
}

/// How far a point is inside a joint: 0 on the tile, 1 in the joint; `x` and `y` in tiles, `joint` in tiles.
fn joint(x: f32, y: f32, joint: f32) -> f32 {
    let edge = |t: f32| (t - t.floor()).min(t.ceil() - t);
    let distance = edge(x).min(edge(y));
    (1.5 - distance / joint).clamp(0.0, 1.0)
}

/// Stone slabs of 0.6 m in two tones, 8 x 8 of them.
fn pavement(u: f32, v: f32) -> Vec3 {
    let (x, y) = (u * 8.0, v * 8.0);
    let (i, j) = (x.floor() as i32, y.floor() as i32);
    let light = Vec3::new(0.60, 0.53, 0.42);
    let dark = Vec3::new(0.42, 0.30, 0.22);
    let tone = if (i + j) % 2 == 0 { light } else { dark };
    let slab = 0.85 + 0.25 * chance(i, j, 31);
    let veins = 0.8 + 0.4 * cloud(u, v, 12, 5, 32);
    (tone * slab * veins).lerp(Vec3::new(0.20, 0.17, 0.14), joint(x, y, 0.012))
}

/// Bricks of 0.32 x 0.08 m in a herringbone, 1.28 m square.
fn herringbone(u: f32, v: f32) -> Vec3 {
    // In units of a brick's width; a brick is 4 long, and rows shift by one, so the pattern repeats every 8 = 2 x 4.
    let (x, y) = (u * 16.0, v * 16.0);
    let (i, j) = (x.floor() as i32, y.floor() as i32);
    let phase = (i - j).rem_euclid(8);
    let (brick, along, across) = if phase < 4 {
        ([i - phase, j], (phase as f32 + x.fract()) / 4.0, y.fract())
    } else {
        (
            [i, j - (7 - phase)],
            ((7 - phase) as f32 + y.fract()) / 4.0,
            x.fract(),
        )
    };
    let edge = (along.min(1.0 - along) * 4.0).min(across.min(1.0 - across));
    let [bi, bj] = brick.map(|c: i32| c.rem_euclid(16));
    let tone = 0.75 + 0.45 * chance(bi, bj, 41 + u32::from(phase < 4));
    let color = Vec3::new(0.52, 0.25, 0.15) * tone * (0.85 + 0.3 * cloud(u, v, 24, 3, 42));
    color.lerp(
        Vec3::new(0.30, 0.26, 0.21),
        (1.5 - edge / 0.07).clamp(0.0, 1.0),
    )
}

/// Boards of 0.3 m along u.
fn boards(u: f32, v: f32) -> Vec3 {
    let y = v * 4.0;
    let board = y.floor() as i32;
    let grain =
        cloud(u * 0.25 + chance(board, 0, 51), v, 8, 2, 52).lerp(cloud(u, v, 64, 1, 53), 0.3);
    let color =
        Vec3::new(0.34, 0.20, 0.11) * (0.7 + 0.3 * chance(board, 1, 54) + 0.4 * (grain - 0.5));
    let edge = y.fract().min(1.0 - y.fract());
    color * (edge / 0.03).clamp(0.25, 1.0)
}

/// A banner with gold bands and a lozenge; u across, v down.
fn banner(color: Vec3, u: f32, v: f32) -> Vec3 {
    let gold = Vec3::new(0.78, 0.52, 0.13);
    let from_edge = u.min(1.0 - u);
    let band = (0.06..0.10).contains(&from_edge)
        || (0.08..0.105).contains(&v)
        || (0.13..0.14).contains(&v);
    // Twice as long as wide.
    let lozenge = (u - 0.5).abs() / 0.26 + (v - 0.45).abs() / 0.17;
    let emblem = (0.82..1.0).contains(&lozenge) || lozenge < 0.45;
    let weave = 0.92 + 0.16 * cloud(u, v, 64, 2, 61);
    (if band || emblem { gold } else { color }) * weave
}
