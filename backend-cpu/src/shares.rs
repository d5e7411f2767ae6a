//! Which thread runs which pieces of a dispatch.
//!
//! Steps that follow each other mostly go over the same rays, pixels or surfels in the same order. A thread that takes the
//! same part of each finds in its own cache what it wrote a step before. Were all pieces taken from one count, half of the
//! lines would come from another core, which triples the time of short steps where cores have no cache in common.
use std::sync::atomic::{AtomicU64, Ordering};

/// What is left of a thread's part: the first piece in the low half, the one past the last in the high half. Two cache lines each,
/// which processors fetch together.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Share(AtomicU64);

fn packed(first: u32, end: u32) -> u64 {
    u64::from(first) | u64::from(end) << 32
}

fn unpacked(left: u64) -> (u32, u32) {
    (left as u32, (left >> 32) as u32)
}

impl Share {
    /// One piece from where its thread goes on, or from the other end. Nothing but the numbers goes by it: who waits for the
    /// threads sees what their kernels wrote.
    fn take(&self, from_end: bool) -> Option<u32> {
        let less = |left| match unpacked(left) {
            (first, end) if first >= end => None,
            (first, end) if from_end => Some(packed(first, end - 1)),
            (first, end) => Some(packed(first + 1, end)),
        };
        let update = self
            .0
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
        let (first, end) = unpacked(update.ok()?);
        Some(if from_end { end - 1 } else { first })
    }
}

/// Looks at the others before a thread leaves them: about a tenth of a millisecond where nobody else wants the processor.
const PATIENCE: u32 = 128;

/// Pauses between two looks.
const SPINS: u32 = 16;

/// The parts of all threads.
#[derive(Debug)]
pub(crate) struct Shares {
    shares: Box<[Share]>,
    /// Pieces that no thread has said to be done.
    unfinished: AtomicU64,
}

impl Shares {
    pub fn new(threads: usize) -> Self {
        Self {
            shares: (0..threads.max(1)).map(|_| Share::default()).collect(),
            unfinished: AtomicU64::new(0),
        }
    }

    /// Runs all of so many pieces, on a thread of the pool.
    pub fn run(&mut self, pieces: u32, piece: impl Fn(u32) + Sync) {
        self.deal(pieces);
        let shares = &*self;
        let work = || {
            let thread = rayon::current_thread_index().unwrap_or(0);
            let mut done = 0;
            while let Some(place) = shares.next(thread) {
                done += 1;
                piece(place);
            }
            shares.finish(done);
        };
        on_threads(self.shares.len().min(pieces as usize), &work);
    }

    /// Deals out `pieces` in order, to each thread as many, give or take one.
    fn deal(&mut self, pieces: u32) {
        let threads = self.shares.len() as u64;
        *self.unfinished.get_mut() = u64::from(pieces);
        // Below 2^32: thread <= threads.
        let bound = |thread: u64| (u64::from(pieces) * thread / threads) as u32;
        for (thread, share) in (0..).zip(&mut self.shares) {
            *share.0.get_mut() = packed(bound(thread), bound(thread + 1));
        }
    }

    /// The next piece for a thread: of its own, then the last ones of others.
    fn next(&self, thread: usize) -> Option<u32> {
        let threads = self.shares.len();
        let own = thread % threads;
        let others = || (1..threads).find_map(|n| self.shares[(own + n) % threads].take(true));
        self.shares[own].take(false).or_else(others)
    }

    /// Says that a thread has done so many pieces and found no more, and stays for the others' last ones, which take
    /// microseconds. Sent back to its pool at once, it would fall asleep and be late for the next step by what the system
    /// takes to wake it. Where others take long, or never say so because a kernel panicked, it leaves.
    fn finish(&self, pieces: u64) {
        let left = self.unfinished.fetch_sub(pieces, Ordering::Relaxed) - pieces;
        if left == 0 {
            return;
        }
        for _ in 0..PATIENCE {
            if self.unfinished.load(Ordering::Relaxed) == 0 {
                return;
            }
            for _ in 0..SPINS {
                std::hint::spin_loop();
            }
            // Who waits has nothing to do: where other programs wait for the processor, they go first.
            std::thread::yield_now();
        }
    }
}

/// Runs `work` as often as there are threads that may take part, and allocates nothing for it.
fn on_threads(threads: usize, work: &(impl Fn() + Sync)) {
    match threads {
        0 | 1 => work(),
        _ => {
            let half = threads / 2;
            rayon::join(
                || on_threads(threads - half, work),
                || on_threads(half, work),
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Shares;

    #[test]
    fn a_thread_goes_forward_and_then_helps_from_the_end() {
        let mut shares = Shares::new(2);
        shares.deal(7);
        let taken: Vec<_> = std::iter::from_fn(|| shares.next(1)).collect();
        assert_eq!(taken, [3, 4, 5, 6, 2, 1, 0]);
        shares.deal(2);
        assert_eq!(
            [shares.next(0), shares.next(0), shares.next(0)],
            [Some(0), Some(1), None]
        );
    }

    #[test]
    fn every_piece_is_taken_once_by_threads_that_race() {
        for (threads, pieces) in [(1, 5), (3, 0), (3, 2), (4, 100_000)] {
            let mut shares = Shares::new(threads);
            shares.deal(pieces);
            let mut taken: Vec<u32> = std::thread::scope(|scope| {
                let shares = &shares;
                let run = |t| scope.spawn(move || std::iter::from_fn(|| shares.next(t)).collect());
                let running: Vec<_> = (0..threads).map(run).collect();
                let join = |run: std::thread::ScopedJoinHandle<'_, Vec<u32>>| run.join();
                running
                    .into_iter()
                    .flat_map(|run| join(run).expect("it runs"))
                    .collect()
            });
            taken.sort_unstable();
            assert_eq!(taken, (0..pieces).collect::<Vec<_>>());
        }
    }

    #[test]
    fn the_largest_dispatch_is_dealt_out() {
        let mut shares = Shares::new(3);
        shares.deal(u32::MAX);
        assert_eq!(shares.next(2), Some(2_863_311_530));
        assert_eq!(Shares::new(0).next(5), None);
    }

    #[test]
    fn nobody_waits_for_one_that_never_says_it_is_done() {
        let mut shares = Shares::new(2);
        shares.deal(3);
        shares.finish(2);
        shares.finish(1);
    }
}
