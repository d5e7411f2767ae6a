//! `gibs graph`: the frame's schedule.
use super::CommandError;
use super::output::{print, say, warning};
use super::scene::{SceneArgs, SettingsArgs};
use crate::renderer::{device_scene, schedule};

/// Show the stages that a scene's frame consists of
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    settings: SettingsArgs,
    /// dot, json or text
    #[arg(long, default_value = "text", value_parser = ["dot", "json", "text"])]
    format: String,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let settings = args.settings.load()?;
    let loaded = args.scene.load()?;
    let scene = device_scene(&loaded.scene, &loaded.view)?;
    for warning in &scene.warnings {
        warning!("{warning}");
    }
    let schedule = schedule(&scene, &loaded.view, loaded.size, &settings)?;
    match args.format.as_str() {
        "dot" => print(&schedule.to_dot())?,
        "json" => say!("{}", schedule.to_json().unwrap_or_default()),
        _ => print(&schedule.to_text())?,
    }
    Ok(())
}
