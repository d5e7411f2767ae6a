//! What is compared: the settings as they are, and with each element switched.
use gibs_passes::frame::{ELEMENTS, Settings, TechniqueElement};

/// Settings to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Configuration {
    /// A short name.
    pub name: String,
    /// What is different, in words.
    pub about: String,
    /// The element of the technique that is switched, if it is one.
    pub element: Option<&'static str>,
    /// The settings.
    pub settings: Settings,
}

/// The settings as they are; with each of `elements` off, or on where it is off; and with a quarter and four times the rays.
pub fn configurations(
    settings: &Settings,
    elements: &[&'static TechniqueElement],
) -> Vec<Configuration> {
    let own = match *settings == Settings::default() {
        true => ("defaults", "the default settings"),
        false => ("as set", "the settings given"),
    };
    let mut all = vec![Configuration {
        name: own.0.into(),
        about: own.1.into(),
        element: None,
        settings: settings.clone(),
    }];
    all.extend(elements.iter().map(|element| {
        let on = element.is_on(settings);
        let word = if on { "without" } else { "with" };
        Configuration {
            name: format!("{word} {}", element.name),
            about: format!("{word} {}", element.about),
            element: Some(element.name),
            settings: element.switched(settings, !on),
        }
    }));
    let most = Settings::all().into_iter().find(|info| info.name == "rays");
    let most = most.map_or(u32::MAX, |info| info.most as u32);
    let more = match settings.rays.saturating_mul(4) {
        more if more <= most => ("4 x the rays", more),
        _ => ("the most rays", most),
    };
    let budgets = [("1/4 of the rays", settings.rays / 4), more];
    // Of the most there are no more, and of few no quarter.
    let others = budgets
        .into_iter()
        .filter(|(_, rays)| *rays != settings.rays && *rays > 0);
    all.extend(others.map(|(name, rays)| Configuration {
        name: name.into(),
        about: format!("{rays} rays a frame at most"),
        element: None,
        settings: Settings {
            rays,
            ..settings.clone()
        },
    }));
    all
}

impl Configuration {
    /// All elements of the technique, for [`configurations`].
    pub fn elements() -> Vec<&'static TechniqueElement> {
        ELEMENTS.iter().collect()
    }
}
