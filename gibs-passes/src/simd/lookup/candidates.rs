//! Pairs of point and surfel whose weights are not known yet.
#![allow(unsafe_code)]
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

use super::pairs::{FULL, ROOM};

/// For each mask of eight lanes, those that are set, in order, a byte each.
static SET: [u64; 256] = {
    let mut all = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask & (1 << lane) != 0 {
                all[mask] |= lane << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    all
};

/// The lanes that a mask of eight names, in order, and zeros.
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub fn set_lanes(mask: u32) -> __m256i {
    _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(SET[mask as usize & 0xff] as i64))
}

/// Surfels that may reach points, in the order of the points and, for each, of its list. What has not been written is not read.
pub struct Candidates {
    surfels: [MaybeUninit<u32>; ROOM],
    points: [MaybeUninit<u32>; ROOM],
    count: usize,
}

impl Candidates {
    /// None.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            surfels: [const { MaybeUninit::uninit() }; ROOM],
            points: [const { MaybeUninit::uninit() }; ROOM],
            count: 0,
        }
    }

    /// The surfels.
    #[inline(always)]
    pub fn surfels(&self) -> impl Iterator<Item = usize> {
        // SAFETY: `Filling` has written what is below the count.
        let written = |surfel: &MaybeUninit<u32>| unsafe { surfel.assume_init() } as usize;
        self.surfels[..self.count].iter().map(written)
    }

    /// Goes on behind the last pair.
    #[inline(always)]
    pub fn filling(&mut self) -> Filling<'_> {
        Filling {
            count: self.count,
            line: self,
        }
    }

    /// Calls `each` with the surfels and points of all pairs, eight at a time, and with how many of them there are, the others being of
    /// surfel and point 0; there are none afterwards.
    #[inline(always)]
    pub fn take(&mut self, mut each: impl FnMut([u32; 8], [u32; 8], usize)) {
        let end = self.count;
        assert!(end + 8 <= ROOM, "{end} pairs in a line of {ROOM}");
        self.surfels[end..end + 8].fill(MaybeUninit::new(0));
        self.points[end..end + 8].fill(MaybeUninit::new(0));
        let from = |line: &[MaybeUninit<u32>; ROOM], start: usize| {
            // SAFETY: eight elements from any start below the count on end within the eight behind the last pair, which were
            // written here; those before were by `Filling`.
            unsafe { line.as_ptr().add(start).cast::<[u32; 8]>().read_unaligned() }
        };
        for start in (0..end).step_by(8) {
            let (surfels, points) = (from(&self.surfels, start), from(&self.points, start));
            each(surfels, points, (end - start).min(8));
        }
        self.count = 0;
    }
}

/// A line that pairs are appended to. It has the count to itself until it is dropped, so that no store of a pair stands between two
/// of the count: the compiler keeps it in a register, and one append does not wait for the count of the one before to come back from memory.
pub struct Filling<'a> {
    line: &'a mut Candidates,
    count: usize,
}

impl Drop for Filling<'_> {
    #[inline(always)]
    fn drop(&mut self) {
        self.line.count = self.count;
    }
}

impl Filling<'_> {
    /// Whether the line takes no more.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count >= FULL
    }

    /// Appends those of eight surfels that a mask names, each with the point that all lanes of `point` have.
    #[inline]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    pub fn append(&mut self, mask: u32, surfels: __m256i, point: __m256i) {
        let room = self.count..self.count + 8;
        let (to, of) = (
            &mut self.line.surfels[room.clone()],
            &mut self.line.points[room],
        );
        // SAFETY: the stores write the eight words of each slice and need no alignment.
        unsafe {
            let surfels = _mm256_permutevar8x32_epi32(surfels, set_lanes(mask));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), surfels);
            _mm256_storeu_si256(of.as_mut_ptr().cast(), point);
        }
        self.count += (mask & 0xff).count_ones() as usize;
    }

    /// Appends those of sixteen surfels that a mask names, each with the point that all lanes of `point` have.
    #[inline]
    #[target_feature(
        enable = "avx512f,avx512bw,avx512vl,avx512vnni,avx2,fma,bmi1,bmi2,lzcnt,popcnt"
    )]
    pub fn append_sixteen(&mut self, mask: u16, surfels: __m512i, point: __m512i) {
        let room = self.count..self.count + 16;
        let (to, of) = (
            &mut self.line.surfels[room.clone()],
            &mut self.line.points[room],
        );
        // SAFETY: the stores write the sixteen words of each slice and need no alignment.
        unsafe {
            let surfels = _mm512_maskz_compress_epi32(mask, surfels);
            _mm512_storeu_si512(to.as_mut_ptr().cast(), surfels);
            _mm512_storeu_si512(of.as_mut_ptr().cast(), point);
        }
        self.count += mask.count_ones() as usize;
    }
}
