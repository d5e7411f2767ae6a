//! Paths, holes and convergence against what is known of them.
use super::*;
use crate::builtin;
use gibs_passes::data::{Camera as DeviceCamera, NONE, SurfacePoint};
use gibs_passes::scene::Camera;
use gibs_passes::shared::octahedral;
use glam::{DVec3, Vec3, Vec4};
use std::path::Path;

fn camera() -> Camera {
    Camera {
        position: DVec3::ZERO,
        target: DVec3::NEG_Z,
        up: DVec3::Y,
        vfov: 1.0,
    }
}

fn parse(text: &str) -> Result<CameraPath, PathError> {
    CameraPath::from_json(text, Path::new("flight.json"), &camera())
}

fn keys(keys: &str) -> Result<CameraPath, PathError> {
    parse(&format!("{{\"keys\": [{keys}]}}"))
}

#[test]
fn a_path_goes_through_its_keys_smoothly_and_rests_at_its_ends() {
    let path = keys(
        r#"{"frame": 10, "position": [0, 0, 0], "target": [0, 0, -5]},
           {"frame": 20, "position": [1, 0, 0], "target": [1, 0, -5]},
           {"frame": 50, "position": [4, 0, 0], "target": [4, 0, -5]}"#,
    )
    .expect("a path");
    let x = |frame: f64| path.camera(frame).position.x;
    assert_eq!(
        [x(0.0), x(10.0), x(20.0), x(50.0), x(99.0)],
        [0.0, 0.0, 1.0, 4.0, 4.0]
    );
    // A constant speed stays one, though the keys are not even in time.
    for frame in 10..=50 {
        assert!(
            (x(f64::from(frame)) - f64::from(frame - 10) / 10.0).abs() < 1e-12,
            "{frame}"
        );
    }
}

/// Between two keys with the same position the camera stays there, whatever comes before and after, and what it looks at goes its
/// own way.
#[test]
fn a_path_rests_between_equal_keys() {
    let path = keys(
        r#"{"frame": 0, "position": [0, 0, 0], "target": [0, 0, -5]},
           {"frame": 63, "position": [0, 0, 0], "target": [0, 0, -5]},
           {"frame": 64, "position": [8, 0, 0], "target": [8, 0, -5]},
           {"frame": 127, "position": [8, 0, 0], "target": [9, 0, -5]}"#,
    )
    .expect("a path");
    for tenth in 0..1400 {
        let frame = f64::from(tenth) * 0.1;
        let camera = path.camera(frame);
        let x = camera.position.x;
        match frame {
            ..=63.0 => assert_eq!((x, camera.target.x), (0.0, 0.0), "{frame}"),
            64.0.. => assert_eq!(x, 8.0, "{frame}"),
            _ => assert!((0.0..=8.0).contains(&x), "{frame}"),
        }
    }
    assert!(path.camera(100.0).target.x > 8.2);
}

