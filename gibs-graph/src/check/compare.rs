//! Two results for one port, element by element.
use super::leaves::{Leaf, leaves};
use crate::comparator::ulp;
use crate::{Comparator, Layout, Order, Scalar};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// What a check fills memory with that holds nothing yet: a NaN of this pattern says that nobody has written there.
pub const UNWRITTEN: u32 = 0x7fc0_dead;

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Elements that were held against each other.
    pub elements: u64,
    /// Elements that were not: of lists that did not fit.
    pub skipped: u64,
    /// Those of which some bit differs.
    pub unequal: u64,
    /// Those that the comparator refuses, ascending.
    pub refused: Vec<u64>,
    /// The worst difference of a number.
    pub worst: Option<Difference>,
}

/// A number on two backends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Index of the element.
    pub element: u64,
    /// Field of the element; empty where it is one number.
    pub field: String,
    /// Value on the first backend.
    pub a: String,
    /// Value on the second.
    pub b: String,
    /// Distance in ULP of the larger of the two, or of the vector's largest component where that is what counts; of
    /// integers their distance. Infinite where one is not finite, which JSON writes as `null`.
    #[serde(deserialize_with = "null_is_infinite")]
    pub ulps: f64,
    /// Distance over the larger magnitude; infinite likewise.
    #[serde(deserialize_with = "null_is_infinite")]
    pub relative: f64,
    /// The comparator refuses it.
    pub refused: bool,
}

fn null_is_infinite<'de, D: serde::Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::INFINITY))
}

/// Holds `b` against `a`, the bytes of `len` elements of one layout. `lists` are those of [`Order::AnyWithin`].
///
/// Elements that one side lacks, or both, are refused.
pub fn compare(
    element: &Layout,
    len: u64,
    comparator: &Comparator,
    a: &[u8],
    b: &[u8],
    lists: &[Range<usize>],
) -> Comparison {
    let size = element.size() as usize;
    let leaves = leaves(element);
    let count = a.len().min(b.len()) / size;
    let longest = (a.len().max(b.len()) / size).max(len as usize);
    let in_order = comparator.order == Order::InOrder || a == b;
    // What the order is free within, and of that the lists that do not fit whole: they hold whatever came first, and nobody may
    // read them.
    let (free, unfit) = match comparator.order {
        Order::InOrder => (Vec::new(), Vec::new()),
        Order::Any => (std::slice::from_ref(&(0..count)).to_vec(), Vec::new()),
        Order::AnyWithin(of) => {
            let room = (of.room)(count).min(count);
            let there = lists
                .iter()
                .filter(|list| !list.is_empty() && list.start < room);
            let (fit, unfit): (Vec<_>, Vec<_>) = there.cloned().partition(|list| list.end <= room);
            let cut = unfit.into_iter().map(|list| list.start..room);
            (fit, cut.collect())
        }
    };
    let places: Option<[Vec<u32>; 2]> =
        (!in_order).then(|| [a, b].map(|bytes| sorted(bytes, size, count, &free)));
    let mut found = Comparison {
        elements: longest as u64,
        unequal: (longest - count) as u64,
        ..Comparison::default()
    };
    for i in 0..count {
        if unfit.iter().any(|list| list.contains(&i)) {
            found.elements -= 1;
            found.skipped += 1;
            continue;
        }
        let [at_a, at_b] = match &places {
            Some([a, b]) => [a[i] as usize, b[i] as usize],
            None => [i, i],
        };
        let pair = [&a[at_a * size..][..size], &b[at_b * size..][..size]];
        let equal = pair[0] == pair[1];
        if equal && (comparator.non_finite || leaves.iter().all(|l| is_sound(l, pair[0]))) {
            continue;
        }
        found.unequal += u64::from(!equal);
        let mut refused = false;
        for leaf in &leaves {
            if let Some(difference) = differ(leaf, &leaves, comparator, pair, at_a) {
                refused |= difference.refused;
                keep_worst(&mut found.worst, difference);
            }
        }
        // Bytes that belong to no number are no value.
        if refused {
            found.refused.push(at_a as u64);
        }
    }
    found.refused.sort_unstable();
    found.refused.extend((count..longest).map(|i| i as u64));
    if longest > count && found.worst.as_ref().is_none_or(|worst| !worst.refused) {
        found.worst = Some(missing(count, a.len(), b.len()));
    }
    found
}

