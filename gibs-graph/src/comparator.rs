//! What counts as the same: how the values of one port, made by two backends from equal inputs, are held against each other.
use crate::{Element, Layout};
use bytemuck::Pod;
use serde::{Serialize, Serializer};
use std::ops::Range;

/// How the values of a port are compared. Integers are always equal or different; what is said here is about floats and
/// order.
///
/// A stage names one per port that it writes, in [`stage!`](crate::stage!); without, [`Comparator::ROUNDING`] holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparator {
    /// How far floats may be apart.
    pub floats: Floats,
    /// Which elements are held against each other.
    pub order: Order,
    /// Infinities and NaN are values; elsewhere each is a difference, even where both backends have it.
    pub non_finite: bool,
    /// Why this is right.
    pub reason: &'static str,
}

/// How far two floats may be apart. An ULP of `x` is `2^(floor(log2 |x|) - 23)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Floats {
    /// Not at all; `0.0` and `-0.0` are apart.
    Exact,
    /// So many ULP of the larger of the two.
    Ulps(u32),
    /// So many ULP of the largest component of the vector or array that it is part of, on either side: the error of a sum
    /// of products is one of its terms.
    Scaled(u32),
    /// That much.
    Absolute(f32),
}

/// Which elements are held against each other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Those of equal index.
    InOrder,
    /// The smallest with the smallest, and so on, as byte strings: a multiset.
    Any,
    /// As [`Order::Any`], within each of several ranges: lists whose places are fixed, and which threads fill in the order
    /// of their arrival.
    AnyWithin(Lists),
}

/// Where the lists of a port lie.
#[derive(Clone, Copy)]
pub struct Lists {
    /// What the lists are, for reports.
    pub name: &'static str,
    /// Ranges of elements, from the ports of the stage after it ran.
    pub of: fn(&Ports<'_>) -> Vec<Range<usize>>,
    /// Of so many elements of the port, those that lists may take, from the first on. A list that ends beyond them did not fit:
    /// which of its elements are there is chance, so they are not compared, and no later stage may read them.
    pub room: fn(usize) -> usize,
}

impl Comparator {
    /// What holds where a stage names nothing.
    pub const ROUNDING: Self = Self {
        floats: Floats::Scaled(16),
        order: Order::InOrder,
        non_finite: false,
        reason: "eight ULP on each side: sixteen roundings of half an ULP, of which a division that a device does with an \
                 error of 2.5 ULP is five; contracting a product and a sum saves one",
    };

    /// Equal to the bit.
    pub const fn exact(reason: &'static str) -> Self {
        Self {
            floats: Floats::Exact,
            reason,
            ..Self::ROUNDING
        }
    }

    /// See [`Floats::Ulps`].
    pub const fn ulps(ulps: u32, reason: &'static str) -> Self {
        Self {
            floats: Floats::Ulps(ulps),
            reason,
            ..Self::ROUNDING
        }
    }

    /// See [`Floats::Scaled`].
    pub const fn scaled(ulps: u32, reason: &'static str) -> Self {
        Self {
            floats: Floats::Scaled(ulps),
            reason,
            ..Self::ROUNDING
        }
    }

    /// See [`Floats::Absolute`].
    pub const fn absolute(most: f32, reason: &'static str) -> Self {
        Self {
            floats: Floats::Absolute(most),
            reason,
            ..Self::ROUNDING
        }
    }

    /// The elements of equal content, wherever they are.
    pub const fn in_any_order(self) -> Self {
        Self {
            order: Order::Any,
            ..self
        }
    }

    /// The same within each list.
    pub const fn in_any_order_within(self, lists: Lists) -> Self {
        Self {
            order: Order::AnyWithin(lists),
            ..self
        }
    }

    /// Infinities and NaN are values here.
    pub const fn with_non_finite(self) -> Self {
        Self {
            non_finite: true,
            ..self
        }
    }

    /// Where two floats of an unequal bit pattern may still be the same.
    pub fn is_exact(&self) -> bool {
        self.floats == Floats::Exact
    }
}

impl Floats {
    /// How much one float may be off; `scale` is the largest magnitude around it, `largest` that of the two.
    pub(crate) fn allowed(self, largest: f32, scale: f32) -> f64 {
        match self {
            Floats::Exact => 0.0,
            Floats::Ulps(n) => f64::from(n) * ulp(largest),
            Floats::Scaled(n) => f64::from(n) * ulp(scale),
            Floats::Absolute(most) => f64::from(most),
        }
    }
}

/// One ULP of a magnitude; that of the smallest normal number for what is below it.
pub(crate) fn ulp(magnitude: f32) -> f64 {
    let exponent = (magnitude.to_bits() >> 23 & 0xff).clamp(1, 254) as i32;
    f64::from(exponent - 127 - 23).exp2()
}

impl PartialEq for Lists {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for Lists {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl Serialize for Lists {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

/// What the ports of a stage hold, by name.
#[derive(Clone, Debug, Default)]
pub struct Ports<'a>(Vec<(&'static str, &'a Layout, &'a [u8])>);

impl<'a> Ports<'a> {
    /// Adds a port.
    pub fn push(&mut self, name: &'static str, element: &'a Layout, bytes: &'a [u8]) {
        self.0.push((name, element, bytes));
    }

    /// The elements of a port; none where it is not bound or has elements of another type.
    pub fn get<T: Element + Pod>(&self, name: &str) -> Vec<T> {
        let found = self.0.iter().find(|(port, ..)| *port == name);
        match found {
            Some((_, element, bytes)) if **element == T::layout() => bytes
                .chunks_exact(size_of::<T>())
                .map(bytemuck::pod_read_unaligned)
                .collect(),
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ulp_is_the_distance_to_the_next_float() {
        for x in [1.0_f32, 1.5, 3.0e-20, 7.0e30, f32::MIN_POSITIVE] {
            let next = f32::from_bits(x.to_bits() + 1);
            assert_eq!(ulp(x), f64::from(next) - f64::from(x), "{x}");
        }
        assert_eq!(ulp(0.0), ulp(f32::MIN_POSITIVE));
        assert_eq!(ulp(f32::INFINITY), ulp(f32::MAX));
    }

    #[test]
    fn ports_give_what_has_the_type_asked_for() {
        let layout = u32::layout();
        let bytes: Vec<u8> = [1_u32, 2, 3].iter().flat_map(|x| x.to_ne_bytes()).collect();
        let mut ports = Ports::default();
        ports.push("counts", &layout, &bytes);
        assert_eq!(ports.get::<u32>("counts"), [1, 2, 3]);
        assert!(ports.get::<f32>("counts").is_empty());
        assert!(ports.get::<u32>("others").is_empty());
    }
}