#[test]
fn broken_paths_name_file_field_and_value() {
    let pose = r#""position": [0, 0, 0], "target": [0, 0, -1]"#;
    let cases = [
        (String::new(), "`keys` is empty"),
        (
            format!(r#"{{"frame": -1, {pose}}}"#),
            "`keys[0].frame` is -1",
        ),
        (
            format!(r#"{{"frame": 5, {pose}}}, {{"frame": 5, {pose}}}"#),
            "`keys[1].frame` is 5",
        ),
        (
            r#"{"frame": 0, "position": [0, 1e99, 0], "target": [0, 0, 0]}"#.into(),
            "`keys[0].position` is [0.0, 1e99, 0.0]",
        ),
        (
            r#"{"frame": 0, "position": [1, 2, 3], "target": [1, 2, 3]}"#.into(),
            "`keys[0].target` is [1.0, 2.0, 3.0], the same as `position`",
        ),
        (
            r#"{"frame": 0, "position": [0, 0, 0], "target": [0, 9, 0]}"#.into(),
            "frame 0",
        ),
        (
            r#"{"frame": 0, "position": [0, 0, 0]}"#.into(),
            "missing field `target`",
        ),
        (
            format!(r#"{{"frame": 0, "roll": 1, {pose}}}"#),
            "unknown field `roll`",
        ),
    ];
    for (text, part) in cases {
        let message = keys(&text).expect_err(&text).to_string();
        assert!(
            message.contains(part) && message.contains("flight.json"),
            "{message}"
        );
    }
    let absent = CameraPath::load("/nowhere/flight.json", &camera()).expect_err("absent");
    assert!(absent.to_string().contains("/nowhere/flight.json"));
}

#[test]
fn every_built_in_scene_has_a_path_of_sound_cameras() {
    for (name, _) in builtin::names() {
        let (_, view) = builtin::by_name(name).expect("built in");
        let path = CameraPath::around(&view.camera, 100);
        assert_eq!(path.last_frame(), 99.0);
        for frame in 0..100 {
            let camera = path.camera(f64::from(frame));
            camera
                .check()
                .unwrap_or_else(|e| panic!("{name}, frame {frame}: {e}"));
        }
    }
}

#[test]
fn the_paths_beside_the_examples_are_sound() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/paths");
    for name in ["atrium", "sponza"] {
        let path = CameraPath::load(folder.join(name).with_extension("json"), &camera());
        let path = path.unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(path.last_frame(), 599.0, "{name}");
    }
}

#[test]
fn convergence_is_where_the_error_stays_below() {
    let from = |errors: &[f64]| converged_from(errors.iter().map(|e| Some(*e)), 0.05);
    assert_eq!(from(&[0.5, 0.04, 0.06, 0.03, 0.01]), Some(3));
    assert_eq!(from(&[0.04, 0.03]), Some(0));
    assert_eq!(from(&[0.04, 0.05]), None);
    assert_eq!(from(&[]), None);
    // A few frames alone say little.
    assert_eq!(from(&[0.5, 0.5, 0.5, 0.04]), Some(3));
    assert_eq!(from(&[0.5, 0.5, 0.5, 0.5, 0.04]), None);
    assert_eq!(converged_from([Some(0.1), None].into_iter(), 0.5), None);
}

fn wall(x: f32, y: f32) -> SurfacePoint {
    SurfacePoint {
        position: Vec3::new(x, y, -4.0),
        geometric_normal: octahedral::pack(Vec3::Z),
        transform_id: 3,
        ..SurfacePoint::default()
    }
}

/// Sixteen pixels of the sky below, as many of a wall above.
fn half_sky() -> Vec<SurfacePoint> {
    let sky = SurfacePoint {
        transform_id: NONE,
        ..SurfacePoint::default()
    };
    let mut points = vec![wall(0.0, 0.0); 16 * 8];
    points.extend(vec![sky; 16 * 8]);
    points
}

#[test]
fn block_errors_are_relative_means_over_surfaces() {
    let blocks = |left: f32, right: f32| {
        let light: Vec<Vec4> = (0..256)
            .map(|i| Vec4::splat(if i % 16 < 8 { left } else { right }))
            .collect();
        BlockMeans::of(&half_sky(), &light, 16)
    };
    let truth = blocks(1.0, 3.0);
    assert_eq!(truth.error(&truth), Some(0.0));
    let error = blocks(1.5, 3.3).error(&truth).expect("light");
    assert!((error - (0.5 + 0.1) / 2.0).abs() < 1e-6, "{error}");
    assert_eq!(
        truth.error(&blocks(0.0, 0.0)),
        None,
        "no light to compare with"
    );
}

/// What an eye at `x` sees of a wall 4 m away.
fn view_at(x: f32) -> (DeviceCamera, Vec<SurfacePoint>) {
    const SIDE: u32 = 16;
    let camera = DeviceCamera {
        eye: Vec3::new(x, 0.0, 0.0),
        width: SIDE,
        right: Vec3::X,
        height: SIDE,
        up: Vec3::Y,
        pixel_angle: 2.0 / SIDE as f32,
        forward: Vec3::NEG_Z,
        ..DeviceCamera::default()
    };
    let at = |i: u32| (i as f32 + 0.5) / SIDE as f32 * 2.0 - 1.0;
    let points = (0..SIDE * SIDE).map(|i| wall(x + 4.0 * at(i % SIDE), -4.0 * at(i / SIDE)));
    (camera, points.collect())
}

#[test]
fn surfaces_settle_and_what_is_revealed_starts_over() {
    let mut holes = Holes::default();
    let covered = vec![1.0; 256];
    for frame in 1..SETTLES {
        let (camera, points) = view_at(0.0);
        let row = holes.count(camera, points, &covered);
        assert_eq!((row.surfaces, row.settled), (256, 0), "{frame}");
    }
    // Two columns come into view (a pixel is half a metre wide there), and one pixel is a hole.
    let (camera, points) = view_at(1.0);
    let mut weights = covered.clone();
    weights[0] = 0.49;
    let row = holes.count(camera, points, &weights);
    assert_eq!((row.settled, row.settled_holes, row.holes), (14 * 16, 1, 1));
    // The node in the picture is another one: nothing of it was in view.
    let (camera, mut points) = view_at(1.0);
    points.iter_mut().for_each(|point| point.transform_id = 4);
    assert_eq!(holes.count(camera, points, &covered).settled, 0);
}

#[test]
fn tables_have_a_value_for_every_column() {
    let row = FrameRow {
        frame: 7,
        ms: 1.5,
        groups_ms: vec![0.25, 1.0],
        live: 3,
        births: 2,
        recycled: 1,
        starved: 0,
        crowded: 4,
        grid_overflow: 0,
        slot_errors: None,
        rays: 9,
        continued: 5,
    };
    let groups = ["gbuffer", "apply"].map(str::to_owned);
    let text = csv(
        &groups,
        &["budget"],
        &["error"],
        [(vec!["9".into()], &row, vec![String::new()])].into_iter(),
    );
    assert_eq!(
        text,
        "budget,frame,ms,gbuffer_ms,apply_ms,live,births,recycled,starved,crowded,grid_overflow,slot_errors,rays,continued,error\n\
         9,7,1.500,0.250,1.000,3,2,1,0,4,0,,9,5,\n"
    );
    let rows = vec![row; 1000];
    let plot = group_plot("cost", &groups, rows.iter());
    assert_eq!(plot.series.len(), 2);
    assert!(
        plot.series
            .iter()
            .all(|s| s.points.len() <= 150 && s.points[0][1] > 0.0)
    );
}
