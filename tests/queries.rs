//! Irradiance at points that a program asks for.
mod common;

use common::{all_backends, cpu, settings};
use gibs::passes::data::SurfacePoint;
use gibs::passes::frame::Settings;
use gibs::passes::scene::Scene;
use gibs::passes::shared::{octahedral, surface};
use gibs::view::View;
use gibs::{Irradiance, RenderError, Renderer, builtin};
use glam::{DVec3, Vec3, Vec4};

const SIZE: [u32; 2] = [48, 48];

fn asking(queries: u32) -> Settings {
    Settings {
        queries,
        // Every pixel of the picture is asked, none is interpolated.
        half_resolution: false,
        ..settings(4000)
    }
}

fn output<T: bytemuck::Pod>(renderer: &mut Renderer, name: &str) -> Vec<T> {
    let exec = renderer.executable();
    let id = exec.schedule().output(name).expect("an output");
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"))
}

/// Asked at the points that are seen, the answer is the picture, but for the rounding of packed normals. More points than fit at a
/// time are asked in turn, and asking changes no later frame.
#[test]
fn the_picture_is_what_is_asked_at_its_points() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let mut reference: Option<Vec<Irradiance>> = None;
    for backend in all_backends() {
        let renderer = |queries| {
            Renderer::new(backend.as_ref(), &scene, &view, SIZE, &asking(queries), 0)
                .unwrap_or_else(|e| panic!("{}: {e}", backend.name()))
        };
        let (mut asks, mut silent) = (renderer(1000), renderer(0));
        for _ in 0..16 {
            asks.frame().expect("a frame");
            silent.frame().expect("a frame");
        }
        let seen: Vec<SurfacePoint> = output(&mut asks, "points");
        let irradiance: Vec<Vec4> = output(&mut asks, "irradiance");
        // The box has no light but its lamp's surface, so no pixel has any either.
        assert!(asks.gi().schedule().output("direct").is_none());
        let picked: Vec<usize> = (0..seen.len())
            .filter(|&i| surface::is_surface(&seen[i]))
            .collect();
        assert!(picked.len() > 1000, "more than fit at a time");
        let origin = asks.gi().scene().origin;
        let world = |&i: &usize| seen[i].position.as_dvec3() + origin;
        let points: Vec<DVec3> = picked.iter().map(world).collect();
        let normals: Vec<Vec3> = picked
            .iter()
            .map(|&i| octahedral::unpack(seen[i].shading_normal))
            .collect();
        let answers = asks.irradiance(&points, &normals).expect("answers");
        assert_eq!(answers.len(), points.len());
        for (answer, &i) in answers.iter().zip(&picked) {
            let expected = irradiance[i].truncate();
            assert!(
                (answer.indirect - expected).abs().max_element()
                    <= 1e-5 * (1.0 + expected.length()),
                "{}: {answer:?} where the picture has {expected}",
                backend.name()
            );
            assert_eq!(answer.direct, Vec3::ZERO);
        }
        let covered = answers.iter().filter(|a| a.confidence > 0.5).count();
        assert!(
            covered * 2 > answers.len(),
            "{covered} of {} covered",
            answers.len()
        );
        match &reference {
            None => reference = Some(answers),
            Some(expected) => assert!(expected == &answers, "{} differs", backend.name()),
        }
        asks.frame().expect("a frame");
        silent.frame().expect("a frame");
        let (a, b): (Vec<Vec4>, Vec<Vec4>) =
            (output(&mut asks, "color"), output(&mut silent, "color"));
        assert!(a == b, "{}: asking changed the next frame", backend.name());
    }
}

