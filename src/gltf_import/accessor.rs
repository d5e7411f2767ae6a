//! Checked reading of accessors: any component type, normalized or not, strided, sparse.
//!
//! All bounds are checked once, when an accessor is opened; reading an element then cannot fail. Elements are read one
//! by one, so that a primitive which uses few vertices of a large accessor costs little.
use super::error::ImportError;
use super::source::Source;
use gltf::json::Index;
use gltf::json::accessor::{
    Accessor, ComponentType, GenericComponentType, IndexComponentType, Type, sparse,
};
use gltf::json::validation::Checked;

/// An accessor whose elements are all within bounds.
pub(super) struct Elements<'a> {
    /// Number of elements.
    pub(super) count: usize,
    component: ComponentType,
    normalized: bool,
    /// Bytes per element.
    size: usize,
    /// Bytes from one element to the next.
    stride: usize,
    /// From the first element on; `None` reads as zero.
    base: Option<&'a [u8]>,
    sparse: Option<Replaced<'a>>,
}

/// Elements of a sparse accessor that differ from its base.
struct Replaced<'a> {
    /// Strictly increasing.
    places: Vec<u32>,
    /// One element each, tightly packed.
    values: &'a [u8],
}

/// More elements than this without data behind them, of all accessors whenever they are read, are a mistake rather than a model.
const MAX_ZERO_ELEMENTS: u64 = 1 << 26;

impl Source {
    /// Opens an accessor of numbers that is of one of `types`.
    pub(super) fn reals(
        &self,
        index: Index<Accessor>,
        types: &[Type],
        owner: &dyn Fn() -> String,
    ) -> Result<Elements<'_>, ImportError> {
        self.elements(index, types, owner)
    }

    /// Opens an accessor of unsigned integers (indices, joints).
    pub(super) fn integers(
        &self,
        index: Index<Accessor>,
        kind: Type,
        owner: &dyn Fn() -> String,
    ) -> Result<Elements<'_>, ImportError> {
        let elements = self.elements(index, &[kind], owner)?;
        match elements.component {
            ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => Ok(elements),
            other => {
                let problem = format!(
                    "has components of type {other:?} where {} needs unsigned integers; use 5121, 5123 or 5125",
                    owner()
                );
                Err(self.error(format!("accessors[{}]", index.value()), problem))
            }
        }
    }

    fn elements(
        &self,
        index: Index<Accessor>,
        types: &[Type],
        owner: &dyn Fn() -> String,
    ) -> Result<Elements<'_>, ImportError> {
        let accessor = self.get(&self.root.accessors, "accessor", index, owner)?;
        let element = || format!("accessors[{}]", index.value());
        let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
            let found = self.stated(&format!("/accessors/{}/componentType", index.value()));
            let problem =
                format!("has componentType {found}; it must be 5120 to 5123, 5125 or 5126");
            return Err(self.error(element(), problem));
        };
        let kind = match accessor.type_ {
            Checked::Valid(kind) if types.contains(&kind) => kind,
            Checked::Valid(kind) => {
                return Err(self.error(
                    element(),
                    format!("has type {kind:?} where {} needs {types:?}; refer to an accessor of that type", owner()),
                ));
            }
            Checked::Invalid => {
                let found = self.stated(&format!("/accessors/{}/type", index.value()));
                let problem =
                    format!("has type {found}; it must be SCALAR, VEC2 to VEC4 or MAT2 to MAT4");
                return Err(self.error(element(), problem));
            }
        };
        let size = component.size() * kind.multiplicity();
        let mut stride = size;
        let mut base = None;
        if let Some(view) = accessor.buffer_view {
            let (bytes, view) = self.view(view, element)?;
            if let Some(step) = &view.byte_stride {
                stride = step.0;
            }
            if stride < size {
                let problem = format!(
                    "needs {size} bytes per element, but its bufferView's byteStride is {stride}; leave the stride out or \
                     make it as long"
                );
                return Err(self.error(element(), problem));
            }
            let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
            base = Some(self.fitting(bytes, offset, accessor.count.0, stride, size, element)?);
        } else if self.zeros(accessor.count.0) > MAX_ZERO_ELEMENTS {
            let problem = format!(
                "has no bufferView and {} elements, with which so many are read without data, more than is plausible; add the \
                 bufferView or correct the count",
                accessor.count.0
            );
            return Err(self.error(element(), problem));
        }
        let sparse = match &accessor.sparse {
            Some(sparse) => Some(self.replaced(sparse, accessor.count.0, size, element)?),
            None => None,
        };
        // In memory, or at most MAX_ZERO_ELEMENTS: fits usize.
        Ok(Elements {
            count: accessor.count.0 as usize,
            component,
            normalized: accessor.normalized,
            size,
            stride,
            base,
            sparse,
        })
    }

    /// The bytes from `offset` on, if `count` elements fit there.
    fn fitting<'a>(
        &self,
        bytes: &'a [u8],
        offset: u64,
        count: u64,
        stride: usize,
        size: usize,
        element: impl Fn() -> String,
    ) -> Result<&'a [u8], ImportError> {
        let end = match count {
            0 => Some(offset),
            _ => (count - 1)
                .checked_mul(stride as u64)
                .and_then(|start| start.checked_add(size as u64))
                .and_then(|length| length.checked_add(offset)),
        };
        if end.is_some_and(|end| end <= bytes.len() as u64) {
            return Ok(&bytes[offset as usize..]);
        }
        let problem = format!(
            "{count} elements of {size} bytes, {stride} bytes apart from byte {offset} on, do not fit its bufferView \
             of {} bytes; correct the count or export the file again",
            bytes.len()
        );
        Err(self.error(element(), problem))
    }

    fn replaced<'a>(
        &'a self,
        sparse: &sparse::Sparse,
        count: u64,
        size: usize,
        element: impl Fn() -> String,
    ) -> Result<Replaced<'a>, ImportError> {
        let Checked::Valid(IndexComponentType(component)) = sparse.indices.component_type else {
            let problem = "has sparse indices of a componentType that is unknown; it must be 5121, 5123 or 5125";
            return Err(self.error(element(), problem));
        };
        let (bytes, _) = self.view(sparse.indices.buffer_view, &element)?;
        let width = component.size();
        let bytes = self.fitting(
            bytes,
            sparse.indices.byte_offset.0,
            sparse.count.0,
            width,
            width,
            &element,
        )?;
        let (values, _) = self.view(sparse.values.buffer_view, &element)?;
        let values = self.fitting(
            values,
            sparse.values.byte_offset.0,
            sparse.count.0,
            size,
            size,
            &element,
        )?;
        let mut places: Vec<u32> = Vec::with_capacity(sparse.count.0 as usize);
        for at in bytes.chunks_exact(width).take(sparse.count.0 as usize) {
            let place = integer(component, at);
            if u64::from(place) >= count || places.last().is_some_and(|&last| last >= place) {
                let problem = format!(
                    "has sparse index {place}, which is not above the previous one and below {count}; list \
                     them in ascending order"
                );
                return Err(self.error(element(), problem));
            }
            places.push(place);
        }
        Ok(Replaced { places, values })
    }
}

