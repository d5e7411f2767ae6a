//! Transforms that flatten, mirror or lose what they move.
use super::file::{BRIGHT, Doc, SQUARE};
use super::run::{drawn, refused};
use serde_json::{Value, json};

const SINGULAR: &str = "singular; give every axis a scale other than zero";
const FAR: &str = "out of range; bring it closer";

/// A second, broken use of the square is left out by name, and the first is drawn as ever.
#[test]
fn flattened_nodes_are_left_out_by_name() {
    for transform in [
        json!({"scale": [1, 1, 0]}),
        json!({"scale": [0, 0, 0]}),
        json!({"matrix": [1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}),
        json!({"matrix": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]}),
    ] {
        let mut node = transform;
        node["mesh"] = json!(0);
        let mut doc = Doc::square();
        doc.node(node.clone());
        let unnamed = drawn(&doc).warns(&[&["node 3 \"nodes[3]\" is left out", SINGULAR]]);
        unnamed.is_the_square();
        node["name"] = json!("lid");
        doc.root["nodes"][3] = node;
        let named = drawn(&doc).warns(&[&["node 3 \"lid\" is left out", SINGULAR]]);
        named.is_the_square();
    }
}

#[test]
fn a_parent_flattens_its_children() {
    let mut doc = Doc::square();
    let child = doc.push("/nodes", json!({"mesh": 0, "name": "child"}));
    doc.node(json!({"scale": [1, 0, 1], "children": [child]}));
    let drawn = drawn(&doc).warns(&[&["\"child\" is left out", SINGULAR]]);
    drawn.is_the_square();
}