#[test]
fn asking_without_room_or_normals_is_an_error_that_says_what_to_do() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let renderer = |queries| {
        Renderer::new(cpu().as_ref(), &scene, &view, SIZE, &asking(queries), 0).expect("a renderer")
    };
    let error = renderer(0)
        .irradiance(&[DVec3::ZERO], &[Vec3::Y])
        .expect_err("no stage");
    assert!(matches!(error, RenderError::Queries { .. }));
    assert!(error.to_string().contains("set `queries`"), "{error}");
    let error = renderer(8)
        .irradiance(&[DVec3::ZERO], &[])
        .expect_err("no normal");
    assert!(
        error.to_string().contains("1 points with 0 normals"),
        "{error}"
    );
    assert_eq!(renderer(8).irradiance(&[], &[]).expect("nothing"), []);
    let early = renderer(8).irradiance(&[DVec3::ZERO], &[Vec3::Y]);
    assert!(
        early
            .expect_err("too early")
            .to_string()
            .contains("no frame has run yet")
    );
    let mut ready = renderer(8);
    ready.frame().expect("a frame");
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let error = ready.irradiance(&[DVec3::ZERO, DVec3::splat(bad)], &[Vec3::Y; 2]);
        assert!(
            error
                .expect_err("no place")
                .to_string()
                .contains("point 1 is")
        );
    }
    for bad in [Vec3::ZERO, Vec3::NAN, Vec3::new(0.0, f32::INFINITY, 0.0)] {
        let error = ready.irradiance(&[DVec3::ZERO], &[bad]);
        assert!(
            error
                .expect_err("no direction")
                .to_string()
                .contains("normal 0 is")
        );
    }
}

/// The length of a normal says nothing.
#[test]
fn normals_may_have_any_length() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let mut renderer =
        Renderer::new(cpu().as_ref(), &scene, &view, SIZE, &asking(8), 0).expect("a renderer");
    for _ in 0..8 {
        renderer.frame().expect("a frame");
    }
    let point = [DVec3::new(0.1, 0.9, 0.1)];
    let normal = Vec3::new(0.6, -0.8, 0.0);
    let expected = renderer.irradiance(&point, &[normal]).expect("an answer");
    assert!(expected[0].indirect.max_element() > 0.0);
    for length in [1e30, 1e-25, 1e-38] {
        let answer = renderer.irradiance(&point, &[normal * length]);
        let answer = answer.expect("a direction")[0].indirect;
        let off = (answer - expected[0].indirect).abs().max_element();
        assert!(off <= 1e-4 * (1.0 + answer.length()), "{length}: {answer}");
    }
}

/// What the surfels of the frame before a change would answer belongs to another grid.
#[test]
fn after_a_change_a_frame_comes_first() {
    type Change = fn(&mut Renderer, &Scene, &View) -> Result<(), RenderError>;
    let changes: [(&str, Change); 4] = [
        ("lights", |r, scene, view| r.set_lights(scene, view)),
        ("scene", |r, scene, view| r.set_scene(scene, view)),
        ("size", |r, _, _| r.resize([32, 32])),
        ("reset", |r, _, _| r.reset()),
    ];
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    for backend in all_backends() {
        // Wide surfels: between the pixels of a small picture, those of a pixel leave gaps.
        let settings = Settings {
            radius: 3.0,
            ..asking(8)
        };
        let mut renderer =
            Renderer::new(backend.as_ref(), &scene, &view, SIZE, &settings, 0).expect("prepares");
        // On the floor: a surfel reaches no farther than its radius.
        let ask = |r: &mut Renderer| r.irradiance(&[DVec3::new(0.0, 0.0, 0.5)], &[Vec3::Y]);
        for (what, change) in changes {
            for _ in 0..8 {
                renderer.frame().expect("a frame");
            }
            let before = ask(&mut renderer).expect("an answer");
            assert!(before[0].indirect.max_element() > 0.0, "{what}: {before:?}");
            change(&mut renderer, &scene, &view).expect("a change");
            let refused = ask(&mut renderer).expect_err("too early").to_string();
            assert!(
                refused.contains("since the start or the last change"),
                "{what}: {refused}"
            );
            renderer.frame().expect("a frame");
            ask(&mut renderer).expect("an answer");
        }
    }
}

/// A frame that answers nothing has no stage, buffer or binding for it.
#[test]
fn without_queries_the_frame_has_nothing_for_them() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let mut renderer =
        Renderer::new(cpu().as_ref(), &scene, &view, SIZE, &asking(0), 0).expect("a renderer");
    let text = renderer.executable().schedule().to_text();
    assert!(!text.contains("query"), "{text}");
}
