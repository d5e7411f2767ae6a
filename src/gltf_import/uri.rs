//! Where a glTF URI points: into itself (data URI) or to a file beside the glTF.
use std::path::{Path, PathBuf};

/// Target of a URI.
#[derive(Debug, PartialEq)]
pub(super) enum Target {
    /// Content of a data URI.
    Data(Vec<u8>),
    /// A file.
    File(PathBuf),
}

/// Follows `uri` from the glTF file `from`. The error says what is wrong with the URI.
pub(super) fn resolve(from: &Path, uri: &str) -> Result<Target, String> {
    if let Some(data) = uri
        .get(..5)
        .filter(|scheme| scheme.eq_ignore_ascii_case("data:"))
    {
        return data_uri(&uri[data.len()..]).map(Target::Data);
    }
    if let Some(scheme) = scheme(uri) {
        return Err(format!(
            "the URI {uri:?} has the scheme {scheme:?}, but only files beside the glTF and data URIs are read; \
             download the file and refer to it by a relative path"
        ));
    }
    let folder = from.parent().unwrap_or(Path::new(""));
    let decoded = String::from_utf8(percent_decode(uri)).unwrap_or_else(|_| uri.to_owned());
    // Exporters also write plain percent signs and backslashes; the first that exists is meant.
    let candidates = [
        folder.join(&decoded),
        folder.join(uri),
        folder.join(decoded.replace('\\', "/")),
    ];
    let found = candidates
        .iter()
        .find(|path| path.is_file())
        .unwrap_or(&candidates[0]);
    Ok(Target::File(found.clone()))
}

/// Content of a file that a glTF refers to. A device or a pipe may have no end, and is none that an exporter writes.
pub(super) fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() && !metadata.is_dir() {
        return Err(std::io::Error::other("it is a device and no file"));
    }
    std::fs::read(path)
}

/// The URI's scheme. One letter is a drive, not a scheme.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, _) = uri.split_once(':')?;
    let letters = scheme
        .bytes()
        .all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    (scheme.len() > 1 && letters).then_some(scheme)
}

/// Content of a data URI after `data:` (RFC 2397).
fn data_uri(rest: &str) -> Result<Vec<u8>, String> {
    let (head, payload) = rest
        .split_once(',')
        .ok_or("the data URI has no comma before its data; export the file again")?;
    let payload = percent_decode(payload);
    let is_base64 = head
        .rsplit(';')
        .next()
        .is_some_and(|last| last.trim().eq_ignore_ascii_case("base64"));
    if is_base64 {
        base64(&payload)
    } else {
        Ok(payload)
    }
}

/// Bytes with every `%xx` replaced; a percent sign without two hexadecimal digits stays.
fn percent_decode(text: &str) -> Vec<u8> {
    let hex = |byte: Option<&u8>| byte.and_then(|&b| char::from(b).to_digit(16));
    let bytes = text.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut i = 0;
    while let Some(&byte) = bytes.get(i) {
        match (byte, hex(bytes.get(i + 1)), hex(bytes.get(i + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push((high * 16 + low) as u8);
                i += 3;
            }
            _ => {
                out.push(byte);
                i += 1;
            }
        }
    }
    out
}

/// Bytes of a base64 text (RFC 4648; both alphabets, padding optional, white space skipped).
fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3 + 3);
    let (mut bits, mut filled) = (0u32, 0u32);
    for (i, &byte) in text.iter().enumerate() {
        let value = match byte {
            b'A'..=b'Z' => byte - b'A',
            b'a'..=b'z' => byte - b'a' + 26,
            b'0'..=b'9' => byte - b'0' + 52,
            b'+' | b'-' => 62,
            b'/' | b'_' => 63,
            b'=' => break,
            _ if byte.is_ascii_whitespace() => continue,
            _ => {
                let shown = char::from(byte);
                return Err(format!(
                    "the data URI has {shown:?} at place {i} of its base64 text; export the file again"
                ));
            }
        };
        bits = bits << 6 | u32::from(value);
        filled += 6;
        if filled >= 8 {
            filled -= 8;
            out.push((bits >> filled) as u8);
        }
    }
    // Six bits left over cannot be part of any byte.
    if filled >= 6 {
        Err("the data URI's base64 text is cut off; copy or export the file again".to_owned())
    } else {
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_follows_the_rfc_vectors() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
        ] {
            assert_eq!(base64(text.as_bytes()).as_deref(), Ok(bytes.as_bytes()));
        }
        assert_eq!(base64(b"+/-_ \n"), Ok(vec![0xfb, 0xff, 0xbf]));
        assert!(base64(b"Zm9vY").is_err());
        assert!(base64(b"Zm?v").is_err());
    }

    #[test]
    fn data_uris_may_be_base64_or_percent_encoded() {
        let data = |uri| resolve(Path::new("a/b.gltf"), uri);
        assert_eq!(
            data("data:application/octet-stream;base64,AQID"),
            Ok(Target::Data(vec![1, 2, 3]))
        );
        assert_eq!(
            data("DATA:text/plain,a%20b"),
            Ok(Target::Data(b"a b".to_vec()))
        );
        assert!(data("data:;base64").is_err());
    }

    #[test]
    fn files_are_beside_the_gltf() {
        let file = |uri| resolve(Path::new("a/b.gltf"), uri);
        assert_eq!(file("c%20d.bin"), Ok(Target::File("a/c d.bin".into())));
        assert_eq!(
            file("../x/100%.bin"),
            Ok(Target::File("a/../x/100%.bin".into()))
        );
        assert!(file("https://example.com/x.bin").is_err_and(|e| e.contains("https")));
    }
}
