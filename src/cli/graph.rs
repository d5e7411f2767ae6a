//! `gibs graph`: the frame's schedule.
use super::CommandError;
use super::output::{print, progress, say, warning};
use super::run::warn_of_no_light;
use super::scene::{SceneArgs, SettingsArgs};
use crate::backends::{self, Choice};
use crate::conditions::{Renders, Subject};
use crate::gi::Gi;
use crate::profile::{Saving, saving_table, savings};
use gibs_passes::frame::Screen;
use serde::Serialize;

/// Show the stages that a scene's frame consists of
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// dot, json or text; with --why json or text
    #[arg(long, default_value = "text", value_parser = ["dot", "json", "text"])]
    format: String,
    /// Say what the scene and the settings need, and what that adds or saves, as text or json
    #[arg(long)]
    why: bool,
    /// With --why: also measure the time that is saved by what is left out, over so many frames
    #[arg(long, value_name = "FRAMES", requires = "why", value_parser = clap::value_parser!(u32).range(1..=65_536))]
    measure: Option<u32>,
    /// Where to measure: auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto", requires = "measure")]
    backend: Choice,
}

/// What a frame needs, as JSON.
#[derive(Serialize)]
struct Needs<'a> {
    #[serde(flatten)]
    subject: Subject,
    /// Where time was measured, if it was.
    #[serde(skip_serializing_if = "Option::is_none")]
    measured: Option<Measured>,
    needs: &'a [Saving],
}

/// Where the time was measured of what is left out.
#[derive(Serialize)]
struct Measured {
    #[serde(flatten)]
    renders: Renders,
    /// Pairs of frames, after as many that were not measured.
    frames: u32,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    if args.why && args.format == "dot" {
        return Err(CommandError::Value {
            option: "--format",
            value: "dot".into(),
            want: "--why has text and json".into(),
        });
    }
    let settings = args.settings.load()?;
    let loaded = args.scene.load()?;
    let gi = Gi::new(
        &loaded.scene,
        &loaded.view,
        loaded.size,
        &settings,
        Screen::Traced,
    )?;
    for warning in &gi.scene().warnings {
        warning!("{warning}");
    }
    warn_of_no_light(&settings);
    if args.why {
        let backend = args.measure.map(|_| backends::open(args.backend));
        let backend = backend.transpose()?;
        let bar = progress(0, "measuring");
        let on = backend.as_deref().zip(args.measure);
        let savings = savings(&gi, &loaded.view, on, |done, of| {
            bar.set_length(of.into());
            bar.set_position(done.into());
        });
        bar.finish_and_clear();
        let savings = savings?;
        match args.format.as_str() {
            "json" => {
                let measured = on.map(|(backend, frames)| Measured {
                    renders: Renders::with(backend),
                    frames,
                });
                let scene = &args.scene.scene;
                let needs = Needs {
                    subject: Subject::new(scene, &loaded.view, loaded.size, &settings),
                    measured,
                    needs: &savings,
                };
                say!(
                    "{}",
                    serde_json::to_string_pretty(&needs).unwrap_or_default()
                );
            }
            _ => print(&saving_table(&savings, true))?,
        }
        return Ok(());
    }
    let schedule = gi.schedule();
    match args.format.as_str() {
        "dot" => print(&schedule.to_dot())?,
        "json" => say!("{}", schedule.to_json().unwrap_or_default()),
        _ => print(&schedule.to_text())?,
    }
    Ok(())
}
