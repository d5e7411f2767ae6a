//! Declaring the resources of a frame.
use crate::graph::ResourceDecl;
use crate::{
    Acceleration, AccelerationTriangle, Buffer, Element, Graph, Image, ImageShape, Initial, Kind,
    Previous, Sampled, State, Stored, Texel,
};
use std::marker::PhantomData;

impl Graph {
    /// A buffer that the host writes between frames and stages only read. Its content stays until it is written
    /// again, also across schedules, as long as key, type and length agree. Of `len` 0, as of every buffer, one element
    /// is allocated, since devices bind nothing smaller; [`Buffer::len`] says so.
    pub fn input<T: Element>(&mut self, key: &str, len: u64) -> Buffer<T> {
        self.declare(key, Kind::Input, len)
    }

    /// What rays are traced in: two inputs that the host writes, `key` of [`AccelerationInstance`](crate::AccelerationInstance)s
    /// and `KEY_triangles` of [`AccelerationTriangle`]s. A backend whose device traces rays
    /// ([`Capabilities::ray_query`](crate::Capabilities::ray_query)) builds the structure before the next frame after either was
    /// written.
    pub fn acceleration(&mut self, key: &str, triangles: u64, instances: u64) -> Acceleration {
        let corners = self.input::<AccelerationTriangle>(&format!("{key}_triangles"), triangles);
        let structure = self.input(key, instances);
        self.resources[structure.resource as usize].triangles = Some(corners.resource);
        Acceleration(structure)
    }

    /// An image that the host provides and stages only read. Without one from the host, a backend makes its own, which
    /// is written as an input is, one value per texel. A side of 0 is 1.
    pub fn import_image<T: Sampled>(&mut self, key: &str, size: [u32; 2]) -> Image<T> {
        self.declare_image(key, Kind::Input, size)
    }

    /// An image that a stage writes for the host, who may provide it; undefined at the start of the frame. Pass its
    /// last version to [`Graph::output_image`]. A side of 0 is 1.
    pub fn export_image<T: Stored>(&mut self, key: &str, size: [u32; 2]) -> Image<T> {
        self.declare_image(key, Kind::Transient, size)
    }

    /// A buffer that lives within the frame, undefined at its start. A `len` of 0 is 1, as for [`Graph::input`].
    pub fn transient<T: Element>(&mut self, name: &str, len: u64) -> Buffer<T> {
        self.declare(name, Kind::Transient, len)
    }

    /// A buffer that lives within the frame, zero at its start. A `len` of 0 is 1, as for [`Graph::input`].
    pub fn zeroed<T: Element>(&mut self, name: &str, len: u64) -> Buffer<T> {
        self.declare(name, Kind::Zeroed, len)
    }

    /// A buffer that outlives the frame and changes in place. [`Graph::keep`] names its last version. A `len` of 0 is 1,
    /// as for [`Graph::input`].
    pub fn state<T: Element>(
        &mut self,
        key: &str,
        len: u64,
        initial: Initial,
    ) -> (State<T>, Buffer<T>) {
        let buffer = self.declare(key, Kind::State(initial), len);
        (
            State {
                token: self.token,
                resource: buffer.resource,
                element: PhantomData,
            },
            buffer,
        )
    }

    /// A buffer that outlives the frame, with the value of the frame before beside the new one. The new one starts
    /// undefined. A `len` of 0 is 1, as for [`Graph::input`].
    pub fn history<T: Element>(
        &mut self,
        key: &str,
        len: u64,
        initial: Initial,
    ) -> (State<T>, Previous<T>, Buffer<T>) {
        let buffer = self.declare(key, Kind::History(initial), len);
        let state = State {
            token: self.token,
            resource: buffer.resource,
            element: PhantomData,
        };
        let previous = Previous {
            token: self.token,
            resource: buffer.resource,
            len: buffer.len,
            element: PhantomData,
        };
        (state, previous, buffer)
    }

    fn declare<T: Element>(&mut self, key: &str, kind: Kind, len: u64) -> Buffer<T> {
        const { assert!(size_of::<T>() > 0, "an element of a buffer has bytes") };
        let resource = self.resources.len() as u32;
        self.resources.push(ResourceDecl {
            key: key.into(),
            kind,
            element: T::layout(),
            len: len.max(1),
            image: None,
            triangles: None,
            kept: None,
        });
        Buffer {
            token: self.token,
            resource,
            version: 0,
            len: len.max(1),
            element: PhantomData,
        }
    }

    fn declare_image<T: Texel>(&mut self, key: &str, kind: Kind, size: [u32; 2]) -> Image<T> {
        let size = size.map(|side| side.max(1));
        let resource = self.resources.len() as u32;
        self.resources.push(ResourceDecl {
            key: key.into(),
            kind,
            element: T::FORMAT.value(),
            len: u64::from(size[0]) * u64::from(size[1]),
            image: Some(ImageShape {
                format: T::FORMAT,
                size,
            }),
            triangles: None,
            kept: None,
        });
        Image {
            token: self.token,
            resource,
            version: 0,
            size,
            texel: PhantomData,
        }
    }
}
