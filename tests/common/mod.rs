//! What several tests share.
#![allow(dead_code, reason = "each test uses a part")]
use gibs::backends::{self, Choice};
use gibs::graph::{Backend, BackendError};
use gibs::passes::frame::Settings;
use gibs::passes::scene::Scene;
use gibs::picture::Picture;
use gibs::view::View;
use gibs::{Renderer, gltf_import};
use std::path::{Path, PathBuf};

/// Every backend that this build has. One that the machine lacks is a failure under `GIBS_STRICT=1`; else it is
/// reported as not run. Vulkan is watched by the validation layer where it is installed; what the layer says fails the test.
pub fn all_backends() -> Vec<Box<dyn Backend>> {
    let mut found = Vec::new();
    for &choice in backends::BUILT {
        match open(choice) {
            Ok(backend) => found.push(backend),
            Err(error) if is_strict() => panic!("{choice}: {error}"),
            Err(error) => eprintln!("not run on {choice}: {error}"),
        }
    }
    found
}

pub fn is_strict() -> bool {
    std::env::var_os("GIBS_STRICT").is_some_and(|v| v == "1")
}

fn open(choice: Choice) -> Result<Box<dyn Backend>, BackendError> {
    #[cfg(feature = "vulkan")]
    if choice == Choice::Vulkan {
        match watched::Watched::open() {
            Ok(backend) => return Ok(Box::new(backend)),
            Err(error) if is_strict() => return Err(error),
            Err(error) => eprintln!("not watched: {error}"),
        }
    }
    backends::open(choice)
}

#[cfg(feature = "vulkan")]
mod watched {
    use gibs::graph::{Backend, BackendError, Capabilities, DeviceInfo, Executable, Schedule};
    use gibs_backend_vulkan::{Options, ValidationLog, VulkanBackend};
    use std::sync::Arc;

    /// Vulkan under its validation layer, synchronization included, which has to stay silent.
    pub struct Watched {
        /// `None` only while the value is dropped.
        backend: Option<VulkanBackend>,
        log: ValidationLog,
    }

    impl Watched {
        pub fn open() -> Result<Self, BackendError> {
            let backend = VulkanBackend::new(Options {
                validation: true,
                sync_validation: true,
                device: None,
            })?;
            Ok(Self {
                log: backend.validation_log(),
                backend: Some(backend),
            })
        }

        fn backend(&self) -> &VulkanBackend {
            self.backend.as_ref().expect("it is there until the end")
        }
    }

    impl Backend for Watched {
        fn name(&self) -> &str {
            self.backend().name()
        }

        fn device(&self) -> &DeviceInfo {
            self.backend().device()
        }

        fn capabilities(&self) -> &Capabilities {
            self.backend().capabilities()
        }

        fn prepare(&self, schedule: Arc<Schedule>) -> Result<Box<dyn Executable>, BackendError> {
            self.backend().prepare(schedule)
        }
    }

    impl Drop for Watched {
        fn drop(&mut self) {
            // Taking the device down is watched as well, where no executable still holds it.
            drop(self.backend.take());
            let messages = self.log.messages();
            // A test that fails already has something else to say.
            if !std::thread::panicking() {
                assert!(
                    messages.is_empty(),
                    "{} messages of the validation layer:\n{}",
                    messages.len(),
                    messages.join("\n")
                );
            }
        }
    }
}

/// The CPU backend.
pub fn cpu() -> Box<dyn Backend> {
    backends::open(Choice::Cpu).expect("the CPU backend needs nothing")
}

/// Settings with a smaller budget than the default, for small pictures.
pub fn settings(rays: u32) -> Settings {
    Settings {
        rays,
        surfels: 8192,
        ..Settings::default()
    }
}

/// A picture after some frames.
pub fn render(
    backend: &dyn Backend,
    (scene, view): &(Scene, View),
    size: [u32; 2],
    frames: u32,
    settings: &Settings,
    seed: u32,
) -> Picture {
    let mut renderer = Renderer::new(backend, scene, view, size, settings, seed)
        .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
    for _ in 0..frames {
        renderer
            .frame()
            .unwrap_or_else(|e| panic!("{}: {e}", backend.name()));
    }
    renderer
        .picture()
        .unwrap_or_else(|e| panic!("{}: {e}", backend.name()))
}

/// Mean of the three channels of a layer over the pixels that hit something.
pub fn mean(picture: &Picture, layer: &str) -> f64 {
    let mask = picture.scalar("mask.A").expect("a mask");
    let planes = picture.rgb(layer).expect("the layer");
    let mut sum = 0.0;
    let mut count = 0.0;
    for (i, _) in mask.iter().enumerate().filter(|(_, m)| **m > 0.0) {
        sum += planes.iter().map(|plane| f64::from(plane[i])).sum::<f64>() / 3.0;
        count += 1.0;
    }
    sum / f64::max(count, 1.0)
}

/// The folder of the truths: `scenes` in what `GIBS_SHARED` names, which must be there then, or else in `../shared`.
pub fn scenes() -> Option<PathBuf> {
    let named = std::env::var_os("GIBS_SHARED").map(PathBuf::from);
    let folder = named
        .clone()
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared"));
    let found = Some(folder.join("scenes")).filter(|f| f.is_dir());
    assert!(
        found.is_some() || named.is_none(),
        "GIBS_SHARED names {}, which has no folder `scenes`",
        folder.display()
    );
    found
}

/// Sponza from the scenes beside the project, with one of its views; nothing, and a word about it, where there are none.
pub fn sponza(view: &str) -> Option<(Scene, View)> {
    let Some(scenes) = scenes() else {
        eprintln!("not run: there are no scenes beside the project");
        return None;
    };
    let folder = scenes.join("sponza");
    let imported = gltf_import::load(&folder.join("sponza.gltf")).expect("loads");
    let view = View::load(folder.join(view)).expect("loads");
    Some((imported.scene, view))
}
