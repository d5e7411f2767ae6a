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

fn line([name, default, unit, range, about]: [&str; 5]) -> String {
    format!("{name:<17} {default:>9} {unit:<13} {range:<18} {about}")
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
        let (default, range) = match s.is_switch {
            true if s.default == 0.0 => ("off".into(), "off or on".into()),
            true => ("on".into(), "off or on".into()),
            false => (
                (s.default as f32).to_string(),
                format!("{} .. {}", s.least as f32, s.most as f32),
            ),
        };
        say!("{}", line([s.name, &default, s.unit, &range, s.about]));
    }
    let about = "a picture of what the technique does; `gibs render --help` lists the views";
    say!("{}", line(["debug", "off", "", "off or a name", about]));
    say!(
        "\nA settings file (TOML) has the same keys, each on a line of its own; names are in quotes there: debug = \"coverage\"."
    );
    Ok(())
}
