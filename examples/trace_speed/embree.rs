//! The few calls of Embree 4 that a comparison of ray rates needs, from a library that is loaded at run time.
//! Nothing of Embree is linked or shipped.
mod abi;

use abi::{
    Device, FLOAT3, FLOAT3X4_ROW_MAJOR, Functions, INDEX, INSTANCE, PROPERTY_VERSION, RayHit,
    Scene, TRIANGLE, UINT3, VERTEX,
};
use gibs::passes::accel::{Hit, Instance, NONE, Ray, TwoLevel};
use glam::Vec3;
use libloading::Library;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{CString, OsStr, c_int};
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why Embree could not be used.
#[derive(Debug, Error)]
pub enum EmbreeError {
    /// The library or one of its functions is not there.
    #[error("{} cannot be used as Embree: {source}; name libembree4.so in EMBREE_LIBRARY", path.display())]
    Library {
        /// The library.
        path: PathBuf,
        /// What the system said.
        source: libloading::Error,
    },
    /// Another version, whose functions take other arguments.
    #[error("{} is Embree {version}; this program knows Embree 4", path.display())]
    Version {
        /// The library.
        path: PathBuf,
        /// Its version.
        version: String,
    },
    /// Embree refused to work.
    #[error("Embree failed to {what} (RTCError {code}); try another build of it")]
    Failed {
        /// What it was asked for.
        what: &'static str,
        /// Its error code.
        code: c_int,
    },
}

/// How much effort Embree puts into its trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Quality {
    /// Embree's default: binned surface area heuristic.
    Medium,
    /// With spatial splits.
    High,
}

/// A two-level scene in Embree: instances of the same bottom levels as in the tree that it was made of.
pub struct Embree {
    functions: Functions,
    device: Device,
    scene: Scene,
    /// `(instance, first triangle)` in the tree, by Embree's instance id.
    instances: Vec<(u32, u32)>,
    /// As in `4.4.0`.
    pub version: String,
    /// Keeps the functions where they are.
    _library: Library,
}

// SAFETY: `&Embree` only queries a committed scene, which Embree allows from many threads at once.
unsafe impl Sync for Embree {}

impl Embree {
    /// Loads the library and builds its trees; `threads` limits the build only.
    ///
    /// # Errors
    /// [`EmbreeError`].
    pub fn new(
        path: &OsStr,
        tree: &TwoLevel,
        threads: usize,
        quality: Quality,
    ) -> Result<Self, EmbreeError> {
        let path = Path::new(path);
        let wrong = |source| EmbreeError::Library {
            path: path.into(),
            source,
        };
        // SAFETY: Embree and the libraries that it needs run no initializers that ask anything of the program.
        let library = unsafe { Library::new(path) }.map_err(wrong)?;
        let functions = Functions::find(&library).map_err(wrong)?;
        let config = CString::new(format!("threads={threads}")).unwrap_or_default();
        // SAFETY: a terminated string, and a device that is checked before its use.
        let device = unsafe { (functions.rtcNewDevice)(config.as_ptr()) };
        if device.is_null() {
            // SAFETY: Embree keeps the error of a device that was not made under null.
            let code = unsafe { (functions.rtcGetDeviceError)(device) };
            return Err(EmbreeError::Failed {
                what: "make a device",
                code,
            });
        }
        // SAFETY: the device is valid; the property numbers are those of every version since 3.
        let [_, major, minor, patch] = [0, 1, 2, 3]
            .map(|i| unsafe { (functions.rtcGetDeviceProperty)(device, PROPERTY_VERSION + i) });
        let version = format!("{major}.{minor}.{patch}");
        // SAFETY: the device is valid, and scenes begin empty.
        let scene = unsafe { (functions.rtcNewScene)(device) };
        let mut embree = Self {
            functions,
            device,
            scene,
            instances: Vec::new(),
            version,
            _library: library,
        };
        if major != 4 {
            return Err(EmbreeError::Version {
                path: path.into(),
                version: embree.version.clone(),
            });
        }
        embree.fill(tree, quality);
        embree.check("build its trees")?;
        Ok(embree)
    }

    fn check(&self, what: &'static str) -> Result<(), EmbreeError> {
        // SAFETY: the device lives as long as `self`.
        let code = unsafe { (self.functions.rtcGetDeviceError)(self.device) };
        if code == 0 {
            Ok(())
        } else {
            Err(EmbreeError::Failed { what, code })
        }
    }

