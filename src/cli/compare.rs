//! `gibs compare`: the errors of a picture against the truth.
use super::output::warning;
use crate::words::counted;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::compare::{
    CompareError, CompareOptions, HEAT_FULL_SCALE, HalvesDoubt, Metrics, Report, compare,
    halves_doubt, noise_floor,
};
use crate::picture::{FINAL_IMAGE, Format, Picture, PictureError, ensure_writable, write_png};

/// Compare a picture with the truth, over the truth's mask
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// The picture to judge (OpenEXR); a whole multiple of the truth's size is averaged down
    #[arg(value_name = "A.exr")]
    pub ours: PathBuf,
    /// The truth (OpenEXR); its mask.A, blend.A and firefly.A choose the pixels
    #[arg(value_name = "B.exr")]
    pub truth: PathBuf,
    /// Write the relative error per pixel: .png as a heat map (brightest at 50 %), .exr as values
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
    /// The channel to compare: E, indirect, ..., or RGB for the final image
    #[arg(long, value_name = "NAME", default_value = "E")]
    pub channel: String,
    /// Factor on both pictures before FLIP [default: brings the truth's mean luminance to 0.18]
    #[arg(long, value_name = "F", value_parser = positive)]
    pub exposure: Option<f64>,
    /// Where the picture is an odd multiple of the truth's size, take the pixels at the truth's centres instead of means
    #[arg(long)]
    pub centers: bool,
    /// The two halves of the truth's samples (OpenEXR), which tell the noise of the truth
    #[arg(long, num_args = 2, value_names = ["HALFA", "HALFB"])]
    pub halves: Option<Vec<PathBuf>>,
}

/// Why `gibs compare` did not succeed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CompareCommandError {
    /// A file could not be read or written.
    #[error(transparent)]
    File(#[from] PictureError),
    /// The pictures could not be compared.
    #[error("{} against {}: {source}", ours.display(), truth.display())]
    Compare {
        /// The picture judged.
        ours: PathBuf,
        /// The truth.
        truth: PathBuf,
        /// Why not.
        source: CompareError,
    },
    /// The noise of the truth could not be found.
    #[error("--halves {} {}: {source}", half_a.display(), half_b.display())]
    Halves {
        /// The first half.
        half_a: PathBuf,
        /// The second half.
        half_b: PathBuf,
        /// Why not.
        source: CompareError,
    },
    /// The picture was compared and is broken.
    #[error(
        "{}: {} of channel {channel} NaN or infinite; \
         render it again, and report it with the command line if that comes back", path.display(), counted(*count as u64, "pixel")
    )]
    NotFinite {
        /// The picture judged.
        path: PathBuf,
        /// How many pixels.
        count: usize,
        /// The channel.
        channel: String,
    },
    /// The report could not be printed.
    #[error("the report cannot be printed ({0}); check where the output goes")]
    Print(#[source] io::Error),
}

impl CompareCommandError {
    /// 1 for a picture that failed the comparison, 2 for input that cannot be used.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::NotFinite { .. } => 1,
            _ => 2,
        }
    }
}

/// Runs `gibs compare`: prints the report, writes the map if asked to.
///
/// # Errors
/// [`CompareCommandError`]; for [`CompareCommandError::NotFinite`] report and map are out already.
pub fn run(args: Args) -> Result<(), CompareCommandError> {
    if let Some(out) = &args.out {
        Format::of(out)?;
        ensure_writable(out).map_err(PictureError::from)?;
    }
    let options = CompareOptions {
        layer: layer_name(&args.channel),
        exposure: args.exposure,
        centers: args.centers,
    };
    let (ours, truth) = read_both(&args.ours, &args.truth)?;
    let mut report =
        compare(&ours, &truth, &options).map_err(|source| CompareCommandError::Compare {
            ours: args.ours.clone(),
            truth: args.truth.clone(),
            source,
        })?;
    if let Some([half_a, half_b]) = args.halves.as_deref() {
        let options = CompareOptions {
            exposure: Some(report.exposure),
            ..options
        };
        let noise = noise_of([half_a, half_b], &truth, &args.truth, &options)?;
        report.noise = Some(noise.errors);
    }
    if let Some(out) = &args.out {
        write_map(&report, out)?;
    }
    print(&report, args.json).map_err(CompareCommandError::Print)?;
    if let Some([elsewhere, of]) = report.other_view() {
        warning!(
            "{elsewhere} of {of} pixels show another surface in {} than in {}; are both of one scene and view?",
            args.ours.display(),
            args.truth.display()
        );
    }
    if report.passed() {
        Ok(())
    } else {
        Err(CompareCommandError::NotFinite {
            path: args.ours,
            count: report.non_finite.anywhere,
            channel: args.channel,
        })
    }
}

/// What halves say of a truth's noise.
pub(super) struct Noise {
    pub errors: Metrics,
    /// Whether they were warned of.
    pub doubted: bool,
}

