//! The 32-bit numbers that an element consists of.
use crate::{Layout, Scalar};

/// One number of an element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Leaf {
    /// As one would write it behind the element, `.mean.y`; empty for an element that is one number.
    pub name: String,
    /// Bytes from the start of the element.
    pub offset: usize,
    pub scalar: Scalar,
    /// The vector or array that it is part of, as leaves `from..to`; itself where there is none.
    pub from: usize,
    pub to: usize,
}

/// The numbers of an element in the order of memory; padding is none.
pub(crate) fn leaves(element: &Layout) -> Vec<Leaf> {
    let mut found = Vec::new();
    collect(element, "", 0, &mut found);
    found
}

fn collect(layout: &Layout, name: &str, offset: usize, found: &mut Vec<Leaf>) {
    let from = found.len();
    match layout {
        Layout::Scalar(scalar) => found.push(Leaf {
            name: name.into(),
            offset,
            scalar: *scalar,
            from,
            to: from + 1,
        }),
        Layout::Vector(scalar, n) => {
            for i in 0..*n as usize {
                found.push(Leaf {
                    name: format!("{name}.{}", ["x", "y", "z", "w"][i.min(3)]),
                    offset: offset + 4 * i,
                    scalar: *scalar,
                    from,
                    to: from + *n as usize,
                });
            }
        }
        Layout::Array {
            element,
            count,
            stride,
        } => {
            for i in 0..*count as usize {
                let at = offset + i * *stride as usize;
                collect(element, &format!("{name}[{i}]"), at, found);
            }
            if matches!(**element, Layout::Scalar(_)) {
                let to = found.len();
                for leaf in &mut found[from..] {
                    (leaf.from, leaf.to) = (from, to);
                }
            }
        }
        Layout::Struct { fields, .. } => {
            for field in fields {
                let name = format!("{name}.{}", field.name);
                collect(&field.layout, &name, offset + field.offset as usize, found);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Element;

    crate::element! {
        /// What a test needs.
        pub struct Mixed {
            /// A vector.
            place: glam::Vec3,
            /// An integer.
            count: u32,
            /// Numbers of one magnitude.
            moments: [f32; 2],
            /// Vectors of their own.
            rows: [glam::Vec2; 2],
        }
    }

    #[test]
    fn names_places_and_groups_are_those_of_the_struct() {
        let found = leaves(&Mixed::layout());
        let described: Vec<_> = found
            .iter()
            .map(|l| (l.name.as_str(), l.offset, l.from..l.to))
            .collect();
        assert_eq!(
            described,
            [
                (".place.x", 0, 0..3),
                (".place.y", 4, 0..3),
                (".place.z", 8, 0..3),
                (".count", 12, 3..4),
                (".moments[0]", 16, 4..6),
                (".moments[1]", 20, 4..6),
                (".rows[0].x", 24, 6..8),
                (".rows[0].y", 28, 6..8),
                (".rows[1].x", 32, 8..10),
                (".rows[1].y", 36, 8..10),
            ]
        );
        assert_eq!(leaves(&u32::layout())[0].name, "");
    }
}
