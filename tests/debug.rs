//! Debug views: the same on all backends, and what they say against what the surfels' own buffers hold.
mod common;

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

/// Up to 1, where the channel of the picture ends, coverage is the weight that apply found, to the bit.
#[test]
fn coverage_is_the_weight_of_apply() {
    let mut renderer = rendered(DebugView::Coverage, 5);
    let irradiance: Vec<Vec4> = renderer.output("irradiance").expect("an output");
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let values = values(&mut renderer);
    for ((value, e), point) in values.iter().zip(&irradiance).zip(&points) {
        let expected = if surface::is_surface(point) {
            e.w
        } else {
            -1.0
        };
        assert_eq!(value.min(1.0), expected);
    }
    assert!(values.iter().any(|v| *v > 1.0) && values.iter().any(|v| (0.0..1.0).contains(v)));
    let picture = renderer.picture().expect("a picture");
    assert_eq!(picture.scalar("debug.coverage").expect("a channel"), values);
}

#[test]
fn transform_ids_are_those_of_the_surfaces() {
    let mut renderer = rendered(DebugView::TransformId, 1);
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    for (value, point) in values(&mut renderer).iter().zip(&points) {
        match surface::is_surface(point) {
            true => assert_eq!(*value, point.transform_id as f32),
            false => assert_eq!(*value, -1.0),
        }
    }
}

#[test]
fn cell_heat_is_the_length_of_the_cells_list() {
    let mut renderer = rendered(DebugView::CellHeat, 5);
    let shape: GridShape = buffer(&mut renderer, "grid")[0];
    let cells: Vec<UVec2> = buffer(&mut renderer, "injected_cells");
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let values = values(&mut renderer);
    for (value, point) in values.iter().zip(&points) {
        if surface::is_surface(point) {
            let cell = grid::cell(point.position, &shape);
            assert_eq!(*value, cells[cell as usize].y as f32);
        }
    }
    assert!(values.iter().any(|v| *v > 1.0));
}

/// The part is the half-axis of the largest coordinate of the offset from the grid's centre, or the cube; and there is a
/// line exactly where the cell to the right or below is another one.
#[test]
fn parts_of_the_grid_follow_from_the_offset() {
    let mut settings = with_view(DebugView::Grid);
    settings.grid_half = 0.2;
    let mut renderer = renderer(cpu().as_ref(), "atrium", &settings);
    renderer.frame().expect("renders");
    let shape: GridShape = buffer(&mut renderer, "grid")[0];
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let pixels: Vec<DebugPixel> = renderer.output("debug").expect("a view");
    let mut met = [0; 7];
    for (pixel, point) in pixels.iter().zip(&points) {
        if !surface::is_surface(point) {
            assert_eq!(pixel.value, -1.0);
            continue;
        }
        let d = (point.position - shape.centre).to_array();
        let axis = (0..3).fold(0, |m, i| if d[i].abs() > d[m].abs() { i } else { m });
        let part = match d[axis].abs() < shape.half {
            true => 0,
            false => 1 + 2 * axis + usize::from(d[axis] < 0.0),
        };
        assert_eq!(pixel.value, part as f32);
        met[part] += 1;
    }
    assert!(
        met[0] > 100 && met.iter().filter(|n| **n > 100).count() > 2,
        "{met:?}"
    );
    // Shades without lines are at least what a headlight leaves, lines at most their own brightness.
    let width = SIZE[0] as usize;
    let cell = |i: usize| {
        let point = points.get(i).filter(|p| surface::is_surface(p))?;
        Some(grid::cell(point.position, &shape))
    };
    let mut lines = 0;
    for (i, pixel) in pixels.iter().enumerate() {
        let Some(own) = cell(i) else { continue };
        let right = (i % width + 1 < width).then(|| cell(i + 1)).flatten();
        let below = cell(i + width);
        let line = right.is_some_and(|c| c != own) || below.is_some_and(|c| c != own);
        assert_eq!(line, pixel.shade < 0.38, "pixel {i} has {}", pixel.shade);
        lines += usize::from(line);
    }
    assert!(lines > 100);
}

