use super::color::{from_opponent, hunt_lab, to_opponent};
use super::*;
use crate::picture::srgb_to_linear;

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

type Planes = [Vec<f32>; 3];

/// A picture from 8-bit sRGB codes.
fn picture(codes: impl Fn(usize, usize) -> [u8; 3]) -> Planes {
    [0, 1, 2].map(|c| {
        let pixels = (0..WIDTH * HEIGHT).map(|i| codes(i % WIDTH, i / WIDTH)[c]);
        pixels
            .map(|code| srgb_to_linear(f32::from(code) / 255.0))
            .collect()
    })
}

fn flip_map(reference: &Planes, test: &Planes) -> Vec<f32> {
    let [reference, test] = [reference, test].map(|p| p.each_ref().map(Vec::as_slice));
    flip(reference, test, WIDTH, PIXELS_PER_DEGREE)
}

fn mean(map: &[f32]) -> f64 {
    map.iter().copied().map(f64::from).sum::<f64>() / map.len() as f64
}

fn pattern(x: usize, y: usize) -> [u8; 3] {
    [(x * 4) as u8, (y * 5) as u8, 128]
}

#[test]
fn equal_pictures_do_not_differ() {
    let p = picture(pattern);
    assert!(flip_map(&p, &p).iter().all(|&d| d == 0.0));
}

#[test]
fn the_difference_is_symmetric_and_bounded() {
    let p = picture(pattern);
    let q = picture(|x, y| {
        if (x / 5 + y / 7) % 2 == 0 {
            [255, 0, 0]
        } else {
            [0, 40, 255]
        }
    });
    let (there, back) = (flip_map(&p, &q), flip_map(&q, &p));
    assert_eq!(there, back);
    assert!(there.iter().all(|d| (0.0..=1.0).contains(d)));
}

#[test]
fn agrees_with_the_authors_program() {
    let plain = |color: [u8; 3]| picture(move |_, _| color);
    let edge = |at: usize| {
        picture(move |x, _| {
            if x < at {
                [40, 80, 120]
            } else {
                [200, 150, 60]
            }
        })
    };
    let dot = picture(|x, y| {
        if (x, y) == (32, 24) {
            [255; 3]
        } else {
            [128; 3]
        }
    });
    let brighter = picture(|x, y| pattern(x, y).map(|code| code.saturating_add(8)));
    let cases = [
        ("black and white", plain([0; 3]), plain([255; 3]), 0.967_392),
        (
            "green and blue",
            plain([0, 255, 0]),
            plain([0, 0, 255]),
            1.0,
        ),
        (
            "red and green",
            plain([255, 0, 0]),
            plain([0, 255, 0]),
            0.986_666,
        ),
        ("a dot", plain([128; 3]), dot, 0.001_400),
        ("an edge moved by a pixel", edge(32), edge(33), 0.049_924),
        (
            "a gradient and a brighter one",
            picture(pattern),
            brighter,
            0.176_325,
        ),
    ];
    for (name, reference, test, expected) in cases {
        let found = mean(&flip_map(&reference, &test));
        // Means over the map of the authors' C++ source (as the crate nv-flip 0.1.2 wraps it) at 67
        // pixels per degree, to six decimals. Other roundings of the colour matrix and another
        // order of sums leave up to 6e-6.
        assert!(
            (found - expected).abs() < 1e-5,
            "{name}: {found}, expected {expected}"
        );
    }
}

#[test]
fn fine_detail_counts_less_than_coarse() {
    let stripes = |period: usize| {
        let light = picture(move |x, _| {
            if (x / period).is_multiple_of(2) {
                [140; 3]
            } else {
                [116; 3]
            }
        });
        let dark = picture(move |x, _| {
            if (x / period).is_multiple_of(2) {
                [116; 3]
            } else {
                [140; 3]
            }
        });
        mean(&flip_map(&light, &dark))
    };
    // The colour term is what blurs: a period of 2 pixels is 33 cycles per degree.
    assert!(stripes(1) < stripes(16));
}

#[test]
fn planes_that_do_not_fit_give_nothing() {
    let (long, short) = ([0.5; 12], [0.5; 11]);
    assert!(flip([&long; 3], [&long, &long, &short], 4, 67.0).is_empty());
    assert!(flip([&long; 3], [&long; 3], 5, 67.0).is_empty());
    assert!(flip([&[]; 3], [&[]; 3], 0, 67.0).is_empty());
    assert_eq!(flip([&long; 3], [&long; 3], 4, 67.0).len(), 12);
}

#[test]
fn colours_convert_as_published() {
    // CIE L*a*b* of pure sRGB red under D65 is 53.24, 80.09, 67.20; Hunt's factor is 0.5324.
    let red = hunt_lab([1.0, 0.0, 0.0]);
    for (found, expected) in red.into_iter().zip([53.24, 80.09 * 0.5324, 67.20 * 0.5324]) {
        assert!((found - expected).abs() < 0.02, "{red:?}");
    }
    let white = hunt_lab([1.0; 3]);
    assert!(
        (white[0] - 100.0).abs() < 1e-3 && white[1].hypot(white[2]) < 1e-3,
        "{white:?}"
    );
    let color = [0.2, 0.7, 0.05];
    for (found, expected) in from_opponent(to_opponent(color)).into_iter().zip(color) {
        assert!((found - expected).abs() < 1e-5);
    }
}
