//! Mutants against captures of the stages that they are mutants of.
use crate::equivalent::reason;
use crate::generate::Kernel;
use crate::twins::Twins;
use gibs::builtin;
use gibs::check::{Capture, Participant, Plan, cases, record, replay, verify};
use gibs::graph::{Action, Backend, StageInfo, WgslSource};
use gibs::passes::stages;
use gibs_shaders::Compiler;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

/// Captures of each kernel in each scene: those of different scenes and frames find what one alone would not.
const CAPTURES: usize = 16;

/// Frames that are captured: the first has no surfels to begin with; then lights change, the camera backs away, and surfels
/// have learned when lights change once more.
const FRAMES: [u32; 8] = [0, 2, 10, 14, 22, 30, 66, 76];

/// A kernel with the features of its bound ports, and what it has been captured doing.
pub struct Target {
    pub stage: StageInfo,
    pub features: Vec<&'static str>,
    pub kernel: Kernel,
    pub captures: Vec<Capture>,
}

/// What became of a mutant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Not a valid kernel, so that no program could contain it.
    Stillborn,
    /// Some output differed from the oracle's, or the device refused it.
    Caught,
    /// No capture showed a difference, but a twin test did.
    CaughtByTwins,
    /// Nothing showed a difference.
    Survived,
    /// Nothing showed a difference, and [`reason`] tells why nothing can.
    Equivalent,
    /// [`reason`] tells why nothing can show a difference, and something did.
    WronglyListed,
}

/// The scenes and their size: no number of elements is a multiple of a workgroup's, so that the last one is not full.
fn plan() -> Plan {
    Plan {
        size: [45, 27],
        surfels: 1000,
        rays: 4011,
        all: true,
        ..Plan::default()
    }
}

/// Every kernel that the cases of some scenes run, in the order of names, with captures by the oracle.
pub fn targets(
    oracle: &dyn Backend,
    scenes: &[&str],
) -> Result<Vec<Target>, Box<dyn std::error::Error>> {
    let scenes: Vec<_> = scenes
        .iter()
        .filter_map(|name| Some((*name, builtin::by_name(name)?)))
        .collect();
    let scenes: Vec<_> = scenes.iter().map(|(name, scene)| (*name, scene)).collect();
    let plan = Plan {
        frames: FRAMES.to_vec(),
        ..plan()
    };
    let mut found: BTreeMap<(&str, Vec<&str>), Vec<Capture>> = BTreeMap::new();
    let mut taken: BTreeMap<_, usize> = BTreeMap::new();
    for case in &mut cases(&scenes, &plan, oracle)? {
        let scene = case.name.split(',').next().unwrap_or_default().to_owned();
        let is_view = case.name.contains("debug view");
        for &frame in &case.frames.clone() {
            let schedule = case.schedule.clone();
            let mut here = BTreeSet::new();
            let captures = record(case, Participant::new(oracle), frame, |_, dispatch| {
                let kernel = (dispatch.stage, dispatch.features());
                // A stage that comes several times in a frame is taken once.
                if !here.insert(kernel.clone()) {
                    return false;
                }
                // Each debug view takes a way of its own through the stages that draw them, and no other of the rest.
                if is_view {
                    return dispatch.stage.starts_with("Debug");
                }
                let count = taken.entry((kernel, scene.clone())).or_default();
                *count += 1;
                *count <= CAPTURES
            })?;
            for capture in captures {
                let step = schedule
                    .steps
                    .iter()
                    .find(|step| step.label == capture.label);
                if let Some(Action::Dispatch(dispatch)) = step.map(|step| &step.action) {
                    let key = (dispatch.stage, dispatch.features());
                    found.entry(key).or_default().push(capture);
                }
            }
        }
    }
    let compiler = Compiler::new();
    let all = stages::all();
    let mut targets = Vec::new();
    for ((name, features), captures) in found {
        let Some(stage) = all.iter().find(|stage| stage.name == name) else {
            continue;
        };
        let bound = |port: &str| captures[0].bindings.iter().any(|b| b.port == port);
        let ports: Vec<_> = stage
            .ports
            .iter()
            .filter(|port| bound(port.name))
            .cloned()
            .collect();
        let compiled = compiler.compile(&stage.kernel.wgsl, &ports)?;
        targets.push(Target {
            kernel: Kernel::new(compiled.wgsl())?,
            stage: stage.clone(),
            features,
            captures,
        });
    }
    Ok(targets)
}

impl Target {
    /// Whether a kernel in place of the stage's own gives anything else than the oracle on any capture.
    pub fn differs(&self, text: &str, device: &dyn Backend) -> Result<(), String> {
        let mut stage = self.stage.clone();
        stage.kernel.wgsl = WgslSource {
            // A mutant is compiled a few times in one run of a tool that then ends.
            name: stage.kernel.wgsl.name,
            text: String::leak(text.to_owned()),
            modules: &[],
            features: &[],
        };
        let stages = [stage];
        for capture in &self.captures {
            let replayed = replay(capture, &stages, device, 1).map_err(|e| e.to_string())?;
            let expected = &capture.results[0].outputs;
            for (port, found) in verify(capture, &replayed.schedule, expected, &replayed.outputs) {
                if let (false, Some(worst)) = (found.refused.is_empty(), found.worst) {
                    let place = format!("{port}[{}]{}", worst.element, worst.field);
                    return Err(format!("{place}: {} and {}", worst.a, worst.b));
                }
            }
        }
        Ok(())
    }

    /// Runs one mutant: its description and what became of it.
    pub fn run(&self, index: usize, twins: &Twins, device: &dyn Backend) -> (String, Fate) {
        let Ok(mutant) = self.kernel.mutant(index) else {
            return (String::new(), Fate::Stillborn);
        };
        let fate = match self.differs(&mutant.text, device) {
            Err(_) => Fate::Caught,
            Ok(()) => {
                let (function, ordinal) = self.kernel.place_of(index);
                match twins.catch(&self.kernel, function, ordinal, device) {
                    true => Fate::CaughtByTwins,
                    false => Fate::Survived,
                }
            }
        };
        let listed = reason(&self.to_string(), &mutant.what).is_some();
        let fate = match (fate, listed) {
            (Fate::Survived, true) => Fate::Equivalent,
            (_, true) => Fate::WronglyListed,
            (fate, false) => fate,
        };
        (mutant.what, fate)
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.stage.kernel.wgsl.name)?;
        match self.features.is_empty() {
            true => Ok(()),
            false => write!(f, " with {}", self.features.join(", ")),
        }
    }
}

/// Which mutants to run: `most` of all targets' together, spread evenly over each kernel, at least two of each.
pub fn sample(targets: &[Target], most: usize) -> Vec<(usize, usize)> {
    let all: usize = targets.iter().map(|target| target.kernel.len()).sum();
    let mut chosen = Vec::new();
    for (i, target) in targets.iter().enumerate() {
        let count = target.kernel.len();
        let share = (count * most).div_ceil(all.max(1)).max(2).min(count);
        // One from each of as many stretches, where in it differs from one to the next.
        let at = |n: usize| n * count / share;
        chosen.extend((0..share).map(|n| {
            let stretch = at(n + 1) - at(n);
            (i, at(n) + hash(n + 7 * i) % stretch.max(1))
        }));
    }
    chosen
}

fn hash(n: usize) -> usize {
    (n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) as usize >> 33
}
