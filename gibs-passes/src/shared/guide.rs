//! Ray guiding (GIBS, "Ray Guiding"): a moving average of luminance over a surfel's hemisphere, in a square of texels
//! (hemi-octahedral, Cigolle et al. 2014), 6x6 by default, that rays are drawn from by walking its distribution.
//!
//! A texel holds the root of the mean square of luminance: the density of least variance is proportional to that times the
//! cosine, and not to the mean, where light varies within a texel (Rath et al. 2020, "Variance-Aware Path Guiding").
//!
//! A surfel learns from the rays of its neighbours and not from its own. There are more of those, and what its own sequence
//! of directions has visited says where the next ones go, so that a guide that knew it would bias the mean.
use super::hash::ALMOST_ONE;
use super::octahedral::{hemisphere_decode, hemisphere_encode};
use glam::{Vec2, Vec3};

/// Most texels along each side; a side is even.
pub const MOST_SIDE: u32 = 8;

/// Most texels of a guide.
pub const MOST_TEXELS: usize = (MOST_SIDE * MOST_SIDE) as usize;

/// Most words of a guide.
pub const MOST_WORDS: usize = words(MOST_SIDE);

/// Words of a guide with so many texels along each side: the first has the luminance of one step, the upper half of an `f32`,
/// in bits 16-31, six bits of the surfel's identity in bits 10-15, and rays learned from, in fours, in bits 0-9. The others
/// have four texels each, row by row, the first in the lowest byte.
#[inline]
pub const fn words(side: u32) -> usize {
    1 + side as usize * side as usize / 4
}

/// Share of the cosine lobe in a texel, by its distances from the nearest edges: what its luminance counts in irradiance. A
/// quarter of the square with two texels along each side, then one with four, with six and with eight; each sums to a quarter.
/// They are whole multiples of 2^-16, so that sums of masses are exact in whatever order a device adds.
const LOBE: [f32; 30] = {
    const STEPS: [u32; 30] = [
        16384, //
        1457, 4310, //
        4310, 6307, //
        301, 836, 1374, //
        836, 2422, 3502, //
        1374, 3502, 2237, //
        103, 251, 407, 545, //
        251, 853, 1418, 1940, //
        407, 1418, 1597, 1815, //
        545, 1940, 1815, 1079,
    ];
    let mut shares = [0.0; 30];
    let mut i = 0;
    while i < 30 {
        shares[i] = STEPS[i] as f32 / 65536.0;
        i += 1;
    }
    shares
};

/// Rays that a guide has learned from before it is used.
pub const LEAST_RAYS: u32 = 32;

/// Rays that it has learned from when it is used in full.
pub const FULL_RAYS: u32 = 256;

/// Share of the rays that follow a guide in full use, of those that do not go to emitters: the rest keeps to the cosine
/// lobe, so that nothing is left unsampled.
pub const MOST_GUIDED: f32 = 0.5;

/// Second moment of light between texels over the square of the first, below which a guide is not used; one above, it is
/// used in full. Over an even hemisphere, where it is one, the lobe is as good, and its points lie more evenly.
pub const LEAST_SPREAD: f32 = 1.25;

/// Rays up to which new ones move all texels towards their mean: until a texel is known, it counts as average.
pub const PRIOR_RAYS: u32 = 64;

/// Least share of a new ray in a texel's average.
pub const BLEND: f32 = 0.05;

/// Neighbours that a surfel learns from in a frame.
pub const NEIGHBOURS: u32 = 8;

/// Surfels of its cell that it looks at to find them.
pub const CANDIDATES: u32 = 16;

/// Cosine between the normals of surfels that learn from each other.
pub const ALIKE: f32 = 0.7;

/// Rays of a neighbour that are learned from in a frame.
pub const RAYS_OF_NEIGHBOUR: u32 = 32;

/// Brightest luminance that a guide holds; beyond, it only stops telling brightness apart. Its square is a finite `f32`.
pub const MOST_LUMINANCE: f32 = 1e18;

/// Rays in a step of the count that a guide keeps.
const RAYS_STEP: u32 = 4;

/// Largest count, in steps.
const MOST_STEPS: u32 = 0x3ff;

/// What tells a surfel's guide from that of the one that had the slot before, but for one in 64.
#[inline]
fn tag(identity: u32) -> u32 {
    identity & 0x3f
}

