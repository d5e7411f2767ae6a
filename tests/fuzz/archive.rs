//! Archives taken apart and put together again, so that what is broken is within a member and not its checksum.
use std::io::{Cursor, Read, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Name and content of every member.
pub type Members = Vec<(String, Vec<u8>)>;

/// The members of an archive.
pub fn unpack(bytes: &[u8]) -> Members {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).expect("an archive");
    let len = archive.len();
    let content = |i: usize| {
        let mut member = archive.by_index(i).expect("it is there");
        let mut content = Vec::new();
        member.read_to_end(&mut content).expect("it is sound");
        let name = member.name().expect("plain names").into_owned();
        (name, content)
    };
    (0..len).map(content).collect()
}

/// An archive of these members; of two with one name, the first.
pub fn pack(members: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    for (name, content) in members {
        if writer.start_file(name, options).is_ok() {
            writer.write_all(content).expect("memory takes it");
        }
    }
    writer.finish().expect("memory takes it").into_inner()
}

/// The content of an array's file, behind its header.
pub fn data(npy: &[u8]) -> &[u8] {
    let length = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    &npy[10 + length..]
}

/// An array's file with another header text.
pub fn with_header(text: &str, data: &[u8]) -> Vec<u8> {
    let length = u16::try_from(text.len()).expect("a short header");
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    npy.extend(length.to_le_bytes());
    npy.extend(text.as_bytes());
    npy.extend(data);
    npy
}

/// An archive of these members, of which the first has another name as well.
pub fn shared(members: &[(String, Vec<u8>)]) -> Vec<u8> {
    let mut writer = ZipWriter::new_append(Cursor::new(pack(members))).expect("an archive");
    writer
        .shallow_copy_file(&members[0].0, "again")
        .expect("it is there");
    writer.finish().expect("memory takes it").into_inner()
}
