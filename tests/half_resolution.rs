//! Screen passes at half the width and height: what lies between the pixels that surfels light is right, and nothing
//! reaches over an edge.
mod common;
#[path = "common/wall.rs"]
mod wall;

use common::{all_backends, cpu, settings};
use gibs::graph::{Backend, Executable};
use gibs::passes::data::{Gathered, SurfacePoint, SurfelPose};
use gibs::passes::frame::{Settings, upload};
use gibs::passes::scene::{Camera, Environment, Scene};
use gibs::passes::shared::estimator::luminance;
use gibs::passes::shared::lookup::complete;
use gibs::passes::shared::{batch, octahedral, surface};
use gibs::view::View;
use gibs::{Renderer, builtin};
use glam::{DVec3, Vec3, Vec4};
use wall::{lit, planes, wall_from_above};

fn half(rays: u32) -> Settings {
    Settings {
        half_resolution: true,
        ..settings(rays)
    }
}

fn full(rays: u32) -> Settings {
    Settings {
        half_resolution: false,
        ..settings(rays)
    }
}

fn output<T: bytemuck::Pod>(exec: &mut dyn Executable, name: &str) -> Vec<T> {
    let id = exec.schedule().output(name).expect("an output");
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"))
}

fn state<T: bytemuck::Pod>(exec: &mut dyn Executable, key: &str) -> Vec<T> {
    let id = exec.schedule().resource(key).expect("a state");
    bytemuck::pod_collect_to_vec(&exec.read(id).expect("readable"))
}

fn rendered(
    backend: &dyn Backend,
    (scene, view): &(Scene, View),
    size: [u32; 2],
    frames: u32,
    settings: &Settings,
) -> Renderer {
    let mut renderer = Renderer::new(backend, scene, view, size, settings, 0).expect("a renderer");
    for _ in 0..frames {
        renderer.frame().expect("a frame");
    }
    renderer
}

/// What one set of surfels says at every pixel and at half the width and height.
struct Pair {
    size: [u32; 2],
    points: Vec<SurfacePoint>,
    full: Vec<Vec4>,
    half: Vec<Vec4>,
}

/// The stages that answer queries ask the same surfels in the same frame, at every pixel.
fn pair(scene: &(Scene, View), size: [u32; 2], frames: u32) -> Pair {
    let settings = Settings {
        queries: size[0] * size[1],
        ..half(20_000)
    };
    let mut renderer = rendered(cpu().as_ref(), scene, size, frames, &settings);
    let exec = renderer.executable();
    let points: Vec<SurfacePoint> = output(exec, "points");
    let half: Vec<Vec4> = output(exec, "irradiance");
    upload(exec, "query_points", &points).expect("uploaded");
    let count = batch::args(settings.queries);
    upload(exec, "query_batch", &[count]).expect("uploaded");
    let schedule = exec.schedule().clone();
    let steps = schedule.dispatches().map(|(i, step, _)| (i, step.group()));
    for (step, _) in steps.filter(|(_, group)| *group == "query") {
        exec.run_step(step).expect("runs");
    }
    let gathered: Vec<Gathered> = output(exec, "query_gathered");
    let full = gathered.iter();
    Pair {
        size,
        points,
        half,
        full: full.map(|g| complete(g).extend(g.weight)).collect(),
    }
}

/// Two points lie in one plane of one node, but for two degrees and a centimetre: a wall of the Cornell box is warped by
/// half of that.
fn same_surface(a: &SurfacePoint, b: &SurfacePoint) -> bool {
    let [n, m] = [a, b].map(|p| octahedral::unpack(p.geometric_normal));
    surface::is_surface(a)
        && a.transform_id == b.transform_id
        && n.dot(m) > 0.9994
        && n.dot(b.position - a.position).abs() < 1e-2
}

