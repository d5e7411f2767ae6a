//! Functions that the invocations of a workgroup call together: through the stages that do little else.
use super::declare::{EXACT, ROUNDED, Twin};
use super::inputs::Draw;
use gibs_graph::{Dispatch, DispatchArgs, Element, Graph, bytemuck};
use gibs_passes::data::Drift;
use gibs_passes::shared::batch;
use gibs_passes::shared::scan::exclusive_scan;
use gibs_passes::stages::count_paths::{self, CountPaths, PATHS_PER_WORD};
use gibs_passes::stages::drift_total::{DriftTotal, Inputs};

/// The prefix sum of all cases.
fn scan(cases: u32) -> Graph {
    let mut g = Graph::new("scan");
    let source = g.input::<u32>("source", u64::from(cases));
    let (scanned, total) = exclusive_scan(&mut g, "scan", &source);
    g.output("target", &scanned);
    g.output("total", &total);
    g
}

/// The sum of all cases.
fn drift(cases: u32) -> Graph {
    let mut g = Graph::new("drift");
    let blocks = g.input::<Drift>("source", u64::from(cases));
    let total = g.transient("target", 1);
    let inputs = Inputs {
        blocks: &blocks,
        total,
    };
    let summed = g.add::<DriftTotal>("twin", inputs, Dispatch::Groups([1, 1, 1]));
    g.output("target", &summed.total);
    g
}

/// Words of paths: more than two blocks of 1024, and a part of one.
const WORDS: u32 = 2 * 1024 + 701;

/// The place of each path among those that go on, a bit of a word each.
fn paths(words: u32) -> Graph {
    let mut g = Graph::new("paths");
    let goes_on = g.input::<u32>("source", u64::from(words));
    let batch = g.input::<DispatchArgs>("batch", 1);
    let before = g.transient("target", u64::from(words));
    let next = g.transient("next", 1);
    let inputs = count_paths::Inputs {
        batch: &batch,
        goes_on: &goes_on,
        before,
        next,
    };
    let counted = g.add::<CountPaths>("twin", inputs, Dispatch::Groups([1, 1, 1]));
    g.output("target", &counted.before);
    g.output("next", &counted.next);
    g
}

fn draw_drift(d: &mut Draw, words: &mut Vec<u32>) {
    let drift = Drift {
        sum: d.number(-10, 10),
        noise: d.number(-10, 10).abs(),
        level: d.number(-10, 10).abs(),
        pad: 0,
    };
    words.extend_from_slice(bytemuck::cast_slice(bytemuck::bytes_of(&drift)));
}

/// All of this family.
pub fn all() -> Vec<Twin> {
    let scanned = Twin {
        name: "prefix_sum",
        of: &["workgroup_scan::workgroup_scan_exclusive"],
        out: u32::layout(),
        // More blocks of 1024 than one workgroup takes at once, and a part of one.
        cases: 1024 * 1024 + 1500,
        words: 1,
        draw: |d, words| words.push(d.word()),
        graph: scan,
        globals: Vec::new(),
        bound: EXACT,
        truth: None,
    };
    let summed = Twin {
        name: "drift_sum",
        of: &["drift_sum::drift_sum_in_pairs"],
        out: Drift::layout(),
        cases: 5000,
        words: 4,
        draw: draw_drift,
        graph: drift,
        globals: Vec::new(),
        bound: ROUNDED,
        truth: None,
    };
    let counted = Twin {
        name: "paths_before",
        of: &["workgroup_scan::workgroup_scan_exclusive"],
        out: u32::layout(),
        cases: WORDS,
        words: 1,
        draw: |d, words| words.push(d.word()),
        graph: paths,
        globals: vec![(
            "batch",
            bytemuck::bytes_of(&batch::args(WORDS * PATHS_PER_WORD - 7)).to_vec(),
        )],
        bound: EXACT,
        truth: None,
    };
    vec![scanned, summed, counted]
}
