//! How far the outputs of a stage move when its inputs move by one rounding.
use super::compare::{UNWRITTEN, differ};
use super::isolate::Isolated;
use super::leaves::leaves;
use crate::{Backend, BackendError, Comparator, Layout, ResourceId, Scalar};

/// Runs with moved inputs. Of a decision that half of them take the other way, one in 256 is missed.
const RUNS: u32 = 8;

/// A difference is explained up to this many times what moved inputs did: they are a sample, not the worst case.
const SPREAD: f64 = 4.0;

/// Most undecided elements among `elements` of a port in one frame: a thousandth, and at least one.
pub fn undecided_cap(elements: u64) -> u64 {
    (elements / 1000).max(1)
}

/// What a stage gives when its inputs are as they are, and when they are moved by at most one ULP each.
pub(crate) struct Condition {
    /// For each resource of the isolated schedule, its bytes after the first run and after each moved one; empty where the
    /// step does not write it.
    outputs: Vec<Vec<Vec<u8>>>,
}

impl Condition {
    /// Runs the step on `oracle`. `contents` are those of the isolated schedule's resources, before the step.
    pub fn measure(
        oracle: &dyn Backend,
        isolated: &Isolated,
        contents: &[&[u8]],
    ) -> Result<Self, BackendError> {
        let schedule = &isolated.schedule;
        let mut exec = oracle.prepare(schedule.clone())?;
        let mut outputs = vec![Vec::new(); contents.len()];
        for run in 0..=RUNS {
            for (id, (bytes, resource)) in (0..).zip(contents.iter().zip(&schedule.resources)) {
                match run {
                    0 => exec.upload(id, 0, bytes)?,
                    _ => exec.upload(id, 0, &moved(&resource.element, bytes, run))?,
                }
            }
            exec.run_step(0)?;
            for output in &schedule.outputs {
                outputs[output.resource as usize].push(exec.read(output.resource)?);
            }
        }
        Ok(Self { outputs })
    }

    /// Whether moved inputs change what the comparator refuses of an element of a resource as much as `a` and `b` differ.
    pub fn explains(
        &self,
        resource: ResourceId,
        element: &Layout,
        index: u64,
        [a, b]: [&[u8]; 2],
        comparator: &Comparator,
    ) -> bool {
        let outputs = &self.outputs[resource as usize];
        let first = index as usize * element.size() as usize;
        let last = first + element.size() as usize;
        let (Some(in_a), Some(in_b)) = (a.get(first..last), b.get(first..last)) else {
            return false; // bytes that are missing have no reason
        };
        let leaves = leaves(element);
        leaves.iter().all(|leaf| {
            let found = differ(leaf, &leaves, comparator, [in_a, in_b], index as usize);
            if found.is_none_or(|difference| !difference.refused) {
                return true;
            }
            let at = first + leaf.offset;
            let word = |bytes: &[u8]| {
                let found = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
                found.map(u32::from_ne_bytes)
            };
            let (Some(x), Some(y)) = (word(a), word(b)) else {
                return false;
            };
            if x == y {
                return false; // no number on both
            }
            let Some((base, moved)) = outputs.split_first() else {
                return false;
            };
            let base: Option<u32> = word(base);
            let moved: Vec<_> = moved.iter().map(|bytes| word(bytes)).collect();
            let [p, q] = [x, y].map(|bits| f64::from(f32::from_bits(bits)));
            if leaf.scalar == Scalar::F32 && p.is_finite() && q.is_finite() {
                let value = |bits: Option<u32>| bits.map_or(f64::NAN, |b| f32::from_bits(b).into());
                let spread = moved
                    .iter()
                    .map(|&bits| (value(bits) - value(base)).abs())
                    // An overflow on the way says nothing of values that did not.
                    .filter(|apart| apart.is_finite())
                    .fold(0.0, f64::max);
                return (p - q).abs() <= SPREAD * spread;
            }
            if leaf.scalar == Scalar::F32 {
                // What is no number has a reason only where moved inputs give none either.
                let is_number = |bits: u32| bits == UNWRITTEN || f32::from_bits(bits).is_finite();
                return x != UNWRITTEN
                    && y != UNWRITTEN
                    && moved.iter().flatten().any(|&bits| !is_number(bits));
            }
            // An integer has no distance: it may be an index, a mask or two halves. What decided about it explains it only
            // where moved inputs give the very values that the two have.
            let given = |bits: u32| base == Some(bits) || moved.contains(&Some(bits));
            given(x) && given(y)
        })
    }
}

/// The bytes of elements with each float moved up, down or not at all, by chance.
fn moved(element: &Layout, bytes: &[u8], run: u32) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let size = element.size() as usize;
    let floats: Vec<usize> = leaves(element)
        .iter()
        .filter(|leaf| leaf.scalar == Scalar::F32)
        .map(|leaf| leaf.offset)
        .collect();
    if floats.is_empty() {
        return bytes;
    }
    let mut state = u64::from(run).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for element in bytes.chunks_exact_mut(size) {
        for &at in &floats {
            let Ok(word) = <&mut [u8; 4]>::try_from(&mut element[at..at + 4]) else {
                continue;
            };
            let bits = u32::from_ne_bytes(*word);
            // A Weyl sequence, mixed: what is needed is that neighbours move apart.
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ (state >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 40;
            let magnitude = bits & 0x7fff_ffff;
            // Zero is often exact, and the largest and what is no number stay as they are.
            if magnitude == 0 || magnitude >= f32::MAX.to_bits() {
                continue;
            }
            let step = (mixed % 3) as u32;
            *word = bits.wrapping_add(step).wrapping_sub(1).to_ne_bytes();
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Element;
    use bytemuck::cast_slice;

    #[test]
    fn floats_move_by_an_ulp_at_most_and_nothing_else_moves() {
        let values = [
            1.0_f32,
            -1.0,
            0.0,
            f32::MAX,
            f32::INFINITY,
            f32::from_bits(UNWRITTEN),
        ];
        let many: Vec<f32> = values.iter().copied().cycle().take(600).collect();
        let mut steps = [0; 3];
        let after = moved(&f32::layout(), cast_slice(&many), 1);
        let after: &[f32] = cast_slice(&after);
        for (x, y) in many.iter().zip(after) {
            let step = y.to_bits().wrapping_sub(x.to_bits()).wrapping_add(1);
            assert!(step <= 2, "{x} became {y}");
            if x.abs() == 1.0 {
                steps[step as usize] += 1;
            } else {
                assert_eq!(x.to_bits(), y.to_bits());
            }
        }
        assert!(steps.iter().all(|&n| n > 40), "{steps:?}");
        let integers = [5_u32; 10];
        assert_eq!(
            moved(&u32::layout(), cast_slice(&integers), 1),
            cast_slice::<_, u8>(&integers)
        );
    }
}
