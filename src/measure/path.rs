//! Where a camera goes, frame by frame.
//!
//! ```text
//! {
//!   "keys": [
//!     { "frame": 0, "position": [0, 1, 3], "target": [0, 1, 0] },
//!     { "frame": 120, "position": [2, 1, 1], "target": [0, 1, -3] }
//!   ],
//!   "note": "anything"
//! }
//! ```
use gibs_passes::scene::Camera;
use glam::{DMat3, DVec3};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The last frame that a key may name.
pub const MOST_FRAME: f64 = 1e6;

/// Farthest coordinate of a key, as of a view's camera.
const FARTHEST: f64 = 1e15;

/// Why a path could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PathError {
    /// The file could not be opened or read.
    #[error("cannot read {}: {source}; check that the path is right and that the file may be read", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not JSON, lacks a field, or has one of the wrong kind or of an unknown name.
    #[error("{} is not a camera path: {source}; correct that line of the file", file.display())]
    Format {
        /// The file.
        file: PathBuf,
        /// What is wrong, and at which line and column.
        source: serde_json::Error,
    },
    /// A field has a value that no path can have.
    #[error("{}: `{field}` is {value}: {remedy}", file.display())]
    Field {
        /// The file.
        file: PathBuf,
        /// The field, as in `keys[2].frame`.
        field: String,
        /// Its value.
        value: String,
        /// What to write instead.
        remedy: &'static str,
    },
    /// Between two keys the camera looks nowhere, or straight along its up direction.
    #[error(
        "{}: in frame {frame} the camera at {position} looks at {target}, {problem}; add a key before that frame, or move \
         those around it", file.display()
    )]
    Between {
        /// The file.
        file: PathBuf,
        /// Frame.
        frame: u32,
        /// Where the camera is then.
        position: DVec3,
        /// What it looks at.
        target: DVec3,
        /// What is wrong with that.
        problem: &'static str,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PathFile {
    keys: Vec<KeyFile>,
    #[serde(default, rename = "note")]
    _note: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyFile {
    frame: f64,
    position: [f64; 3],
    target: [f64; 3],
}

/// A pose at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Key {
    frame: f64,
    position: DVec3,
    target: DVec3,
}

/// A smooth path through key poses: cubic Hermite curves whose tangent at a key is the slope from the key before to the
/// key after (Catmull and Rom 1974, with times that need not be even). Between two keys with the same position, or target, that
/// stays where it is. Before the first key and after the last one the camera rests there.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    /// By frame.
    keys: Vec<Key>,
    /// Up direction and field of view.
    camera: Camera,
}

impl CameraPath {
    /// Reads a path file; up and field of view are those of `camera`.
    ///
    /// # Errors
    /// [`PathError`] names the file, the field and its value, and says what to write instead.
    pub fn load(file: impl AsRef<Path>, camera: &Camera) -> Result<Self, PathError> {
        let file = file.as_ref();
        let text = crate::files::read_text(file).map_err(|source| PathError::Read {
            file: file.to_owned(),
            source,
        })?;
        Self::from_json(&text, file, camera)
    }

    /// Reads a path from `text`; `file` is where it stands, for errors.
    ///
    /// # Errors
    /// As [`CameraPath::load`].
    pub fn from_json(text: &str, file: &Path, camera: &Camera) -> Result<Self, PathError> {
        let text = text.trim_start_matches('\u{feff}');
        let parsed: PathFile = serde_json::from_str(text).map_err(|source| PathError::Format {
            file: file.to_owned(),
            source,
        })?;
        let wrong = |field: String, value: String, remedy| PathError::Field {
            file: file.to_owned(),
            field,
            value,
            remedy,
        };
        if parsed.keys.is_empty() {
            let remedy = "give at least one key pose";
            return Err(wrong("keys".into(), "empty".into(), remedy));
        }
        let mut keys: Vec<Key> = Vec::new();
        for (i, key) in parsed.keys.iter().enumerate() {
            let name = |field: &str| format!("keys[{i}].{field}");
            let after = keys.last().is_none_or(|last| key.frame > last.frame);
            if !((0.0..=MOST_FRAME).contains(&key.frame) && after) {
                let remedy = "give frames from 0 to 1000000, each above the one before";
                return Err(wrong(name("frame"), key.frame.to_string(), remedy));
            }
            for (field, value) in [("position", key.position), ("target", key.target)] {
                if !value.iter().all(|c| c.abs() <= FARTHEST) {
                    let remedy = "give three numbers of at most 1e15";
                    return Err(wrong(name(field), format!("{value:?}"), remedy));
                }
            }
            if key.position == key.target {
                let value = format!("{:?}, the same as `position`", key.target);
                let remedy = "give another point to look at";
                return Err(wrong(name("target"), value, remedy));
            }
            keys.push(Key {
                frame: key.frame,
                position: DVec3::from_array(key.position),
                target: DVec3::from_array(key.target),
            });
        }
        let path = Self {
            keys,
            camera: *camera,
        };
        path.check(file)?;
        Ok(path)
    }

