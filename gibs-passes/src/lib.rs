//! The stages of surfel global illumination (GIBS, SIGGRAPH 2021), their CPU kernels, and the frames that wire them.
//!
//! [`frame`] records a frame into a [`Graph`](gibs_graph::Graph) and uploads what it needs; [`scene`] is what is lit, as
//! host data; [`device`] makes the tables of it that kernels read; [`accel`] is the acceleration structure; [`data`] has
//! what buffers hold; [`stages`] has one module per stage, and [`shared`] the formulas that several of them, and the
//! modules of the same names in WGSL, have in common. Most programs want the crate `gibs` above it, which does the calls
//! in the right order.
//!
//! # Units and coordinates
//! - Lengths are metres as far as defaults go. Coordinates are right-handed; angles are in radians.
//! - [`scene`] is in `f64` in world coordinates. Everything on a device is in `f32`, relative to the floating origin that
//!   the caller of [`device::DeviceScene::build`] chooses; keep it near the camera.
//! - Colours are linear RGB with Rec. 709 primaries; irradiance is in W/m^2, radiance in W/(m^2 sr).
//!
//! # Contracts
//! - *Kernels and twins.* Each WGSL kernel has a twin in Rust with the same ports and formula. The twin is the oracle; a
//!   second, wide CPU kernel gives the oracle's bits.
//! - *Determinism.* The same inputs give the same bits on one backend, in whatever order workgroups run: random numbers
//!   are hashes of stable identities, sums run in a fixed order, and atomics only count.
//! - *Threads.* Everything here is plain data and functions. Trees are built on rayon's global pool; kernels run on the
//!   threads of whoever calls them, and no two workgroups of one stage touch one element that either writes.
//! - *Panics.* A scene that a program puts together itself goes through [`scene::Scene::validate`] first, which refuses or
//!   repairs what cannot be; what follows indexes by what it has checked. Kernels index buffers of the sizes that the
//!   frames declare, and panic on others.
//! - *Stability.* Names and layouts of buffers and stages follow the technique and may change in any release; [`scene`],
//!   [`frame::Settings`] and what [`frame`] hands out change with minor versions before 1.0.
pub mod accel;
pub mod data;
pub mod device;
pub mod frame;
pub mod scene;
pub mod shared;
pub mod simd;
pub mod stages;
