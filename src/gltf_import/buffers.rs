//! Reads the buffers that buffer views use.
use super::error::ImportError;
use super::uri::{self, Target};
use gltf::json;
use rayon::prelude::*;
use std::path::Path;

/// Content per buffer, cut to its `byteLength`. `None` for buffers that no view uses and for those that have no
/// content of their own (placeholders of compressed data).
pub(super) fn load(
    file: &Path,
    root: &json::Root,
    bin: Option<Vec<u8>>,
) -> Result<Vec<Option<Vec<u8>>>, ImportError> {
    let mut used = vec![false; root.buffers.len()];
    for view in &root.buffer_views {
        if let Some(used) = used.get_mut(view.buffer.value()) {
            *used = true;
        }
    }
    let chunk = std::sync::Mutex::new(bin);
    root.buffers
        .par_iter()
        .enumerate()
        .map(|(i, buffer)| {
            if !used[i] {
                return Ok(None);
            }
            let (mut bytes, place) = match &buffer.uri {
                Some(uri) => content(file, i, uri)?,
                // Only the first buffer can be the GLB's chunk (glTF 2.0, 4.4.3.3).
                None if i == 0 => match chunk.lock().ok().and_then(|mut bin| bin.take()) {
                    Some(bytes) => (bytes, "the GLB's binary chunk".to_owned()),
                    None => return Ok(None),
                },
                None => return Ok(None),
            };
            let length = buffer.byte_length.0;
            if (bytes.len() as u64) < length {
                let problem = format!(
                    "{place} is cut off: {length} bytes are needed, it has {}; copy or export it again",
                    bytes.len()
                );
                return Err(ImportError::content(file, format!("buffers[{i}]"), problem));
            }
            bytes.truncate(length as usize);
            Ok(Some(bytes))
        })
        .collect()
}

fn content(file: &Path, i: usize, uri: &str) -> Result<(Vec<u8>, String), ImportError> {
    match uri::resolve(file, uri)
        .map_err(|problem| ImportError::content(file, format!("buffers[{i}]"), problem))?
    {
        Target::Data(bytes) => Ok((bytes, "its data URI".to_owned())),
        Target::File(path) => match uri::read(&path) {
            Ok(bytes) => Ok((bytes, path.display().to_string())),
            Err(source) => Err(ImportError::Read { file: path, source }),
        },
    }
}

/// Whether a view's content is compressed with meshopt.
pub(super) fn is_meshopt(view: &json::buffer::View) -> bool {
    view.extensions.as_ref().is_some_and(|extensions| {
        ["EXT_meshopt_compression", "KHR_meshopt_compression"]
            .iter()
            .any(|name| extensions.others.contains_key(*name))
    })
}
