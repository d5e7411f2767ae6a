//! Words that several outputs share.
use std::path::Path;

/// A number of things: `1 frame`, `2 frames`.
pub(crate) fn counted(count: impl Into<u64>, what: &str) -> String {
    match count.into() {
        1 => format!("1 {what}"),
        count => format!("{count} {what}s"),
    }
}

/// Text of a file or a driver without what a terminal would obey, or what would break a line.
pub(crate) fn printable(text: &str) -> String {
    let shown = |c: char| match c.is_control() {
        true => c.escape_debug().to_string(),
        false => c.to_string(),
    };
    text.chars().map(shown).collect()
}

/// How a scene is called in titles and names of files: a built-in one's name, a file's without folders and extension.
pub(crate) fn scene_name(scene: &str) -> String {
    let stem = Path::new(scene).file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}