impl Elements<'_> {
    /// Element `i` (below [`Self::count`]) as floats; components beyond the element's own are zero.
    pub(super) fn real<const N: usize>(&self, i: usize) -> [f32; N] {
        let mut out = [0.0; N];
        let width = self.component.size();
        for (out, bytes) in out.iter_mut().zip(self.bytes(i).chunks_exact(width)) {
            *out = real(self.component, self.normalized, bytes);
        }
        out
    }

    /// Element `i` (below [`Self::count`]) as unsigned integers.
    pub(super) fn integer<const N: usize>(&self, i: usize) -> [u32; N] {
        let mut out = [0; N];
        let width = self.component.size();
        for (out, bytes) in out.iter_mut().zip(self.bytes(i).chunks_exact(width)) {
            *out = integer(self.component, bytes);
        }
        out
    }

    /// Bytes of element `i`; none where it is zero.
    fn bytes(&self, i: usize) -> &[u8] {
        if let Some(sparse) = &self.sparse
            && let Ok(at) = sparse.places.binary_search(&(i as u32))
        {
            return &sparse.values[at * self.size..][..self.size];
        }
        self.base
            .map_or(&[], |base| &base[i * self.stride..][..self.size])
    }
}

/// One component as a float (glTF 2.0, 3.6.2.2 for normalized integers).
fn real(component: ComponentType, normalized: bool, bytes: &[u8]) -> f32 {
    let (value, scale) = match (component, bytes) {
        (ComponentType::I8, &[a, ..]) => (f32::from(a as i8), 127.0),
        (ComponentType::U8, &[a, ..]) => (f32::from(a), 255.0),
        (ComponentType::I16, &[a, b, ..]) => (f32::from(i16::from_le_bytes([a, b])), 32767.0),
        (ComponentType::U16, &[a, b, ..]) => (f32::from(u16::from_le_bytes([a, b])), 65535.0),
        (ComponentType::U32, &[a, b, c, d, ..]) => {
            (u32::from_le_bytes([a, b, c, d]) as f32, u32::MAX as f32)
        }
        (ComponentType::F32, &[a, b, c, d, ..]) => return f32::from_le_bytes([a, b, c, d]),
        _ => return 0.0,
    };
    if normalized {
        (value / scale).max(-1.0)
    } else {
        value
    }
}

/// One component of an unsigned integer type.
fn integer(component: ComponentType, bytes: &[u8]) -> u32 {
    match (component, bytes) {
        (ComponentType::U8, &[a, ..]) => a.into(),
        (ComponentType::U16, &[a, b, ..]) => u16::from_le_bytes([a, b]).into(),
        (ComponentType::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}
