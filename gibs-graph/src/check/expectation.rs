//! Differences that are known of a device.
use super::report::{Lane, Report, Verdict};
use serde::{Deserialize, Serialize};

/// Differences that are known, device by device. One that is listed and does not come is an error as well: the list has to
/// say what is so.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectations {
    /// All of them.
    #[serde(default)]
    pub expected: Vec<Expectation>,
}

/// A difference that is known of a device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// Part of the device's name or its driver's, in any case; an empty one is of no device.
    pub device: String,
    /// Name of the participant, the whole of it; any where it is missing.
    pub backend: Option<String>,
    /// Type name of the stage.
    pub stage: String,
    /// Port; any that the stage writes where it is missing.
    pub port: Option<String>,
    /// Why this is so.
    pub reason: String,
}

impl Expectation {
    fn is_of(&self, lane: &Lane) -> bool {
        let device = self.device.to_lowercase();
        let names = [&lane.device.name, &lane.device.driver];
        let named = self
            .backend
            .as_ref()
            .is_none_or(|backend| lane.name == *backend);
        named
            && !device.trim().is_empty()
            && names
                .iter()
                .any(|name| name.to_lowercase().contains(&device))
    }

    fn names(&self, stage: &str, port: &str) -> bool {
        self.stage == stage && self.port.as_deref().is_none_or(|expected| expected == port)
    }
}

impl Expectations {
    /// Makes differences that are listed expected ones, and gives what is listed for a device that took part and did not
    /// come, where its stage ran.
    pub fn apply(&self, report: &mut Report) -> Vec<&Expectation> {
        let lanes = report.lanes.clone();
        let has = |expectation: &Expectation, name: &str| {
            lanes
                .iter()
                .any(|lane| lane.name == name && expectation.is_of(lane))
        };
        let mut came = vec![false; self.expected.len()];
        let mut ran = vec![false; self.expected.len()];
        for step in report.cases.iter_mut().flat_map(|case| &mut case.steps) {
            for port in &mut step.ports {
                for pair in &mut port.pairs {
                    for (i, expectation) in self.expected.iter().enumerate() {
                        let concerns = has(expectation, &pair.a) || has(expectation, &pair.b);
                        if !concerns || !expectation.names(&step.stage, &port.port) {
                            continue;
                        }
                        ran[i] = true;
                        if matches!(pair.verdict, Verdict::Differs | Verdict::Expected) {
                            came[i] = true;
                            pair.verdict = Verdict::Expected;
                        }
                    }
                }
            }
        }
        let listed = self.expected.iter().zip(ran.into_iter().zip(came));
        listed
            .filter(|(_, (ran, came))| *ran && !came)
            .map(|(expectation, _)| expectation)
            .collect()
    }
}