/// Mirrored twice it is the same, so it must be drawn as if it were not mirrored at all.
#[test]
fn mirrored_squares_keep_their_front() {
    for scale in [[-1, 1, 1], [1, -1, 1], [-1, -1, 1], [-1, 1, -1]] {
        let mut doc = Doc::square();
        doc.root["nodes"][0]["scale"] = json!(scale);
        drawn(&doc).warns(&[]).is_the_square();
    }
    let mut doc = Doc::square();
    doc.root["nodes"][0]["matrix"] = json!([-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    drawn(&doc).warns(&[]).is_the_square();
}

/// Only the front of a one-sided emitter shines. glTF turns the winding around with the sign of the determinant, so
/// that mirroring along x leaves the front where it is and mirroring along z takes it to the other side.
#[test]
fn mirrored_emitters_shine_from_their_front() {
    for (scale, front) in [
        ([1, 1, 1], true),
        ([-1, 1, 1], true),
        ([1, -1, 1], true),
        ([-1, -1, 1], true),
        ([1, 1, -1], false),
        ([-1, 1, -1], false),
    ] {
        let mut doc = Doc::square();
        doc.shape(&SQUARE, &[0, 1, 2, 0, 2, 3]);
        doc.root["materials"][0]["emissiveFactor"] = json!([1, 1, 1]);
        doc.root["nodes"][0]["scale"] = json!(scale);
        let drawn = drawn(&doc).warns(&[]);
        let expected = if front { 1.0 } else { 0.0 };
        assert_eq!(drawn.color("emission", 12, 12), [expected; 3], "{scale:?}");
        drawn.is_grey(12, 12, BRIGHT + expected);
    }
}

/// The lower right half of the square becomes its lower left half.
#[test]
fn mirroring_moves_what_is_on_one_side() {
    let mut doc = Doc::square();
    doc.shape(&SQUARE, &[0, 1, 2]);
    let right = drawn(&doc).warns(&[]);
    assert!(right.sees(18, 12) && !right.sees(5, 12));
    doc.root["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let left = drawn(&doc).warns(&[]);
    assert!(left.sees(5, 12) && !left.sees(18, 12));
    // Up to the diagonal's pixels, which go to one side or the other.
    assert!(left.seen().abs_diff(right.seen()) <= 16);
    left.is_grey(5, 12, BRIGHT);
}

#[test]
fn rotations_of_no_length_are_none() {
    let mut doc = Doc::square();
    doc.root["nodes"][0]["rotation"] = json!([0, 0, 0, 0]);
    let drawn = drawn(&doc).warns(&[&["1 node", "rotation of no length", "node 0"]]);
    drawn.is_the_square();
}

#[test]
fn projective_matrices_are_told() {
    let mut doc = Doc::square();
    doc.root["nodes"][0]["matrix"] = json!([1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    let drawn = drawn(&doc).warns(&[&["nodes[0].matrix", "not affine", "ignored"]]);
    drawn.is_the_square();
}

#[test]
fn transforms_that_are_not_finite_are_named() {
    for (key, value, what) in [
        ("translation", json!([0, 1e39, 0]), "translation"),
        ("scale", json!([-1e39, 1, 1]), "scale"),
        ("rotation", json!([0, 0, 0, 1e39]), "rotation"),
        (
            "matrix",
            json!([1e39, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]),
            "transform",
        ),
    ] {
        let mut doc = Doc::square();
        doc.root["nodes"][0] = json!({"mesh": 0, "name": "wall", key: value});
        refused(&doc, &["node 0 \"wall\"", what, "inf", "must be finite"]);
    }
}

/// A chain of nodes, each scaling by 1e38, with `leaf` at its end; returns the leaf's index.
fn beyond_all_numbers(doc: &mut Doc, leaf: Value) -> usize {
    let last = doc.push("/nodes", leaf);
    let mut child = last;
    let scale = [1e38; 3];
    for _ in 0..8 {
        child = doc.push("/nodes", json!({"children": [child], "scale": scale}));
    }
    doc.node(json!({"children": [child], "scale": scale}));
    last
}

/// What is out of every range is left out, and does not take the camera that is made up along.
#[test]
fn nodes_out_of_range_are_left_out_and_do_not_move_the_camera() {
    let mut alone = Doc::square();
    alone.root["scenes"][0]["nodes"] = json!([0]);
    let whole = drawn(&alone).warns(&[&["no camera"], &["no light"]]);
    let mut far = alone.clone();
    far.node(json!({"mesh": 0, "translation": [3e38, 0, 0]}));
    let mut infinite = alone.clone();
    beyond_all_numbers(&mut infinite, json!({"mesh": 0, "translation": [1, 1, 1]}));
    for doc in [far, infinite] {
        let drawn = drawn(&doc).warns(&[
            &["no camera"],
            &["no light"],
            &["\"nodes[3]\" is left out", FAR],
        ]);
        assert!(drawn.seen() > 60 && drawn.seen() == whole.seen());
        assert_eq!(drawn.color("", 12, 12), whole.color("", 12, 12));
    }
}

#[test]
fn lights_without_a_place_or_a_direction_are_left_out_by_name() {
    let light = json!({"KHR_lights_punctual": {"light": 1}});
    let with = |kind: &str, node: Value| {
        let mut doc = Doc::square();
        let lights = "/extensions/KHR_lights_punctual/lights";
        doc.push(lights, json!({"type": kind, "intensity": 5, "spot": {}}));
        doc.node(node);
        doc
    };
    for (kind, key, value, why) in [
        (
            "spot",
            "scale",
            json!([1, 1, 0]),
            "no direction; give every axis",
        ),
        (
            "directional",
            "scale",
            json!([0, 0, 0]),
            "no direction; give every axis",
        ),
        ("spot", "translation", json!([0, 3e38, 2]), FAR),
        ("point", "translation", json!([0, 3e38, 2]), FAR),
    ] {
        let doc = with(
            kind,
            json!({"name": "lamp", "extensions": light.clone(), key: value}),
        );
        let drawn = drawn(&doc).warns(&[&["light 1 in node 3 \"lamp\" is left out", why]]);
        drawn.is_the_square();
    }
    let mut doc = with("point", json!({}));
    beyond_all_numbers(
        &mut doc,
        json!({"extensions": light, "translation": [1, 1, 1]}),
    );
    let drawn = drawn(&doc).warns(&[&["light 1 in node", "is left out", FAR]]);
    drawn.is_the_square();
}

/// A point light needs no direction, so a flat node does it no harm.
#[test]
fn point_lights_shine_from_flat_nodes() {
    let brightness = |scale: [u32; 3]| {
        let mut doc = Doc::square();
        *doc.at("/extensions/KHR_lights_punctual/lights/0") =
            json!({"type": "point", "intensity": 4});
        doc.root["nodes"][2]["translation"] = json!([0, 0, 2]);
        doc.root["nodes"][2]["scale"] = json!(scale);
        drawn(&doc).warns(&[]).color("", 12, 12)
    };
    let lit = brightness([1, 1, 1]);
    assert!(lit[0] > 0.1, "{lit:?}");
    assert_eq!(brightness([0, 0, 0]), lit);
}
