//! The elements of the technique that can be switched off, and what switches them.
use super::Settings;

/// An element of the technique that can be switched on and off, to see what it gains and costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TechniqueElement {
    /// Name, as in `--without name`.
    pub name: &'static str,
    /// The setting that switches it.
    pub setting: &'static str,
    /// Its value where the element is off.
    pub off: &'static str,
    /// Its value where the element is on and nobody says how much of it.
    pub on: &'static str,
    /// What it is.
    pub about: &'static str,
}

const fn switch(
    name: &'static str,
    setting: &'static str,
    about: &'static str,
) -> TechniqueElement {
    TechniqueElement {
        name,
        setting,
        off: "off",
        on: "on",
        about,
    }
}

/// All of them.
pub const ELEMENTS: &[TechniqueElement] = &[
    switch("depth", "depth", "depth functions"),
    switch("guiding", "guiding", "ray guiding"),
    switch(
        "fallback",
        "fallback",
        "the cell's average where surfels do not cover",
    ),
    switch("sharing", "sharing", "irradiance shared between neighbours"),
    switch("sorting", "sorting", "ray sorting"),
    switch("steering", "steering", "ray counts by variance"),
    switch("emitters", "emitters", "rays to emitters"),
    TechniqueElement {
        name: "continuation",
        setting: "continuations",
        off: "0",
        on: "8",
        about: "paths that go on where no surfel is",
    },
    switch(
        "half-resolution",
        "half_resolution",
        "gap filling and apply at half resolution",
    ),
    switch("clamp", "clamp", "firefly clamp"),
    TechniqueElement {
        name: "hit-births",
        setting: "hit_births",
        off: "0",
        on: "256",
        about: "surfels born at hits",
    },
];

impl TechniqueElement {
    /// The element of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        ELEMENTS.iter().find(|element| element.name == name)
    }

    /// The settings with the element switched on or off.
    pub fn switched(&self, settings: &Settings, on: bool) -> Settings {
        let mut switched = settings.clone();
        let value = if on { self.on } else { self.off };
        // A test sets every value; none is out of range.
        let _ = switched.set(self.setting, value);
        switched
    }

    /// Whether the settings have it.
    pub fn is_on(&self, settings: &Settings) -> bool {
        self.switched(settings, false) != *settings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_element_can_be_switched_both_ways() {
        for element in ELEMENTS {
            assert_eq!(TechniqueElement::named(element.name), Some(element));
            for value in [element.on, element.off] {
                let mut settings = Settings::default();
                assert_eq!(settings.set(element.setting, value), Ok(()), "{element:?}");
            }
            let settings = Settings::default();
            for on in [true, false] {
                let switched = element.switched(&settings, on);
                assert_eq!(element.is_on(&switched), on, "{element:?}");
                if element.is_on(&settings) == on {
                    assert_eq!(switched, settings, "{element:?}: `on` is not the default");
                }
            }
        }
        assert_eq!(TechniqueElement::named("gravity"), None);
    }
}
