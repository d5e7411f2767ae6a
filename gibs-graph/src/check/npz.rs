//! NumPy's `.npz`: a zip archive of arrays, which `numpy.load` opens.
use crate::{Layout, Scalar};
use npyz::{DType, Field, NpyHeader, Order};
use std::io::{self, Read, Seek, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// What NumPy calls the type of an element, and how many of it along further axes an element has.
fn dtype(element: &Layout) -> (DType, Vec<u64>) {
    match element {
        Layout::Scalar(scalar) => (DType::new_scalar(number(*scalar)), Vec::new()),
        Layout::Vector(scalar, n) => (DType::new_scalar(number(*scalar)), vec![u64::from(*n)]),
        Layout::Array { element, count, .. } => {
            let (inner, mut axes) = dtype(element);
            axes.insert(0, u64::from(*count));
            (inner, axes)
        }
        Layout::Struct { fields, .. } => {
            let fields = fields.iter().map(|field| {
                let (inner, axes) = dtype(&field.layout);
                let nested = axes
                    .into_iter()
                    .rev()
                    .fold(inner, |inner, n| DType::Array(n, Box::new(inner)));
                Field {
                    name: field.name.clone(),
                    dtype: nested,
                }
            });
            (DType::Record(fields.collect()), Vec::new())
        }
    }
}

#[expect(
    clippy::expect_used,
    reason = "the three names are valid, as a test says"
)]
fn number(scalar: Scalar) -> npyz::TypeStr {
    let name = match scalar {
        Scalar::F32 => "<f4",
        Scalar::U32 => "<u4",
        Scalar::I32 => "<i4",
    };
    name.parse().expect("a type of NumPy")
}

/// Magic number and version 1.0.
const MAGIC: &[u8; 8] = b"\x93NUMPY\x01\x00";

/// The header of a file of `len` elements, padded so that the data begins at a multiple of 64.
fn header(element: &Layout, len: u64) -> Vec<u8> {
    let (dtype, axes) = dtype(element);
    let mut shape = format!("{len},");
    for axis in axes {
        shape += &format!(" {axis},");
    }
    let descr = dtype.descr();
    let mut text = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': ({shape}), }}");
    let unpadded = MAGIC.len() + 2 + text.len() + 1;
    text.extend(std::iter::repeat_n(
        ' ',
        unpadded.next_multiple_of(64) - unpadded,
    ));
    text.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

/// How deep brackets of a header may nest: a struct takes two levels, its arrays one, the header itself one.
const MOST_NESTING: usize = 16;

/// Refuses a header that the parser of Python's literals is no match for: it allocates what a header says that it is long
/// before it reads it, calls itself for every bracket, and tries the content of one several times, a dictionary's most
/// often.
fn check_header(file: &[u8]) -> Result<(), String> {
    let word = |at: usize, n: usize| {
        let bytes = file.get(at..at + n)?;
        Some((bytes.iter().rev()).fold(0_usize, |word, &byte| word << 8 | usize::from(byte)))
    };
    let (start, length) = match file.get(6) {
        Some(1) => (10, word(8, 2)),
        _ => (12, word(8, 4)),
    };
    let end = length.and_then(|length| length.checked_add(start));
    let Some(text) = end.and_then(|end| file.get(start..end)) else {
        return Err("its header is cut off".into());
    };
    let (mut depth, mut dictionaries) = (0_usize, 0);
    for byte in text {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            _ => {}
        }
        dictionaries += usize::from(*byte == b'{');
        if depth > MOST_NESTING || dictionaries > 1 {
            return Err("its header has brackets that no array needs".into());
        }
    }
    Ok(())
}

/// An archive that is being written.
pub(crate) struct Writer<W: Write + Seek>(ZipWriter<W>);

impl<W: Write + Seek> Writer<W> {
    pub fn new(to: W) -> Self {
        Self(ZipWriter::new(to))
    }

    /// Adds a file as it is.
    pub fn file(&mut self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
        self.0.start_file(name, options).map_err(io::Error::other)?;
        self.0.write_all(bytes)
    }

    /// Adds an array under `name` and `.npy`.
    pub fn array(&mut self, name: &str, element: &Layout, bytes: &[u8]) -> io::Result<()> {
        let len = bytes.len() as u64 / u64::from(element.size().max(1));
        let mut whole = header(element, len);
        whole.extend(bytes);
        self.file(&format!("{name}.npy"), &whole)
    }

    pub fn finish(self) -> io::Result<W> {
        self.0.finish().map_err(io::Error::other)
    }
}

/// An archive to read from.
pub(crate) struct Reader<R: Read + Seek>(ZipArchive<R>);

