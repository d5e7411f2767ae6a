//! Debug views: the same on all backends, and what they say against what the surfels' own buffers hold.
#[path = "../common/mod.rs"]
mod common;
mod pixels;
mod surfels;

use common::{all_backends, cpu, settings};
use gibs::graph::{Backend, DispatchArgs, Element};
use gibs::passes::data::{DebugPixel, GridShape, SurfacePoint, SurfelIrradiance, SurfelPose};
use gibs::passes::frame::{DebugScale, DebugView, Settings};
use gibs::passes::shared::depth::Depths;
use gibs::passes::shared::guide::Guides;
use gibs::passes::shared::{depth, grid, lookup, octahedral, sampling, surface};
use gibs::picture::{OUTSIDE_COLOR, cool_warm, inferno};
use gibs::{DebugPicture, RenderError, Renderer, builtin};
use glam::{UVec2, Vec3, Vec4};

const SIZE: [u32; 2] = [96, 54];

fn with_view(view: DebugView) -> Settings {
    Settings {
        guiding: true,
        debug: Some(view),
        // Each pixel is looked at and looks itself.
        half_resolution: false,
        ..settings(20_000)
    }
}

/// A renderer whose buffers can all be read after a frame.
fn renderer(backend: &dyn Backend, scene: &str, settings: &Settings) -> Renderer {
    let (scene, view) = builtin::by_name(scene).expect("built in");
    let keep = |g: &mut gibs::graph::Graph, _| g.keep_transients();
    Renderer::extended(backend, &scene, &view, SIZE, settings, 0, keep).expect("prepares")
}

/// The atrium after some frames, on the processor.
fn rendered(view: DebugView, frames: u32) -> Renderer {
    let mut renderer = renderer(cpu().as_ref(), "atrium", &with_view(view));
    for _ in 0..frames {
        renderer.frame().expect("renders");
    }
    renderer
}

/// All elements of a buffer of the frame.
fn buffer<T: Element>(renderer: &mut Renderer, key: &str) -> Vec<T> {
    let exec = renderer.executable();
    let id = exec
        .schedule()
        .resource(key)
        .unwrap_or_else(|| panic!("{key}"));
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("reads"))
}

fn values(renderer: &mut Renderer) -> Vec<f32> {
    let pixels: Vec<DebugPixel> = renderer.output("debug").expect("a view");
    pixels.iter().map(|p| p.value).collect()
}

/// Slot of the surfel that each pixel shows, -1 for none.
fn slots(frames: u32) -> Vec<f32> {
    values(&mut rendered(DebugView::Surfels, frames))
}

/// Each view has equal bits on every backend, whether it was there from the start or came later; and the picture does
/// not change by it.
#[test]
fn views_are_equal_on_all_backends_and_change_nothing() {
    let plain = Settings {
        debug: None,
        ..with_view(DebugView::Surfels)
    };
    let mut first: Option<Vec<Vec<u8>>> = None;
    // In any order of workgroups, no two of which may write one element.
    let checked = gibs_backend_cpu::Options {
        checked: true,
        ..gibs_backend_cpu::Options::default()
    };
    let mut backends = all_backends();
    backends.push(Box::new(
        gibs_backend_cpu::CpuBackend::new(checked).expect("threads start"),
    ));
    for backend in backends {
        let mut unwatched = renderer(backend.as_ref(), "atrium", &plain);
        let mut watched = renderer(backend.as_ref(), "atrium", &plain);
        for _ in 0..6 {
            unwatched.frame().expect("renders");
            watched.frame().expect("renders");
        }
        let mut shown = Vec::new();
        for &view in DebugView::ALL {
            watched.set_settings(&with_view(view)).expect("adopts");
            watched.frame().expect("renders");
            unwatched.frame().expect("renders");
            let pixels: Vec<DebugPixel> = watched.output("debug").expect("a view");
            assert!(pixels.iter().any(|p| p.value >= 0.0), "{view}: empty");
            shown.push(bytemuck::cast_slice(&pixels).to_vec());
        }
        let colors =
            [&mut watched, &mut unwatched].map(|r| r.output::<Vec4>("color").expect("a picture"));
        assert_eq!(colors[0], colors[1], "{}", backend.name());
        let Some(first) = &first else {
            first = Some(shown);
            continue;
        };
        for ((view, a), b) in DebugView::ALL.iter().zip(first).zip(&shown) {
            assert!(a == b, "{view}: {} has other bits", backend.name());
        }
    }
}

#[test]
fn what_is_switched_off_has_no_view() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let mut settings = with_view(DebugView::Guide);
    settings.guiding = false;
    let new = |s: &Settings| Renderer::new(cpu().as_ref(), &scene, &view, SIZE, s, 0);
    let error = new(&settings).err().expect("refused").to_string();
    assert!(
        error.contains("`guide`") && error.contains("guiding=on"),
        "{error}"
    );
    settings.debug = Some(DebugView::DepthFunction);
    settings.depth = false;
    let error = new(&settings).err().expect("refused").to_string();
    assert!(error.contains("`depth=on`"), "{error}");
    settings.debug = None;
    let mut renderer = new(&settings).expect("prepares");
    renderer.frame().expect("renders");
    let error = renderer.debug_picture().unwrap_err();
    assert!(matches!(error, RenderError::NoDebugView), "{error}");
}

/// Ends and middle of each kind of scale, shades, and what is no value.
#[test]
fn pictures_are_coloured_over_the_range_that_is_named() {
    let image = |view: DebugView, values: &[f32], shade: f32| -> Vec<[u8; 3]> {
        let pixels: Vec<_> = values
            .iter()
            .map(|&value| DebugPixel { value, shade })
            .collect();
        let picture = DebugPicture::new(view, [values.len() as u32, 1], &pixels);
        picture.image().pixels().map(|p| p.0).collect()
    };
    let DebugScale::Heat(most) = DebugView::Radius.scale() else {
        panic!("radii are magnitudes");
    };
    assert_eq!(
        image(DebugView::Radius, &[-1.0, 0.0, most, 2.0 * most], 1.0),
        [OUTSIDE_COLOR, inferno(0.0), inferno(1.0), inferno(1.0)]
    );
    let DebugScale::BlueToRed(most) = DebugView::Coverage.scale() else {
        panic!("coverage has a middle");
    };
    let values = [0.0, 1.0 / most, 1.0, most, 100.0];
    let colors = [0.0, 0.0, 0.5, 1.0, 1.0].map(cool_warm);
    assert_eq!(image(DebugView::Coverage, &values, 1.0), colors);
    let [bright] = image(DebugView::Surfels, &[5.0], 1.0)[..] else {
        panic!("one pixel");
    };
    let [dark] = image(DebugView::Surfels, &[5.0], 0.25)[..] else {
        panic!("one pixel");
    };
    assert!(bright.iter().zip(dark).all(|(b, d)| *b > d));
    let names: std::collections::BTreeSet<_> = (0..50)
        .map(|n| image(DebugView::Surfels, &[n as f32], 1.0)[0])
        .collect();
    assert_eq!(names.len(), 50, "names in a row look different");
}
