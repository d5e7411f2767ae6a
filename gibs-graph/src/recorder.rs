//! Binding the ports of a stage while it is added.
use crate::graph::BindingDecl;
use crate::handle::GraphToken;
use crate::{
    Acceleration, Access, Buffer, DispatchArgs, Element, GraphError, Image, Previous, Sampled,
    Stored,
};

/// Collects the bindings of a stage while it is added. For [`stage!`](crate::stage!) alone: a method per access, which
/// takes the handle that suits it, so that no stage can bind a resource otherwise than the graph believes.
#[derive(Debug)]
pub struct Recorder<'r> {
    pub(crate) token: GraphToken,
    pub(crate) stage: &'r str,
    pub(crate) bindings: &'r mut Vec<BindingDecl>,
    pub(crate) errors: &'r mut Vec<GraphError>,
}

macro_rules! reads {
    ($($name:ident $access:ident)*) => {
        $(
            #[doc(hidden)]
            pub fn $name<T: Element>(&mut self, handle: &Buffer<T>, port: &'static str) {
                self.bind_buffer(handle, port, Access::$access);
            }
        )*
    };
}

macro_rules! writes {
    ($($name:ident $access:ident)*) => {
        $(
            #[doc(hidden)]
            pub fn $name<T: Element>(&mut self, handle: Buffer<T>, port: &'static str) -> Buffer<T> {
                self.bind_buffer(&handle, port, Access::$access);
                Buffer {
                    version: handle.version + 1,
                    ..handle
                }
            }
        )*
    };
}

impl Recorder<'_> {
    reads! {
        uniform Uniform
        read Read
        host_only HostOnly
    }

    writes! {
        write Write
        read_write ReadWrite
        atomic Atomic
    }

    #[doc(hidden)]
    pub fn previous<T: Element>(&mut self, handle: &Previous<T>, port: &'static str) {
        self.bind(handle.token, handle.resource, None, port, Access::Previous);
    }

    #[doc(hidden)]
    pub fn acceleration(&mut self, handle: &Acceleration, port: &'static str) {
        self.bind_buffer(&handle.0, port, Access::Acceleration);
    }

    #[doc(hidden)]
    pub fn sampled<T: Sampled>(&mut self, image: &Image<T>, port: &'static str) {
        let version = Some(image.version);
        self.bind(image.token, image.resource, version, port, Access::Sampled);
    }

    #[doc(hidden)]
    pub fn stored<T: Stored>(&mut self, image: Image<T>, port: &'static str) -> Image<T> {
        let version = Some(image.version);
        self.bind(image.token, image.resource, version, port, Access::Stored);
        Image {
            version: image.version + 1,
            ..image
        }
    }

    /// The sizes of an indirect dispatch, which are no port.
    pub(crate) fn indirect(&mut self, args: &Buffer<DispatchArgs>) {
        self.bind_buffer(args, "(indirect)", Access::Indirect);
    }

    fn bind_buffer<T>(&mut self, handle: &Buffer<T>, port: &'static str, access: Access) {
        let version = Some(handle.version);
        self.bind(handle.token, handle.resource, version, port, access);
    }

    fn bind(
        &mut self,
        token: GraphToken,
        resource: u32,
        version: Option<u32>,
        port: &'static str,
        access: Access,
    ) {
        if token == self.token {
            self.bindings.push(BindingDecl {
                port,
                resource,
                version,
                access,
            });
        } else {
            self.errors.push(GraphError::ForeignHandle {
                stage: self.stage.into(),
                port: port.into(),
            });
        }
    }
}
