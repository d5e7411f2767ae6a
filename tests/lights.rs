//! Direct light against closed forms, and the choice of lights against all of them.
mod common;

use common::{all_backends, cpu, render, settings};
use gibs::passes::frame::Settings;
use gibs::passes::scene::{
    Camera, Environment, Light, LightKind, LocalTransform, Material, Mesh, Node, Scene,
};
use gibs::view::View;
use glam::{DQuat, DVec3, Vec3};
use std::f64::consts::FRAC_PI_2;

/// A floor of 20 m x 20 m at y = 0, and lights that look straight down.
fn floor(lights: &[(LightKind, DVec3, Vec3)]) -> (Scene, View) {
    let corners = [(-10.0, 10.0), (10.0, 10.0), (10.0, -10.0), (-10.0, -10.0)];
    let mut scene = Scene {
        name: "floor".into(),
        meshes: vec![Mesh {
            positions: corners.iter().map(|&(x, z)| Vec3::new(x, 0.0, z)).collect(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }],
        materials: vec![Material::default()],
        nodes: vec![Node {
            name: "floor".into(),
            parent: None,
            local: LocalTransform::IDENTITY,
            meshes: vec![0],
            skin: None,
        }],
        ..Scene::default()
    };
    for &(kind, position, intensity) in lights {
        let local = LocalTransform::Parts {
            translation: position,
            rotation: DQuat::from_rotation_x(-FRAC_PI_2),
            scale: DVec3::ONE,
        };
        let node = scene.nodes.len() as u32;
        scene.nodes.push(Node {
            name: String::new(),
            parent: None,
            local,
            meshes: Vec::new(),
            skin: None,
        });
        scene.lights.push(Light {
            node,
            kind,
            intensity,
        });
    }
    let view = View {
        scene: None,
        camera: Camera {
            position: DVec3::new(0.0, 6.0, 0.0),
            target: DVec3::ZERO,
            up: DVec3::NEG_Z,
            vfov: 1.2,
        },
        resolution: [32, 32],
        sun: None,
        environment: Environment::default(),
        animation: Vec::new(),
        exposure: 1.0,
        warnings: Vec::new(),
    };
    (scene, view)
}

/// Direct irradiance of every pixel equals `want(position)` within 0.1 %: positions and cosines carry 1e-4.
fn check(light: (LightKind, DVec3, Vec3), want: impl Fn(DVec3) -> f64) {
    let scene = floor(&[light]);
    for backend in all_backends() {
        let picture = render(backend.as_ref(), &scene, [32, 32], 1, &settings(100), 0);
        let direct = picture.rgb("direct").expect("direct light")[0];
        let position = picture.xyz("position").expect("positions");
        for i in 0..direct.len() {
            let p = DVec3::new(
                position[0][i].into(),
                position[1][i].into(),
                position[2][i].into(),
            );
            let (got, want) = (f64::from(direct[i]), want(p));
            let bound = 1e-3 * want + 1e-6;
            assert!(
                (got - want).abs() <= bound,
                "{}: at {p}: {got} instead of {want}",
                backend.name()
            );
        }
    }
}

#[test]
fn a_directional_light_gives_its_irradiance() {
    check(
        (
            LightKind::Directional,
            DVec3::new(0.0, 3.0, 0.0),
            Vec3::splat(7.0),
        ),
        |_| 7.0,
    );
}

#[test]
fn a_point_light_falls_with_the_square_and_the_cosine() {
    let at = DVec3::new(1.0, 2.0, -0.5);
    check((LightKind::Point, at, Vec3::splat(10.0)), |p| {
        let d = at - p;
        10.0 * d.y / d.length().powi(3)
    });
}

#[test]
fn a_spot_light_fades_between_its_cones() {
    let at = DVec3::new(0.0, 3.0, 0.0);
    let (inner, outer) = (0.3f32, 0.6f32);
    check(
        (LightKind::Spot { inner, outer }, at, Vec3::splat(10.0)),
        |p| {
            let d = at - p;
            let (low, high) = (f64::from(outer).cos(), f64::from(inner).cos());
            let share = ((d.y / d.length() - low) / (high - low)).clamp(0.0, 1.0);
            10.0 * d.y / d.length().powi(3) * share * share
        },
    );
}

/// Two of six lights at random, over 64 seeds of 256 pixels, against all six. One choice scatters by at most 1.5 times
/// the mean here, so that the mean over 2 x 64 x 256 choices stays within 1.5 / sqrt(32768) = 0.8 %, and 3 of those.
#[test]
fn choosing_lights_is_unbiased() {
    let lights: Vec<_> = (0..6)
        .map(|i| {
            let x = f64::from(i) * 1.5 - 3.75;
            (
                LightKind::Point,
                DVec3::new(x, 2.0 + f64::from(i % 2), 0.0),
                Vec3::splat(1.0 + i as f32),
            )
        })
        .collect();
    let scene = floor(&lights);
    let backend = cpu();
    let mean = |lights: u32, seed: u32| {
        let settings = Settings {
            lights,
            ..settings(100)
        };
        common::mean(
            &render(backend.as_ref(), &scene, [16, 16], 1, &settings, seed),
            "direct",
        )
    };
    let all = mean(8, 0);
    let chosen = (0..64).map(|seed| mean(2, seed)).sum::<f64>() / 64.0;
    assert!(
        (chosen / all - 1.0).abs() < 0.024,
        "{chosen} instead of {all}"
    );
}
