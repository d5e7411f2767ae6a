//! Captures as `.npz` archives.
use super::{Capture, CapturedSize, VERSION};
use crate::check::error::CaptureError;
use crate::check::npz::{Reader, Writer};
use crate::{AccelerationInstance, AccelerationTriangle, Access, DispatchArgs, Element, Layout};
use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::Path;

/// Longest `capture.json`: far more than the stages of this project need.
const MOST_JSON: u64 = 16 << 20;

impl Capture {
    /// Writes it.
    ///
    /// # Errors
    /// [`CaptureError::Write`].
    pub fn write(&self, file: &Path) -> Result<(), CaptureError> {
        let failed = |source| CaptureError::Write {
            file: file.into(),
            source,
        };
        // Under another name first, so that nobody ever finds half a file.
        let partial = file.with_extension("npz.part");
        let write = || {
            let mut writer = Writer::new(BufWriter::new(File::create(&partial)?));
            writer.file("capture.json", &serde_json::to_vec_pretty(self)?)?;
            for buffer in &self.buffers {
                let name = format!("before/{}", buffer.key);
                writer.array(&name, &buffer.element, &buffer.bytes)?;
            }
            for origin in &self.results {
                for (&buffer, bytes) in origin.buffers.iter().zip(&origin.outputs) {
                    let buffer = &self.buffers[buffer as usize];
                    let name = format!("after-{}/{}", origin.lane, buffer.key);
                    writer.array(&name, &buffer.element, bytes)?;
                }
            }
            let done = writer.finish()?.into_inner();
            done.map_err(std::io::IntoInnerError::into_error)?
                .sync_all()?;
            std::fs::rename(&partial, file)
        };
        let written = write();
        if written.is_err() {
            // What is left of it helps nobody; that it cannot be removed either is not the error to tell.
            let _ = std::fs::remove_file(&partial);
        }
        written.map_err(failed)
    }

    /// Reads one.
    ///
    /// # Errors
    /// [`CaptureError::Read`], [`CaptureError::Folder`], [`CaptureError::Format`].
    pub fn read(file: &Path) -> Result<Self, CaptureError> {
        // Before it is opened: whether a folder can be is up to the system, and reading it says little of why it fails.
        if file.is_dir() {
            return Err(CaptureError::Folder { file: file.into() });
        }
        let opened = File::open(file).map_err(|source| CaptureError::Read {
            file: file.into(),
            source,
        })?;
        Self::from_archive(BufReader::new(opened)).map_err(|problem| CaptureError::Format {
            file: file.into(),
            problem,
        })
    }

    /// Reads one from memory; the error says what is wrong.
    pub(crate) fn from_archive(from: impl std::io::Read + std::io::Seek) -> Result<Self, String> {
        let mut reader = Reader::new(from)?;
        let json = reader.file("capture.json", MOST_JSON)?;
        let mut capture: Self =
            serde_json::from_slice(&json).map_err(|e| format!("`capture.json`: {e}"))?;
        if capture.version != VERSION {
            return Err(format!("its format is {}, not {VERSION}", capture.version));
        }
        capture.check()?;
        for buffer in &mut capture.buffers {
            let name = format!("before/{}", buffer.key);
            buffer.bytes = reader.array(&name, &buffer.element, buffer.len)?;
        }
        let buffers = &capture.buffers;
        for origin in &mut capture.results {
            for &id in &origin.buffers {
                let buffer = &buffers[id as usize];
                let name = format!("after-{}/{}", origin.lane, buffer.key);
                origin
                    .outputs
                    .push(reader.array(&name, &buffer.element, buffer.len)?);
            }
        }
        Ok(capture)
    }

