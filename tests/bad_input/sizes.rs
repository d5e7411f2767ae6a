//! Pictures of one pixel and of odd sizes, whose last tiles and workgroups are never full.
use super::file::{BRIGHT, Doc, Folder};
use super::run::{drawn_file, gibs, stderr};
use gibs::picture::Picture;

const SIZES: [[u32; 2]; 5] = [[1, 1], [7, 3], [17, 31], [1, 65], [129, 1]];

/// The square, seen so that no pixel's centre lies on its edge.
fn square() -> Doc {
    let mut doc = Doc::square();
    doc.at("/cameras/0/perspective")["yfov"] = (2.0 * (1.6f64 / 3.0).atan()).into();
    doc
}

/// The square covers the middle 1/1.6 of the height, and as many pixels of the width.
fn covers([width, height]: [u32; 2], x: u32, y: u32) -> bool {
    let half = f64::from(height) / 3.2;
    let within = |at: u32, size: u32| (f64::from(at) + 0.5 - f64::from(size) / 2.0).abs() < half;
    within(x, width) && within(y, height)
}

#[test]
fn renders_of_odd_sizes_have_every_pixel_right() {
    let folder = Folder::new();
    let path = square().write(&folder);
    for size in SIZES {
        let drawn = drawn_file(&path, size).warns(&[]);
        for y in 0..size[1] {
            for x in 0..size[0] {
                let inside = covers(size, x, y);
                assert_eq!(drawn.sees(x, y), inside, "{size:?} at {x}, {y}");
                drawn.is_grey(x, y, if inside { BRIGHT } else { 0.0 });
            }
        }
        assert!(drawn.seen() > 0, "{size:?}");
    }
}

/// A picture of any size can be judged, and has no error against itself.
#[test]
fn references_of_odd_sizes_can_be_compared() {
    let folder = Folder::new();
    let scene = square().write(&folder);
    let out = folder.0.join("truth.exr");
    let [scene, truth] = [&scene, &out].map(|path| path.to_str().unwrap());
    for size @ [width, height] in SIZES {
        let text = format!("{width}x{height}");
        let output = gibs(&[
            "reference",
            scene,
            "--backend",
            "cpu",
            "--size",
            &text,
            "--spp",
            "2",
            "--out",
            truth,
        ]);
        assert_eq!(output.status.code(), Some(0), "{text}: {}", stderr(&output));
        assert_eq!(stderr(&output), "", "{text}");
        let picture = Picture::read_exr(&out).unwrap();
        assert_eq!([picture.width, picture.height], size);
        let red = picture.scalar("R").unwrap();
        for (i, &red) in red.iter().enumerate() {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let expected = if covers(size, x, y) { BRIGHT } else { 0.0 };
            assert!((red - expected).abs() <= 2e-3, "{text}: {red} at {x}, {y}");
        }
        let output = gibs(&["compare", truth, truth, "--channel", "RGB", "--json"]);
        assert_eq!(output.status.code(), Some(0), "{text}: {}", stderr(&output));
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(report["metrics"]["rmse"], 0.0, "{text}: {report}");
    }
}