/// Each pixel shows, of all surfels that were there before the frame's births and that overlap its point, the one with
/// the nearest centre. Looked for among all of them, without the grid.
#[test]
fn discs_are_those_of_the_nearest_surfels() {
    let mut renderer = rendered(DebugView::Surfels, 5);
    let poses: Vec<SurfelPose> = buffer(&mut renderer, "surfel_poses");
    let shown: Vec<f32> = buffer(&mut renderer, "debug_surfels");
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let mut met = 0;
    for (value, point) in values(&mut renderer).iter().zip(&points) {
        if !surface::is_surface(point) {
            continue;
        }
        let normal = octahedral::unpack(point.shading_normal);
        let overlapping = (0..poses.len()).filter(|&i| {
            let pose = &poses[i];
            let d = point.position - pose.position;
            shown[i] >= 0.0
                && d.length() <= pose.radius
                && lookup::falloff(d, pose) * lookup::alignment(normal, pose) > 0.0
        });
        let distance = |i: usize| (point.position - poses[i].position).length_squared();
        let nearest = overlapping.min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        match nearest {
            None => assert_eq!(*value, -1.0),
            Some(i) => {
                assert_eq!(distance(*value as usize), distance(i));
                met += 1;
            }
        }
    }
    assert!(met > 2000, "{met} pixels show a surfel");
}

/// Shares of all surfels sum to the budget, which the frame spends to the ray; each pixel shows a mean of some of them.
#[test]
fn ray_counts_sum_to_the_budget() {
    for budget in [0, 7, 20_000] {
        let mut settings = with_view(DebugView::RayCount);
        settings.rays = budget;
        let mut renderer = renderer(cpu().as_ref(), "atrium", &settings);
        for _ in 0..4 {
            renderer.frame().expect("renders");
        }
        let spent: DispatchArgs = buffer(&mut renderer, "ray_batch")[0];
        let counts: Vec<f32> = renderer.output("debug_surfels").expect("an output");
        let sum: f32 = counts.iter().filter(|n| **n > 0.0).sum();
        assert_eq!((sum, spent.count), (budget as f32, budget));
        let most = counts.iter().copied().fold(0.0, f32::max);
        let values = values(&mut renderer);
        // A weighted mean of numbers up to `most`, rounded once per surfel: 1e-4 is a thousand roundings.
        assert!(values.iter().all(|v| (-1.0..=most * 1.0001).contains(v)));
    }
}

/// Of a surfel that the grid does not limit, the radius is the wanted one; no radius is above it.
#[test]
fn radii_are_at_most_the_wanted_one() {
    let mut renderer = rendered(DebugView::Radius, 5);
    let wanted = with_view(DebugView::Radius).radius_in(SIZE);
    let values: Vec<f32> = values(&mut renderer)
        .into_iter()
        .filter(|v| *v >= 0.0)
        .collect();
    // The same product and quotient in two orders: a few roundings.
    let is_wanted = |v: f32| (v / wanted - 1.0).abs() < 1e-5;
    assert!(
        values
            .iter()
            .all(|&v| v > 0.0 && (v < wanted || is_wanted(v)))
    );
    assert!(values.iter().filter(|v| is_wanted(**v)).count() > values.len() / 2);
}

#[test]
fn variances_are_those_of_the_estimator() {
    let slots = slots(6);
    let mut renderer = rendered(DebugView::Variance, 6);
    let states: Vec<SurfelIrradiance> = buffer(&mut renderer, "surfel_irradiance");
    let luminance = |c: Vec3| c.as_dvec3().dot(glam::DVec3::new(0.2126, 0.7152, 0.0722));
    let mut met = 0;
    for (value, slot) in values(&mut renderer).into_iter().zip(slots) {
        if value < 0.0 || states[slot as usize].samples == 0 {
            continue;
        }
        let state = &states[slot as usize];
        let level = luminance(state.mean).max(luminance(state.short_mean));
        let expected = match level > 0.0 {
            true => (f64::from(state.variance) / 4.0).sqrt() / level,
            false => 0.0,
        };
        // Half a dozen roundings to 24 bits.
        assert!(
            (f64::from(value) - expected).abs() <= 1e-6 * expected,
            "{value} for {expected}"
        );
        met += 1;
    }
    assert!(met > 2000, "{met}");
}

