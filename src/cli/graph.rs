//! `gibs graph`: the frame's schedule.
use super::CommandError;
use super::output::{print, say, warning};
use super::scene::{SceneArgs, SettingsArgs};
use crate::gi::Gi;
use gibs_passes::frame::{Need, Screen};
use std::fmt::Write;

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
    /// Say what the scene and the settings need, and what that adds or saves
    #[arg(long, conflicts_with = "format")]
    why: bool,
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
    if args.why {
        return print(&why(&gi.needs()?));
    }
    let schedule = gi.schedule();
    match args.format.as_str() {
        "dot" => print(&schedule.to_dot())?,
        "json" => say!("{}", schedule.to_json().unwrap_or_default()),
        _ => print(&schedule.to_text())?,
    }
    Ok(())
}

/// Needs as text, those that are there first.
fn why(needs: &[Need]) -> String {
    let mut text = String::new();
    for (present, title) in [(true, "needed"), (false, "left out")] {
        for need in needs.iter().filter(|need| need.present == present) {
            let megabytes = need.bytes as f64 / 1e6;
            let count = need.stages.len();
            let _ = writeln!(
                text,
                "{title}: {}, because of {}\n  {count} stages, {} bindings of others, {megabytes:.1} MB",
                need.name,
                need.reason,
                need.bindings.len()
            );
            for stage in &need.stages {
                let _ = writeln!(text, "    {stage}");
            }
            for binding in &need.bindings {
                let _ = writeln!(text, "    {binding} (binding)");
            }
        }
    }
    text
}
