use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use super::*;

/// A folder of its own for each test, removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("gibs-picture-{}-{number}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn awkward() -> Picture {
    let values = [
        -1.5,
        f32::MAX,
        f32::MIN,
        f32::from_bits(1),
        -0.0,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::from_bits(0x7fc0_1234),
    ];
    let mut picture = Picture::new(4, 2);
    picture
        .set_rgb("E", [values.to_vec(), vec![0.1; 8], vec![1e-20; 8]])
        .unwrap();
    picture
        .set_rgb(FINAL_IMAGE, [0.1, 0.2, 0.3].map(|v| vec![v; 8]))
        .unwrap();
    picture
        .set_xyz("normal", [-1.0, 0.0, 1.0].map(|v| vec![v; 8]))
        .unwrap();
    picture
        .set_scalar("mask.A", (0..8).map(|i| i as f32).collect())
        .unwrap();
    picture
}

fn bits(picture: &Picture) -> Vec<(String, Vec<u32>)> {
    let channels = picture.channels.iter();
    channels
        .map(|(name, values)| (name.clone(), values.iter().map(|v| v.to_bits()).collect()))
        .collect()
}

#[test]
fn exr_keeps_every_bit() {
    let folder = Folder::new();
    let path = folder.file("picture.exr");
    let picture = awkward();
    picture.write_exr(&path).unwrap();
    let back = Picture::read_exr(&path).unwrap();
    assert_eq!((back.width, back.height), (4, 2));
    // By bits: NaN is not equal to itself, and its payload and the sign of zero shall survive.
    assert_eq!(bits(&back), bits(&picture));
    assert_eq!(folder.names(), ["picture.exr"], "no temporary file is left");
}

#[test]
fn exr_spans_several_compressed_blocks() {
    let folder = Folder::new();
    let path = folder.file("picture.exr");
    // ZIP compresses 16 rows at a time; 37 rows make two whole blocks and a part.
    let mut picture = Picture::new(19, 37);
    let values = (0..19 * 37).map(|i| (i as f32 * 0.37).sin()).collect();
    picture.set_scalar("depth.Z", values).unwrap();
    picture.write_exr(&path).unwrap();
    assert_eq!(Picture::read_exr(&path).unwrap(), picture);
}

#[test]
fn exr_reads_half_floats_and_parts() {
    use exr::prelude::*;
    let folder = Folder::new();
    let path = folder.file("parts.exr");
    let part = |name: &str, value: f32| {
        let samples = FlatSamples::F16(vec![f16::from_f32(value); 6]);
        let channels = AnyChannels::sort(SmallVec::from_iter([AnyChannel::new("R", samples)]));
        let attributes = LayerAttributes::named(name);
        Layer::new((3, 2), attributes, Encoding::FAST_LOSSLESS, channels)
    };
    let window = IntegerBounds::from_dimensions((3, 2));
    let image = Image::from_layers(
        ImageAttributes::new(window),
        vec![part("E", 0.5), part("albedo", 0.25)],
    );
    image.write().to_file(&path).unwrap();
    let picture = Picture::read_exr(&path).unwrap();
    assert_eq!(picture.scalar("E.R").unwrap(), [0.5; 6]);
    assert_eq!(picture.scalar("albedo.R").unwrap(), [0.25; 6]);
}

