//! Stages of one's own in the frame of gibs, from a crate outside its workspace: auto-exposure and a tone curve.
//!
//! ```sh
//! cargo run --release --manifest-path examples/custom_stage/Cargo.toml
//! ```
//!
//! Renders the Cornell box on every backend that opens, and compares. Exits with 1 if the backends disagree, or a
//! device kernel and its twin. `docs/extending.md` tells how it is made.
mod expose;
mod meter;

use gibs::backends;
use gibs::graph::glam::Vec4;
use gibs::graph::{Dispatch, Graph, GraphErrors, Initial, ShaderCompiler, Stage};
use gibs::passes::frame::{Light, Settings, SurfelOutputs};
use gibs::{Renderer, builtin};
use std::error::Error;
use std::process::ExitCode;

const SIZE: [u32; 2] = [96, 96];
const FRAMES: u32 = 16;
/// Largest difference of a pixel between the device's kernel and its twin, on the same input; of values up to 1.
const KERNELS: f32 = 1e-5;
/// Largest mean difference between pictures of two backends. They may differ at all because WGSL fixes no rounding.
const PICTURES: f32 = 2e-3;

/// Records both stages after those of the frame.
fn record(g: &mut Graph, frame: SurfelOutputs) {
    let Light::Traced { color, .. } = frame.light else {
        return; // an engine that brings its own surfaces also makes its own picture
    };
    let batch = &frame.scene.pixels;
    let (state, exposure) = g.state("exposure", 1, Initial::fill(1.0_f32));
    let inputs = meter::Inputs {
        batch,
        color: &color,
        exposure,
    };
    let metered = g.add::<meter::Meter>("apply/meter", inputs, Dispatch::Groups([1, 1, 1]));
    let inputs = expose::Inputs {
        batch,
        color: &color,
        exposure: &metered.exposure,
        shown: g.transient("shown", color.len()),
    };
    let exposed = g.add::<expose::Expose>("apply/expose", inputs, Dispatch::Elements(color.len()));
    g.output("shown", &exposed.shown);
    g.output("exposure", &metered.exposure);
    g.keep(state, metered.exposure);
}

fn check<S: Stage>(shaders: &impl ShaderCompiler) -> Result<(), GraphErrors> {
    let (graph, ports) = ("custom_stage".into(), S::ports());
    let checked = shaders.check(S::NAME, &S::kernel(), &ports, &[]);
    checked.map_err(|errors| GraphErrors { graph, errors })?;
    println!(
        "{}: its device kernel fits its {} ports",
        S::NAME,
        ports.len()
    );
    Ok(())
}

fn differences(a: &[Vec4], b: &[Vec4]) -> impl Iterator<Item = f32> {
    a.iter().zip(b).map(|(a, b)| (a - b).abs().max_element())
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    // Making the renderer checks them, too; this only shows how to do it without a frame.
    let shaders = gibs::shaders::Compiler::new();
    check::<meter::Meter>(&shaders)?;
    check::<expose::Expose>(&shaders)?;

    let (scene, view) = builtin::by_name("cornell").ok_or("no such scene")?;
    let mut first: Option<(String, Vec<Vec4>)> = None;
    let mut agree = true;
    for &choice in backends::BUILT {
        let backend = match backends::open(choice) {
            Ok(backend) => backend,
            Err(error) => {
                println!("not run on {choice}: {error}");
                continue;
            }
        };
        let settings = Settings {
            surfels: 8192,
            rays: 8000,
            ..Settings::default()
        };
        let backend = backend.as_ref();
        let mut renderer = Renderer::extended(backend, &scene, &view, SIZE, &settings, 0, record)?;
        for _ in 0..FRAMES {
            renderer.frame()?;
        }
        let exposure = renderer.output::<f32>("exposure")?[0];
        let color: Vec<Vec4> = renderer.output("color")?;
        let shown: Vec<Vec4> = renderer.output("shown")?;
        let twin: Vec<Vec4> = color.iter().map(|&c| expose::curve(c, exposure)).collect();
        let off = differences(&shown, &twin).fold(0.0, f32::max);
        println!("{choice}: exposure {exposure:.4} after {FRAMES} frames, {off:.1e} off the twin");
        // `max` skips a NaN, so finiteness is a check of its own.
        agree &= off <= KERNELS && exposure.is_finite() && shown.iter().all(|p| p.is_finite());
        if let Some((name, other)) = &first {
            let mean = differences(&shown, other).sum::<f32>() / shown.len() as f32;
            let bits = if shown == *other {
                ", equal to the bit"
            } else {
                ""
            };
            println!("{choice} and {name}: mean difference {mean:.1e}{bits}");
            agree &= mean <= PICTURES;
        } else {
            first = Some((choice.to_string(), shown));
        }
    }
    first.ok_or("no backend opened")?;
    println!("{}", if agree { "agrees" } else { "DIFFERS" });
    Ok(ExitCode::from(u8::from(!agree)))
}