/// No surfel is older than the first frame; those of this frame are of age 0.
#[test]
fn surfels_age_by_a_frame_at_a_time() {
    for frames in [2, 9] {
        let values = values(&mut rendered(DebugView::Life, frames));
        let oldest = values.iter().copied().fold(0.0, f32::max);
        assert_eq!(oldest, frames as f32 - 1.0);
        assert!(values.iter().all(|v| *v == -1.0 || *v >= 0.0));
    }
}

/// The camera looks away for five frames: what it sees again has not been seen for six, this one included.
#[test]
fn frames_unseen_are_counted_until_seen_again() {
    let mut renderer = renderer(cpu().as_ref(), "cornell", &with_view(DebugView::Unseen));
    let (_, view) = builtin::by_name("cornell").expect("built in");
    for _ in 0..8 {
        renderer.frame().expect("renders");
    }
    assert!(values(&mut renderer).contains(&1.0));
    let mut away = view.camera;
    away.target = 2.0 * away.position - away.target;
    renderer.set_camera(away);
    for _ in 0..5 {
        renderer.frame().expect("renders");
    }
    renderer.set_camera(view.camera);
    renderer.frame().expect("renders");
    let values = values(&mut renderer);
    let shown = values.iter().filter(|v| **v >= 0.0).count();
    let six = values.iter().filter(|v| **v == 6.0).count();
    assert!(shown > 1000 && six * 10 > shown * 9, "{six} of {shown}");
}

/// What is drawn is the mean distance that a lookup at the pixel compares with, and some of it is nearer than the
/// diameter.
#[test]
fn depth_functions_are_looked_up_towards_the_pixel() {
    let slots = slots(12);
    let mut renderer = rendered(DebugView::DepthFunction, 12);
    let poses: Vec<SurfelPose> = buffer(&mut renderer, "surfel_poses");
    let depths: Vec<u32> = buffer(&mut renderer, "surfel_depths");
    let depths = Depths::new(&depths, Settings::default().depth_side);
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let states: Vec<SurfelIrradiance> = buffer(&mut renderer, "surfel_irradiance");
    let mut nearer = 0;
    for ((value, slot), point) in values(&mut renderer).into_iter().zip(slots).zip(&points) {
        // Where the nearest one has no ray yet, another one is drawn.
        if value < 0.0 || states[slot as usize].samples == 0 {
            continue;
        }
        let pose = &poses[slot as usize];
        let d = point.position - pose.position;
        let toward = match d.length() < 0.02 * pose.radius {
            true => pose.normal,
            false => d.normalize(),
        };
        let local = sampling::to_local(toward, pose.normal).max(Vec3::new(-1.0, -1.0, 0.0));
        let expected = depth::depth_moments(depths.get(slot as usize).expect("there"), local).x;
        assert!((value - expected).abs() < 1e-5, "{value} for {expected}");
        nearer += usize::from(value < 0.7);
    }
    assert!(nearer > 50, "{nearer}");
}

/// A pixel shows a texel of its surfel's guide, over the brightest one; at a centre, one of the four in the middle.
#[test]
fn guides_are_drawn_on_discs() {
    let slots = slots(12);
    let mut renderer = rendered(DebugView::Guide, 12);
    let poses: Vec<SurfelPose> = buffer(&mut renderer, "surfel_poses");
    let guides: Vec<u32> = buffer(&mut renderer, "surfel_guides");
    let guides = Guides::new(&guides, Settings::default().guide_side);
    let points: Vec<SurfacePoint> = renderer.output("points").expect("an output");
    let states: Vec<SurfelIrradiance> = buffer(&mut renderer, "surfel_irradiance");
    let (mut met, mut bright) = (0, 0);
    for ((value, slot), point) in values(&mut renderer).into_iter().zip(slots).zip(&points) {
        if value < 0.0 || states[slot as usize].samples == 0 {
            continue;
        }
        let pose = &poses[slot as usize];
        let guide = guides.get(slot as usize).expect("there");
        let has = |i: u32| guide.texel(i) as f32 / 255.0 == value;
        assert!(
            (0..guide.texels()).any(has),
            "{value} is no texel of surfel {slot}"
        );
        if (point.position - pose.position).length() < 0.1 * pose.radius {
            assert!(
                [14, 15, 20, 21].into_iter().any(has),
                "{value} in the middle"
            );
            met += 1;
        }
        bright += usize::from(value == 1.0);
    }
    assert!(met > 20 && bright > 20, "{met}, {bright}");
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
