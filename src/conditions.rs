//! What reports say of the conditions that their figures were measured under.
use crate::view::View;
use gibs_graph::Backend;
use gibs_passes::frame::Settings;
use gibs_passes::scene::Environment;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// A view as in a view file. Of a map of the sky, whose texels no report holds, it says that there was one.
pub(crate) fn view_value(view: &View) -> Value {
    let parsed = |view: &View| {
        let text = view.to_json().ok()?;
        serde_json::from_str::<Value>(&text).ok()
    };
    parsed(view)
        .or_else(|| {
            let constant = View {
                environment: Environment::Constant(glam::Vec3::ZERO),
                ..view.clone()
            };
            let mut value = parsed(&constant)?;
            let view = value.as_object_mut()?;
            view.remove("sky_radiance_rgb");
            view.insert("environment".into(), "a map".into());
            Some(value)
        })
        .unwrap_or_default()
}

/// What was rendered.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Subject {
    /// Version of the program.
    pub version: &'static str,
    /// The scene, as it was asked for.
    pub scene: String,
    /// How it is seen, as in a view file.
    pub view: Value,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Every setting.
    pub settings: BTreeMap<String, Value>,
}

/// What rendered it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Renders {
    /// Backend.
    pub backend: String,
    /// Device behind it.
    pub device: String,
    /// Its driver and version.
    pub driver: String,
}

impl Subject {
    pub fn new(scene: &str, view: &View, size: [u32; 2], settings: &Settings) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            scene: scene.into(),
            view: view_value(view),
            size,
            settings: settings_map(settings),
        }
    }
}

impl Renders {
    pub fn with(backend: &dyn Backend) -> Self {
        let device = backend.device();
        Self {
            backend: backend.name().into(),
            device: device.name.clone(),
            driver: device.driver.clone(),
        }
    }
}

/// Every setting with its value.
pub(crate) fn settings_map(settings: &Settings) -> BTreeMap<String, Value> {
    match serde_json::to_value(settings) {
        Ok(Value::Object(map)) => map.into_iter().collect(),
        _ => BTreeMap::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;
    use gibs_passes::scene::EnvironmentMap;

    #[test]
    fn views_and_settings_are_told_in_the_words_of_their_files() {
        let (_, view) = builtin::by_name("cornell").expect("it is built in");
        let value = view_value(&view);
        let again = View::from_json(&value.to_string(), std::path::Path::new("v.json"));
        let again = again.expect("it is a view");
        assert_eq!(again.camera.position, view.camera.position);
        assert_eq!(again.resolution, view.resolution);
        let settings = settings_map(&Settings::default());
        for setting in Settings::all() {
            assert!(settings.contains_key(setting.name), "{}", setting.name);
        }
        assert_eq!(settings["rays"], Settings::default().rays);
    }

    #[test]
    fn a_map_of_the_sky_is_told_of() {
        let (_, view) = builtin::by_name("cornell").expect("it is built in");
        let map = EnvironmentMap {
            width: 2,
            height: 1,
            texels: vec![glam::Vec3::ONE; 2],
            rotation_y: 0.0,
        };
        let view = View {
            environment: Environment::Map(map),
            ..view
        };
        let value = view_value(&view);
        assert_eq!(value["environment"], "a map");
        assert!(value["camera"]["position"].is_array(), "{value}");
    }
}
