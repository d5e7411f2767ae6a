//! Reading a file through library and program, and judging what they answer.
use super::file::{BRIGHT, Doc, Folder};
use gibs::picture::Picture;
use std::path::Path;
use std::process::{Command, Output};

/// The program, with its answer.
pub fn gibs(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gibs"))
        .args(args)
        .output()
        .unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Arguments of a small render on the CPU.
fn render_args<'a>(scene: &'a str, size: &'a str, out: &'a str) -> [&'a str; 14] {
    [
        "render",
        scene,
        "--backend",
        "cpu",
        "--size",
        size,
        "--frames",
        "4",
        "--rays",
        "2000",
        "--set",
        "surfels=4096",
        "--out",
        out,
    ]
}

/// The file is refused by library and program alike; the message has its name and all `parts`, and says after a
/// semicolon or a comma what to do. The program writes no picture.
pub fn refused_file(path: &Path, parts: &[&str]) {
    refused_naming(path, path.file_name().unwrap().to_str().unwrap(), parts);
}

/// As [`refused_file`], but the message names another file.
pub fn refused_naming(path: &Path, name: &str, parts: &[&str]) {
    let text = match gibs::gltf_import::load(path) {
        Ok(_) => panic!("{name} with {parts:?} was accepted"),
        Err(error) => error.to_string(),
    };
    for part in parts.iter().chain(&[name, "; "]) {
        assert!(text.contains(part), "{part:?} is not in: {text}");
    }
    let out = path.with_file_name("refused.exr");
    let output = gibs(&render_args(
        path.to_str().unwrap(),
        "24x24",
        out.to_str().unwrap(),
    ));
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
    assert_eq!(stderr(&output), format!("error: {text}\n"));
    assert!(output.stdout.is_empty() && !out.exists(), "{text}");
}

/// As [`refused_file`], for a document.
pub fn refused(doc: &Doc, parts: &[&str]) {
    let folder = Folder::new();
    refused_file(&doc.write(&folder), parts);
}

/// What the program made of a file.
pub struct Drawn {
    /// What it warned of.
    pub warnings: Vec<String>,
    /// The picture; every number in it is finite.
    pub picture: Picture,
}

/// The program draws the file.
pub fn drawn_file(path: &Path, size: [u32; 2]) -> Drawn {
    let out = path.with_file_name("drawn.exr");
    let size_text = format!("{}x{}", size[0], size[1]);
    let output = gibs(&render_args(
        path.to_str().unwrap(),
        &size_text,
        out.to_str().unwrap(),
    ));
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let picture = Picture::read_exr(&out).unwrap();
    assert_eq!([picture.width, picture.height], size);
    for (name, values) in &picture.channels {
        assert!(values.iter().all(|v| v.is_finite()), "{name}");
    }
    let preview = image::image_dimensions(out.with_extension("png")).unwrap();
    assert_eq!(preview, size.into());
    let warnings = stderr(&output)
        .lines()
        .map(|line| {
            let warning = line.strip_prefix("warning: ");
            warning.unwrap_or_else(|| panic!("{line}")).to_owned()
        })
        .collect();
    Drawn { warnings, picture }
}

/// As [`drawn_file`], for a document, in 24x24 pixels.
pub fn drawn(doc: &Doc) -> Drawn {
    let folder = Folder::new();
    drawn_file(&doc.write(&folder), [24, 24])
}

impl Drawn {
    /// The warnings are these, in this order: each has all parts of its list.
    pub fn warns(self, expected: &[&[&str]]) -> Self {
        let found = &self.warnings;
        assert_eq!(found.len(), expected.len(), "{found:#?}");
        for (warning, parts) in found.iter().zip(expected) {
            for part in *parts {
                assert!(warning.contains(part), "{part:?} is not in: {warning}");
            }
        }
        self
    }

    /// Pixels that see a surface.
    pub fn seen(&self) -> usize {
        let mask = self.picture.scalar("mask.A").unwrap();
        mask.iter().filter(|&&m| m == 1.0).count()
    }

    /// Whether the pixel sees a surface.
    pub fn sees(&self, x: u32, y: u32) -> bool {
        self.picture.scalar("mask.A").unwrap()[(y * self.picture.width + x) as usize] == 1.0
    }

    /// A layer's red, green and blue at a pixel.
    pub fn color(&self, layer: &str, x: u32, y: u32) -> [f32; 3] {
        let planes = self.picture.rgb(layer).unwrap();
        planes.map(|plane| plane[(y * self.picture.width + x) as usize])
    }

    /// The whole square is there, as bright as it should be, and black around it.
    #[track_caller]
    pub fn is_the_square(&self) {
        assert_eq!(self.seen(), super::file::SQUARE_PIXELS);
        for [x, y] in [[4, 4], [19, 4], [12, 12], [4, 19], [19, 19]] {
            assert!(self.sees(x, y), "{x}, {y}");
            self.is_grey(x, y, BRIGHT);
        }
        self.is_grey(3, 12, 0.0);
        self.is_grey(20, 12, 0.0);
    }

    /// The picture has this grey at a pixel.
    #[track_caller]
    pub fn is_grey(&self, x: u32, y: u32, expected: f32) {
        let color = self.color("", x, y);
        let near = color.iter().all(|c| (c - expected).abs() <= 2e-3);
        assert!(near, "{color:?} at {x}, {y} instead of {expected}");
    }
}