impl Pair {
    /// Holds every pixel at half resolution within the least and the largest that full resolution has on the same surface
    /// in the 3x3 pixels around it: bilinear weights sum to one, so that a mean of those cannot leave that range but by
    /// rounding, a dozen operations of 2^-24 each. Gives the pixels that were interpolated.
    fn check(&self, name: &str) -> usize {
        let [width, height] = self.size.map(|n| n as i32);
        let mut interpolated = 0;
        for y in 0..height {
            for x in 0..width {
                let i = (y * width + x) as usize;
                let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
                for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                    let (x, y) = (x + dx, y + dy);
                    let j = (y * width + x) as usize;
                    let inside = (0..width).contains(&x) && (0..height).contains(&y);
                    if inside && same_surface(&self.points[i], &self.points[j]) {
                        low = low.min(self.full[j].truncate());
                        high = high.max(self.full[j].truncate());
                    }
                }
                let (got, exact) = (self.half[i].truncate(), self.full[i].truncate());
                if !surface::is_surface(&self.points[i]) {
                    assert_eq!(got, Vec3::ZERO, "{name}: ({x}, {y}) has no surface");
                    continue;
                }
                let slack = 12.0 * 2f32.powi(-24) * high;
                let within = got.cmpge(low - slack).all() && got.cmple(high + slack).all();
                assert!(
                    within,
                    "{name}: ({x}, {y}) is {got}, around it {low} to {high}"
                );
                if x % 2 == 0 && y % 2 == 0 {
                    assert_eq!(got, exact, "{name}: ({x}, {y}) is its own");
                }
                if self.contrasts(x as u32, y as u32) {
                    assert_eq!(got, exact, "{name}: ({x}, {y}) is in a contrast");
                }
                interpolated += usize::from(got != exact);
            }
        }
        interpolated
    }

    /// Light differs by more than a factor of two between the corners of a pixel's block: in no order of rounding less.
    fn contrasts(&self, x: u32, y: u32) -> bool {
        let [width, height] = self.size;
        let corners =
            [(0, 0), (2, 0), (0, 2), (2, 2)].map(|(dx, dy)| (x / 2 * 2 + dx, y / 2 * 2 + dy));
        let inside = corners.iter().filter(|(x, y)| *x < width && *y < height);
        let there = inside.map(|(x, y)| (y * width + x) as usize);
        let seen = there.filter(|&i| surface::is_surface(&self.points[i]));
        let light: Vec<f32> = seen.map(|i| luminance(self.full[i].truncate())).collect();
        let least = light.iter().copied().fold(f32::MAX, f32::min);
        let most = light.iter().copied().fold(0.0, f32::max);
        most > 2.00001 * least
    }

    fn mean(pixels: &[Vec4]) -> f64 {
        let sum: f64 = pixels
            .iter()
            .map(|p| f64::from(p.truncate().element_sum()))
            .sum();
        sum / (3.0 * pixels.len() as f64)
    }
}

/// In a white box each pixel of full resolution has the closed form and noise; the mean at half resolution is that of a
/// quarter of them, up to the rims. The noise of a pixel bounds the difference: n pixels around a surfel share theirs, so
/// that the mean over a quarter of the pixels is off by no more than the standard deviation over the square root of the
/// surfels that are seen, here three of those.
#[test]
fn both_resolutions_have_the_furnaces_closed_form() {
    let albedo = 0.5;
    let pair = pair(&builtin::furnace(albedo, 1.0), [63, 49], 48);
    let interpolated = pair.check("furnace");
    assert!(interpolated > 63 * 49 / 2, "only {interpolated} pixels");
    let (full, half) = (Pair::mean(&pair.full), Pair::mean(&pair.half));
    let squares = pair.full.iter().map(|p| (f64::from(p.x) - full).powi(2));
    let deviation = (squares.sum::<f64>() / pair.full.len() as f64).sqrt();
    let radius = f64::from(settings(0).radius_in(pair.size));
    let surfels = (63.0 * 49.0) / (std::f64::consts::PI * radius * radius);
    let bound = 3.0 * deviation / surfels.sqrt();
    let want = std::f64::consts::PI / (1.0 - f64::from(albedo));
    println!("closed form {want:.4}, full {full:.4}, half {half:.4}, bound {bound:.4}");
    assert!((half - full).abs() <= bound, "{half} and {full}");
    assert!((half / want - 1.0).abs() < 0.03, "{half} for {want}");
}

