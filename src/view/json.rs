//! The JSON form of a view.
//!
//! ```text
//! {
//!   "scene": "room.gltf",                     optional; relative to the view file
//!   "camera": { "position": [0, 1, 3], "target": [0, 1, 0], "up": [0, 1, 0], "vfov_degrees": 50 },
//!   "resolution": [1280, 720],                optional
//!   "sun": { "direction": [-1, -2, 0], "irradiance_rgb": [6, 6, 5] },               or null
//!   "sky_radiance_rgb": [0.3, 0.4, 0.6],      or null, and then perhaps
//!   "environment": { "file": "sky.hdr", "scale": 1, "rotation_y_degrees": 0 },
//!   "animation": [{ "index": 0, "time": 1.5 }],
//!   "transparent": "coverage",
//!   "exposure": 1,
//!   "note": "anything"
//! }
//! ```
use super::{DEFAULT_RESOLUTION, MAX_RESOLUTION, View, ViewError, environment};
use gibs_passes::scene::{Camera, Environment, MOST_RADIANCE, Sun};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct ViewFile {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    scene: Option<PathBuf>,
    camera: CameraFile,
    #[serde(default = "default_resolution")]
    resolution: [u32; 2],
    #[serde(default)]
    sun: Option<SunFile>,
    #[serde(default)]
    sky_radiance_rgb: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    environment: Option<EnvironmentFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    animation: Vec<ClipFile>,
    #[serde(default)]
    transparent: Transparent,
    #[serde(default = "one")]
    exposure: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct CameraFile {
    position: [f64; 3],
    target: [f64; 3],
    #[serde(default = "y_up")]
    up: [f64; 3],
    vfov_degrees: f64,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct SunFile {
    direction: [f64; 3],
    irradiance_rgb: [f64; 3],
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct EnvironmentFile {
    file: PathBuf,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default)]
    rotation_y_degrees: f64,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct ClipFile {
    index: usize,
    time: f64,
}

/// How transparent surfaces act. There is one way; the field lets a file say so.
#[derive(Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum Transparent {
    #[default]
    Coverage,
}

fn default_resolution() -> [u32; 2] {
    DEFAULT_RESOLUTION
}

fn one() -> f64 {
    1.0
}

fn y_up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

/// Makes errors about fields of one file.
struct Check<'a> {
    file: &'a Path,
}

impl Check<'_> {
    fn wrong(&self, field: &'static str, value: String, remedy: impl Into<String>) -> ViewError {
        let (file, remedy) = (self.file.to_owned(), remedy.into());
        ViewError::Field {
            file,
            field,
            value,
            remedy,
        }
    }

    fn point(&self, field: &'static str, value: [f64; 3]) -> Result<DVec3, ViewError> {
        let point = DVec3::from_array(value);
        // Far beyond any scene, and squares of it still are numbers.
        if point.abs().max_element() <= 1e15 {
            return Ok(point);
        }
        Err(self.wrong(
            field,
            format!("{value:?}"),
            "give three numbers of at most 1e15",
        ))
    }

    fn direction(&self, field: &'static str, value: [f64; 3]) -> Result<DVec3, ViewError> {
        let largest = DVec3::from_array(value).abs().max_element();
        (DVec3::from_array(value) / largest)
            .try_normalize()
            .ok_or_else(|| {
                self.wrong(
                    field,
                    format!("{value:?}"),
                    "give a direction with a length",
                )
            })
    }

    fn number(&self, field: &'static str, value: f64) -> Result<f64, ViewError> {
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.wrong(field, value.to_string(), "give a finite number"))
    }

    fn light(&self, field: &'static str, value: [f64; 3]) -> Result<Vec3, ViewError> {
        let light = DVec3::from_array(value).as_vec3();
        if light.is_finite() && light.min_element() >= 0.0 && light.max_element() <= MOST_RADIANCE {
            return Ok(light);
        }
        let remedy = "give three numbers from 0 to 1e13, linear red, green and blue";
        Err(self.wrong(field, format!("{value:?}"), remedy))
    }

    fn camera(&self, camera: &CameraFile) -> Result<Camera, ViewError> {
        let position = self.point("camera.position", camera.position)?;
        let target = self.point("camera.target", camera.target)?;
        let up = self.direction("camera.up", camera.up)?;
        let Some(forward) = (target - position).try_normalize() else {
            let value = format!("{:?}, the same as `camera.position`", camera.target);
            return Err(self.wrong("camera.target", value, "give another point to look at"));
        };
        if forward.cross(up).length() < 1e-9 {
            let remedy = "it is parallel to the line of sight: give another direction";
            return Err(self.wrong("camera.up", format!("{:?}", camera.up), remedy));
        }
        let degrees = camera.vfov_degrees;
        let vfov = degrees.to_radians();
        // The smallest numbers of degrees are no number of radians.
        if !(vfov > 0.0 && degrees < 180.0) {
            let remedy = "give an angle above 0 and below 180 degrees";
            return Err(self.wrong("camera.vfov_degrees", degrees.to_string(), remedy));
        }
        Ok(Camera {
            position,
            target,
            up,
            vfov,
        })
    }
}

