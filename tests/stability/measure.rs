//! Drawing, and what is measured of pictures.
use super::build::{self, LAMP, LAMP_INTENSITY};
use super::common::{self, cpu};
use gibs::Renderer;
use gibs::graph::Backend;
use gibs::passes::frame::Settings;
use gibs::passes::scene::Scene;
use gibs::picture::Picture;
use gibs::view::View;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock};

/// Unit roundoff of `f32`.
pub const U: f64 = 1.0 / 16_777_216.0;

/// Size of pictures and frames before them in cases that compare one room with another: little enough for a software driver.
pub const SIZE: [u32; 2] = [48, 27];
pub const FRAMES: u32 = 32;

pub fn settings() -> Settings {
    Settings {
        surfels: 4096,
        rays: 4096,
        ..Settings::default()
    }
}

/// A picture after some frames, of which every value of every channel is finite.
pub fn draw(
    backend: &dyn Backend,
    scene: &(Scene, View),
    size: [u32; 2],
    frames: u32,
    settings: &Settings,
    seed: u32,
) -> Picture {
    let picture = common::render(backend, scene, size, frames, settings, seed);
    assert_finite(&picture, backend.name());
    picture
}

/// The room of `build` at its usual size, as this backend draws it: once for all cases that compare others with it.
pub fn room(backend: &dyn Backend) -> Arc<Picture> {
    static DRAWN: Mutex<BTreeMap<String, Arc<Picture>>> = Mutex::new(BTreeMap::new());
    let mut drawn = DRAWN.lock().expect("no case has failed while it drew this");
    let picture = drawn
        .entry(backend.name().to_owned())
        .or_insert_with(|| Arc::new(draw(backend, &build::room(), SIZE, FRAMES, &settings(), 0)));
    Arc::clone(picture)
}

pub fn assert_finite(picture: &Picture, what: &str) {
    for (name, values) in &picture.channels {
        let bad = values.iter().position(|x| !x.is_finite());
        assert_eq!(bad, None, "{what}: {name} is not finite at this pixel");
    }
}

/// Draws further frames; the picture after them, all finite.
pub fn go_on(renderer: &mut Renderer, frames: u32, what: &str) -> Picture {
    for _ in 0..frames {
        renderer.frame().unwrap_or_else(|e| panic!("{what}: {e}"));
    }
    let picture = renderer.picture().unwrap_or_else(|e| panic!("{what}: {e}"));
    assert_finite(&picture, what);
    picture
}

/// Mean of the three channels of a layer at each pixel.
pub fn levels(picture: &Picture, layer: &str) -> Vec<f64> {
    let [r, g, b] = picture.rgb(layer).expect("the layer");
    let mean = |i: usize| (f64::from(r[i]) + f64::from(g[i]) + f64::from(b[i])) / 3.0;
    (0..r.len()).map(mean).collect()
}

/// Position of each pixel's surface; `None` where there is none.
pub fn positions(picture: &Picture) -> Vec<Option<glam::DVec3>> {
    let [x, y, z] = picture.xyz("position").expect("positions");
    let mask = picture.scalar("mask.A").expect("a mask");
    let at = |i: usize| glam::DVec3::new(x[i].into(), y[i].into(), z[i].into());
    (0..x.len())
        .map(|i| (mask[i] > 0.0).then(|| at(i)))
        .collect()
}

/// Every value of a layer, bit by bit.
pub fn bits(picture: &Picture, layer: &str) -> Vec<u32> {
    let planes = picture.rgb(layer).expect("the layer");
    planes.concat().iter().map(|x| x.to_bits()).collect()
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Standard deviation, as of a sample.
pub fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    (squares / (values.len() as f64 - 1.0)).sqrt()
}

/// Mean magnitude of the difference between two pictures' E, over the mean of the first.
pub fn difference(a: &Picture, b: &Picture) -> f64 {
    let (a, b) = (levels(a, "E"), levels(b, "E"));
    let apart: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).collect();
    mean(&apart) / mean(&a)
}

