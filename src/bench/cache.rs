//! References on disk, found by what they are made of.
use super::key::{Hash, Key};
use crate::RenderError;
use crate::picture::Picture;
use crate::reference::{ReferenceOptions, reference};
use crate::view::View;
use gibs_graph::Backend;
use gibs_passes::scene::Scene;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A folder with references. Files have the name of their key, and hold it with its ingredients and a hash of the content, so
/// that one which was renamed, cut short or changed is not taken for what it is not.
#[derive(Clone, Debug)]
pub struct TruthCache {
    folder: PathBuf,
}

/// A reference, rendered or found.
#[derive(Clone, Debug)]
pub struct CachedReference {
    /// The picture, as of [`reference()`].
    pub picture: Picture,
    /// Whether it was there already.
    pub found: bool,
    /// What was wrong with the file that was there, or with keeping this one.
    pub warning: Option<String>,
}

const KEY: &str = "gibs.key";
const CONTENT: &str = "gibs.content";
const MADE_OF: &str = "gibs.made_of";

impl TruthCache {
    /// In this folder, which is made when there is something to keep.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    /// In `$XDG_CACHE_HOME/gibs/truths`, or `~/.cache/gibs/truths`; `None` where neither is known.
    pub fn usual() -> Option<Self> {
        let absolute = |name: &str| {
            let path = PathBuf::from(std::env::var_os(name)?);
            path.is_absolute().then_some(path)
        };
        let cache =
            absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
        Some(Self::new(cache.join("gibs").join("truths")))
    }

    /// The reference with these options: of the folder where it is there and whole, else rendered and kept. `progress` is that of
    /// [`reference()`], which is not called for one that is there.
    ///
    /// # Errors
    /// As [`reference()`]. A file that cannot be used or written is a warning.
    pub fn reference(
        &self,
        backend: &dyn Backend,
        scene: &Scene,
        view: &View,
        options: &ReferenceOptions,
        progress: impl FnMut(u32, u32),
    ) -> Result<CachedReference, RenderError> {
        let key = Key::of(backend, scene, view, options)?;
        let path = self.folder.join(format!("{}.exr", key.hash));
        let mut warning = None;
        match load(&path, &key, options.size) {
            Ok(Some(picture)) => {
                return Ok(CachedReference {
                    picture,
                    found: true,
                    warning,
                });
            }
            Ok(None) => {}
            Err(problem) => {
                warning = Some(format!("{problem}; the truth is rendered anew"));
            }
        }
        let (picture, _) = reference(backend, scene, view, options, progress)?;
        if let Err(problem) = self.store(&path, &key, &picture) {
            warning = Some(format!(
                "the truth cannot be kept: {problem}; name another folder with --cache, or none with --no-cache"
            ));
        }
        Ok(CachedReference {
            picture,
            found: false,
            warning,
        })
    }

    fn store(&self, path: &Path, key: &Key, picture: &Picture) -> Result<(), String> {
        std::fs::create_dir_all(&self.folder)
            .map_err(|error| format!("{}: {error}", self.folder.display()))?;
        let notes = BTreeMap::from([
            (KEY.to_owned(), key.hash.clone()),
            (CONTENT.to_owned(), content(picture)),
            (MADE_OF.to_owned(), key.text()),
        ]);
        picture
            .write_exr_with_notes(path, &notes)
            .map_err(|error| error.to_string())
    }
}

/// The picture, if there is a file; what is wrong with it, if it is not the one.
fn load(path: &Path, key: &Key, size: [u32; 2]) -> Result<Option<Picture>, String> {
    match std::fs::metadata(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(format!("{}: {error}", path.display())),
        // Others, such as a pipe, may never end.
        Ok(found) if !found.is_file() => return Err(format!("{} is no file", path.display())),
        Ok(_) => {}
    }
    let (picture, notes) = Picture::read_exr_with_notes(path).map_err(|error| error.to_string())?;
    let wrong = |what: &str| format!("{}: {what}", path.display());
    let note = |name| notes.get(name).map(String::as_str);
    if note(KEY) != Some(&key.hash) || [picture.width, picture.height] != size {
        return Err(wrong("it is another picture than its name says"));
    }
    if note(CONTENT) != Some(&content(&picture)) {
        return Err(wrong("its content has changed since it was written"));
    }
    Ok(Some(picture))
}

/// A hash of all channels.
fn content(picture: &Picture) -> String {
    let mut hash = Hash::default();
    hash.part(&picture.width.to_le_bytes());
    hash.part(&picture.height.to_le_bytes());
    for (name, values) in &picture.channels {
        hash.part(name.as_bytes());
        hash.part(bytemuck::cast_slice(values));
    }
    hash.hex()
}

#[cfg(all(test, feature = "cpu"))]
mod tests;