/// The guides of all surfels, one surfel's after the other's.
#[derive(Clone, Copy, Debug, Default)]
pub struct Guides<'a> {
    words: &'a [u32],
    side: u32,
}

impl<'a> Guides<'a> {
    /// Of so many texels along each side; without words where a frame has no guides.
    #[inline]
    pub fn new(words: &'a [u32], side: u32) -> Self {
        Self { words, side }
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// The guide of a surfel; `None` where there are none.
    #[inline]
    pub fn get(&self, surfel: usize) -> Option<Guide<'a>> {
        let count = words(self.side);
        let words = self.words.get(surfel * count..(surfel + 1) * count)?;
        Some(Guide::new(words, self.side))
    }
}

/// The guide of a surfel.
#[derive(Clone, Copy, Debug)]
pub struct Guide<'a> {
    words: &'a [u32],
    side: u32,
}

impl<'a> Guide<'a> {
    /// From its words, see [`words`].
    #[inline]
    pub fn new(words: &'a [u32], side: u32) -> Self {
        Self { words, side }
    }

    /// Texels.
    #[inline]
    pub fn texels(&self) -> u32 {
        self.side.saturating_mul(self.side)
    }

    /// Rays that it has learned from, up to 4092; none where it is not that of the surfel with this identity.
    #[inline]
    pub fn rays(&self, identity: u32) -> u32 {
        let scale = self.words[0];
        match scale >> 10 & 0x3f == tag(identity) {
            true => (scale & MOST_STEPS) * RAYS_STEP,
            false => 0,
        }
    }

    /// A texel's value, in steps.
    #[inline]
    pub fn texel(&self, index: u32) -> u32 {
        self.words[1 + (index / 4) as usize] >> (index % 4 * 8) & 0xff
    }

    #[inline]
    fn lobe(&self, index: u32) -> f32 {
        let (x, y) = (index % self.side, index / self.side);
        let (half, last) = (self.side / 2, self.side - 1);
        // After the squares of all smaller halves.
        let first = (half - 1) * half * (2 * half - 1) / 6;
        LOBE[(first + y.min(last - y) * half + x.min(last - x)) as usize]
    }

    /// What a texel counts in the distribution.
    #[inline]
    fn mass(&self, index: u32) -> f32 {
        self.texel(index) as f32 * self.lobe(index)
    }

    /// Sum of the distribution; zero for a guide that knows nothing.
    #[inline]
    pub fn total(&self) -> f32 {
        (0..self.texels()).fold(0.0, |sum, index| sum + self.mass(index))
    }

    /// Share of the rays of the surfel with this identity that follow the guide, of those that do not go to emitters.
    #[inline]
    pub fn share(&self, identity: u32, total: f32) -> f32 {
        let rays = self.rays(identity);
        if rays < LEAST_RAYS || total <= 0.0 {
            return 0.0;
        }
        let squares = (0..self.texels()).fold(0.0, |sum, index| {
            let value = self.texel(index) as f32;
            // The constant first: a driver may move it there.
            sum + self.lobe(index) * (value * value)
        });
        let spread = squares / (total * total);
        let known = (rays as f32 / FULL_RAYS as f32).min(1.0);
        MOST_GUIDED * ((spread - LEAST_SPREAD).clamp(0.0, 1.0) * known)
    }

    /// Probability that a ray not to an emitter falls into a texel, where `share` of them follow the guide.
    #[inline]
    pub fn probability(&self, total: f32, share: f32, index: u32) -> f32 {
        let lobe = self.lobe(index);
        if share <= 0.0 {
            return lobe;
        }
        lobe + (self.mass(index) / total - lobe) * share
    }

    /// The texel of a direction of the surfel's frame.
    #[inline]
    pub fn texel_of(&self, local: Vec3) -> u32 {
        let uv = hemisphere_encode(Vec3::new(local.x, local.y, local.z.max(0.0)));
        let at = |x: f32| ((x * self.side as f32) as u32).min(self.side - 1);
        at(uv.y) * self.side + at(uv.x)
    }