/// Differences of E at each pixel, over the mean of the first.
pub fn relative(a: &Picture, b: &Picture) -> Vec<f64> {
    let (a, b) = (levels(a, "E"), levels(b, "E"));
    let level = mean(&a);
    a.iter()
        .zip(&b)
        .map(|(a, b)| (b - a).abs() / level)
        .collect()
}

/// What chance does to a scene's E, from eight seeds on the processor: the relative standard deviation of the mean over all
/// pixels, and the mean of [`difference`] between one seed and the next.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    pub of_mean: f64,
    pub of_pixels: f64,
}

impl Noise {
    pub fn of(scene: &(Scene, View), size: [u32; 2], frames: u32, settings: &Settings) -> Self {
        let backend = cpu();
        let seed = |seed: u32| draw(backend.as_ref(), scene, size, frames, settings, 100 + seed);
        let drawn: Vec<Picture> = (0..8).map(seed).collect();
        let means: Vec<f64> = drawn.iter().map(|p| mean(&levels(p, "E"))).collect();
        let apart: Vec<f64> = drawn.windows(2).map(|p| difference(&p[0], &p[1])).collect();
        Self {
            of_mean: deviation(&means) / mean(&means),
            of_pixels: mean(&apart),
        }
    }

    /// Of the room of `build`, as it is drawn everywhere.
    pub fn of_room() -> Self {
        static NOISE: OnceLock<Noise> = OnceLock::new();
        *NOISE.get_or_init(|| Self::of(&build::room(), SIZE, FRAMES, &settings()))
    }

    /// Largest relative difference of two means of E that are the same but for chance: five standard deviations of a
    /// difference.
    pub fn most(&self) -> f64 {
        5.0 * 2f64.sqrt() * self.of_mean
    }
}

/// Most angle between a normal and what 16 bits of its octahedral square hold: half a step is `h = 1 / 65535` on each axis, the
/// map moves a point by at most `sqrt(6) h`, and the point is at least `1 / sqrt(3)` from the middle.
pub const PACKED: f64 = 4.2427 / 65_535.0;

/// Holds direct light in two pictures of the room, at `scale`, against where its light and its surfaces are: of numbers up to
/// `reach` metres, 16 roundings in either picture make a place uncertain by `d = 2 * 16 U * reach`. The gradient of
/// `I cos / r^2` is at most `4 I / r^3`, the light itself moves as much, and `turned` is how far normals differ:
/// `|dE| <= I (8 d / r + turned) / r^2 + 4 U E`.
pub fn assert_same_direct(one: &Picture, other: &Picture, reach: f64, turned: f64, what: &str) {
    let place = 2.0 * 16.0 * U * reach;
    let (a, b) = (levels(one, "direct"), levels(other, "direct"));
    let mut worst = 0f64;
    for (i, p) in positions(one).into_iter().enumerate() {
        let Some(p) = p else { continue };
        let r = (p - LAMP).length();
        let bound = LAMP_INTENSITY * (8.0 * place / r + turned) / (r * r) + 4.0 * U * a[i];
        let share = (b[i] - a[i]).abs() / bound;
        assert!(
            share <= 1.0,
            "{what}: direct light at {p}: {share} of the bound"
        );
        worst = worst.max(share);
    }
    println!("{what}: direct light at most {worst:.3} of its bound");
}

/// Holds two pictures of the same light against chance: means within [`Noise::most`], and pixels no farther apart than those of
/// two seeds, but for a quarter. Rounding may decide otherwise where a surfel is born, and all that follows is another draw.
pub fn assert_same_light(a: &Picture, b: &Picture, noise: &Noise, what: &str) {
    let (one, other) = (mean(&levels(a, "E")), mean(&levels(b, "E")));
    let (of_mean, of_pixels) = (other / one - 1.0, difference(a, b));
    println!(
        "{what}: mean of E {:+.3} % (bound {:.3} %), pixels {:.3} % (two seeds {:.3} %)",
        of_mean * 100.0,
        noise.most() * 100.0,
        of_pixels * 100.0,
        noise.of_pixels * 100.0
    );
    assert!(of_mean.abs() <= noise.most(), "{what}: {of_mean}");
    assert!(of_pixels <= 1.25 * noise.of_pixels, "{what}: {of_pixels}");
}
