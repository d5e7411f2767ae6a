//! What holes look like: the error where few surfels cover a pixel, beside that where they are enough, on a camera's way
//! through a scene.
//!
//! ```sh
//! cargo run --release --example hole_error -- SCENE.gltf --view VIEW.json --path PATH.json --at 100,344
//! ```
//!
//! At each of the frames that `--at` names a path-traced picture of the same camera is the truth. Pixels are put in order by
//! coverage, the summed weight of their surfels; what lacks of a full one is the average of the grid's cell. For each class the
//! mean irradiance is compared with that of the truth at the same pixels, and each pixel with the mean of the truth over up to 7x7
//! pixels of the same surface, which takes most of the truth's noise away. Nothing is asserted. `docs/performance.md` has figures.
#[path = "shared/scene.rs"]
mod scene;

use clap::Parser;
use gibs::Renderer;
use gibs::backends::{self, Choice};
use gibs::measure::CameraPath;
use gibs::passes::data::SurfacePoint;
use gibs::passes::frame::Settings;
use gibs::passes::shared::{estimator, octahedral, surface};
use gibs::reference::{ReferenceOptions, reference};
use glam::{Vec3, Vec4};
use std::error::Error;
use std::path::PathBuf;

/// Errors of pixels by coverage along a path
#[derive(Parser)]
struct Args {
    /// A .gltf or .glb file, or a built-in scene
    scene: String,
    /// Camera, sun, sky and animation [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    view: Option<PathBuf>,
    /// Key poses of the camera
    #[arg(long, value_name = "P.json")]
    path: PathBuf,
    /// Frames at which to compare
    #[arg(long, value_delimiter = ',', required = true)]
    at: Vec<u32>,
    /// Samples per pixel of the truth
    #[arg(long, default_value_t = 512)]
    spp: u32,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "cpu")]
    backend: Choice,
}

/// Width and height of the pictures, pixels.
const SIZE: [u32; 2] = [480, 270];

/// Classes of pixels by coverage: a name, and where it begins and ends.
const CLASSES: [(&str, f32, f32); 3] = [
    ("below 0.5", 0.0, 0.5),
    ("0.5 to 1", 0.5, 1.0),
    ("1", 1.0, f32::INFINITY),
];

/// Pixels to each side that the truth is averaged over.
const AROUND: i64 = 3;

/// Farthest that those may be, metres, and off the plane.
const NEAR: [f32; 2] = [0.3, 0.02];

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let (scene, mut view) = scene::load(&args.scene, args.view.as_deref())?;
    let backend = backends::open(args.backend)?;
    let backend = backend.as_ref();
    let path = CameraPath::load(&args.path, &view.camera)?;
    let settings = Settings::default();
    let mut renderer = Renderer::new(backend, &scene, &view, SIZE, &settings, 0)?;
    let last = args.at.iter().max().copied().unwrap_or(0);
    println!("frame   coverage    pixels   bias      mean error of a pixel, over the truth's mean");
    for frame in 0..=last {
        renderer.set_camera(path.camera(f64::from(frame)));
        renderer.frame()?;
        if !args.at.contains(&frame) {
            continue;
        }
        let found: Vec<Vec4> = renderer.output("irradiance")?;
        let points: Vec<SurfacePoint> = renderer.output("points")?;
        view.camera = path.camera(f64::from(frame));
        let options = ReferenceOptions {
            size: SIZE,
            samples: args.spp,
            seed: 1,
            emitters: true,
        };
        let (truth, _) = reference(backend, &scene, &view, &options, |_, _| {})?;
        let [r, g, b] = truth.rgb("E")?;
        let truth: Vec<f64> = (0..points.len())
            .map(|i| f64::from(estimator::luminance(Vec3::new(r[i], g[i], b[i]))))
            .collect();
        for (name, from, to) in CLASSES {
            let is_in =
                |i: &usize| surface::is_surface(&points[*i]) && (from..to).contains(&found[*i].w);
            let pixels: Vec<usize> = (0..points.len()).filter(is_in).collect();
            let of = |i: usize| f64::from(estimator::luminance(found[i].truncate()));
            let sum = |value: &dyn Fn(usize) -> f64| pixels.iter().map(|&i| value(i)).sum::<f64>();
            let level = sum(&|i| truth[i]);
            let bias = (sum(&of) / level - 1.0) * 100.0;
            let error = sum(&|i| (of(i) - smooth(&truth, &points, i)).abs()) / level * 100.0;
            let count = pixels.len();
            println!("{frame:5}   {name:9} {count:8}   {bias:+6.1} %  {error:6.1} %");
        }
    }
    Ok(())
}

/// The truth around a pixel, where it is of the same surface.
fn smooth(truth: &[f64], points: &[SurfacePoint], pixel: usize) -> f64 {
    let [width, height] = SIZE.map(i64::from);
    let (x, y) = (pixel as i64 % width, pixel as i64 / width);
    let own = &points[pixel];
    let normal = octahedral::unpack(own.shading_normal);
    let (mut sum, mut count) = (0.0, 0.0);
    for dy in -AROUND..=AROUND {
        for dx in -AROUND..=AROUND {
            let (x, y) = (x + dx, y + dy);
            if !(0..width).contains(&x) || !(0..height).contains(&y) {
                continue;
            }
            let i = (y * width + x) as usize;
            let d = points[i].position - own.position;
            let turned = octahedral::unpack(points[i].shading_normal).dot(normal) < 0.9;
            let is_near = d.length() < NEAR[0] && d.dot(normal).abs() < NEAR[1];
            if surface::is_surface(&points[i]) && !turned && is_near {
                sum += truth[i];
                count += 1.0;
            }
        }
    }
    sum / f64::max(count, 1.0)
}
