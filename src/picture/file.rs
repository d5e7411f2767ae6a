//! Replacing a file as a whole: readers see the old content or the new, never a part.
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// An error about a file to be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The folder is missing.
    #[error("{path}: the folder {folder} does not exist; create it first")]
    NoFolder {
        /// The file to be written.
        path: PathBuf,
        /// The folder it should lie in.
        folder: PathBuf,
    },
    /// The path names something that is not a plain file.
    #[error("{path}: exists and is not a plain file; choose another name")]
    NotAFile {
        /// The file to be written.
        path: PathBuf,
    },
    /// A folder was wanted, and there is something else.
    #[error("{path}: exists and is not a folder; choose another name")]
    NotAFolder {
        /// The folder wanted.
        path: PathBuf,
    },
    /// The folder or the disk does not take the file.
    #[error(
        "{path}: cannot be written ({source}); check the folder's permissions and the free space"
    )]
    Io {
        /// The file to be written.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// Writes `bytes` to a temporary name beside `path`, then renames it to `path`. A symbolic link is
/// followed, so that the link stays.
///
/// # Errors
/// [`WriteError`]; the temporary file is gone then and an earlier file at `path` is as it was.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let io_error = |source| WriteError::Io {
        path: path.to_owned(),
        source,
    };
    let target = resolve(path)?;
    let (mut file, temporary) = create_temporary(path, &target)?;
    let written = file.write_all(bytes);
    drop(file);
    let result = written.and_then(|()| fs::rename(&temporary, &target));
    result.map_err(|source| {
        // The first error is the one to report; a temporary file that cannot be removed changes
        // nothing about it.
        let _ = fs::remove_file(&temporary);
        io_error(source)
    })
}

/// Checks that [`replace_file`] can write `path`, by making and removing a temporary file beside
/// it. Worth a call before work that takes long.
///
/// # Errors
/// [`WriteError`], as [`replace_file`] would give.
pub fn ensure_writable(path: &Path) -> Result<(), WriteError> {
    let target = resolve(path)?;
    let (file, temporary) = create_temporary(path, &target)?;
    drop(file);
    fs::remove_file(&temporary).map_err(|source| WriteError::Io {
        path: path.to_owned(),
        source,
    })
}

/// The plain file behind `path`, which need not exist.
fn resolve(path: &Path) -> Result<PathBuf, WriteError> {
    let not_a_file = || WriteError::NotAFile {
        path: path.to_owned(),
    };
    match fs::metadata(path) {
        // Renaming over a device or a folder would destroy it or fail late.
        Ok(metadata) if !metadata.is_file() => Err(not_a_file()),
        Ok(_) => fs::canonicalize(path).map_err(|source| WriteError::Io {
            path: path.to_owned(),
            source,
        }),
        Err(_) if path.file_name().is_none() => Err(not_a_file()),
        Err(_) => Ok(path.to_owned()),
    }
}

fn create_temporary(path: &Path, target: &Path) -> Result<(File, PathBuf), WriteError> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(WriteError::NoFolder {
            path: path.to_owned(),
            folder: folder.to_owned(),
        });
    }
    loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let temporary = folder.join(format!(".gibs-{}-{number}.tmp", std::process::id()));
        match OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&temporary)
        {
            Ok(file) => return Ok((file, temporary)),
            // Left by a process that was killed and had the same number: the next name is free
            // sooner or later.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(source) => {
                return Err(WriteError::Io {
                    path: path.to_owned(),
                    source,
                });
            }
        }
    }
}
