//! `gibs guiding`: probes under environment maps, over the cosine lobe and guided.
use super::CommandError;
use super::output::{prepare_folder, say, warning};
use crate::backends::{self, Choice};
use crate::guiding::{self, Options, Row};
use crate::picture::replace_file;
use crate::view::load_environment;
use gibs_passes::frame::{SettingError, Settings};
use gibs_passes::scene::EnvironmentMap;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Measure ray guiding under environment maps: error of irradiance probes against the number of rays
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Radiance .hdr or OpenEXR maps, or built-in environments: windows, sun, overcast
    #[arg(value_name = "ENV", required = true)]
    environments: Vec<String>,
    /// auto, cpu, wgpu or vulkan
    #[arg(long, default_value = "auto")]
    backend: Choice,
    /// Probes, with normals spread over the sphere
    #[arg(long, value_name = "N", default_value_t = Options::default().probes, value_parser = clap::value_parser!(u32).range(1..=64))]
    probes: u32,
    /// Repetitions with other random numbers
    #[arg(long, value_name = "N", default_value_t = Options::default().seeds, value_parser = clap::value_parser!(u32).range(2..=64))]
    seeds: u32,
    /// Probes at one place, which learn from each other
    #[arg(long, value_name = "N", default_value_t = Options::default().per_place, value_parser = clap::value_parser!(u32).range(1..=64))]
    per_place: u32,
    /// Rays of a probe in all
    #[arg(long, value_name = "N", default_value_t = Options::default().rays, value_parser = clap::value_parser!(u32).range(1..=131_072))]
    rays: u32,
    /// Rays of a probe in a frame
    #[arg(long, value_name = "N", default_value_t = Options::default().rays_per_frame, value_parser = clap::value_parser!(u32).range(1..=256))]
    rays_per_frame: u32,
    /// Texels along each side of a guide: 2, 4, 6 or 8
    #[arg(long, value_name = "N", default_value_t = Options::default().guide_side, value_parser = guide_side)]
    guide_side: u32,
    /// Write a plot for each environment, and all figures as guiding.csv, into this folder
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The errors under one environment.
#[derive(Debug, Serialize)]
struct Measured {
    environment: String,
    probes: u32,
    seeds: u32,
    rays_per_frame: u32,
    guide_side: u32,
    rows: Vec<Row>,
}

/// What the setting of this name takes.
fn guide_side(text: &str) -> Result<u32, String> {
    let mut settings = Settings::default();
    match settings.set("guide_side", text) {
        Ok(()) => Ok(settings.guide_side),
        Err(SettingError::Value { want, .. }) => Err(want),
        Err(other) => Err(other.to_string()),
    }
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let options = Options {
        probes: args.probes,
        seeds: args.seeds,
        per_place: args.per_place,
        rays_per_frame: args.rays_per_frame,
        rays: args.rays,
        guide_side: args.guide_side,
    };
    if args.rays < args.rays_per_frame {
        return Err(CommandError::Value {
            option: "--rays",
            value: args.rays.to_string(),
            want: format!("give at least the {} of a frame", args.rays_per_frame),
        });
    }
    // All of them first, so that a wrong name does not show after minutes.
    let environments = args.environments.iter().map(|name| find(name));
    let mut environments = environments.collect::<Result<Vec<_>, _>>()?;
    number_namesakes(&mut environments);
    if let Some(folder) = &args.report {
        prepare_folder(folder, TABLE)?;
    }
    let backend = backends::open(args.backend)?;
    let mut all = Vec::new();
    for (name, map) in environments {
        let measured = Measured {
            rows: guiding::measure(backend.as_ref(), &map, &options)?,
            environment: name,
            probes: args.probes,
            seeds: args.seeds,
            rays_per_frame: args.rays_per_frame,
            guide_side: args.guide_side,
        };
        if !args.json {
            say!(
                "{} on {}: {} probes, {} seeds, {} rays a frame, guides of {}x{} texels",
                measured.environment,
                backend.name(),
                args.probes,
                args.seeds,
                args.rays_per_frame,
                args.guide_side,
                args.guide_side
            );
            say!("{}", table(&measured.rows));
        }
        if let Some(folder) = &args.report {
            let svg = guiding::plot(&measured.environment, &measured.rows);
            let path = folder.join(format!("{}.svg", measured.environment));
            replace_file(&path, svg.as_bytes())?;
        }
        all.push(measured);
    }
    if let Some(folder) = &args.report {
        replace_file(&folder.join(TABLE), csv(&all).as_bytes())?;
    }
    if args.json {
        say!("{}", serde_json::to_string_pretty(&all).unwrap_or_default());
    }
    Ok(())
}

/// Maps of one name in different folders are told apart by a number, in tables and in the names of plots.
fn number_namesakes(environments: &mut [(String, EnvironmentMap)]) {
    for i in (1..environments.len()).rev() {
        let (before, rest) = environments.split_at_mut(i);
        let name = &mut rest[0].0;
        match before.iter().filter(|(other, _)| other == name).count() {
            0 => {}
            earlier => *name += &format!("-{}", earlier + 1),
        }
    }
}

/// The file in the folder of a report that has all figures.
const TABLE: &str = "guiding.csv";

/// All figures, a line for each environment and count of rays; errors are relative, not percentages.
fn csv(all: &[Measured]) -> String {
    let mut text = String::from("environment,guide_side,rays");
    for side in ["cosine", "guided"] {
        for column in ["error", "plus_minus", "bias", "bias_plus_minus"] {
            text += &format!(",{side}_{column}");
        }
    }
    text.push('\n');
    for measured in all {
        for row in &measured.rows {
            // A name is text of the user's: quoted as RFC 4180 says.
            let name = measured.environment.replace('"', "\"\"");
            text += &format!("\"{name}\",{},{}", measured.guide_side, row.rays);
            for e in [row.cosine, row.guided] {
                let values = [e.error, e.plus_minus, e.bias, e.bias_plus_minus];
                text.extend(values.map(|value| format!(",{value}")));
            }
            text.push('\n');
        }
    }
    text
}

/// The name that an environment goes by, and its texels.
fn find(name: &str) -> Result<(String, EnvironmentMap), CommandError> {
    if let Some(map) = guiding::built_in(name) {
        return Ok((name.to_owned(), map));
    }
    let path = Path::new(name);
    if path.extension().is_none() && !path.exists() {
        return Err(CommandError::NoEnvironment {
            name: name.to_owned(),
            names: guiding::names().collect::<Vec<_>>().join(", "),
        });
    }
    let mut warnings = Vec::new();
    let map = load_environment(path, 1.0, &mut warnings)?;
    for text in warnings {
        warning!("{text}");
    }
    let stem = path.file_stem().unwrap_or_default();
    Ok((stem.to_string_lossy().into_owned(), map))
}

fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "    rays |     cosine: error      bias     |     guided: error      bias     | guided / cosine\n",
    );
    for row in rows {
        let side = |e: &guiding::Error| {
            format!(
                "{:6.2} % +- {:5.2}   {:+6.2} +- {:4.2}",
                e.error * 100.0,
                e.plus_minus * 100.0,
                e.bias * 100.0,
                e.bias_plus_minus * 100.0
            )
        };
        text += &format!(
            "{:8} | {} | {} | {:5.3}\n",
            row.rays,
            side(&row.cosine),
            side(&row.guided),
            row.guided.error / row.cosine.error.max(1e-12)
        );
    }
    text
}
