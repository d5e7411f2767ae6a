//! Options that several commands share: the scene, the view, the settings.
use super::CommandError;
use super::output::warning;
use crate::renderer::MOST_PIXELS;
use crate::view::View;
use crate::{builtin, gltf_import};
use gibs_passes::frame::{ELEMENTS, Settings, TechniqueElement};
use gibs_passes::scene::Scene;
use std::path::{Path, PathBuf};

/// The scene and how it is seen.
#[derive(Clone, Debug, clap::Args)]
pub struct SceneArgs {
    /// A .gltf or .glb file, or a built-in scene
    #[arg(value_name = "SCENE")]
    pub scene: String,
    /// Camera, sun, sky and animation [default: the scene's own]
    #[arg(long, value_name = "V.json")]
    pub view: Option<PathBuf>,
    /// Size of the picture [default: the view's]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
}

pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    let Some(size) = parsed else {
        return Err("give width and height in pixels, such as 960x540".into());
    };
    match size.iter().all(|side| (1..=MOST_PIXELS).contains(side)) {
        true => Ok(size),
        false => Err(format!("each side takes 1 to {MOST_PIXELS} pixels")),
    }
}

/// A scene, how it is seen, and at what size.
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// Camera, light and pose.
    pub view: View,
    /// Width and height, pixels.
    pub size: [u32; 2],
}

impl SceneArgs {
    /// Loads what was asked for; warnings go to standard error.
    pub fn load(&self) -> Result<Loaded, CommandError> {
        let (scene, own_view) = match builtin::by_name(&self.scene) {
            Some((scene, view)) => (scene, Some(view)),
            None => {
                let path = Path::new(&self.scene);
                let is_scene = path.extension().is_some_and(|e| {
                    e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb")
                });
                if !is_scene && !path.exists() {
                    let names: Vec<_> = builtin::names().iter().map(|(name, _)| *name).collect();
                    return Err(CommandError::NoScene {
                        name: self.scene.clone(),
                        names: names.join(", "),
                    });
                }
                if path
                    .extension()
                    .is_some_and(|e| e.eq_ignore_ascii_case("json"))
                {
                    return Err(CommandError::Value {
                        option: "SCENE",
                        value: self.scene.clone(),
                        want: "a scene is a .gltf or .glb file; give a view with --view".into(),
                    });
                }
                let imported = gltf_import::load(path)?;
                for warning in &imported.warnings {
                    warning!("{warning}");
                }
                (imported.scene, None)
            }
        };
        let view = match (&self.view, own_view) {
            (Some(path), _) => View::load(path)?,
            (None, Some(view)) => view,
            (None, None) => View::framing(&scene),
        };
        for warning in &view.warnings {
            warning!("{warning}");
        }
        for (clip, _) in view
            .animation
            .iter()
            .filter(|(clip, _)| *clip >= scene.animations.len())
        {
            warning!(
                "the view poses clip {clip}, the scene has {}; it stays as it is",
                scene.animations.len()
            );
        }
        let size = self.size.unwrap_or(view.resolution);
        Ok(Loaded { scene, view, size })
    }
}

/// Settings of the surfel frame.
#[derive(Clone, Debug, clap::Args)]
pub struct SettingsArgs {
    /// Ray budget of a frame [default: 100000]
    #[arg(long, value_name = "N", value_parser = ray_budget)]
    pub rays: Option<u32>,
    #[command(flatten)]
    pub others: TechniqueArgs,
}

/// Settings of the surfel frame but for its ray budget.
#[derive(Clone, Debug, clap::Args)]
pub struct TechniqueArgs {
    /// Switch elements of the technique off
    #[arg(long, value_name = "ELEMENT,..", value_delimiter = ',')]
    pub without: Vec<String>,
    /// Change a setting; `gibs settings` lists them
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Settings file (TOML) with the same keys
    #[arg(long, value_name = "FILE")]
    pub settings: Option<PathBuf>,
}

/// A ray budget that the setting takes.
pub(super) fn ray_budget(text: &str) -> Result<u32, String> {
    let mut settings = Settings::default();
    settings.set("rays", text).map_err(|e| e.to_string())?;
    Ok(settings.rays)
}

impl SettingsArgs {
    /// The settings: defaults, then the file, then `--rays`, `--without` and `--set`.
    pub fn load(&self) -> Result<Settings, CommandError> {
        self.others.load(self.rays)
    }
}

impl TechniqueArgs {
    /// Whether `--set` changes a setting.
    pub fn sets(&self, name: &str) -> bool {
        let mut pairs = self.set.iter().filter_map(|text| pair(text));
        pairs.any(|(key, _)| key == name)
    }

    /// The settings: defaults, then the file, then `rays`, `--without` and `--set`.
    pub fn load(&self, rays: Option<u32>) -> Result<Settings, CommandError> {
        let mut settings = match &self.settings {
            None => Settings::default(),
            Some(path) => from_file(path).map_err(|message| CommandError::SettingsFile {
                path: path.clone(),
                message,
            })?,
        };
        if let Some(rays) = rays {
            settings.set("rays", &rays.to_string())?;
        }
        let mut idle = Vec::new();
        for name in &self.without {
            let element = element("--without", name)?;
            if !element.is_on(&settings) {
                idle.push(name);
            }
            settings = element.switched(&settings, false);
        }
        for (index, text) in self.set.iter().enumerate() {
            let Some((key, value)) = pair(text) else {
                let want = "give KEY=VALUE, such as radius=6".into();
                return Err(CommandError::Value {
                    option: "--set",
                    value: text.clone(),
                    want,
                });
            };
            let twice = |option: String| CommandError::SetTwice {
                key: key.into(),
                option,
            };
            let names = |text: &&String| pair(text).is_some_and(|(other, _)| other == key);
            if let Some(other) = self.set[..index].iter().find(names) {
                return Err(twice(format!("--set {other}")));
            }
            if key == "rays" && rays.is_some() {
                return Err(twice("--rays".into()));
            }
            for name in &self.without {
                if element("--without", name)?.setting == key {
                    return Err(twice(format!("--without {name}")));
                }
            }
            settings.set(key, value)?;
        }
        for name in idle {
            warning!("`--without {name}` changes nothing: it is off already");
        }
        Ok(settings)
    }
}

/// Key and value of a `--set`.
fn pair(text: &str) -> Option<(&str, &str)> {
    let (key, value) = text.split_once('=')?;
    Some((key.trim(), value.trim()))
}

/// The defaults with what a settings file changes, whose values are those of `--set`; or what is wrong with it.
fn from_file(path: &Path) -> Result<Settings, String> {
    let text = crate::files::read_text(path).map_err(|e| e.to_string())?;
    let table: toml::Table = text.parse().map_err(|e: toml::de::Error| e.to_string())?;
    let mut settings = Settings::default();
    for (key, value) in &table {
        let value = match value {
            toml::Value::String(text) => text.clone(),
            plain => plain.to_string(),
        };
        settings.set(key, &value).map_err(|e| e.to_string())?;
    }
    settings.check().map_err(|e| e.to_string())?;
    Ok(settings)
}

/// The element of the technique that an option names.
pub(super) fn element(
    option: &'static str,
    name: &str,
) -> Result<&'static TechniqueElement, CommandError> {
    TechniqueElement::named(name).ok_or_else(|| {
        let names: Vec<_> = ELEMENTS.iter().map(|element| element.name).collect();
        CommandError::Value {
            option,
            value: name.into(),
            want: format!("the elements are {}", names.join(", ")),
        }
    })
}
