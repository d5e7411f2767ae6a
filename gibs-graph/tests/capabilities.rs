//! What a device allows, one limit after the other, lowered by one.
use gibs_graph::{
    Capabilities, Dispatch, Float, Graph, ImageFormat, Rgba8Unorm, Schedule, WgslSource, Workgroup,
    stage,
};

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

type Lower = fn(&mut Capabilities);

/// Exactly what the schedule needs.
fn enough() -> Capabilities {
    let mut enough = Capabilities::webgpu();
    enough.storage_binding = 400;
    enough.uniform_binding = 16;
    enough.buffer = 400;
    enough.memory = 872;
    enough.storage_buffers = 2;
    enough.uniform_buffers = 1;
    enough.sampled_images = 1;
    enough.stored_images = 1;
    enough.image_side = 4;
    enough.formats = vec![ImageFormat::Float, ImageFormat::Rgba8Unorm];
    enough.workgroup_size = [8, 4, 1];
    enough.workgroup_invocations = 32;
    enough.workgroups = [3, 2, 1];
    enough
}

#[test]
fn one_less_of_anything_is_named() {
    let schedule = schedule();
    enough().check("test", &schedule).unwrap();
    let cases: [(&str, Lower); 13] = [
        (
            "stage `group/small`, buffer `source` (bytes of a storage binding) needs 400",
            |l| l.storage_binding -= 1,
        ),
        (
            "stage `group/small`, buffer `size` (bytes of a uniform) needs 16",
            |l| l.uniform_binding -= 1,
        ),
        (
            "stage `group/small`, buffer `source` (bytes of a buffer) needs 400",
            |l| l.buffer -= 1,
        ),
        ("stage `group/small` (storage buffers) needs 2", |l| {
            l.storage_buffers -= 1
        }),
        ("stage `group/small` (uniform buffers) needs 1", |l| {
            l.uniform_buffers -= 1
        }),
        (
            "stage `group/small` (invocations per workgroup) needs 32",
            |l| l.workgroup_invocations -= 1,
        ),
        (
            "stage `group/small` (workgroup size along y) needs 4",
            |l| l.workgroup_size[1] -= 1,
        ),
        ("stage `group/small` (workgroups along x) needs 3", |l| {
            l.workgroups[0] -= 1
        }),
        ("stage `group/small` (sampled images) needs 1", |l| {
            l.sampled_images -= 1
        }),
        ("stage `group/small` (stored images) needs 1", |l| {
            l.stored_images -= 1
        }),
        (
            "stage `group/small`, image `seen` (texels along a side) needs 4",
            |l| l.image_side -= 1,
        ),
        (
            "stage `group/small`, image `shown`: the device `test` has no images of",
            |l| l.formats.truncate(1),
        ),
        ("graph `small` (bytes of memory in all) needs 872", |l| {
            l.memory -= 1
        }),
    ];
    for (expected, lower) in cases {
        let mut limits = enough();
        lower(&mut limits);
        let error = limits.check("test", &schedule).unwrap_err().to_string();
        assert!(
            error.contains(expected) && error.contains("`test`"),
            "{error}"
        );
    }
}

mod hosted {
    use gibs_graph::{Workgroup, stage};

    stage! {
        /// Has data for wide CPU kernels.
        pub stage Hosted {
            wgsl: gibs_graph::WgslSource { name: "hosted", text: "", modules: &[], features: &[] },
            workgroup: [64, 1, 1],
            ports: { host_only tree: [u32; 4], write target_: u32 },
            cpu: kernel,
            wide: None,
        }
    }

    fn kernel(_: &Views<'_>, _: Workgroup) {}
}

/// Nothing is allocated, so the numbers may be as large as they like.
#[test]
fn what_only_hosts_see_counts_where_it_is_kept() {
    let mut g = Graph::new("hosted");
    let tree = g.input("tree", 1 << 40);
    let target_ = g.transient("target", 1 << 10);
    let inputs = hosted::Inputs {
        tree: &tree,
        target_,
    };
    let out = g.add::<hosted::Hosted>("hosted", inputs, Dispatch::Elements(1 << 10));
    g.output("target", &out.target_);
    let schedule = g.compile(None).unwrap();
    let mut limits = Capabilities::unlimited();
    limits.memory = 4 << 10;
    limits.check("test", &schedule).unwrap();
    limits.host_data = true;
    let error = limits.check("test", &schedule).unwrap_err().to_string();
    let need = (16_u64 << 40) + (4 << 10);
    let want = format!("graph `hosted` (bytes of memory in all) needs {need}, ");
    assert!(error.starts_with(&want), "{error}");
    limits.memory = need;
    limits.check("test", &schedule).unwrap();
}
