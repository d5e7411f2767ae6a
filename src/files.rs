//! Reading files that users name.
use std::io;
use std::path::Path;

/// The content of a file. A device is refused, since it may have no end; a pipe is read until who writes it closes it.
pub(crate) fn read(path: &Path) -> io::Result<Vec<u8>> {
    refuse_devices(path)?;
    std::fs::read(path)
}

/// The same as text.
pub(crate) fn read_text(path: &Path) -> io::Result<String> {
    refuse_devices(path)?;
    std::fs::read_to_string(path)
}

#[cfg(unix)]
fn refuse_devices(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::FileTypeExt;
    let kind = std::fs::metadata(path)?.file_type();
    match kind.is_char_device() || kind.is_block_device() {
        true => Err(io::Error::other("it is a device and no file")),
        false => Ok(()),
    }
}

#[cfg(not(unix))]
fn refuse_devices(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn devices_without_an_end_are_refused() {
        for device in ["/dev/zero", "/dev/null"] {
            let error = read(Path::new(device)).unwrap_err();
            assert!(error.to_string().contains("a device"), "{error}");
            assert!(read_text(Path::new(device)).is_err());
        }
        let missing = read(Path::new("/missing")).unwrap_err();
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
    }
}
