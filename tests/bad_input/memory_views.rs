//! Views built in memory that have no picture: cameras, planes and descriptions of G-buffers.
use super::memory::{Running, SIZE, repaired, settings, whole};
use gibs::RenderError;
use gibs::passes::data::HostGbuffer;
use gibs::passes::frame::Screen;
use gibs::passes::scene::Camera;
use glam::DVec3;

/// Cameras that show nothing, each with what the message says of it.
fn blind() -> Vec<(Camera, [&'static str; 2])> {
    let sound = whole().1.camera;
    let at = |position| Camera { position, ..sound };
    let to = |target| Camera { target, ..sound };
    let wide = |vfov| Camera { vfov, ..sound };
    let field = "between 0 and pi radians";
    vec![
        (at(DVec3::NAN), ["position is [NaN", "must be finite"]),
        (at(DVec3::INFINITY), ["position is [inf", "must be finite"]),
        (at(DVec3::X * 1e16), ["position is [1", "at most 1e15"]),
        (to(DVec3::NAN), ["target is [NaN", "must be finite"]),
        (
            to(sound.position),
            ["target is [0, 0, 2]", "another point than the position"],
        ),
        (
            Camera {
                up: DVec3::NAN,
                ..sound
            },
            ["up direction is [NaN", "must be finite"],
        ),
        (wide(f64::NAN), ["vertical field of view is NaN", field]),
        (wide(0.0), ["vertical field of view is 0", field]),
        (wide(-1.0), ["vertical field of view is -1", field]),
        (
            wide(std::f64::consts::PI),
            ["vertical field of view is 3.14", field],
        ),
        (wide(50.0), ["vertical field of view is 50", field]),
    ]
}

#[test]
fn cameras_without_a_picture_are_named() {
    let mut running = Running::new(Screen::Traced);
    for (camera, parts) in blind() {
        let parts = [&["the view's camera"][..], &parts].concat();
        // The change of lights takes no camera, and keeps the one that is there.
        running.refuses(&|_, v| v.camera = camera, &parts);
        let (gi, exec) = (&mut running.gi, running.exec.as_mut());
        for (way, result) in [
            ("begin_frame", gi.begin_frame(exec, &camera, None)),
            ("resize", gi.resize(exec, [9, 9], &camera)),
            ("set_settings", gi.set_settings(exec, &settings(), &camera)),
        ] {
            let text = result.map_err(|e| e.to_string()).expect_err(way);
            for part in &parts {
                assert!(text.contains(part), "{way}: {part:?} is not in: {text}");
            }
        }
        assert_eq!((gi.size(), gi.frames()), (SIZE, 0));
    }
}

/// A camera that looks along its own up direction has a picture: the way an engine looks straight down.
#[test]
fn a_camera_may_look_along_its_up_direction() {
    repaired(&|_, v| v.camera.up = DVec3::Z, &[]);
    repaired(&|_, v| v.camera.up = DVec3::ZERO, &[]);
}

#[test]
fn planes_that_make_no_projection_are_named() {
    for reversed in [false, true] {
        let of = |near, far| HostGbuffer::perspective(near, far, reversed);
        assert_eq!(of(0.1, Some(f64::INFINITY)), of(0.1, None));
        for (near, text) in [
            (f64::NAN, "NaN m"),
            (0.0, "at 0 m"),
            (-0.1, "-0.1 m"),
            (f64::INFINITY, "inf m"),
            (1e-60, "m; give a finite distance above zero"),
        ] {
            for far in [None, Some(10.0)] {
                let error = of(near, far).expect_err("refused").to_string();
                for part in ["near plane", text, "give a finite distance above zero"] {
                    assert!(error.contains(part), "{part:?} is not in: {error}");
                }
            }
        }
        for (far, text) in [
            (0.1, "far plane is at 0.1 m"),
            (0.05, "far plane is at 0.05 m"),
            (-1.0, "far plane is at -1 m"),
            (f64::NEG_INFINITY, "far plane is at -inf m"),
            (f64::NAN, "far plane is at NaN m"),
        ] {
            let error = of(0.1, Some(far)).expect_err("refused").to_string();
            for part in [
                text,
                "near plane at 0.1 m",
                "beyond the near one, or `None`",
            ] {
                assert!(error.contains(part), "{part:?} is not in: {error}");
            }
        }
        for far in [0.100_001, 1e6, 1e300, f64::MAX] {
            let host = of(0.1, Some(far)).expect("planes");
            assert_eq!(host.check(), Ok(()), "{far}");
        }
    }
}

#[test]
fn descriptions_of_gbuffers_that_mean_nothing_are_named() {
    let mut running = Running::new(Screen::Imported);
    let camera = whole().1.camera;
    let sound = HostGbuffer::perspective(0.1, None, true).expect("planes");
    type Breaks = fn(&mut HostGbuffer);
    let cases: [(Breaks, [&str; 2]); 11] = [
        (
            |h| h.depth_scale = f32::NAN,
            ["`depth_scale`", "is NaN; it must be finite and not zero"],
        ),
        (
            |h| h.depth_scale = 0.0,
            ["`depth_scale`", "is 0; it must be finite and not zero"],
        ),
        (
            |h| h.depth_offset = f32::INFINITY,
            ["`depth_offset`", "is inf; it must be finite"],
        ),
        (
            |h| h.depth_clear = f32::NAN,
            ["`depth_clear`", "is NaN; it must be finite"],
        ),
        (
            |h| h.depth_step = -1.0,
            ["`depth_step`", "is -1; it must be finite and not negative"],
        ),
        (
            |h| h.jitter.x = f32::NAN,
            ["`jitter.x`", "is NaN; it must be finite"],
        ),
        (
            |h| h.jitter.y = f32::INFINITY,
            ["`jitter.y`", "is inf; it must be finite"],
        ),
        (
            |h| h.exposure = f32::NAN,
            ["`exposure`", "is NaN; it must be finite"],
        ),
        (
            |h| h.exposure = -2.0,
            ["`exposure`", "is -2; it must be finite and not negative"],
        ),
        (
            |h| h.normals = 3,
            ["`normals`", "is 3; it must be one of `NORMALS_SIGNED` (0)"],
        ),
        (
            |h| h.radiance = 2,
            ["`radiance`", "is 2; it must be 1 to get radiance"],
        ),
    ];
    let (gi, exec) = (&mut running.gi, running.exec.as_mut());
    for (breaking, parts) in cases {
        let mut host = sound;
        breaking(&mut host);
        let error = gi
            .begin_frame(exec, &camera, Some(&host))
            .expect_err("refused");
        assert!(matches!(error, RenderError::Gbuffer(_)), "{error:?}");
        for part in parts {
            let text = error.to_string();
            assert!(text.contains(part), "{part:?} is not in: {text}");
        }
    }
    assert_eq!(gi.frames(), 0);
    gi.begin_frame(exec, &camera, Some(&sound))
        .expect("a frame");
}
