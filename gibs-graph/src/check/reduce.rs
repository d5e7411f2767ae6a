//! Shrinking a capture to what a failure needs.
use super::{Capture, CapturedSize};
use std::ops::Range;

/// A smaller capture that still fails.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// The capture, without results.
    pub capture: Capture,
    /// Bytes of input that are not zero, before and after.
    pub nonzero: [u64; 2],
    /// Candidates that were tried.
    pub tried: u32,
}

/// Shrinks a capture as long as `fails` says that what is left still fails: fewer workgroups first, then zeros in place of
/// inputs, whole buffers at first, then by halves, down to single elements (as hierarchical delta debugging does). Lengths
/// stay, since kernels ask for them. Stops after `most` candidates; what was found so far is the result then.
///
/// # Errors
/// The first that `fails` gives.
pub fn reduce<E>(
    capture: &Capture,
    most: u32,
    fails: impl FnMut(&Capture) -> Result<bool, E>,
) -> Result<Reduced, E> {
    let mut search = Search {
        best: Capture {
            results: Vec::new(),
            ..capture.clone()
        },
        tried: 0,
        most,
        fails,
    };
    for axis in 0..3 {
        search.fewer_groups(axis)?;
    }
    // Large buffers first: they have the most to lose.
    let mut order: Vec<usize> = (0..search.best.buffers.len()).collect();
    order.sort_by_key(|&id| std::cmp::Reverse(search.best.buffers[id].bytes.len()));
    for id in order {
        let elements = search.best.buffers[id].len as usize;
        search.zeros(id, 0..elements)?;
    }
    Ok(Reduced {
        nonzero: [nonzero(capture), nonzero(&search.best)],
        capture: search.best,
        tried: search.tried,
    })
}

fn nonzero(capture: &Capture) -> u64 {
    let bytes = capture.buffers.iter().flat_map(|buffer| &buffer.bytes);
    bytes.filter(|&&byte| byte != 0).count() as u64
}

struct Search<F> {
    best: Capture,
    tried: u32,
    most: u32,
    fails: F,
}

impl<E, F: FnMut(&Capture) -> Result<bool, E>> Search<F> {
    /// Makes the best capture a smaller one, if that fails as well.
    fn attempt(&mut self, change: impl FnOnce(&mut Capture)) -> Result<bool, E> {
        if self.tried >= self.most {
            return Ok(false);
        }
        self.tried += 1;
        let mut candidate = self.best.clone();
        change(&mut candidate);
        let still = (self.fails)(&candidate)?;
        if still {
            self.best = candidate;
        }
        Ok(still)
    }

    /// The fewest workgroups along an axis; those with the lowest numbers stay.
    fn fewer_groups(&mut self, axis: usize) -> Result<(), E> {
        let CapturedSize::Groups(groups) = self.best.size else {
            return Ok(()); // a device reads the number from a buffer, which is an input like others
        };
        let (mut low, mut high) = (1, groups[axis]);
        while low < high {
            let middle = low.midpoint(high);
            let still = self.attempt(|candidate| {
                if let CapturedSize::Groups(groups) = &mut candidate.size {
                    groups[axis] = middle;
                }
            })?;
            match still {
                true => high = middle,
                false => low = middle + 1,
            }
        }
        Ok(())
    }

    /// Zeros for as many of these elements as the failure does without.
    fn zeros(&mut self, id: usize, elements: Range<usize>) -> Result<(), E> {
        let buffer = &self.best.buffers[id];
        let size = buffer.element.size() as usize;
        let bytes = elements.start * size..elements.end * size;
        let given = buffer.bytes.get(bytes.clone());
        if given.is_none_or(|given| given.iter().all(|&byte| byte == 0)) {
            return Ok(());
        }
        let gone = self.attempt(|candidate| candidate.buffers[id].bytes[bytes].fill(0))?;
        if gone || elements.len() == 1 {
            return Ok(());
        }
        let middle = elements.start.midpoint(elements.end);
        self.zeros(id, elements.start..middle)?;
        self.zeros(id, middle..elements.end)
    }
}