/// The noise of a truth by its halves, with a warning of those that are none.
pub(super) fn noise_of(
    [half_a, half_b]: [&Path; 2],
    truth: &Picture,
    path: &Path,
    options: &CompareOptions,
) -> Result<Noise, CompareCommandError> {
    let (a, b) = read_both(half_a, half_b)?;
    let noise = noise_floor(&a, &b, truth, options);
    let noise = noise.map_err(|source| CompareCommandError::Halves {
        half_a: half_a.to_owned(),
        half_b: half_b.to_owned(),
        source,
    })?;
    let doubt = halves_doubt(&a, &b, truth, &noise, options);
    match doubt {
        Some(HalvesDoubt::Alike) => {
            warning!("--halves: both halves are the same, and tell nothing of the truth's noise");
        }
        Some(HalvesDoubt::OfAnother { rel_mse }) => warning!(
            "--halves: their mean is another picture than {} (relMSE {rel_mse:.2e}); are they halves of it?",
            path.display()
        ),
        None => {}
    }
    Ok(Noise {
        errors: noise,
        doubted: doubt.is_some(),
    })
}

/// The layer that a `--channel` names: `RGB` in any case is the final image.
fn layer_name(channel: &str) -> String {
    if channel.eq_ignore_ascii_case("rgb") {
        FINAL_IMAGE.to_owned()
    } else {
        channel.to_owned()
    }
}

fn read_both(a: &Path, b: &Path) -> Result<(Picture, Picture), PictureError> {
    let (a, b) = rayon::join(|| Picture::read_exr(a), || Picture::read_exr(b));
    Ok((a?, b?))
}

fn write_map(report: &Report, path: &Path) -> Result<(), PictureError> {
    match Format::of(path)? {
        Format::Exr => report.error_picture()?.write_exr(path),
        Format::Png => write_png(path, &report.heat_map(HEAT_FULL_SCALE)),
    }
}

fn print(report: &Report, json: bool) -> io::Result<()> {
    let mut out = io::stdout().lock();
    let printed = if json {
        serde_json::to_string_pretty(report)
            .map_err(io::Error::from)
            .and_then(|text| writeln!(out, "{text}"))
    } else {
        write!(out, "{report}")
    };
    match printed {
        // A reader such as `head` that has seen enough is no failure.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("use a positive number, such as 1 or 0.05".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Program {
        #[command(flatten)]
        args: Args,
    }

    fn parse(words: &[&str]) -> Result<Args, clap::Error> {
        let words = [&["compare"], words].concat();
        Program::try_parse_from(words).map(|program| program.args)
    }

    #[test]
    fn arguments_have_their_defaults() {
        let args = parse(&["a.exr", "b.exr"]).unwrap();
        assert_eq!(
            (args.channel.as_str(), args.exposure, args.json),
            ("E", None, false)
        );
        let args = parse(&["a.exr", "b.exr", "--halves", "c.exr", "d.exr"]).unwrap();
        assert_eq!(args.halves.unwrap().len(), 2);
        assert_eq!(layer_name("rgb"), FINAL_IMAGE);
        assert_eq!(layer_name("indirect"), "indirect");
    }

    #[test]
    fn unusable_arguments_are_refused() {
        for words in [
            &["a.exr"][..],
            &["a.exr", "b.exr", "--halves", "c.exr"],
            &["a.exr", "b.exr", "--exposure=-1"],
            &["a.exr", "b.exr", "--exposure", "nan"],
        ] {
            assert!(parse(words).is_err(), "{words:?}");
        }
    }

    #[test]
    fn a_broken_picture_fails_after_its_map_is_written() {
        let folder = std::env::temp_dir().join(format!("gibs-compare-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let save = |name: &str, value: f32| {
            let mut picture = Picture::new(8, 8);
            let mut plane = vec![1.0; 64];
            plane[9] = value;
            picture
                .set_rgb("E", [plane.clone(), plane.clone(), plane])
                .unwrap();
            let path = folder.join(name);
            picture.write_exr(&path).unwrap();
            path.to_str().unwrap().to_owned()
        };
        let (sound, broken) = (save("sound.exr", 1.5), save("broken.exr", f32::NAN));
        let map = folder.join("map.png");
        let out = map.to_str().unwrap();

        let result = run(parse(&[&broken, &sound, "--out", out, "--json"]).unwrap());
        let error = result.unwrap_err();
        assert_eq!(error.exit_code(), 1, "{error}");
        assert!(
            error.to_string().contains("broken.exr: 1 pixel of"),
            "{error}"
        );
        let pixel = image::open(&map).unwrap().into_rgb8().get_pixel(1, 1).0;
        assert_eq!(pixel, crate::picture::NON_FINITE_COLOR);

        run(parse(&[&sound, &sound, "--json"]).unwrap()).unwrap();
        let missing = run(parse(&["missing.exr", &sound]).unwrap()).unwrap_err();
        assert_eq!(missing.exit_code(), 2, "{missing}");
        assert!(missing.to_string().contains("missing.exr"), "{missing}");
        let _ = std::fs::remove_dir_all(&folder);
    }
}
