//! The ends of small number formats: 16-bit albedo, 8-bit textures and guides of 8 bits. tests/imported.rs has half floats,
//! `estimator` depth moments.
use super::build::Build;
use super::common::all_backends;
use super::measure::{U, draw, levels, settings};
use super::pictures;
use gibs::passes::data::SurfacePoint;
use gibs::passes::scene::{Material, Sampler, Sun, Texture, TextureRef};
use gibs::passes::shared::guide::{self, Guide, MOST_LUMINANCE};
use gibs::passes::shared::surface::{albedo, pack_albedo, unorm16};
use glam::{Affine2, DVec3, Vec2, Vec3};

/// 16 bits hold `[0, 1]` to half a step, with both ends exact; what is outside is the nearer end, and what is no number is 0.
#[test]
fn packed_albedo_has_exact_ends() {
    let back = |x: f32| {
        let (albedo_rg, albedo_b_flags) = pack_albedo(Vec3::splat(x), 0);
        let point = SurfacePoint {
            albedo_rg,
            albedo_b_flags,
            ..SurfacePoint::default()
        };
        albedo(&point)
    };
    for (x, want) in [
        (0.0, 0.0),
        (1.0, 1.0),
        (-1.0, 0.0),
        (f32::MAX, 1.0),
        (f32::INFINITY, 1.0),
        (f32::NEG_INFINITY, 0.0),
        (f32::MIN_POSITIVE, 0.0),
        (f32::NAN, 0.0),
    ] {
        assert_eq!(back(x), Vec3::splat(want), "{x}");
    }
    let mut worst = 0f64;
    for i in 0..=1_000_000u32 {
        let x = i as f32 / 1e6;
        worst = worst.max((f64::from(back(x).x) - f64::from(x)).abs());
    }
    let bound = 0.5 / 65_535.0 + 2.0 * U;
    println!("packed albedo: off by {worst:.3e} (bound {bound:.3e})");
    assert!(worst <= bound, "{worst}");
    assert_eq!((unorm16(1.0), unorm16(0.0)), (65_535, 0));
}

/// A guide keeps its brightest texel to the step's 8 bits, `1/128`, and half a step, from the smallest normal number on, of
/// which 255 steps are above nothing, to 1e18, where it stops telling; beyond, and below, it is finite and its shares are in
/// `[0, 1/2]`.
#[test]
fn guides_hold_every_luminance() {
    const IDENTITY: u32 = 5;
    const SIDE: u32 = 6;
    for brightest in [
        0.0,
        1e-45,
        f32::MIN_POSITIVE,
        1e-30,
        1.0,
        1e13,
        1e18,
        1e30,
        f32::MAX,
    ] {
        let mut luminances = [0.0; (SIDE * SIDE) as usize];
        luminances[7] = brightest;
        luminances[20] = brightest * 0.5;
        let words = guide::pack(&luminances, IDENTITY, 1000, |_| 0.5);
        let packed = Guide::new(&words, SIDE);
        let (back, total) = (packed.unpack(), packed.total());
        assert!(
            back.iter().all(|x| x.is_finite() && *x >= 0.0),
            "{brightest}"
        );
        let share = packed.share(IDENTITY, total);
        assert!(
            (0.0..=guide::MOST_GUIDED).contains(&share),
            "{brightest}: {share}"
        );
        if (1e-30..=MOST_LUMINANCE).contains(&brightest) {
            let off = (f64::from(back[7]) / f64::from(brightest) - 1.0).abs();
            assert!(off <= 1.0 / 128.0 + 0.5 / 255.0, "{brightest}: {off}");
            let sum: f32 = (0..packed.texels())
                .map(|i| packed.probability(total, share, i))
                .sum();
            assert!((sum - 1.0).abs() < 1e-5, "{brightest}: {sum}");
            println!(
                "guide up to {brightest:e}: brightest texel off by {:.2} %",
                off * 100.0
            );
        }
    }
}

/// A floor with a texture of all 256 codes, a texel 1/16 m wide, read without filtering under a sun from above. IEC 61966-2-1
/// gives each code's albedo, which passes a table of `f32` and 16 bits: half a step and roundings. Radiance is albedo over pi
/// times the sun, and codes 0 and 255 are 0 and 1 exactly.
#[test]
fn textures_are_exact_at_both_ends() {
    let mut scene = Build::new("codes", [0.0, 1.0, 0.0], [0.0; 3], 2.0 * 0.5f64.atan());
    let texels = (0..=255u8).map(|code| [code, code, code, 255]).collect();
    scene.scene.textures.push(Texture {
        name: "codes".into(),
        width: 16,
        height: 16,
        texels,
    });
    scene.scene.materials.push(Material {
        base_color_texture: Some(TextureRef {
            texture: 0,
            sampler: Sampler {
                nearest: true,
                ..Sampler::default()
            },
            transform: Affine2::IDENTITY,
        }),
        ..Material::default()
    });
    scene.floor(0, [0.0; 3], 0.5);
    let uvs = [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)];
    scene.scene.meshes[0].uvs = uvs.map(Vec2::from).to_vec();
    scene.view.sun = Some(Sun {
        direction: DVec3::NEG_Y,
        irradiance: Vec3::splat(1.0),
    });
    let scene = scene.done();
    for backend in all_backends() {
        let name = backend.name();
        // Four pixels to a texel along each side.
        let picture = draw(backend.as_ref(), &scene, [64, 64], 2, &settings(), 0);
        let mut worst = 0f64;
        let mut errors = Vec::new();
        for (i, found) in levels(&picture, "albedo").into_iter().enumerate() {
            let code = i / 64 / 4 * 16 + i % 64 / 4;
            let c = code as f64 / 255.0;
            let linear = match c <= 0.04045 {
                true => c / 12.92,
                false => ((c + 0.055) / 1.055).powf(2.4),
            };
            let off = (found - linear).abs();
            let bound = 0.5 / 65_535.0 + 4.0 * U;
            assert!(off <= bound, "{name}: code {code}: {found}, not {linear}");
            assert!(
                ![0, 255].contains(&code) || off == 0.0,
                "{name}: code {code}"
            );
            worst = worst.max(off);
            errors.push(off);
        }
        println!("{name}: albedo of 256 codes: off by {worst:.2e} (bound 7.87e-6)");
        pictures::errors("texture-codes", name, &picture, &errors, 1e-5);
    }
}