/// How far apart two results are, element by element: the largest distance of a number, in ULP of the larger of the two
/// (integers: their distance), infinite where one side is missing or not finite. For pictures.
pub fn apart(element: &Layout, a: &[u8], b: &[u8]) -> Vec<f64> {
    let size = element.size() as usize;
    let leaves = leaves(element);
    let any = Comparator {
        non_finite: true,
        ..Comparator::ulps(0, "every difference counts")
    };
    let (count, longest) = (a.len().min(b.len()) / size, a.len().max(b.len()) / size);
    let one = |i: usize| {
        if i >= count {
            return f64::INFINITY;
        }
        let pair = [&a[i * size..][..size], &b[i * size..][..size]];
        let found = leaves
            .iter()
            .filter_map(|leaf| differ(leaf, &leaves, &any, pair, i));
        found.map(|difference| difference.ulps).fold(0.0, f64::max)
    };
    (0..longest).map(one).collect()
}

fn missing(first: usize, a: usize, b: usize) -> Difference {
    Difference {
        element: first as u64,
        field: String::new(),
        a: format!("{a} bytes"),
        b: format!("{b} bytes"),
        ulps: f64::INFINITY,
        relative: f64::INFINITY,
        refused: true,
    }
}

fn keep_worst(worst: &mut Option<Difference>, new: Difference) {
    let beats = |old: &Difference| (new.refused, new.ulps) > (old.refused, old.ulps);
    if worst.as_ref().is_none_or(beats) {
        *worst = Some(new);
    }
}

/// The elements in the order in which they are compared: by their bytes within `free` ranges.
fn sorted(bytes: &[u8], size: usize, count: usize, free: &[Range<usize>]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    let key = |i: &u32| &bytes[*i as usize * size..][..size];
    for range in free {
        order[range.clone()].sort_by(|a, b| key(a).cmp(key(b)));
    }
    order
}

fn word(leaf: &Leaf, element: &[u8]) -> u32 {
    let bytes = element.get(leaf.offset..leaf.offset + 4);
    u32::from_ne_bytes(bytes.and_then(|b| b.try_into().ok()).unwrap_or_default())
}

/// Finite, no float, or never written.
fn is_sound(leaf: &Leaf, element: &[u8]) -> bool {
    let bits = word(leaf, element);
    leaf.scalar != Scalar::F32 || bits == UNWRITTEN || f32::from_bits(bits).is_finite()
}

/// The difference of one number, if it is one. `element` is the index that it is reported with.
pub(super) fn differ(
    leaf: &Leaf,
    leaves: &[Leaf],
    comparator: &Comparator,
    pair: [&[u8]; 2],
    element: usize,
) -> Option<Difference> {
    let bits = pair.map(|bytes| word(leaf, bytes));
    let said = |[a, b]: [String; 2], ulps: f64, relative: f64, refused: bool| Difference {
        element: element as u64,
        field: leaf.name.clone(),
        a,
        b,
        ulps,
        relative,
        refused,
    };
    if leaf.scalar != Scalar::F32 {
        let values = bits.map(|bits| match leaf.scalar {
            Scalar::I32 => f64::from(bits.cast_signed()),
            _ => f64::from(bits),
        });
        let apart = (values[0] - values[1]).abs();
        let largest = values[0].abs().max(values[1].abs());
        return (apart > 0.0)
            .then(|| said(values.map(|v| v.to_string()), apart, apart / largest, true));
    }
    let values = bits.map(f32::from_bits);
    let unwritten = bits.map(|bits| bits == UNWRITTEN);
    let shown = || {
        let show = |i: usize| match unwritten[i] {
            true => "unwritten".into(),
            false => format!("{:?}", values[i]),
        };
        [show(0), show(1)]
    };
    if !values.iter().all(|v| v.is_finite()) {
        let same = bits[0] == bits[1] && (comparator.non_finite || unwritten[0]);
        // Which NaN it is counts where every bit does.
        let any_nan = comparator.non_finite && !comparator.is_exact();
        let both_nan = any_nan && values.iter().all(|v| v.is_nan());
        let same = same || (both_nan && unwritten[0] == unwritten[1]);
        return (!same).then(|| said(shown(), f64::INFINITY, f64::INFINITY, true));
    }
    if bits[0] == bits[1] {
        return None;
    }
    let apart = (f64::from(values[0]) - f64::from(values[1])).abs();
    let largest = values[0].abs().max(values[1].abs());
    let group = &leaves[leaf.from..leaf.to];
    let magnitude = |leaf: &Leaf, bytes: &[u8]| f32::from_bits(word(leaf, bytes)).abs();
    let scale = group
        .iter()
        .flat_map(|leaf| pair.map(|bytes| magnitude(leaf, bytes)))
        .filter(|x| x.is_finite())
        .fold(largest, f32::max);
    let allowed = comparator.floats.allowed(largest, scale);
    let unit = match comparator.floats {
        crate::Floats::Scaled(_) => ulp(scale),
        _ => ulp(largest),
    };
    // Zeros of two signs are apart only where every bit counts.
    let refused = apart > allowed || comparator.is_exact();
    let relative = apart / f64::from(largest).max(f64::MIN_POSITIVE);
    Some(said(shown(), apart / unit, relative, refused))
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
