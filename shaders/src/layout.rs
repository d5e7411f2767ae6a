//! Layouts: what naga says of a type, and how it differs from what a port says.
use crate::names;
use gibs_graph::{Field, Layout, Scalar};
use naga::{ArraySize, Handle, Module, ScalarKind, Type, TypeInner, VectorSize};

/// The layout of a WGSL type. A matrix is an array of columns, as WGSL lays it out.
///
/// # Errors
/// Why no port can have the type.
pub(crate) fn reflect(module: &Module, ty: Handle<Type>) -> Result<Layout, String> {
    let ty = &module.types[ty];
    Ok(match &ty.inner {
        TypeInner::Scalar(number) => Layout::Scalar(scalar(*number)?),
        TypeInner::Vector {
            size,
            scalar: number,
        } => Layout::Vector(scalar(*number)?, *size as u32),
        TypeInner::Matrix {
            columns,
            rows,
            scalar: number,
        } => Layout::Array {
            element: Box::new(Layout::Vector(scalar(*number)?, *rows as u32)),
            count: *columns as u32,
            stride: if *rows == VectorSize::Bi { 8 } else { 16 },
        },
        TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            stride,
        } => Layout::Array {
            element: Box::new(reflect(module, *base)?),
            count: count.get(),
            stride: *stride,
        },
        TypeInner::Array { .. } => {
            return Err("an array within an element needs a constant length".into());
        }
        TypeInner::Struct { members, span } => Layout::Struct {
            name: ty.name.clone().unwrap_or_default(),
            size: *span,
            fields: members
                .iter()
                .map(|member| {
                    let name = member.name.clone().unwrap_or_default();
                    let layout =
                        reflect(module, member.ty).map_err(|e| format!("member `{name}`: {e}"))?;
                    Ok(Field {
                        name,
                        offset: member.offset,
                        layout,
                    })
                })
                .collect::<Result<_, String>>()?,
        },
        TypeInner::Atomic(_) => {
            return Err("atomics within a struct or an array are not supported; give them a port of their own".into());
        }
        _ => return Err("a port holds numbers, vectors, matrices, arrays and structs only".into()),
    })
}

/// A scalar that hosts and devices share.
pub(crate) fn scalar(scalar: naga::Scalar) -> Result<Scalar, String> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4) => Ok(Scalar::F32),
        (ScalarKind::Uint, 4) => Ok(Scalar::U32),
        (ScalarKind::Sint, 4) => Ok(Scalar::I32),
        _ => Err("a port holds `f32`, `u32` and `i32` only".into()),
    }
}

/// Every difference between the layout that a port declares and that of the WGSL, with the path of the member.
pub(crate) fn differences(rust: &Layout, wgsl: &Layout) -> Vec<String> {
    let mut found = Vec::new();
    compare(rust, wgsl, "", &mut found);
    found
}

fn compare(rust: &Layout, wgsl: &Layout, path: &str, found: &mut Vec<String>) {
    let at = if path.is_empty() {
        String::new()
    } else {
        format!("`{path}`: ")
    };
    match (rust, wgsl) {
        (
            Layout::Array {
                element: a,
                count: n,
                stride: s,
            },
            Layout::Array {
                element: b,
                count: m,
                stride: t,
            },
        ) => {
            if n != m {
                found.push(format!("{at}{n} elements in Rust, {m} in WGSL"));
            }
            if s != t {
                found.push(format!(
                    "{at}elements are {s} bytes apart in Rust, {t} in WGSL"
                ));
            }
            compare(a, b, &format!("{path}[]"), found);
        }
        (
            Layout::Struct {
                name: a,
                size: s,
                fields: x,
            },
            Layout::Struct {
                name: b,
                size: t,
                fields: y,
            },
        ) => {
            if a != b {
                found.push(format!(
                    "{at}struct `{a}` in Rust, `{b}` in WGSL; give both one name"
                ));
            }
            if s != t {
                found.push(format!(
                    "{at}struct `{a}` has {s} bytes in Rust, {t} in WGSL"
                ));
            }
            fields(x, y, path, found);
        }
        (a, b) if a != b => found.push(format!("{at}`{a}` in Rust, `{b}` in WGSL")),
        _ => {}
    }
}

fn fields(rust: &[Field], wgsl: &[Field], path: &str, found: &mut Vec<String>) {
    let named = |name: &str| {
        if path.is_empty() {
            name.to_owned()
        } else {
            format!("{path}.{name}")
        }
    };
    for a in rust {
        let path = named(&a.name);
        let Some(b) = wgsl.iter().find(|b| b.name == names::global(&a.name)) else {
            found.push(format!("member `{path}` is missing in WGSL"));
            continue;
        };
        if a.offset != b.offset {
            found.push(format!(
                "member `{path}` is at byte {} in Rust, {} in WGSL",
                a.offset, b.offset
            ));
        }
        compare(&a.layout, &b.layout, &path, found);
    }
    for b in wgsl
        .iter()
        .filter(|b| rust.iter().all(|a| names::global(&a.name) != b.name))
    {
        found.push(format!("member `{}` is missing in Rust", named(&b.name)));
    }
}
