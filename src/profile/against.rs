//! Two profiles beside each other.
use super::{Figure, Interval, Profile, StageCost};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeSet;

/// A profile against an older one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// What the two were not alike in: of the program, the scene, the view, the settings, the measurement or the device.
    pub differences: Vec<String>,
    /// The frame as a whole.
    pub frame: Change,
    /// Each group, then each stage of the new profile, and then those that are gone.
    pub stages: Vec<Change>,
}

/// How something changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// What, as `group/stage`.
    pub name: String,
    /// Geometric mean of the runs' medians of before, milliseconds, or the median where one of those is zero; `None` where it was not there
    /// or not timed.
    pub before_ms: Option<f64>,
    /// That of now, milliseconds; `None` where it is not there or not timed.
    pub now_ms: Option<f64>,
    /// Now over before, where both are there and took some time in every run.
    pub ratio: Option<Interval>,
    /// What that says.
    pub verdict: Verdict,
}

/// Milliseconds below which times are not judged: of such, reading the clock is a part, and a ratio says nothing of a frame.
const NOTHING: f64 = 0.01;

/// What a change says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The interval of the ratio lies below 1.
    Faster,
    /// It lies above.
    Slower,
    /// It holds 1.
    Noise,
    /// There are too few runs to tell.
    Unknown,
    /// Both took next to nothing.
    TooShort,
    /// It took nothing in a run, so that there is no ratio.
    Nothing,
    /// One of the devices measures no time of it.
    NotTimed,
    /// It was not there before.
    New,
    /// It is not there now.
    Gone,
}

/// Compares two profiles, stage by stage.
pub fn compare(now: &Profile, before: &Profile) -> Comparison {
    let mut differences = Vec::new();
    let mut differ = |what: &str, before: String, now: String| {
        if before != now {
            differences.push(format!("{what}: {before} before, {now} now"));
        }
    };
    differ("version", before.version.clone(), now.version.clone());
    differ("scene", before.scene.clone(), now.scene.clone());
    differ("backend", before.backend.clone(), now.backend.clone());
    differ("device", before.device.clone(), now.device.clone());
    differ("driver", before.driver.clone(), now.driver.clone());
    let size = |profile: &Profile| profile.size.map(|side| side.to_string()).join("x");
    differ(
        "backend's notes",
        before.notes.join(", "),
        now.notes.join(", "),
    );
    differ("size", size(before), size(now));
    differ("seed", before.seed.to_string(), now.seed.to_string());
    differ("runs", before.runs.to_string(), now.runs.to_string());
    differ("frames", before.frames.to_string(), now.frames.to_string());
    let warm_up = |profile: &Profile| profile.warm_up.to_string();
    differ("frames to warm up", warm_up(before), warm_up(now));
    let told = |value: Option<&Value>| value.map_or_else(|| "absent".to_owned(), Value::to_string);
    let keys: BTreeSet<&String> = before.settings.keys().chain(now.settings.keys()).collect();
    for key in keys {
        let value = |profile: &Profile| told(profile.settings.get(key));
        differ(&format!("setting {key}"), value(before), value(now));
    }
    let views = [&before.view, &now.view].map(Value::as_object);
    let keys: BTreeSet<&String> = views
        .iter()
        .flatten()
        .flat_map(|view| view.keys())
        .collect();
    for key in keys {
        let [before, now] = views.map(|view| told(view.and_then(|view| view.get(key))));
        differ(&format!("view's {key}"), before, now);
    }
    let name = |stage: &StageCost| format!("{}/{}", stage.group, stage.cost.name);
    let costs = |profile: &Profile| -> Vec<(String, Option<Figure>)> {
        let groups = profile.groups.iter();
        let groups = groups.map(|group| (group.name.clone(), group.ms.clone()));
        let stages = profile.stages.iter();
        let stages = stages.map(|stage| (name(stage), stage.cost.ms.clone()));
        groups.chain(stages).collect()
    };
    let (new, old) = (costs(now), costs(before));
    let find = |all: &[(String, Option<Figure>)], name: &str| {
        let found = all.iter().find(|(known, _)| known == name);
        found.map(|(_, figure)| figure.clone())
    };
    let here = new
        .iter()
        .map(|(name, figure)| Change::of(name, Some(figure.clone()), find(&old, name)));
    let gone = old.iter().filter(|(name, _)| find(&new, name).is_none());
    let gone = gone.map(|(name, figure)| Change::of(name, None, Some(figure.clone())));
    Comparison {
        differences,
        frame: Change::of(
            "frame",
            Some(Some(now.frame.wall_ms.clone())),
            Some(Some(before.frame.wall_ms.clone())),
        ),
        stages: here.chain(gone).collect(),
    }
}

impl Change {
    /// Of figures that are there or not, and timed or not.
    fn of(name: &str, now: Option<Option<Figure>>, before: Option<Option<Figure>>) -> Self {
        let ratio = match (&now, &before) {
            (Some(Some(now)), Some(Some(before))) if now.took_time() && before.took_time() => {
                Some(Interval::of_samples(&now.of_runs, &before.of_runs))
            }
            _ => None,
        };
        let short = |figure: &Figure| figure.median < NOTHING;
        let verdict = match (&now, &before, ratio.and_then(|ratio| ratio.bounds)) {
            (None, ..) => Verdict::Gone,
            (_, None, _) => Verdict::New,
            (Some(None), ..) | (_, Some(None), _) => Verdict::NotTimed,
            (Some(Some(now)), Some(Some(before)), _) if short(now) && short(before) => {
                Verdict::TooShort
            }
            (.., None) if ratio.is_none() => Verdict::Nothing,
            (.., None) => Verdict::Unknown,
            (.., Some([_, high])) if high < 1.0 => Verdict::Faster,
            (.., Some([low, _])) if low > 1.0 => Verdict::Slower,
            _ => Verdict::Noise,
        };
        let mean = |figure: Option<Option<Figure>>| figure.flatten().map(|f| f.mean_of_runs());
        Self {
            name: name.into(),
            before_ms: mean(before),
            now_ms: mean(now),
            ratio,
            verdict,
        }
    }
}