impl<R: Read + Seek> Reader<R> {
    pub fn new(from: R) -> Result<Self, String> {
        let mut archive = ZipArchive::new(from).map_err(|e| e.to_string())?;
        // Files that share bytes unpack to any multiple of the archive's size.
        match archive.has_overlapping_files() {
            Ok(false) => Ok(Self(archive)),
            Ok(true) => Err("some of its files are stored in the same place".into()),
            Err(e) => Err(e.to_string()),
        }
    }

    /// A file of at most so many bytes.
    pub fn file(&mut self, name: &str, most: u64) -> Result<Vec<u8>, String> {
        let file = self.0.by_name(name).map_err(|e| format!("`{name}`: {e}"))?;
        let mut bytes = Vec::new();
        let read = file.take(most.saturating_add(1)).read_to_end(&mut bytes);
        read.map_err(|e| format!("`{name}`: {e}"))?;
        match bytes.len() as u64 > most {
            true => Err(format!("`{name}` has more than {most} bytes")),
            false => Ok(bytes),
        }
    }

    /// The data of the array `name` and `.npy`, of `len` elements.
    pub fn array(&mut self, name: &str, element: &Layout, len: u64) -> Result<Vec<u8>, String> {
        let bytes = len
            .checked_mul(u64::from(element.size()))
            .ok_or_else(|| format!("`{name}` cannot have {len} elements"))?;
        // A header is as long as the type is: some kilobytes.
        let mut whole = self.file(&format!("{name}.npy"), bytes.saturating_add(1 << 16))?;
        let mut rest = whole.as_slice();
        check_header(rest).map_err(|problem| format!("`{name}`: {problem}"))?;
        let header = NpyHeader::from_reader(&mut rest).map_err(|e| format!("`{name}`: {e}"))?;
        let (dtype, axes) = dtype(element);
        let shape: Vec<u64> = std::iter::once(len).chain(axes).collect();
        if header.dtype() != dtype || header.shape() != shape {
            return Err(format!(
                "`{name}` is an array of {} and shape {:?} instead of {} and {shape:?}",
                header.dtype().descr(),
                header.shape(),
                dtype.descr(),
            ));
        }
        if header.order() != Order::C && shape.len() > 1 {
            return Err(format!("`{name}` is in Fortran order"));
        }
        let data = rest.len();
        if data as u64 != bytes {
            return Err(format!(
                "`{name}` has {data} bytes of data instead of {bytes}"
            ));
        }
        whole.drain(..whole.len() - data);
        Ok(whole)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Element;
    use bytemuck::cast_slice;
    use std::io::Cursor;

    crate::element! {
        /// What a test needs.
        pub struct Row {
            /// A vector.
            place: glam::Vec3,
            /// An integer.
            count: u32,
            /// A matrix.
            rows: [glam::Vec2; 2],
        }
    }

    /// The spelling is what NumPy itself writes for such a type, but for blanks.
    #[test]
    fn types_are_spelled_as_numpy_does() {
        let (found, axes) = dtype(&Row::layout());
        let plain = found.descr().replace(' ', "");
        assert_eq!(
            plain,
            "[('place','<f4',(3,)),('count','<u4'),('rows','<f4',(2,2,)),]"
        );
        assert!(axes.is_empty());
        let (found, axes) = dtype(&<[glam::Vec4; 3]>::layout());
        assert_eq!((found.descr().as_str(), axes), ("'<f4'", vec![3, 4]));
        assert_eq!(dtype(&i32::layout()).0.descr(), "'<i4'");
    }

    #[test]
    fn data_begins_at_a_multiple_of_64() {
        for element in [u32::layout(), Row::layout(), glam::Vec3::layout()] {
            for len in [0, 1, 12_345] {
                let header = header(&element, len);
                assert_eq!(header.len() % 64, 0);
                assert!(NpyHeader::from_reader(header.as_slice()).is_ok());
            }
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let rows = [Row {
            place: glam::Vec3::new(1.0, f32::NAN, -0.0),
            count: 7,
            rows: [glam::Vec2::ONE; 2],
        }; 3];
        let mut writer = Writer::new(Cursor::new(Vec::new()));
        writer
            .array("rows", &Row::layout(), cast_slice(&rows))
            .expect("memory takes it");
        let file = writer.finish().expect("memory takes it");
        let mut reader = Reader::new(file).expect("an archive");
        let bytes = reader
            .array("rows", &Row::layout(), 3)
            .expect("it is there");
        assert_eq!(bytes, cast_slice::<_, u8>(&rows));
        assert!(reader.array("rows", &Row::layout(), 4).is_err());
        assert!(reader.array("rows", &u32::layout(), 3).is_err());
        assert!(reader.array("others", &Row::layout(), 3).is_err());
    }
}
