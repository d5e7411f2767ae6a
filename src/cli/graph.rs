//! `gibs graph`: the frame's schedule.
use super::CommandError;
use super::output::{print, say, warning};
use super::scene::{SceneArgs, SettingsArgs};
use crate::gi::Gi;
use gibs_passes::frame::Screen;

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
    let schedule = gi.schedule();
    match args.format.as_str() {
        "dot" => print(&schedule.to_dot())?,
        "json" => say!("{}", schedule.to_json().unwrap_or_default()),
        _ => print(&schedule.to_text())?,
    }
    Ok(())
}
