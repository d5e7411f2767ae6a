//! The document with its buffers, and checked ways into both.
use super::buffers;
use super::document::Document;
use super::error::ImportError;
use gltf::json;
use serde_json::Value;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A document with its buffers in memory.
pub(super) struct Source {
    /// The glTF file, for messages and relative URIs.
    pub(super) file: PathBuf,
    /// The JSON.
    pub(super) root: json::Root,
    value: Value,
    /// Content per buffer; `None` where nothing was stored (see [`buffers::load`]).
    buffers: Vec<Option<Vec<u8>>>,
    /// Elements of accessors that were opened so far without data behind them.
    zeros: AtomicU64,
}

impl Source {
    /// Reads the buffers of a document.
    pub(super) fn open(document: Document) -> Result<Self, ImportError> {
        let Document {
            file,
            root,
            value,
            bin,
        } = document;
        let buffers = buffers::load(&file, &root, bin)?;
        Ok(Self {
            file,
            root,
            value,
            buffers,
            zeros: AtomicU64::new(0),
        })
    }

    /// Counts elements without data behind them, on top of those before; gives all.
    pub(super) fn zeros(&self, more: u64) -> u64 {
        let before = self.zeros.fetch_add(more, Relaxed);
        before.saturating_add(more)
    }

    /// An error about a part of the document.
    pub(super) fn error(
        &self,
        element: impl Into<String>,
        problem: impl Into<String>,
    ) -> ImportError {
        ImportError::content(&self.file, element, problem)
    }

    /// What the file has at a JSON pointer: the typed document forgets values that glTF does not know.
    pub(super) fn stated(&self, pointer: &str) -> String {
        self.value
            .pointer(pointer)
            .map_or_else(|| "missing".to_owned(), Value::to_string)
    }

    /// The element of a list that `owner` refers to.
    pub(super) fn get<'a, T>(
        &self,
        list: &'a [T],
        what: &str,
        index: json::Index<T>,
        owner: impl FnOnce() -> String,
    ) -> Result<&'a T, ImportError> {
        list.get(index.value()).ok_or_else(|| {
            self.error(
                owner(),
                format!(
                    "refers to {what} {}, but there are {}; correct the index or add what it refers to",
                    index.value(),
                    list.len()
                ),
            )
        })
    }

    /// Bytes of a buffer view.
    pub(super) fn view(
        &self,
        index: json::Index<json::buffer::View>,
        owner: impl FnOnce() -> String,
    ) -> Result<(&[u8], &json::buffer::View), ImportError> {
        let view = self.get(&self.root.buffer_views, "bufferView", index, owner)?;
        let element = || format!("bufferViews[{}]", index.value());
        self.get(&self.root.buffers, "buffer", view.buffer, element)?;
        let buffer = view.buffer.value();
        let Some(Some(bytes)) = self.buffers.get(buffer) else {
            let problem = if buffers::is_meshopt(view) {
                "is compressed with meshopt, which gibs does not support; export the file without meshopt compression"
                    .to_owned()
            } else {
                format!("buffer {buffer} has neither a URI nor a GLB chunk; add the buffer's file")
            };
            return Err(self.error(element(), problem));
        };
        let from = view.byte_offset.map_or(0, |offset| offset.0);
        let to = from
            .checked_add(view.byte_length.0)
            .filter(|&to| to <= bytes.len() as u64);
        let Some(to) = to else {
            let length = view.byte_length.0;
            let problem = format!(
                "{length} bytes from byte {from} do not fit buffer {buffer} of {} bytes; correct them or export the file again",
                bytes.len()
            );
            return Err(self.error(element(), problem));
        };
        // Both are at most the slice's length, hence fit usize.
        Ok((&bytes[from as usize..to as usize], view))
    }
}
