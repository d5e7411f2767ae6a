//! What buffers hold: plain data whose layout is known field by field.
//!
//! The layout is derived from the Rust type (`offset_of!`), never written twice, and is what the reflection of a
//! stage's WGSL is compared with.
use bytemuck::Pod;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Plain data that stages exchange.
///
/// Implemented for `u32`, `i32`, `f32`, glam vectors, arrays, and by [`element!`](crate::element!) for structs.
pub trait Element: Pod + Send + Sync + 'static {
    /// Layout of one value, as WGSL sees it.
    fn layout() -> Layout;
}

/// Layout of a type that host and device share. Sizes and offsets are in bytes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Layout {
    /// One 32-bit number.
    Scalar(Scalar),
    /// `vecN<scalar>`.
    Vector(Scalar, u32),
    /// `array<element, count>`.
    Array {
        /// Type of each element.
        element: Box<Layout>,
        /// Number of elements.
        count: u32,
        /// Distance between elements.
        stride: u32,
    },
    /// A struct.
    Struct {
        /// Type name, the same in Rust and WGSL.
        name: String,
        /// Size with trailing padding.
        size: u32,
        /// Members in declaration order.
        fields: Vec<Field>,
    },
}

/// A member of a struct.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Field {
    /// Name, the same in Rust and WGSL.
    pub name: String,
    /// Bytes from the start of the struct.
    pub offset: u32,
    /// Type.
    pub layout: Layout,
}

/// 32-bit scalar types, all that WebGPU guarantees in storage buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Scalar {
    /// `f32`.
    F32,
    /// `u32`, also `atomic<u32>`.
    U32,
    /// `i32`, also `atomic<i32>`.
    I32,
}

impl Layout {
    /// Bytes of one value.
    pub fn size(&self) -> u32 {
        match self {
            Layout::Scalar(_) => 4,
            Layout::Vector(_, n) => 4 * n,
            Layout::Array { count, stride, .. } => count * stride,
            Layout::Struct { size, .. } => *size,
        }
    }
}

impl fmt::Display for Layout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Layout::Scalar(s) => write!(f, "{}", s.name()),
            Layout::Vector(s, n) => write!(f, "vec{n}<{}>", s.name()),
            Layout::Array { element, count, .. } => write!(f, "array<{element}, {count}>"),
            Layout::Struct { name, .. } => write!(f, "{name}"),
        }
    }
}

impl Scalar {
    /// WGSL name.
    pub fn name(self) -> &'static str {
        match self {
            Scalar::F32 => "f32",
            Scalar::U32 => "u32",
            Scalar::I32 => "i32",
        }
    }
}

macro_rules! primitive {
    ($($ty:ty => $layout:expr;)*) => {
        $(impl Element for $ty {
            fn layout() -> Layout {
                $layout
            }
        })*
    };
}

primitive! {
    f32 => Layout::Scalar(Scalar::F32);
    u32 => Layout::Scalar(Scalar::U32);
    i32 => Layout::Scalar(Scalar::I32);
    glam::Vec2 => Layout::Vector(Scalar::F32, 2);
    glam::Vec3 => Layout::Vector(Scalar::F32, 3);
    glam::Vec4 => Layout::Vector(Scalar::F32, 4);
    glam::UVec2 => Layout::Vector(Scalar::U32, 2);
    glam::UVec3 => Layout::Vector(Scalar::U32, 3);
    glam::UVec4 => Layout::Vector(Scalar::U32, 4);
}

impl<T: Element, const N: usize> Element for [T; N] {
    fn layout() -> Layout {
        Layout::Array {
            element: Box::new(T::layout()),
            count: N as u32,
            stride: size_of::<T>() as u32,
        }
    }
}

/// Declares a struct that host and device share.
///
/// The struct becomes `#[repr(C)]` plain data with public fields and an [`Element`] layout. It must have no padding
/// that is not a field; the compiler says so.
///
/// ```
/// gibs_graph::element! {
///     /// A ray.
///     pub struct Ray {
///         /// Start.
///         origin: glam::Vec3,
///         /// Least distance.
///         t_min: f32,
///     }
/// }
/// assert_eq!(<Ray as gibs_graph::Element>::layout().size(), 16);
/// ```
#[macro_export]
macro_rules! element {
    ($($(#[$meta:meta])* pub struct $name:ident { $($(#[$fmeta:meta])* $field:ident : $ty:ty),* $(,)? })*) => {
        $(
            $(#[$meta])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, Default, PartialEq, $crate::bytemuck::Pod, $crate::bytemuck::Zeroable)]
            #[bytemuck(crate = "gibs_graph::bytemuck")]
            pub struct $name {
                $($(#[$fmeta])* pub $field: $ty,)*
            }

            $crate::element_layout!($name { $($field: $ty),* });
        )*
    };
}

/// Gives a `#[repr(C)]` plain-data struct that exists already its [`Element`] layout. Lists every field with its type.
#[macro_export]
macro_rules! element_layout {
    ($name:ident { $($field:ident : $ty:ty),* $(,)? }) => {
        const _: () = assert!(
            0 $(+ core::mem::size_of::<$ty>())* == core::mem::size_of::<$name>(),
            "a layout lists every field with its type",
        );

        impl $crate::Element for $name {
            fn layout() -> $crate::Layout {
                $crate::Layout::Struct {
                    name: stringify!($name).into(),
                    size: size_of::<$name>() as u32,
                    fields: vec![$($crate::Field {
                        name: stringify!($field).into(),
                        offset: core::mem::offset_of!($name, $field) as u32,
                        layout: <$ty as $crate::Element>::layout(),
                    },)*],
                }
            }
        }
    };
}

/// Sizes of an indirect dispatch, and the count they were made from. Also fit for a uniform.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct DispatchArgs {
    /// Workgroups along x.
    pub x: u32,
    /// Workgroups along y.
    pub y: u32,
    /// Workgroups along z.
    pub z: u32,
    /// Invocations wanted; those beyond do nothing.
    pub count: u32,
    /// Element that the first invocation is for, where a stage works on a part of its buffers.
    pub first: u32,
    /// Zero: a uniform has a multiple of 16 bytes.
    pub pad0: u32,
    /// Zero.
    pub pad1: u32,
    /// Zero.
    pub pad2: u32,
}

impl Element for DispatchArgs {
    fn layout() -> Layout {
        let field = |name: &str, offset| Field {
            name: name.into(),
            offset,
            layout: u32::layout(),
        };
        Layout::Struct {
            name: "DispatchArgs".into(),
            size: 32,
            fields: vec![
                field("x", 0),
                field("y", 4),
                field("z", 8),
                field("count", 12),
                field("first", 16),
                field("pad0", 20),
                field("pad1", 24),
                field("pad2", 28),
            ],
        }
    }
}
