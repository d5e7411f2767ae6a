//! What commands print and write: results to standard output, warnings to standard error, pictures to files.
use super::CommandError;
use crate::picture::{Format, Picture, WriteError, ensure_writable};
use crate::words::{printable, scene_name};
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Prints to standard output. A reader that has seen enough is no failure.
pub(super) fn print(text: &str) -> Result<(), CommandError> {
    match io::stdout()
        .write_all(text.as_bytes())
        .and_then(|()| io::stdout().flush())
    {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CommandError::Output { source: error })
        }
        _ => Ok(()),
    }
}

/// Prints to standard error, if anybody can hear it.
pub(super) fn tell(text: &str) {
    let lines: Vec<String> = text.split('\n').map(printable).collect();
    let _ = writeln!(io::stderr(), "{}", lines.join("\n"));
}

/// Prints a line of the command's result.
macro_rules! say {
    ($($part:tt)*) => {
        $crate::cli::output::print(&(format!($($part)*) + "\n"))?
    };
}

/// Prints a warning.
macro_rules! warning {
    ($($part:tt)*) => {
        $crate::cli::output::tell(&(String::from("warning: ") + &format!($($part)*)))
    };
}

pub(super) use {say, warning};

/// A bar on a terminal, nothing in a pipe.
pub(super) fn progress(length: u64, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar.set_message(what);
    bar
}

/// Writes a picture as its extension says; a PNG goes beside an EXR.
pub(super) fn write(picture: &Picture, out: &Path, exposure: f32) -> Result<(), CommandError> {
    picture.write(out, exposure)?;
    if Format::of(out)? == Format::Exr {
        picture.write_preview(&out.with_extension("png"), "", exposure)?;
    }
    Ok(())
}

/// Fails where the picture holds anything that is not a number.
pub(super) fn check_finite(picture: &Picture) -> Result<(), CommandError> {
    let bad: std::collections::BTreeSet<usize> = picture
        .channels
        .values()
        .flat_map(|c| {
            c.iter()
                .enumerate()
                .filter(|(_, x)| !x.is_finite())
                .map(|(i, _)| i)
        })
        .collect();
    if bad.is_empty() {
        Ok(())
    } else {
        Err(CommandError::NonFinite {
            count: bad.len(),
            pixels: picture.pixels(),
        })
    }
}

/// Where a picture of a scene goes that nobody named.
pub(super) fn default_out(scene: &str) -> PathBuf {
    PathBuf::from(scene_name(scene) + ".exr")
}

/// Makes the folder of a report and sees that a file of this name can be written there.
pub(super) fn prepare_folder(folder: &Path, file: &str) -> Result<(), WriteError> {
    let path = folder.to_owned();
    if folder.exists() && !folder.is_dir() {
        return Err(WriteError::NotAFolder { path });
    }
    std::fs::create_dir_all(folder).map_err(|source| WriteError::Io { path, source })?;
    ensure_writable(&folder.join(file))
}