#[test]
fn exr_with_a_shifted_data_window_is_refused() {
    use exr::prelude::*;
    let folder = Folder::new();
    let path = folder.file("window.exr");
    let samples = FlatSamples::F32(vec![1.0; 4]);
    let channels = AnyChannels::sort(SmallVec::from_iter([AnyChannel::new("R", samples)]));
    let attributes = LayerAttributes::default().with_position(Vec2(1, 0));
    let layer = Layer::new((2, 2), attributes, Encoding::FAST_LOSSLESS, channels);
    let window = IntegerBounds::from_dimensions((3, 2));
    let image = Image::new(ImageAttributes::new(window), SmallVec::from_iter([layer]));
    image.write().to_file(&path).unwrap();
    let error = Picture::read_exr(&path).unwrap_err();
    assert!(matches!(error, PictureError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains("data window"), "{error}");
}

#[test]
fn unreadable_files_are_told_apart() {
    let folder = Folder::new();
    let missing = Picture::read_exr(&folder.file("missing.exr")).unwrap_err();
    assert!(matches!(missing, PictureError::Missing { .. }), "{missing}");
    assert!(missing.to_string().contains("missing.exr"), "{missing}");

    let is_folder = Picture::read_exr(&folder.0).unwrap_err();
    assert!(
        matches!(is_folder, PictureError::Unreadable { .. }),
        "{is_folder}"
    );

    let path = folder.file("text.exr");
    for content in ["", "ve are no EXR"] {
        fs::write(&path, content).unwrap();
        let foreign = Picture::read_exr(&path).unwrap_err();
        assert!(matches!(foreign, PictureError::NotExr { .. }), "{foreign}");
    }

    let whole = folder.file("whole.exr");
    awkward().write_exr(&whole).unwrap();
    let bytes = fs::read(&whole).unwrap();
    for length in [4, 8, 100, bytes.len() / 2, bytes.len() - 1] {
        fs::write(&path, &bytes[..length]).unwrap();
        let cut = Picture::read_exr(&path).unwrap_err();
        assert!(
            matches!(cut, PictureError::Damaged { .. }),
            "{length} bytes: {cut}"
        );
    }
}

#[test]
fn a_header_cannot_ask_for_endless_memory() {
    let folder = Folder::new();
    let path = folder.file("huge.exr");
    awkward().write_exr(&path).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    // Both windows are stored as four little-endian i32 after their type name and size.
    for name in ["dataWindow\0box2i\0", "displayWindow\0box2i\0"] {
        let at = bytes
            .windows(name.len())
            .position(|w| w == name.as_bytes())
            .unwrap();
        let maximum = at + name.len() + 4 + 8;
        bytes[maximum..maximum + 4].copy_from_slice(&60_000_i32.to_le_bytes());
        bytes[maximum + 4..maximum + 8].copy_from_slice(&60_000_i32.to_le_bytes());
    }
    fs::write(&path, &bytes).unwrap();
    let error = Picture::read_exr(&path).unwrap_err();
    assert!(
        matches!(error, PictureError::TooLarge { width: 60_001, .. }),
        "{error}"
    );
}

#[test]
fn what_cannot_be_written_is_named() {
    let folder = Folder::new();
    let path = folder.file("picture.exr");
    let empty = Picture::new(0, 2).write_exr(&path).unwrap_err();
    assert!(matches!(empty, PictureError::Empty { .. }), "{empty}");

    for name in ["", "E.\u{3b1}", &"x".repeat(256)] {
        let mut picture = Picture::new(1, 1);
        picture.set_scalar(name, vec![1.0]).unwrap();
        let error = picture.write_exr(&path).unwrap_err();
        assert!(matches!(error, PictureError::ChannelName { .. }), "{error}");
    }

    let mut short = awkward();
    short.channels.insert("late.A".to_owned(), vec![0.0; 3]);
    let error = short.write_exr(&path).unwrap_err();
    assert!(
        matches!(
            error,
            PictureError::ChannelLength {
                found: 3,
                expected: 8,
                ..
            }
        ),
        "{error}"
    );
    assert!(folder.names().is_empty());
}

#[test]
fn missing_channels_list_those_present() {
    let picture = awkward();
    let error = picture.rgb("indirect").unwrap_err().to_string();
    assert!(error.contains("indirect.R"), "{error}");
    for (name, _) in bits(&picture) {
        assert!(error.contains(&name), "{error} should list {name}");
    }
    assert_eq!(picture.rgb(FINAL_IMAGE).unwrap()[2][0], 0.3);
    assert_eq!(picture.xyz("normal").unwrap()[0][0], -1.0);
    assert_eq!(picture.rgb_layers(), [FINAL_IMAGE, "E"]);
}

#[test]
fn set_rgb_changes_all_or_nothing() {
    let mut picture = Picture::new(2, 1);
    let error = picture
        .set_rgb("E", [vec![1.0; 2], vec![1.0; 2], vec![1.0; 3]])
        .unwrap_err();
    assert!(
        matches!(error, PictureError::ChannelLength { .. }),
        "{error}"
    );
    assert!(picture.channels.is_empty());
}

#[test]
fn extensions_choose_the_format() {
    let folder = Folder::new();
    let picture = awkward();
    picture.write(&folder.file("a.EXR"), 1.0).unwrap();
    picture.write(&folder.file("a.png"), 1.0).unwrap();
    assert!(Picture::read_exr(&folder.file("a.EXR")).is_ok());
    let png = image::open(folder.file("a.png")).unwrap().into_rgb8();
    // The final image is preferred: sRGB codes of 0.1, 0.2 and 0.3.
    assert_eq!(png.get_pixel(0, 0).0, [89, 124, 149]);
    for name in ["a.tiff", "a"] {
        let error = picture.write(&folder.file(name), 1.0).unwrap_err();
        assert!(
            matches!(error, PictureError::UnknownExtension { .. }),
            "{error}"
        );
    }
}

#[test]
fn writing_replaces_whole_files_only() {
    let folder = Folder::new();
    let path = folder.file("out.json");
    replace_file(&path, b"old").unwrap();
    replace_file(&path, b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"new");
    ensure_writable(&path).unwrap();
    ensure_writable(&folder.file("other.json")).unwrap();
    assert_eq!(folder.names(), ["out.json"], "nothing else is left");

    let nowhere = folder.file("missing/out.json");
    for result in [replace_file(&nowhere, b""), ensure_writable(&nowhere)] {
        let error = result.unwrap_err();
        assert!(matches!(error, WriteError::NoFolder { .. }), "{error}");
    }
    let error = replace_file(&folder.0, b"").unwrap_err();
    assert!(matches!(error, WriteError::NotAFile { .. }), "{error}");
}

#[cfg(unix)]
#[test]
fn symbolic_links_stay() {
    let folder = Folder::new();
    let (target, link) = (folder.file("target"), folder.file("link"));
    fs::write(&target, "old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    replace_file(&link, b"new").unwrap();
    assert_eq!(fs::read(&target).unwrap(), b"new");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
}

#[test]
fn srgb_curve_has_the_standard_values() {
    // IEC 61966-2-1; 0.5 is 187.516 of 255 and 0.18 is 117.6 of 255.
    for (linear, code) in [
        (0.0, 0.0),
        (1.0, 1.0),
        (0.5, 0.735_357),
        (0.18, 0.461_356),
        (0.002, 0.02584),
    ] {
        assert!((linear_to_srgb(linear) - code).abs() < 1e-5, "{linear}");
    }
    for code in (0..=255).map(|c| c as f32 / 255.0) {
        // Far below half an 8-bit step, so that codes survive the round trip.
        assert!(
            (linear_to_srgb(srgb_to_linear(code)) - code).abs() < 1e-5,
            "{code}"
        );
    }
}

#[test]
fn previews_expose_clamp_and_mark() {
    let plane = [0.25, 4.0, -1.0, f32::NAN, f32::MAX];
    let image = tone_map(5, 1, [&plane; 3], 2.0);
    let row: Vec<[u8; 3]> = image.pixels().map(|p| p.0).collect();
    assert_eq!(
        row,
        [[188; 3], [255; 3], [0; 3], NON_FINITE_COLOR, [255; 3]]
    );
}

#[test]
fn heat_maps_rise_and_mark() {
    let light = |t: f32| luminance(inferno(t).map(|c| srgb_to_linear(f32::from(c) / 255.0)));
    for step in 0..100 {
        let [dark, bright] = [step, step + 1].map(|s| light(s as f32 / 100.0));
        assert!(bright > dark, "step {step}");
    }
    let values = [0.0, -0.5, 2.0, f32::INFINITY, 0.0];
    let image = heat_map(5, 1, &values, 1.0, |i| i != 4);
    let row: Vec<[u8; 3]> = image.pixels().map(|p| p.0).collect();
    assert_eq!(
        row,
        [
            inferno(0.0),
            inferno(0.5),
            inferno(1.0),
            NON_FINITE_COLOR,
            OUTSIDE_COLOR
        ]
    );
    assert_eq!(inferno(f32::NAN), inferno(0.0));
}
