//! Nodes that mirror, flatten, and blow up what they draw.
use super::build::room;
use super::common::all_backends;
use super::measure::{
    FRAMES, Noise, PACKED, SIZE, assert_same_direct, assert_same_light, bits, draw, go_on,
    relative, settings,
};
use super::{measure, pictures};
use gibs::Renderer;
use gibs::passes::scene::{LocalTransform, Material, Node, Scene};
use gibs::view::View;
use glam::{DQuat, DVec3, Vec3};

/// The room with its meshes divided by `scale`, and its nodes multiplying by it: the same in the world.
fn through(scale: Vec3) -> (Scene, View) {
    let (mut scene, view) = room();
    for mesh in &mut scene.meshes {
        mesh.positions.iter_mut().for_each(|p| *p /= scale);
        // A normal is divided by the transpose's inverse; its length counts for nothing.
        for n in &mut mesh.normals {
            *n = (*n * scale).normalize();
        }
        // The front is the counter-clockwise side in the node's space, and goes where the node takes it.
        if scale.x * scale.y * scale.z < 0.0 {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }
    for node in &mut scene.nodes {
        if let LocalTransform::Parts { scale: own, .. } = &mut node.local {
            *own *= scale.as_dvec3();
        }
    }
    (scene, view)
}

fn assert_same_bits(scale: Vec3, what: &str) {
    for backend in all_backends() {
        let name = backend.name();
        let one = measure::room(backend.as_ref());
        let other = draw(
            backend.as_ref(),
            &through(scale),
            SIZE,
            FRAMES,
            &settings(),
            0,
        );
        for layer in ["E", "direct"] {
            let same = bits(&one, layer) == bits(&other, layer);
            assert!(same, "{name}: {layer} through a scale of {scale}");
        }
        println!("{name}: scaled by {what}: every bit of E and direct light is the same");
        pictures::irradiance(&format!("node-scales-{what}"), name, &other);
    }
}

/// A mirrored mesh in a node that mirrors is where it was. Changing signs is exact, but for packed normals, of vertices and of
/// surfels, which are kept in the node's space: the octahedral square has no step for zero, is rounded to one side, and the
/// mirror makes that the other. Directions of rays differ by as much. So direct light is the same within twice [`PACKED`] and
/// the roundings of numbers below 16 m, and indirect light is another draw, [`Noise`].
#[test]
fn mirrors_change_no_light() {
    let noise = Noise::of_room();
    for (scale, case) in [
        (Vec3::new(-1.0, 1.0, 1.0), "mirrored-x"),
        (Vec3::NEG_ONE, "mirrored-all"),
    ] {
        for backend in all_backends() {
            let name = backend.name();
            let one = measure::room(backend.as_ref());
            let other = draw(
                backend.as_ref(),
                &through(scale),
                SIZE,
                FRAMES,
                &settings(),
                0,
            );
            let what = format!("{name}: {case}");
            assert_same_direct(&one, &other, 16.0, 2.0 * PACKED, &what);
            assert_same_light(&one, &other, &noise, &what);
            pictures::errors(
                &format!("node-scales-{what}"),
                name,
                &one,
                &relative(&one, &other),
                0.5,
            );
        }
    }
}

/// Powers of two are exact while nothing leaves the normal numbers, 2^-126 to 2^128. What comes closest is the product of an
/// area and a direction in the node's space, `2^-30` cubed, and at 2^-30 the cube of 2^30. A normal does not: it is leveled
/// before it is squared. The bound is equality of all bits.
#[test]
fn huge_and_tiny_scales_change_no_bit() {
    assert_same_bits(Vec3::splat(2f32.powi(30)), "2^30");
    assert_same_bits(Vec3::splat(2f32.powi(-30)), "2^-30");
}

/// At 2^40 that product is 2^-120 times an area in square metres and a cosine: below 2^-126, which is the lamp of 1.4 m^2 at
/// less than a degree, or a few cm^2, digits get lost. E is that of the room but for chance.
#[test]
fn a_scale_of_2_to_the_40_changes_no_light() {
    let noise = Noise::of_room();
    let scene = through(Vec3::splat(2f32.powi(40)));
    for backend in all_backends() {
        let name = backend.name();
        let one = measure::room(backend.as_ref());
        let other = draw(backend.as_ref(), &scene, SIZE, FRAMES, &settings(), 0);
        assert_same_light(&one, &other, &noise, &format!("{name}: scaled by 2^40"));
        let errors = relative(&one, &other);
        pictures::errors("node-scales-2^40", name, &one, &errors, 0.5);
    }
}

/// A node that flattens its mesh to a plane, a line or a point draws nothing and is named, a lamp in it shines for nobody, and
/// the rest is what it is without: by the bit, since it is the last node and its mesh the last mesh.
#[test]
fn singular_nodes_are_left_out() {
    let singular = |scale: DVec3| {
        let (mut scene, view) = room();
        let mut mesh = scene.meshes[0].clone();
        mesh.material = scene.materials.len() as u32;
        scene.materials.push(Material {
            emission: Vec3::splat(100.0),
            ..Material::default()
        });
        scene.meshes.push(mesh);
        scene.nodes.push(Node {
            name: "flat".into(),
            local: LocalTransform::Parts {
                translation: DVec3::new(0.0, 0.0, 8.0),
                rotation: DQuat::IDENTITY,
                scale,
            },
            meshes: vec![scene.meshes.len() as u32 - 1],
            ..Node::default()
        });
        (scene, view)
    };
    let flat = DVec3::new(1.0, 1.0, 0.0);
    for backend in all_backends() {
        let name = backend.name();
        let one = measure::room(backend.as_ref());
        let (scene, view) = singular(flat);
        let mut renderer =
            Renderer::new(backend.as_ref(), &scene, &view, SIZE, &settings(), 0).expect("prepares");
        let other = go_on(&mut renderer, FRAMES, name);
        for layer in ["E", "direct"] {
            let same = bits(&one, layer) == bits(&other, layer);
            assert!(same, "{name}: {layer} beside a scale of {flat}");
        }
        println!("{name}: a node that is flat: every bit of the rest is the same");
    }
    for scale in [flat, DVec3::ZERO, DVec3::new(1e-300, 1.0, 1.0)] {
        let (scene, view) = singular(scale);
        let backend = super::common::cpu();
        let mut renderer =
            Renderer::new(backend.as_ref(), &scene, &view, SIZE, &settings(), 0).expect("prepares");
        let warnings = renderer.warnings();
        let warned = warnings.iter().any(|w| w.contains("\"flat\" is left out"));
        assert!(warned, "{scale}: {warnings:?}");
        go_on(&mut renderer, 4, "cpu");
    }
    println!("cpu: singular nodes: named");
}

/// Scales that are no numbers are refused; those whose product with a place is none, or beyond 1e18 m, are left out by name.
#[test]
fn scales_out_of_range_are_refused_or_left_out() {
    let backend = super::common::cpu();
    let with = |scale: f64| {
        let (mut scene, view) = room();
        let node = scene.nodes.iter_mut().find(|n| !n.meshes.is_empty());
        if let LocalTransform::Parts { scale: own, .. } = &mut node.expect("a node").local {
            *own = DVec3::splat(scale);
        }
        Renderer::new(backend.as_ref(), &scene, &view, SIZE, &settings(), 0)
    };
    for scale in [f64::NAN, f64::INFINITY] {
        let refused = with(scale).err().map(|e| e.to_string());
        assert!(
            refused
                .as_ref()
                .is_some_and(|e| e.contains("scale") && e.contains("finite")),
            "{scale}: {refused:?}"
        );
    }
    for scale in [1e19, 1e300] {
        let mut renderer = with(scale).expect("prepares");
        let warned = renderer
            .warnings()
            .iter()
            .any(|w| w.contains("is left out"));
        assert!(warned, "{scale}: {:?}", renderer.warnings());
        go_on(&mut renderer, 4, "cpu");
    }
    // Just within: 5 m times 1e16.
    let mut renderer = with(1e16).expect("prepares");
    go_on(&mut renderer, 4, "cpu");
    println!("cpu: scales of NaN and infinity refused, 1e19 and 1e300 left out, 1e16 finite");
}
