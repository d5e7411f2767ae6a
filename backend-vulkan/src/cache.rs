//! Compiled pipelines on disk, so that the next start need not compile them again.
//!
//! A file is a magic number, a checksum and what the driver gave. Drivers check that the data is theirs, but not that
//! it is whole; the checksum does. Everything here may fail without harm: the pipelines are compiled again.
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

const MAGIC: &[u8; 8] = b"gibsvkp1";
const HEADER: usize = MAGIC.len() + 8;

/// The file for a device: `$XDG_CACHE_HOME/gibs/` or `~/.cache/gibs/`.
pub(crate) fn path(device: &str) -> Option<PathBuf> {
    let absolute = |name: &str| {
        let path = PathBuf::from(std::env::var_os(name)?);
        path.is_absolute().then_some(path)
    };
    let cache = absolute("XDG_CACHE_HOME").or_else(|| Some(absolute("HOME")?.join(".cache")))?;
    Some(cache.join("gibs").join(format!("vulkan-{device}.bin")))
}

/// What [`save`] wrote, if all of it is there.
pub(crate) fn load(path: &Path) -> Option<Vec<u8>> {
    let mut file = fs::read(path).ok()?;
    let sum = u64::from_le_bytes(file.get(MAGIC.len()..HEADER)?.try_into().ok()?);
    if file[..MAGIC.len()] != *MAGIC || checksum(&file[HEADER..]) != sum {
        return None;
    }
    file.drain(..HEADER);
    Some(file)
}

/// Writes `data` under a temporary name and renames it, so that a reader never sees half of it.
pub(crate) fn save(path: &Path, data: &[u8]) -> std::io::Result<()> {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let unique = NEXT.fetch_add(1, Ordering::Relaxed);
    let temporary = path.with_extension(format!("{}-{unique}.tmp", std::process::id()));
    let written = fs::File::create(&temporary).and_then(|mut file| {
        file.write_all(MAGIC)?;
        file.write_all(&checksum(data).to_le_bytes())?;
        file.write_all(data)
    });
    let renamed = written.and_then(|()| fs::rename(&temporary, path));
    if renamed.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    renamed
}

/// 64-bit FNV-1a (Fowler, Noll and Vo).
fn checksum(data: &[u8]) -> u64 {
    data.iter().fold(0xcbf2_9ce4_8422_2325, |sum, &byte| {
        (sum ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_files_load() -> std::io::Result<()> {
        let folder = std::env::temp_dir().join(format!("gibs-cache-{}", std::process::id()));
        let path = folder.join("deeper").join("a.bin");
        assert_eq!(load(&path), None);
        let data: Vec<u8> = (0..100).collect();
        save(&path, &data)?;
        assert_eq!(load(&path), Some(data.clone()));
        save(&path, &data[..50])?;
        assert_eq!(
            load(&path),
            Some(data[..50].to_vec()),
            "a second save replaces the first"
        );

        let good = fs::read(&path)?;
        for bad in [
            good[..good.len() - 1].to_vec(),
            good[..HEADER - 1].to_vec(),
            good.iter()
                .enumerate()
                .map(|(i, b)| b ^ u8::from(i == 40))
                .collect(),
            good.iter()
                .enumerate()
                .map(|(i, b)| b ^ u8::from(i == 0))
                .collect(),
        ] {
            fs::write(&path, bad)?;
            assert_eq!(load(&path), None);
        }
        let left = fs::read_dir(folder.join("deeper"))?.count();
        assert_eq!(left, 1, "no temporary file stays");
        fs::remove_dir_all(folder)
    }

    #[test]
    fn checksum_is_fnv_1a() {
        // From the authors' list of test vectors.
        assert_eq!(checksum(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(checksum(b"foobar"), 0x8594_4171_f739_67e8);
    }
}