impl View {
    /// Reads a view file and the environment map that it names. Paths in the file are relative to it.
    ///
    /// Environment maps are Radiance (.hdr) or OpenEXR (.exr) images with red, green and blue; texels that are negative
    /// or not finite are clamped and counted in [`View::warnings`].
    ///
    /// # Errors
    /// [`ViewError`] names the file, the field and its value, and says what to write instead.
    pub fn load(path: impl AsRef<Path>) -> Result<View, ViewError> {
        let path = path.as_ref();
        let text = crate::files::read_text(path).map_err(|source| ViewError::Read {
            file: path.to_owned(),
            source,
        })?;
        Self::from_json(&text, path)
    }

    /// Reads a view from `text`; `path` is where it stands, for relative paths and for errors.
    ///
    /// # Errors
    /// As [`View::load`].
    pub fn from_json(text: &str, path: &Path) -> Result<View, ViewError> {
        let view: ViewFile =
            serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|source| {
                ViewError::Format {
                    file: path.to_owned(),
                    source,
                }
            })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let check = Check { file: path };
        let mut warnings = Vec::new();

        let camera = check.camera(&view.camera)?;
        if view
            .resolution
            .iter()
            .any(|side| !(1..=MAX_RESOLUTION).contains(side))
        {
            let remedy = format!("give a width and a height from 1 to {MAX_RESOLUTION} pixels");
            return Err(check.wrong("resolution", format!("{:?}", view.resolution), remedy));
        }
        let sun = match &view.sun {
            None => None,
            Some(sun) => Some(Sun {
                direction: check.direction("sun.direction", sun.direction)?,
                irradiance: check.light("sun.irradiance_rgb", sun.irradiance_rgb)?,
            }),
        };
        let environment = match (&view.sky_radiance_rgb, &view.environment) {
            (Some(sky), Some(_)) => {
                let remedy = "a view has this or `environment`: make one of them null";
                return Err(check.wrong("sky_radiance_rgb", format!("{sky:?}"), remedy));
            }
            (Some(sky), None) => Environment::Constant(check.light("sky_radiance_rgb", *sky)?),
            (None, None) => Environment::default(),
            (None, Some(map)) => {
                let scale = check.number("environment.scale", map.scale)? as f32;
                if !(scale.is_finite() && scale >= 0.0) {
                    let remedy = "give a factor that is not below zero";
                    return Err(check.wrong("environment.scale", map.scale.to_string(), remedy));
                }
                let degrees =
                    check.number("environment.rotation_y_degrees", map.rotation_y_degrees)?;
                let mut loaded = environment::load(&folder.join(&map.file), scale, &mut warnings)?;
                loaded.rotation_y = degrees.to_radians();
                Environment::Map(loaded)
            }
        };
        let exposure = view.exposure as f32;
        if !(exposure.is_finite() && exposure > 0.0) {
            let remedy = "give a factor above zero";
            return Err(check.wrong("exposure", view.exposure.to_string(), remedy));
        }
        let mut animation = Vec::with_capacity(view.animation.len());
        for clip in &view.animation {
            animation.push((clip.index, check.number("animation.time", clip.time)?));
        }
        Ok(View {
            scene: view.scene.map(|scene| folder.join(scene)),
            camera,
            resolution: view.resolution,
            sun,
            environment,
            animation,
            exposure,
            warnings,
        })
    }

    /// The view as the text of a view file. `scene` is written as it stands.
    ///
    /// # Errors
    /// [`ViewError::Unwritable`] for an environment map, which a view file only names.
    pub fn to_json(&self) -> Result<String, ViewError> {
        let Environment::Constant(sky) = &self.environment else {
            return Err(ViewError::Unwritable {
                field: "environment",
                value: "a map in memory".to_owned(),
                remedy: "write a view with a constant sky and name the map in the file by hand",
            });
        };
        let file = ViewFile {
            scene: self.scene.clone(),
            camera: CameraFile {
                position: self.camera.position.to_array(),
                target: self.camera.target.to_array(),
                up: self.camera.up.to_array(),
                vfov_degrees: self.camera.vfov.to_degrees(),
            },
            resolution: self.resolution,
            sun: self.sun.map(|sun| SunFile {
                direction: sun.direction.to_array(),
                irradiance_rgb: sun.irradiance.as_dvec3().to_array(),
            }),
            sky_radiance_rgb: Some(sky.as_dvec3().to_array()),
            environment: None,
            animation: (self.animation.iter())
                .map(|&(index, time)| ClipFile { index, time })
                .collect(),
            transparent: Transparent::Coverage,
            exposure: f64::from(self.exposure),
            note: None,
        };
        serde_json::to_string_pretty(&file).map_err(|source| ViewError::Unwritable {
            field: "view",
            value: source.to_string(),
            remedy: "give it finite numbers",
        })
    }
}
