//! What can go wrong with a picture, with the file, the value and the way out.
use std::io;
use std::path::PathBuf;

use super::file::WriteError;

/// An error about a picture or its file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The file does not exist.
    #[error("{path}: no such file; check the path")]
    Missing {
        /// The file asked for.
        path: PathBuf,
    },
    /// The file exists and cannot be read.
    #[error("{path}: cannot be read ({source}); check its permissions and that it is a file")]
    Unreadable {
        /// The file asked for.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file does not start as an OpenEXR file does.
    #[error("{path}: not an OpenEXR file (it starts with {start}); convert it to .exr first")]
    NotExr {
        /// The file asked for.
        path: PathBuf,
        /// Its first bytes in hexadecimal.
        start: String,
    },
    /// An OpenEXR file whose content is damaged or contradicts itself.
    #[error("{path}: damaged OpenEXR file ({reason}); write or copy it again")]
    Damaged {
        /// The file asked for.
        path: PathBuf,
        /// What the decoder said.
        reason: String,
    },
    /// A valid OpenEXR file of a kind that is not read here.
    #[error("{path}: {what}; {remedy}")]
    Unsupported {
        /// The file asked for.
        path: PathBuf,
        /// What it has.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The picture would need more memory than is allowed for one file.
    #[error(
        "{path}: {width}x{height} pixels with {channels} channels is more than the {limit} values \
         read from one file; crop it or remove channels"
    )]
    TooLarge {
        /// The file asked for.
        path: PathBuf,
        /// Its width in pixels.
        width: usize,
        /// Its height in pixels.
        height: usize,
        /// Its channels.
        channels: usize,
        /// The largest number of values.
        limit: usize,
    },
    /// A channel was asked for that the picture does not have.
    #[error("no channel {wanted}; the channels present are: {present}")]
    MissingChannel {
        /// The full channel name asked for.
        wanted: String,
        /// Names of the channels present, comma-separated.
        present: String,
    },
    /// A channel with another number of values than the picture has pixels.
    #[error(
        "channel {channel} has {found} values where {width}x{height} pixels need {expected}; \
         set one value for each pixel"
    )]
    ChannelLength {
        /// The full channel name.
        channel: String,
        /// Values it has.
        found: usize,
        /// The picture's width in pixels.
        width: u32,
        /// The picture's height in pixels.
        height: u32,
        /// Values it should have.
        expected: usize,
    },
    /// A channel name that OpenEXR cannot hold.
    #[error("{path}: channel name {name:?} cannot be written; use 1 to 255 ASCII characters")]
    ChannelName {
        /// The file to be written.
        path: PathBuf,
        /// The name.
        name: String,
    },
    /// A picture without pixels or without channels has no file.
    #[error(
        "{path}: a picture of {width}x{height} pixels with {channels} channels cannot be written; \
         render at least one pixel and one channel"
    )]
    Empty {
        /// The file to be written.
        path: PathBuf,
        /// The picture's width in pixels.
        width: u32,
        /// The picture's height in pixels.
        height: u32,
        /// Its channels.
        channels: usize,
    },
    /// A file name with an extension that names no known format.
    #[error(
        "{path}: unknown extension {extension:?}; \
         use .exr (all channels, float) or .png (a preview)"
    )]
    UnknownExtension {
        /// The file to be written.
        path: PathBuf,
        /// Its extension in lower case, empty if it has none.
        extension: String,
    },
    /// The picture could not be encoded.
    #[error("{path}: cannot be encoded ({reason}); write .exr or a smaller picture")]
    Encode {
        /// The file to be written.
        path: PathBuf,
        /// What the encoder said.
        reason: String,
    },
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}