    /// A path for a view without one: forward by a third of the way to what the camera looks at, around that by twenty
    /// degrees to either side, once around on the spot, and back, in so many frames.
    pub fn around(camera: &Camera, frames: u32) -> Self {
        let [_, up, _] = camera.axes();
        let to = camera.target - camera.position;
        let near = camera.position + to * 0.3;
        let turned =
            |vector: DVec3, degrees: f64| DMat3::from_axis_angle(up, degrees.to_radians()) * vector;
        let beside = |degrees| camera.target + turned(near - camera.target, degrees);
        let look = |degrees| near + turned(camera.target - near, degrees);
        let poses = [
            (0.00, camera.position, camera.target),
            (0.20, near, camera.target),
            (0.30, beside(20.0), camera.target),
            (0.40, near, camera.target),
            (0.50, beside(-20.0), camera.target),
            (0.60, near, look(0.0)),
            (0.65, near, look(72.0)),
            (0.70, near, look(144.0)),
            (0.75, near, look(216.0)),
            (0.80, near, look(288.0)),
            (0.85, near, look(360.0)),
            (1.00, camera.position, camera.target),
        ];
        let last = f64::from(frames.max(2) - 1);
        let key = |(time, position, target)| Key {
            frame: time * last,
            position,
            target,
        };
        Self {
            keys: poses.map(key).to_vec(),
            camera: *camera,
        }
    }

    /// Frame of the last key.
    pub fn last_frame(&self) -> f64 {
        self.keys.last().map_or(0.0, |key| key.frame)
    }

    /// The camera at a time, in frames.
    pub fn camera(&self, frame: f64) -> Camera {
        let next = self.keys.partition_point(|key| key.frame <= frame);
        let (position, target) = match (next.checked_sub(1), self.keys.get(next)) {
            (None, None) => (self.camera.position, self.camera.target),
            (None, Some(key)) => (key.position, key.target),
            (Some(i), None) => (self.keys[i].position, self.keys[i].target),
            (Some(i), Some(after)) => {
                let before = &self.keys[i];
                let length = after.frame - before.frame;
                let t = (frame - before.frame) / length;
                let curve = |of: fn(&Key) -> DVec3| {
                    let slopes = [self.slope(i, of) * length, self.slope(next, of) * length];
                    hermite(of(before), of(after), slopes, t)
                };
                (curve(|key| key.position), curve(|key| key.target))
            }
        };
        Camera {
            position,
            target,
            ..self.camera
        }
    }

    /// Slope at a key, per frame.
    fn slope(&self, i: usize, of: fn(&Key) -> DVec3) -> DVec3 {
        let before = i.checked_sub(1).map(|i| &self.keys[i]);
        let (own, after) = (&self.keys[i], self.keys.get(i + 1));
        let rests = |key: Option<&Key>| key.is_some_and(|key| of(key) == of(own));
        if rests(before) || rests(after) {
            return DVec3::ZERO;
        }
        let (before, after) = (before.unwrap_or(own), after.unwrap_or(own));
        match after.frame - before.frame {
            length if length > 0.0 => (of(after) - of(before)) / length,
            _ => DVec3::ZERO,
        }
    }

    /// Every frame has a camera that sees something.
    fn check(&self, file: &Path) -> Result<(), PathError> {
        for frame in 0..=self.last_frame() as u32 {
            let camera = self.camera(f64::from(frame));
            let forward = (camera.target - camera.position).try_normalize();
            let problem = match forward {
                None => "where it is itself",
                Some(forward) if forward.cross(camera.up.normalize_or_zero()).length() < 1e-6 => {
                    "along its own up direction"
                }
                Some(_) => continue,
            };
            return Err(PathError::Between {
                file: file.to_owned(),
                frame,
                position: camera.position,
                target: camera.target,
                problem,
            });
        }
        Ok(())
    }
}

/// The cubic with these values and slopes at 0 and 1.
fn hermite(a: DVec3, b: DVec3, [da, db]: [DVec3; 2], t: f64) -> DVec3 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0)
        + da * (t3 - 2.0 * t2 + t)
        + b * (3.0 * t2 - 2.0 * t3)
        + db * (t3 - t2)
}
