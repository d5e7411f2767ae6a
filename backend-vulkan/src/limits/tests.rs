//! One limit after the other, lowered by one.
use super::*;
use gibs_graph::{Dispatch, Float, Graph, Rgba8Unorm, WgslSource, Workgroup, stage};

stage! {
    /// Two storage buffers, a uniform, and an image of either kind.
    pub stage Small {
        wgsl: WgslSource { name: "small", text: "", modules: &[], features: &[] },
        workgroup: [8, 4, 1],
        ports: {
            uniform size: [u32; 4], read source: u32, write target_: u32,
            sampled seen: Float, stored shown: Rgba8Unorm,
        },
        cpu: kernel,
        wide: None,
    }
}

fn kernel(_: &Views<'_>, _: Workgroup) {}

fn schedule() -> Schedule {
    let mut g = Graph::new("small");
    let size = g.input("size", 1);
    let source = g.input("source", 100);
    let target_ = g.transient("target", 50);
    let seen = g.import_image("seen", [3, 4]);
    let shown = g.export_image("shown", [2, 2]);
    let inputs = Inputs {
        size: &size,
        source: &source,
        target_,
        seen: &seen,
        shown,
    };
    let out = g.add::<Small>("group/small", inputs, Dispatch::Groups([3, 2, 1]));
    g.output("target", &out.target_);
    g.output_image("shown", &out.shown);
    g.compile(None).unwrap()
}

type Lower = fn(&mut Limits);

/// Exactly what the schedule needs.
fn enough() -> Limits {
    Limits {
        device: "test".into(),
        storage_range: 400,
        uniform_range: 16,
        buffer: 400,
        heap: 872,
        storage_buffers: 2,
        uniform_buffers: 1,
        sampled_images: 1,
        storage_images: 1,
        image_side: 4,
        formats: vec![ImageFormat::Float, ImageFormat::Rgba8Unorm],
        group_size: [8, 4, 1],
        group_lanes: 32,
        group_count: [3, 2, 1],
    }
}

#[test]
fn one_less_of_anything_is_named() {
    let schedule = schedule();
    enough().check(&schedule).unwrap();
    let cases: [(&str, Lower); 13] = [
        ("resource `source` (bytes) needs 400", |l| {
            l.storage_range -= 1
        }),
        ("resource `size` (bytes) needs 16", |l| l.uniform_range -= 1),
        ("resource `source` (bytes) needs 400", |l| l.buffer -= 1),
        ("stage `group/small` (storage buffers) needs 2", |l| {
            l.storage_buffers -= 1
        }),
        ("stage `group/small` (uniforms) needs 1", |l| {
            l.uniform_buffers -= 1
        }),
        (
            "stage `group/small` (invocations per workgroup) needs 32",
            |l| l.group_lanes -= 1,
        ),
        (
            "stage `group/small` (workgroup size along y) needs 4",
            |l| l.group_size[1] -= 1,
        ),
        ("stage `group/small` (workgroups along x) needs 3", |l| {
            l.group_count[0] -= 1
        }),
        ("stage `group/small` (sampled images) needs 1", |l| {
            l.sampled_images -= 1
        }),
        ("stage `group/small` (storage images) needs 1", |l| {
            l.storage_images -= 1
        }),
        ("image `seen` (height) needs 4", |l| l.image_side -= 1),
        ("image `shown`: the device `test` has no images of", |l| {
            l.formats.truncate(1)
        }),
        ("allocating 872 bytes for `small`", |l| l.heap -= 1),
    ];
    for (expected, lower) in cases {
        let mut limits = enough();
        lower(&mut limits);
        let error = limits.check(&schedule).unwrap_err().to_string();
        assert!(
            error.contains(expected) && error.contains("`test`"),
            "{error}"
        );
    }
}
