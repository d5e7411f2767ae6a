//! Bytes to and from the device.
use crate::stages::*;
use crate::support::{prepare, read, watched, words};
use gibs_graph::{BackendError, Dispatch, Graph, bytemuck};

fn doubling(len: u64) -> Graph {
    let mut g = Graph::new("doubling");
    let source = g.input("source", len);
    let target_ = g.transient("target", len);
    let inputs = double::Inputs {
        source: &source,
        target_,
    };
    let out = g.add::<double::Double>("double", inputs, Dispatch::Elements(len));
    g.output("target", &out.target_);
    g
}

#[test]
fn odd_ranges_and_overlaps() {
    watched(|backend| {
        let mut e = prepare(backend, doubling(8));
        let source = e.schedule().resource("source").unwrap();
        let mut expected = vec![0u8; 32];
        let pieces: [(usize, &[u8]); 6] = [
            (0, &[1; 32]),
            (3, &[2; 5]),
            (7, &[3; 1]),
            (4, &[4; 2]),
            (31, &[5]),
            (16, &[]),
        ];
        for (offset, bytes) in pieces {
            e.upload(source, offset as u64, bytes).unwrap();
            expected[offset..offset + bytes.len()].copy_from_slice(bytes);
        }
        assert_eq!(e.read(source).unwrap(), expected);
        e.run().unwrap();
        let doubled: Vec<u32> = words(&expected).iter().map(|n| n.wrapping_mul(2)).collect();
        assert_eq!(read(&mut *e, "target"), doubled);
    });
}

#[test]
fn out_of_range_is_refused() {
    watched(|backend| {
        let mut e = prepare(backend, doubling(8));
        let source = e.schedule().resource("source").unwrap();
        for (offset, len) in [(30, 4), (u64::MAX, 4)] {
            let error = e.upload(source, offset, &vec![0; len]).unwrap_err();
            assert!(matches!(error, BackendError::Range { .. }), "{error}");
        }
        for error in [
            e.upload(99, 0, &[0; 4]).unwrap_err(),
            e.read(99).unwrap_err(),
        ] {
            assert!(matches!(error, BackendError::Refused { .. }), "{error}");
        }
    });
}

/// More than all staging pages hold together, and more than is read back at once; neither is a multiple of the other.
#[test]
fn large_uploads_and_reads() {
    watched(|backend| {
        let len = (21 << 20) / 4 + 5;
        let mut e = prepare(backend, doubling(len));
        let source = e.schedule().resource("source").unwrap();
        for round in 0..2u32 {
            let numbers: Vec<u32> = (0..len as u32)
                .map(|i| i.wrapping_mul(2_654_435_761) + round)
                .collect();
            e.upload(source, 0, bytemuck::cast_slice(&numbers)).unwrap();
            e.run().unwrap();
            assert!(e.read(source).unwrap() == bytemuck::cast_slice::<u32, u8>(&numbers));
            let doubled: Vec<u32> = numbers.iter().map(|n| n.wrapping_mul(2)).collect();
            assert!(read(&mut *e, "target") == doubled);
        }
    });
}

/// Enough small uploads that pages fill up and are used again while frames are under way.
#[test]
fn many_small_uploads() {
    watched(|backend| {
        let len = 100_000;
        let mut e = prepare(backend, doubling(len));
        let source = e.schedule().resource("source").unwrap();
        let mut expected = vec![0u32; len as usize];
        for i in 0..600usize {
            let start = i * 7919 % (len as usize - 9000);
            let piece: Vec<u32> = (0..9000).map(|k| (i * 10_000 + k) as u32).collect();
            e.upload(source, 4 * start as u64, bytemuck::cast_slice(&piece))
                .unwrap();
            expected[start..start + 9000].copy_from_slice(&piece);
            if i % 3 == 0 {
                e.run().unwrap();
            }
        }
        assert!(read(&mut *e, "source") == expected);
    });
}
