//! Which transients share memory.
use crate::step::Step;
use crate::{Kind, Resource};

/// First and last step that touch a resource.
type Lifetime = (usize, usize);

/// Lets transients whose lifetimes do not meet share memory. `outlives` says what is read after the frame.
///
/// Sharing makes the new user of a memory wait for the old one. Only memory is taken whose last user stands before a
/// barrier that is there anyway, so that sharing adds none and stages that are independent stay so.
///
/// Greedy over the steps: a transient takes, of the memory that is free when it is first touched, the smallest that is
/// large enough, or else the largest, which then grows. One that a cache may hold takes only what is of about its size: a
/// processor's threads each go over the same part of every buffer, and of memory that was cut into other parts before, half
/// the lines would be in another core's cache.
pub(super) fn share(steps: &[Step], resources: &mut [Resource], outlives: &[bool]) {
    let lifetimes = lifetimes(steps, resources.len());
    let mut sharing: Vec<(Lifetime, usize)> = resources
        .iter()
        .enumerate()
        .filter(|(i, r)| {
            let passes = matches!(r.kind, Kind::Transient | Kind::Zeroed);
            passes && r.image.is_none() && r.usage.on_device() && !outlives[*i]
        })
        .filter_map(|(i, _)| Some((lifetimes[i]?, i)))
        .collect();
    // Of those that begin together, the large ones choose first.
    sharing.sort_by_key(|&((first, _), i)| (first, std::cmp::Reverse(resources[i].bytes), i));
    // Per step, the last barrier up to it.
    let mut fence = 0;
    let fences: Vec<usize> = (0..)
        .zip(steps)
        .map(|(i, step)| {
            if !step.hazards.is_empty() {
                fence = i;
            }
            fence
        })
        .collect();
    let mut homes: Vec<(usize, usize)> = Vec::new();
    for ((first, last), i) in sharing {
        let bytes = resources[i].bytes;
        let free = homes.iter_mut().filter(|(home, until)| {
            let fits = !CACHED.contains(&bytes) || is_alike(resources[*home].room, bytes);
            *until < fences[first] && fits
        });
        let best = free.min_by_key(|(home, _)| {
            let room = resources[*home].room;
            if room >= bytes {
                (0, room)
            } else {
                (1, u64::MAX - room)
            }
        });
        match best {
            Some((home, until)) => {
                *until = last;
                resources[i].home = *home as u32;
                resources[i].room = 0;
                resources[*home].room = resources[*home].room.max(bytes);
            }
            None => homes.push((i, last)),
        }
    }
}

/// Sizes of transients, bytes, that do not take what is of another size: smaller ones have few lines, and of larger ones no cache
/// has kept any.
const CACHED: std::ops::RangeInclusive<u64> = 64 << 10..=16 << 20;

/// Whether sizes differ by no more than a quarter.
fn is_alike(a: u64, b: u64) -> bool {
    let (less, more) = (a.min(b), a.max(b));
    more - less <= less / 4
}

fn lifetimes(steps: &[Step], resources: usize) -> Vec<Option<Lifetime>> {
    let mut lifetimes: Vec<Option<Lifetime>> = vec![None; resources];
    for (i, step) in steps.iter().enumerate() {
        for (resource, _) in step.touches() {
            let lifetime = &mut lifetimes[resource as usize];
            *lifetime = Some((lifetime.map_or(i, |(first, _)| first), i));
        }
    }
    lifetimes
}