    /// What can be wrong with `capture.json` alone.
    fn check(&self) -> Result<(), String> {
        let count = self.buffers.len();
        let bound = self.bindings.iter().map(|binding| binding.buffer);
        let sized = match self.size {
            CapturedSize::Indirect(buffer) => Some(buffer),
            CapturedSize::Groups(_) => None,
        };
        let made = self
            .results
            .iter()
            .flat_map(|origin| origin.buffers.iter().copied());
        if let Some(id) = bound
            .chain(sized)
            .chain(made)
            .find(|&id| id as usize >= count)
        {
            return Err(format!("it names buffer {id} of {count}"));
        }
        self.check_names()?;
        if let Some(id) = sized
            && self.buffers[id as usize].element != DispatchArgs::layout()
        {
            let key = &self.buffers[id as usize].key;
            return Err(format!("`{key}` cannot say how many workgroups run"));
        }
        self.check_structures()?;
        for buffer in &self.buffers {
            let texels = buffer.image.map(|image| image.size.map(u64::from));
            if buffer.len == 0
                || buffer.len > 1 << 32
                || plain_size(&buffer.element).is_none()
                || texels.is_some_and(|[w, h]| w.checked_mul(h) != Some(buffer.len))
            {
                return Err(format!("`{}` has an impossible type or length", buffer.key));
            }
        }
        Ok(())
    }

    /// Whatever is bound as an acceleration structure has triangles, which are nothing else.
    fn check_structures(&self) -> Result<(), String> {
        for (id, buffer) in (0..).zip(&self.buffers) {
            let bound = self.bindings.iter().filter(|binding| binding.buffer == id);
            let traced = bound.map(|binding| binding.access == Access::Acceleration);
            let is_structure = buffer.triangles.is_some();
            let has_triangles = match buffer.triangles {
                Some(triangles) => {
                    let found = self.buffers.get(triangles as usize);
                    let is_bound = self.bindings.iter().any(|b| b.buffer == triangles);
                    found.is_some_and(|found| {
                        found.element == AccelerationTriangle::layout()
                            && found.triangles.is_none()
                            && found.image.is_none()
                            && !is_bound
                    }) && buffer.element == AccelerationInstance::layout()
                }
                None => true,
            };
            if !has_triangles || !traced.into_iter().all(|traced| traced == is_structure) {
                let key = &buffer.key;
                return Err(format!("`{key}` is no acceleration structure as it stands"));
            }
        }
        Ok(())
    }

    /// Every buffer and every result is there once, so that the file's size bounds what is read of it; and a buffer that
    /// is written is bound once, since kernels rely on that.
    fn check_names(&self) -> Result<(), String> {
        let ports = self.bindings.iter().map(|binding| binding.port.as_str());
        let keys = self.buffers.iter().map(|buffer| buffer.key.as_str());
        let lanes = self.results.iter().map(|origin| origin.lane.as_str());
        let twice = twice(ports)
            .or_else(|| twice(keys))
            .or_else(|| twice(lanes));
        if let Some(name) = twice {
            return Err(format!("it has `{name}` twice"));
        }
        let written = self.written();
        for &id in &written {
            let bound = self.bindings.iter().filter(|binding| binding.buffer == id);
            if bound.count() > 1 {
                let key = &self.buffers[id as usize].key;
                return Err(format!("it binds `{key}` to two ports, and writes it"));
            }
        }
        match self.results.iter().find(|origin| origin.buffers != written) {
            None => Ok(()),
            Some(origin) => Err(format!(
                "`{}` has other results than the step writes",
                origin.lane
            )),
        }
    }
}

/// A name that comes twice.
fn twice<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = HashSet::new();
    names.find(|name| !seen.insert(*name))
}

/// Bytes of a type whose numbers lie within it and do not overlap, and which has no bytes beside them; `None` of any other.
fn plain_size(element: &Layout) -> Option<u32> {
    match element {
        Layout::Scalar(_) => Some(4),
        Layout::Vector(_, n) => (2..=4).contains(n).then(|| 4 * n),
        Layout::Array {
            element,
            count,
            stride,
        } => {
            let size = plain_size(element).filter(|size| size == stride)?;
            (1..=1 << 16)
                .contains(count)
                .then(|| count.checked_mul(size))?
        }
        Layout::Struct { size, fields, .. } => {
            let end = fields.iter().try_fold(0_u32, |end, field| {
                let size = plain_size(&field.layout).filter(|_| field.offset == end)?;
                end.checked_add(size)
            });
            end.filter(|end| end == size && *size > 0)
        }
    }
}