    /// Density per solid angle, 1/sr, of [`Guide::draw`] in a direction of the surfel's frame: constant over the square within
    /// a texel, over `2 (|x| + |y| + z)^3`, the solid angle per area of the square.
    #[inline]
    pub fn density(&self, total: f32, local: Vec3) -> f32 {
        let s = local.x.abs() + local.y.abs() + local.z.max(0.0);
        self.mass(self.texel_of(local)) / total * (0.5 * self.texels() as f32) / (s * s * s)
    }

    /// A direction of the surfel's frame, from two numbers in `[0, 1)`: they walk a mip of 2x2 texels first, then the four of
    /// the block where they stop (McCool and Harwood 1997), each along one axis. What is left of them places the direction.
    /// Numbers that are close give directions that are close, so that points spread evenly over the square stay so over the
    /// hemisphere.
    #[inline]
    pub fn draw(&self, (u, v): (f32, f32)) -> Vec3 {
        let blocks = self.side / 2;
        let block = |row, column| {
            let at = |y, x| self.mass((row * 2 + y) * self.side + column * 2 + x);
            [[at(0, 0), at(0, 1)], [at(1, 0), at(1, 1)]]
        };
        let sum = |row, column| {
            let [[a, b], [c, d]] = block(row, column);
            (a + b) + (c + d)
        };
        let line = |row| (0..blocks).fold(0.0, |total, column| total + sum(row, column));
        let (row, v) = walk(v, blocks, line);
        let (column, u) = walk(u, blocks, |column| sum(row, column));
        let texels = block(row, column);
        let (y, v) = walk(v, 2, |y| texels[y as usize][0] + texels[y as usize][1]);
        let (x, u) = walk(u, 2, |x| texels[y as usize][x as usize]);
        hemisphere_decode(Vec2::new(
            ((column * 2 + x) as f32 + u) / self.side as f32,
            ((row * 2 + y) as f32 + v) / self.side as f32,
        ))
    }

    /// Luminances of all texels; of those that it does not have, zero.
    #[inline]
    pub fn unpack(&self) -> [f32; MOST_TEXELS] {
        let step = f32::from_bits(self.words[0] & 0xffff_0000);
        let count = self.texels();
        std::array::from_fn(|index| match (index as u32) < count {
            true => self.texel(index as u32) as f32 * step,
            false => 0.0,
        })
    }
}

/// Where a number in `[0, 1)` stops among so many masses, and how far within, in `[0, 1)`.
#[inline]
fn walk(u: f32, count: u32, mass: impl Fn(u32) -> f32) -> (u32, f32) {
    let mut masses = [0.0; (MOST_SIDE / 2) as usize];
    for (index, slot) in (0..count).zip(&mut masses) {
        *slot = mass(index);
    }
    let mut left = u * masses.iter().fold(0.0, |sum, mass| sum + mass);
    let mut chosen = 0;
    let mut within = 0.0;
    for (index, mass) in (0..).zip(masses) {
        if mass > 0.0 {
            chosen = index;
            within = (left / mass).min(ALMOST_ONE);
            if left < mass {
                break;
            }
        }
        left -= mass;
    }
    (chosen, within)
}

/// The words of a guide of these luminances, row by row, that has learned from so many rays, with steps as small as the brightest texel
/// allows. `dither(index)` in `[0, 1)` rounds up or down, so that averages survive the rounding.
#[inline]
pub fn pack(
    luminances: &[f32],
    identity: u32,
    rays: u32,
    dither: impl Fn(u32) -> f32,
) -> [u32; MOST_WORDS] {
    let brightest = luminances
        .iter()
        .fold(0.0f32, |a, &b| a.max(b))
        .min(MOST_LUMINANCE);
    let mut words = [0; MOST_WORDS];
    words[0] = rays.div_ceil(RAYS_STEP).min(MOST_STEPS) | tag(identity) << 10;
    // The step is rounded up, so that the brightest texel still fits.
    let bits = ((brightest / 255.0).to_bits() + 0xffff) & 0xffff_0000;
    let step = f32::from_bits(bits);
    if brightest <= 0.0 || step <= 0.0 {
        return words;
    }
    words[0] |= bits;
    for (index, luminance) in (0..).zip(luminances) {
        let value = ((luminance / step + dither(index)) as u32).min(255);
        words[1 + (index / 4) as usize] |= value << (index % 4 * 8);
    }
    words
}

#[cfg(test)]
mod tests;
