//! What a truth is made of, as one number.
use crate::RenderError;
use crate::reference::{ReferenceOptions, schedules};
use crate::renderer::device_scene;
use crate::view::View;
use bytemuck::cast_slice;
use gibs_graph::{Backend, Schedule};
use gibs_passes::device::DeviceScene;
use gibs_passes::scene::{Camera, Scene};
use gibs_shaders::compose::{File, Target, compose};
use sha2::{Digest, Sha256};

/// What the host does around the kernels.
const HOST: [&str; 2] = [
    include_str!("../reference.rs"),
    include_str!("../channels.rs"),
];

/// SHA-256 of everything that determines a reference, in hexadecimal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Key {
    /// The number itself.
    pub hash: String,
    /// Its ingredients for people: name and value, or the value's own hash.
    pub ingredients: Vec<(&'static str, String)>,
}

impl Key {
    /// Of a reference with these options.
    ///
    /// In it are the posed scene as the device gets it, the camera, the options, the schedules with the composed WGSL of all
    /// their kernels, the host's code around them, the version of the program, and the backend with its device and driver. A
    /// CPU kernel stands in it by its WGSL twin and the version.
    ///
    /// # Errors
    /// As [`crate::reference::reference`], of the scene, the view and the graph.
    pub fn of(
        backend: &dyn Backend,
        scene: &Scene,
        view: &View,
        options: &ReferenceOptions,
    ) -> Result<Self, RenderError> {
        let device = device_scene(scene, view, view.camera.position)?;
        let mut kernels = Hash::default();
        for schedule in schedules(&device, options.size)? {
            kernels.schedule(&schedule);
        }
        for text in HOST {
            kernels.part(text.as_bytes());
        }
        let [width, height] = options.size;
        let info = backend.device();
        let ingredients = vec![
            ("gibs", env!("CARGO_PKG_VERSION").to_owned()),
            ("scene", scene_hash(&device)),
            ("camera", camera_text(&view.camera)),
            ("size", format!("{width}x{height}")),
            ("samples", options.samples.to_string()),
            ("seed", options.seed.to_string()),
            ("emitters", options.emitters.to_string()),
            ("kernels", kernels.hex()),
            ("backend", backend.name().to_owned()),
            ("device", info.name.clone()),
            ("driver", info.driver.clone()),
        ];
        let mut all = Hash::default();
        for (name, value) in &ingredients {
            all.part(name.as_bytes());
            all.part(value.as_bytes());
        }
        Ok(Self {
            hash: all.hex(),
            ingredients,
        })
    }

    /// The ingredients in one line.
    pub fn text(&self) -> String {
        let parts = self.ingredients.iter();
        let parts: Vec<String> = parts
            .map(|(name, value)| format!("{name}={value}"))
            .collect();
        parts.join("; ")
    }
}

/// A hash of parts, each with its length, so that no two sequences of parts run together.
#[derive(Default)]
pub(super) struct Hash(Sha256);

impl Hash {
    pub fn part(&mut self, bytes: &[u8]) {
        self.0.update((bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
    }

    pub fn hex(self) -> String {
        let digest = self.0.finalize();
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    fn schedule(&mut self, schedule: &Schedule) {
        let shape = serde_json::to_vec(schedule).unwrap_or_default();
        self.part(&shape);
        for (.., dispatch) in schedule.dispatches() {
            let wgsl = &dispatch.kernel.wgsl;
            let modules = wgsl.modules.iter();
            let modules: Vec<File<'_>> =
                modules.map(|(path, text)| File::new(path, text)).collect();
            let root = File::new(wgsl.name, wgsl.text);
            // What does not compose stands for itself, with all that it might import.
            match compose(&root, &modules, wgsl.features, Target::Naga) {
                Ok(composed) => self.part(composed.text().as_bytes()),
                Err(_) => {
                    self.part(wgsl.text.as_bytes());
                    modules
                        .iter()
                        .for_each(|file| self.part(file.text.as_bytes()));
                }
            }
        }
    }
}

fn scene_hash(device: &DeviceScene) -> String {
    let mut hash = Hash::default();
    let (environment, emitters) = (&device.environment, &device.emitters);
    let origin = device.origin.to_array();
    let power = emitters.power.to_le_bytes();
    let sampled = [u8::from(environment.sampled)];
    let parts: [&[u8]; 14] = [
        cast_slice(&device.tree.nodes),
        cast_slice(&device.tree.triangles),
        cast_slice(&device.tree.instances),
        cast_slice(&device.corners),
        cast_slice(&device.materials),
        cast_slice(&device.texels),
        cast_slice(&device.lights),
        cast_slice(&device.transforms),
        cast_slice(&environment.texels),
        cast_slice(&environment.cumulative),
        &sampled,
        cast_slice(&emitters.emitters),
        &power,
        cast_slice(&origin),
    ];
    for part in parts {
        hash.part(part);
    }
    hash.hex()
}

/// All digits of the camera, so that equal texts are equal cameras.
fn camera_text(camera: &Camera) -> String {
    let Camera {
        position,
        target,
        up,
        vfov,
    } = camera;
    format!("{position} {target} {up} {vfov}")
}
