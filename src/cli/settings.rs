//! `gibs settings`: every setting.
use super::CommandError;
use super::output::say;
use gibs_passes::frame::Settings;

/// List every setting with its unit, default and range
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let all = Settings::all();
    if args.json {
        say!("{}", serde_json::to_string_pretty(&all).unwrap_or_default());
        return Ok(());
    }
    for s in all {
        // Settings are f32; as such they print as they were written.
        let range = format!("{} .. {}", s.least as f32, s.most as f32);
        say!(
            "{:<14} {:>9} {:<12} {:<18} {}",
            s.name,
            s.default as f32,
            s.unit,
            range,
            s.about
        );
    }
    say!(
        "{:<14} {:>9} {:<12} {:<18} a picture of what the technique does; `gibs render --help` lists the views",
        "debug",
        "off",
        "",
        "off or a name"
    );
    Ok(())
}
