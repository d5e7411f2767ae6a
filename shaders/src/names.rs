//! Names of ports and globals.
use std::borrow::Cow;

/// The WGSL global that belongs to a port: of the same name, with an underscore where that is reserved in WGSL.
pub(crate) fn global(port: &str) -> Cow<'_, str> {
    if naga::keywords::wgsl::RESERVED.contains(&port) {
        format!("{port}_").into()
    } else {
        port.into()
    }
}