/// Bright planes in front of a dark one, all facing the camera: a broad one, and bars of one to three pixels, at whatever
/// phase to the pixels with even coordinates. A lamp beside the camera shines from close by on those in front.
fn two_planes() -> (Scene, View) {
    let mut front = vec![[-3.0, -1.5, -0.4, 1.5, 0.0]];
    for bar in 0..8 {
        let x = 0.1 + 0.31 * bar as f32;
        front.push([x, -1.5, x + 0.02 + 0.013 * bar as f32, 1.5, 0.0]);
    }
    let mut lamp = planes(&[[-2.0, -2.0, 2.0, 2.0, 3.5]], 1);
    lamp.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let meshes = vec![
        planes(&front, 0),
        planes(&[[-20.0, -20.0, 20.0, 20.0, -8.0]], 0),
        lamp,
    ];
    // In one node, so that only their places tell them apart.
    let scene = lit(meshes, 1.0);
    let mut view = builtin::furnace(0.5, 1.0).1;
    view.camera = Camera {
        position: DVec3::new(0.0, 0.0, 3.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        vfov: 1.0,
    };
    view.environment = Environment::Constant(Vec3::ZERO);
    (scene, view)
}

/// What is on a bright plane takes nothing from the dark one behind, and the reverse: see [`Pair::check`].
#[test]
fn nothing_reaches_over_an_edge() {
    let pair = pair(&two_planes(), [97, 64], 48);
    let interpolated = pair.check("two planes");
    assert!(interpolated > 1000, "only {interpolated} pixels");
    let mean = |z: f32| {
        let seen = pair.points.iter().zip(&pair.full);
        let on = seen.filter(|(p, _)| surface::is_surface(p) && (p.position.z - z).abs() < 0.1);
        let (count, sum) = on.fold((0.0, 0.0), |(n, sum), (_, e)| (n + 1.0, sum + e.x));
        assert!(count > 500.0, "{count} pixels at {z}");
        sum / count
    };
    let (bright, dark) = (mean(0.0), mean(-8.0));
    println!("bright {bright:.3}, dark {dark:.3} W/m^2");
    assert!(
        bright > 5.0 * dark,
        "{bright} and {dark}: nothing would show"
    );
}

/// In the first frame as well, and at every pixel on either side of it.
#[test]
fn pixels_between_light_and_dark_are_lit_by_themselves_at_once() {
    let pair = pair(&wall_from_above(1.0), [121, 67], 1);
    let interpolated = pair.check("wall");
    let pixels = (0..67).flat_map(|y| (0..121).map(move |x| (x, y)));
    let contrasts = pixels.filter(|&(x, y)| pair.contrasts(x, y)).count();
    println!("{contrasts} in contrasts, {interpolated} interpolated");
    assert!(
        contrasts > 100 && interpolated > 1000,
        "{contrasts}, {interpolated}"
    );
}

/// Both sides of such a wall look like one floor. What is gathered on its bright side stays there, as if every pixel were
/// lit by itself. The bound is that of sealed rooms, 0.1 % in the dark; with interpolation alone there is 0.25 %.
#[test]
fn nothing_reaches_over_a_wall_that_is_not_seen() {
    let scene = wall_from_above(1.0);
    let [half, full] = [half(25_000), full(25_000)].map(|settings| {
        let mut renderer = rendered(cpu().as_ref(), &scene, [240, 134], 32, &settings);
        wall::leaked(&mut renderer, 0.5)
    });
    println!(
        "in the dark {:.4} % of the light, {:.4} % at full resolution",
        half * 100.0,
        full * 100.0
    );
    assert!(half <= 0.001, "{half}, {full} at full resolution");
}

/// Corners, contact shadows, a lamp half a centimetre below its ceiling.
#[test]
fn nothing_reaches_over_the_edges_of_a_room() {
    let (scene, view) = builtin::by_name("cornell").expect("built in");
    let interpolated = pair(&(scene, view), [96, 96], 48).check("cornell");
    assert!(interpolated > 2000, "only {interpolated} pixels");
}

/// Pictures without pixels between others, without a middle, without a second row: each pixel is there, and the
/// backends agree to the bit.
#[test]
fn every_size_has_all_of_its_pixels() {
    let scene = builtin::by_name("cornell").expect("built in");
    for size in [
        [1, 1],
        [2, 1],
        [1, 2],
        [2, 2],
        [3, 3],
        [65, 1],
        [1, 34],
        [33, 31],
    ] {
        let frames = 12;
        let mut expected = rendered(cpu().as_ref(), &scene, size, frames, &half(2_000));
        let exec = expected.executable();
        let (irradiance, points): (Vec<Vec4>, Vec<SurfacePoint>) =
            (output(exec, "irradiance"), output(exec, "points"));
        let poses: Vec<SurfelPose> = state(exec, "surfel_poses");
        for (e, point) in irradiance.iter().zip(&points) {
            let seen = surface::is_surface(point);
            assert!(e.is_finite() && (seen || *e == Vec4::ZERO), "{size:?}: {e}");
        }
        if size == [1, 1] {
            let mut full = rendered(cpu().as_ref(), &scene, size, frames, &full(2_000));
            let full: Vec<Vec4> = output(full.executable(), "irradiance");
            assert_eq!(irradiance, full, "one pixel is at full resolution");
        }
        for backend in all_backends() {
            let mut got = rendered(backend.as_ref(), &scene, size, frames, &half(2_000));
            let exec = got.executable();
            let same = output::<Vec4>(exec, "irradiance") == irradiance;
            assert!(same, "{}, {size:?}: pixels differ", backend.name());
            let same = state::<SurfelPose>(exec, "surfel_poses") == poses;
            assert!(same, "{}, {size:?}: surfels differ", backend.name());
        }
    }
}

/// Surfels are born as densely and as large as at full resolution, and none that is in sight counts as unseen: the
/// pixels of a texel take turns of four frames, so that a surfel may go three frames without being looked at.
#[test]
fn surfels_are_as_many_as_at_full_resolution_and_stay_seen() {
    let scene = builtin::by_name("cornell").expect("built in");
    let (size, frames) = ([96, 96], 64);
    let surfels = |settings: Settings| {
        let mut renderer = rendered(cpu().as_ref(), &scene, size, frames, &settings);
        let exec = renderer.executable();
        let unseen: Vec<u32> = state(exec, "surfel_unseen");
        let poses: Vec<SurfelPose> = state(exec, "surfel_poses");
        let live = poses.iter().zip(&unseen).filter(|(p, _)| p.radius > 0.0);
        let (mut count, mut hidden, mut radius) = (0, 0, 0.0);
        for (pose, &unseen) in live {
            count += 1;
            hidden += u32::from(unseen > 3);
            radius += f64::from(pose.radius);
        }
        (count, hidden, radius / f64::from(count))
    };
    let (many, hidden, wide) = surfels(half(10_000));
    let (full_many, full_hidden, full_wide) = surfels(full(10_000));
    println!(
        "half {many} surfels of {wide:.4} m, {hidden} unseen; full {full_many} of {full_wide:.4} m, {full_hidden}"
    );
    let ratio = f64::from(many) / f64::from(full_many);
    assert!((ratio - 1.0).abs() < 0.05, "{many} and {full_many} surfels");
    assert!(
        (wide / full_wide - 1.0).abs() < 0.05,
        "{wide} and {full_wide} m"
    );
    assert!(
        hidden <= full_hidden + many / 100,
        "{hidden} and {full_hidden} unseen"
    );
}