    fn fill(&mut self, tree: &TwoLevel, quality: Quality) {
        // RTCBuildQuality
        let quality = match quality {
            Quality::Medium => 1,
            Quality::High => 2,
        };
        let present = || {
            tree.instances
                .iter()
                .enumerate()
                .filter(|(_, i)| i.flags & Instance::LEFT_OUT == 0)
        };
        // A bottom level ends where the next one begins: the levels of all instances fill the triangles.
        let starts: BTreeSet<u32> = tree.instances.iter().map(|i| i.first_triangle).collect();
        let mut levels: BTreeMap<u32, Scene> = BTreeMap::new();
        let f = &self.functions;
        for (index, instance) in present() {
            let first = instance.first_triangle;
            let level = *levels.entry(first).or_insert_with(|| {
                let end = starts
                    .range(first + 1..)
                    .next()
                    .map_or(tree.triangles.len(), |&end| end as usize);
                self.bottom_level(tree, first as usize..end, quality)
            });
            let rows = &raw const instance.object_to_world;
            // SAFETY: device and scenes are valid; the rows are twelve floats, which Embree copies; what is attached is
            // kept alive by what it is attached to.
            unsafe {
                let geometry = (f.rtcNewGeometry)(self.device, INSTANCE);
                (f.rtcSetGeometryInstancedScene)(geometry, level);
                (f.rtcSetGeometryTransform)(geometry, 0, FLOAT3X4_ROW_MAJOR, rows.cast());
                (f.rtcCommitGeometry)(geometry);
                // Embree counts ids up from zero.
                (f.rtcAttachGeometry)(self.scene, geometry);
                (f.rtcReleaseGeometry)(geometry);
            }
            self.instances.push((index as u32, first));
        }
        // SAFETY: all are valid; each level was counted once when it was made and once per instance.
        unsafe {
            (f.rtcSetSceneBuildQuality)(self.scene, quality);
            (f.rtcCommitScene)(self.scene);
            levels
                .values()
                .for_each(|&level| (f.rtcReleaseScene)(level));
        }
    }

    /// A committed scene of some triangles of the tree.
    fn bottom_level(&self, tree: &TwoLevel, range: Range<usize>, quality: c_int) -> Scene {
        let triangles = &tree.triangles[range];
        let f = &self.functions;
        // SAFETY: Embree gives buffers of the size asked for, which nothing else points to, or null.
        unsafe {
            let scene = (f.rtcNewScene)(self.device);
            let geometry = (f.rtcNewGeometry)(self.device, TRIANGLE);
            let count = 3 * triangles.len();
            let vertices =
                (f.rtcSetNewGeometryBuffer)(geometry, VERTEX, 0, FLOAT3, size_of::<Vec3>(), count);
            let indices =
                (f.rtcSetNewGeometryBuffer)(geometry, INDEX, 0, UINT3, 12, triangles.len());
            if !vertices.is_null() && !indices.is_null() {
                let vertices = std::slice::from_raw_parts_mut(vertices.cast::<Vec3>(), count);
                for (corners, t) in vertices.chunks_exact_mut(3).zip(triangles) {
                    corners.copy_from_slice(&[t.v0, t.v0 + t.e1, t.v0 + t.e2]);
                }
                let indices = std::slice::from_raw_parts_mut(indices.cast::<u32>(), count);
                indices
                    .iter_mut()
                    .zip(0..)
                    .for_each(|(index, i)| *index = i);
            }
            (f.rtcSetGeometryBuildQuality)(geometry, quality);
            (f.rtcCommitGeometry)(geometry);
            (f.rtcAttachGeometry)(scene, geometry);
            (f.rtcReleaseGeometry)(geometry);
            (f.rtcSetSceneBuildQuality)(scene, quality);
            (f.rtcCommitScene)(scene);
            scene
        }
    }

    /// Closest hit, with the tree's numbers of instance and triangle.
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Hit {
        let mut query = RayHit::new(ray);
        // SAFETY: the scene is committed, the query is as long and aligned as Embree wants, null stands for defaults.
        unsafe { (self.functions.rtcIntersect1)(self.scene, &mut query, std::ptr::null_mut()) };
        if query.geometry == NONE {
            return Hit::miss(ray.t_max);
        }
        let (instance, first) = self.instances[query.instance[0] as usize];
        Hit {
            t: query.t_far,
            u: query.u,
            v: query.v,
            triangle: first + query.primitive,
            instance,
        }
    }

    /// Whether anything is hit.
    #[inline]
    pub fn any(&self, ray: &Ray) -> bool {
        let mut query = RayHit::new(ray);
        // SAFETY: as in `closest`; the query begins with the ray that an occlusion query takes.
        unsafe { (self.functions.rtcOccluded1)(self.scene, &mut query, std::ptr::null_mut()) };
        query.t_far < 0.0
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: both were made by `new` and are not used again.
        unsafe {
            (self.functions.rtcReleaseScene)(self.scene);
            (self.functions.rtcReleaseDevice)(self.device);
        }
    }
}
