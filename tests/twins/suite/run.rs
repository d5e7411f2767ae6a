//! Runs twins on a backend and compares what came out.
use super::declare::{Bound, Truth, Twin, floats};
use super::inputs::Draw;
use gibs_graph::{Backend, bytemuck};
use std::sync::Arc;

/// Cases of a twin that does not say how many.
pub const CASES: u32 = 1 << 15;

/// The cases of a twin, word by word.
pub fn cases(twin: &Twin) -> Vec<u32> {
    let mut words = Vec::with_capacity(twin.cases as usize * twin.words);
    for case in 0..twin.cases {
        (twin.draw)(&mut Draw::of(case), &mut words);
    }
    words
}

/// What a backend makes of cases.
///
/// # Panics
/// If it fails.
pub fn run(twin: &Twin, backend: &dyn Backend, cases: &[u32]) -> Vec<u32> {
    let fail =
        |e: &dyn std::fmt::Display| -> ! { panic!("{}, {}: {e}", twin.name, backend.name()) };
    let schedule = (twin.graph)(twin.cases).compile(None);
    let schedule = Arc::new(schedule.unwrap_or_else(|e| fail(&e)));
    let id = |key: &str| schedule.resource(key).expect("the graph has it");
    let mut run = backend
        .prepare(schedule.clone())
        .unwrap_or_else(|e| fail(&e));
    let mut upload = |key, bytes: &[u8]| {
        run.upload(id(key), 0, bytes).unwrap_or_else(|e| fail(&e));
    };
    upload("source", bytemuck::cast_slice(cases));
    for (key, bytes) in &twin.globals {
        upload(key, bytes);
    }
    run.run().unwrap_or_else(|e| fail(&e));
    let out = schedule.output("target").expect("the graph has it");
    bytemuck::pod_collect_to_vec(&run.read(out).unwrap_or_else(|e| fail(&e)))
}

/// How far apart two results are.
#[derive(Clone, Debug, Default)]
pub struct Difference {
    /// Results that differ.
    pub differ: u32,
    /// Largest distance between two floats, in steps from one to the next.
    pub steps: u64,
    /// Words that are no floats and differ.
    pub words: u32,
    /// Results that differ in the sign of a zero alone, which WGSL lets devices ignore.
    pub zeros: u32,
    /// The worst result, in words: what went in, what came out on the one side and on the other.
    pub worst: Option<[Vec<u32>; 3]>,
}

/// Steps from one float to another; both zeros are one. What is not a number is as far as can be from any number.
pub fn steps(a: u32, b: u32) -> u64 {
    let place = |bits: u32| {
        let magnitude = i64::from(bits & 0x7fff_ffff);
        if bits >> 31 == 0 {
            magnitude
        } else {
            -magnitude
        }
    };
    let is_nan = |bits| f32::from_bits(bits).is_nan();
    match (is_nan(a), is_nan(b)) {
        (true, true) => 0,
        (false, false) => place(a).abs_diff(place(b)),
        _ => u64::from(u32::MAX),
    }
}

/// Holds results against those of the Rust twin.
pub fn compare(twin: &Twin, cases: &[u32], expected: &[u32], got: &[u32]) -> Difference {
    let kinds = floats(&twin.out);
    let mut found = Difference::default();
    let mut most = 0;
    let results = expected.chunks(kinds.len()).zip(got.chunks(kinds.len()));
    for (case, (a, b)) in cases.chunks(twin.words).zip(results) {
        if a == b {
            continue;
        }
        let mut apart = 0;
        for ((&a, &b), &is_float) in a.iter().zip(b).zip(&kinds) {
            let d = if is_float {
                steps(a, b)
            } else {
                u64::from(a != b) << 32
            };
            if is_float {
                found.steps = found.steps.max(d);
            } else {
                found.words += u32::from(a != b);
            }
            apart = apart.max(d);
        }
        found.differ += u32::from(apart > 0);
        found.zeros += u32::from(apart == 0);
        if apart > most {
            most = apart;
            found.worst = Some([case.to_vec(), a.to_vec(), b.to_vec()]);
        }
    }
    found
}

impl Difference {
    /// Whether it is within the bound, on a device that rounds as the standard for floats says or on another one.
    pub fn fits(&self, bound: &Bound, rounds: bool) -> bool {
        let most = if rounds {
            Some(bound.steps)
        } else {
            bound.elsewhere
        };
        most.is_none_or(|most| self.steps <= most && self.words == 0)
    }

    /// The worst case, for messages.
    pub fn example(&self, twin: &Twin) -> String {
        let Some([case, expected, got]) = &self.worst else {
            return "no case differs".into();
        };
        let kinds = floats(&twin.out);
        let shown = |words: &[u32]| {
            let word = |(&w, &is_float): (&u32, &bool)| match is_float {
                true => format!("{:e}", f32::from_bits(w)),
                false => format!("{w:#x}"),
            };
            words
                .iter()
                .zip(&kinds)
                .map(word)
                .collect::<Vec<_>>()
                .join(", ")
        };
        let case = case
            .iter()
            .map(|&w| format!("{w:#x} ({:e})", f32::from_bits(w)));
        format!(
            "of [{}] Rust makes [{}], the device [{}]",
            case.collect::<Vec<_>>().join(", "),
            shown(expected),
            shown(got)
        )
    }
}

/// Largest error of each of the results against what is right, in units of the last place of that.
pub fn errors(truth: &Truth, twin: &Twin, cases: &[u32], got: &[u32]) -> Vec<f64> {
    let mut most = vec![0.0f64; truth.what.len()];
    for (case, got) in cases.chunks(twin.words).zip(got.chunks(truth.what.len())) {
        for ((right, &bits), most) in (truth.of)(case).into_iter().zip(got).zip(&mut most) {
            let near = (right as f32).abs();
            let unit = f64::from(near.next_up()) - f64::from(near);
            *most = most.max((f64::from(f32::from_bits(bits)) - right).abs() / unit);
        }
    }
    most
}

/// Whether a backend's device rounds each of `+ - * / sqrt` correctly, keeps what is subnormal and fuses nothing.
pub fn rounds(backend: &dyn Backend, oracle: &dyn Backend) -> bool {
    super::numbers::operations().iter().all(|twin| {
        let cases = cases(twin);
        let expected = run(twin, oracle, &cases);
        compare(twin, &cases, &expected, &run(twin, backend, &cases)).steps == 0
    })
}
