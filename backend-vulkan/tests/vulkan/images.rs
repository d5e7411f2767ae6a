//! Images that the backend makes itself.
use crate::stages::*;
use crate::support::{compile, prepare, read, watched, words};
use gibs_graph::{
    Backend, BackendError, Dispatch, Executable, Float, Graph, Rgba8Unorm, Rgba16Float,
    Rgba32Float, Stored, Uint, bytemuck,
};
use glam::Vec4;

const SIZES: [[u32; 2]; 4] = [[1, 1], [7, 3], [64, 33], [1, 300]];

fn texels([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// Values in and out of the range of bytes, some of which 16 bits cannot hold.
fn colors(count: u64, seed: u32) -> Vec<Vec4> {
    let number = |i: u64| (i as u32 ^ seed).wrapping_mul(2_654_435_761) as f32 / u32::MAX as f32;
    (0..count)
        .map(|i| {
            let all = [
                number(4 * i),
                number(4 * i + 1),
                3.0 * number(4 * i + 2),
                0.5,
            ];
            Vec4::from_array(all) - Vec4::new(0.0, 0.0, 1.0, 0.0)
        })
        .collect()
}

fn values(bytes: &[u8]) -> Vec<Vec4> {
    let values = bytes.as_chunks::<16>().0.iter();
    values.map(|b| bytemuck::pod_read_unaligned(b)).collect()
}

macro_rules! stored_graph {
    ($name:ident, $module:ident, $stage:ident, $texel:ty) => {
        pub fn $name(size: [u32; 2]) -> Graph {
            let mut g = Graph::new(stringify!($name));
            let source = g.import_image::<Float>("source", size);
            let target_ = g.export_image::<$texel>("target", size);
            let inputs = $module::Inputs {
                source: &source,
                target_,
            };
            let elements = Dispatch::Elements(texels(size));
            let out = g.add::<$module::$stage>("store", inputs, elements);
            g.output_image("target", &out.target_);
            g
        }
    };
}

stored_graph!(halves, half_texels, HalfTexels, Rgba16Float);
stored_graph!(fulls, full_texels, FullTexels, Rgba32Float);
stored_graph!(bytes, byte_texels, ByteTexels, Rgba8Unorm);

/// Runs a graph on values that change from frame to frame; gives what went in and came out of the last one.
fn pass(e: &mut dyn Executable, size: [u32; 2]) -> (Vec<Vec4>, Vec<Vec4>) {
    let [source, target] = ["source", "target"].map(|key| e.schedule().resource(key).unwrap());
    let mut colors_in = Vec::new();
    for frame in 0..3 {
        colors_in = colors(texels(size), frame);
        e.upload(source, 0, bytemuck::cast_slice(&colors_in))
            .unwrap();
        e.run().unwrap();
    }
    assert_eq!(values(&e.read(source).unwrap()), colors_in);
    (colors_in, values(&e.read(target).unwrap()))
}

/// The same number, but for how a device rounds what lies between two of the format.
fn assert_close(got: &[Vec4], expected: impl Iterator<Item = Vec4>, relative: f32, absolute: f32) {
    let expected: Vec<_> = expected.collect();
    assert_eq!(got.len(), expected.len());
    for (got, expected) in got.iter().zip(expected) {
        let most = expected.abs() * relative + Vec4::splat(absolute);
        assert!(
            (got - expected).abs().cmple(most).all(),
            "{got} instead of {expected}"
        );
    }
}

#[test]
fn texels_come_back_as_their_format_has_them() {
    watched(|backend| {
        for size in SIZES {
            let (colors, got) = pass(&mut *prepare(backend, fulls(size)), size);
            assert_eq!(got, colors);
            let (colors, got) = pass(&mut *prepare(backend, halves(size)), size);
            let expected = colors.iter().map(|c| Rgba16Float::rounded(*c));
            assert_close(&got, expected, 1.0 / 1024.0, 1e-7);
            let (colors, got) = pass(&mut *prepare(backend, bytes(size)), size);
            let expected = colors.iter().map(|c| Rgba8Unorm::rounded(*c));
            assert_close(&got, expected, 0.0, 1.001 / 255.0);
        }
    });
}

/// What a format holds exactly comes back exactly.
#[test]
fn exact_values_survive() {
    watched(|backend| {
        let size = [16, 16];
        let steps: Vec<Vec4> = (0..256).map(|i| Vec4::splat(i as f32 / 255.0)).collect();
        let halves_exactly: Vec<Vec4> = (0..256)
            .map(|i| Vec4::new(i as f32, -(i as f32) / 256.0, 65_504.0, 0.0))
            .collect();
        for (graph, colors) in [(bytes(size), &steps), (halves(size), &halves_exactly)] {
            let mut e = prepare(backend, graph);
            let [source, target] =
                ["source", "target"].map(|key| e.schedule().resource(key).unwrap());
            e.upload(source, 0, bytemuck::cast_slice(colors)).unwrap();
            e.run().unwrap();
            assert_eq!(values(&e.read(target).unwrap()), *colors);
        }
    });
}

fn ids(size: [u32; 2]) -> Graph {
    let mut g = Graph::new("ids");
    let source = g.import_image::<Uint>("source", size);
    let target_ = g.transient("target", texels(size));
    let inputs = texel_ids::Inputs {
        source: &source,
        target_,
    };
    let elements = Dispatch::Elements(texels(size));
    let out = g.add::<texel_ids::TexelIds>("load", inputs, elements);
    g.output("target", &out.target_);
    g
}

#[test]
fn integers_are_loaded_whole() {
    watched(|backend| {
        for size in SIZES {
            let mut e = prepare(backend, ids(size));
            e.run().unwrap();
            let zeros = vec![0; 4 * texels(size) as usize];
            assert_eq!(read(&mut *e, "target"), zeros, "at first");
            let numbers: Vec<u32> = (0..zeros.len() as u32)
                .map(|i| u32::MAX - i * 1_000_003)
                .collect();
            let source = e.schedule().resource("source").unwrap();
            e.upload(source, 0, bytemuck::cast_slice(&numbers)).unwrap();
            e.run().unwrap();
            assert_eq!(read(&mut *e, "target"), numbers);
            assert_eq!(words(&e.read(source).unwrap()), numbers);
        }
    });
}

/// More than a staging page holds, and more than is read back at once.
#[test]
fn large_images_go_in_pieces() {
    watched(|backend| {
        let size = [1001, 601];
        let (colors, got) = pass(&mut *prepare(backend, fulls(size)), size);
        assert!(got == colors);
    });
}

/// As on every backend.
#[test]
fn an_image_is_written_as_a_whole() {
    watched(|backend| {
        let mut e = prepare(backend, fulls([7, 5]));
        let source = e.schedule().resource("source").unwrap();
        let all = colors(35, 1);
        e.upload(source, 0, bytemuck::cast_slice(&all)).unwrap();
        for (offset, len) in [(0, 16), (16, 16), (0, 16 * 34), (0, 0)] {
            let error = e.upload(source, offset, &vec![0; len]).unwrap_err();
            let said = error.to_string();
            assert!(matches!(error, BackendError::Refused { .. }), "{said}");
            assert!(said.contains("`source`") && said.contains("560"), "{said}");
        }
        let error = e.upload(source, 16 * 30, &[0; 96]).unwrap_err();
        assert!(matches!(error, BackendError::Range { .. }), "{error}");
        assert_eq!(values(&e.read(source).unwrap()), all);
    });
}

/// An image is an input: what it holds carries over, if only the shape is the same.
#[test]
fn images_are_adopted() {
    watched(|backend| {
        let mut e = prepare(backend, fulls([7, 3]));
        let source = e.schedule().resource("source").unwrap();
        let colors = colors(21, 5);
        e.upload(source, 0, bytemuck::cast_slice(&colors)).unwrap();
        e.adopt(compile(bytes([7, 3]))).unwrap();
        assert_eq!(values(&e.read(source).unwrap()), colors);
        e.run().unwrap();
        e.adopt(compile(fulls([3, 7]))).unwrap();
        assert_eq!(values(&e.read(source).unwrap()), [Vec4::ZERO; 21]);
        e.run().unwrap();
    });
}

#[test]
fn an_image_beyond_the_limit_is_named() {
    watched(|backend| {
        let error = backend.prepare(compile(bytes([1, 1 << 24]))).err();
        let Some(BackendError::Limit { what, need, .. }) = &error else {
            panic!("{error:?}")
        };
        assert!(what.contains("`source`") && *need == 1 << 24, "{what}");
    });
}
