//! Types, numbers and functions of Embree 4's C interface, as its public headers (`rtcore_*.h`) declare them.
use gibs::passes::accel::{NONE, Ray};
use glam::Vec3;
use libloading::Library;
use std::ffi::{c_char, c_int, c_uint, c_void};

pub type Device = *mut c_void;
pub type Scene = *mut c_void;
pub type Geometry = *mut c_void;

/// `RTCRayHit`: `RTCRay`, then `RTCHit`. Longer than any build of Embree 4 makes it, since the number of instance ids
/// depends on the build.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct RayHit {
    origin: Vec3,
    t_near: f32,
    direction: Vec3,
    time: f32,
    /// Distance of the hit; `-inf` after an occlusion query that found one.
    pub t_far: f32,
    mask: c_uint,
    id: c_uint,
    flags: c_uint,
    normal: Vec3,
    pub u: f32,
    pub v: f32,
    pub primitive: c_uint,
    pub geometry: c_uint,
    /// The geometry id of the instance, then what deeper builds append.
    pub instance: [c_uint; 13],
}

impl RayHit {
    pub fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin,
            t_near: ray.t_min,
            direction: ray.direction,
            time: 0.0,
            t_far: ray.t_max,
            mask: !0,
            id: 0,
            flags: 0,
            normal: Vec3::ZERO,
            u: 0.0,
            v: 0.0,
            primitive: NONE,
            geometry: NONE,
            instance: [NONE; 13],
        }
    }
}

/// Function pointers under their names in the library.
macro_rules! functions {
    ($($name:ident ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        #[allow(non_snake_case, reason = "names of the C functions")]
        pub struct Functions { $(pub $name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)* }

        impl Functions {
            pub fn find(library: &Library) -> Result<Self, libloading::Error> {
                Ok(Self { $(
                    // SAFETY: the types are those of the C declarations in Embree 4; before the version is known,
                    // only functions are called that are the same in version 3.
                    $name: *unsafe { library.get(concat!(stringify!($name), "\0").as_bytes()) }?,
                )* })
            }
        }
    };
}

functions! {
    rtcNewDevice(*const c_char) -> Device;
    rtcReleaseDevice(Device);
    rtcGetDeviceError(Device) -> c_int;
    rtcGetDeviceProperty(Device, c_int) -> isize;
    rtcNewScene(Device) -> Scene;
    rtcReleaseScene(Scene);
    rtcSetSceneBuildQuality(Scene, c_int);
    rtcCommitScene(Scene);
    rtcNewGeometry(Device, c_int) -> Geometry;
    rtcReleaseGeometry(Geometry);
    rtcSetNewGeometryBuffer(Geometry, c_int, c_uint, c_int, usize, usize) -> *mut c_void;
    rtcSetGeometryBuildQuality(Geometry, c_int);
    rtcSetGeometryInstancedScene(Geometry, Scene);
    rtcSetGeometryTransform(Geometry, c_uint, c_int, *const c_void);
    rtcCommitGeometry(Geometry);
    rtcAttachGeometry(Scene, Geometry) -> c_uint;
    rtcIntersect1(Scene, *mut RayHit, *mut c_void);
    rtcOccluded1(Scene, *mut RayHit, *mut c_void);
}

/// `RTCDeviceProperty`: version, major, minor and patch.
pub const PROPERTY_VERSION: c_int = 0;
/// `RTCGeometryType`.
pub const TRIANGLE: c_int = 0;
pub const INSTANCE: c_int = 121;
/// `RTCBufferType`.
pub const INDEX: c_int = 0;
pub const VERTEX: c_int = 1;
/// `RTCFormat`.
pub const UINT3: c_int = 0x5003;
pub const FLOAT3: c_int = 0x9003;
pub const FLOAT3X4_ROW_MAJOR: c_int = 0x9134;
