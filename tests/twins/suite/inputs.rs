//! Inputs: ordinary ones, drawn by a hash, and among them the edges of what a function is asked.
use gibs_graph::glam::{Vec2, Vec3};
use gibs_passes::shared::hash;

/// Draws the arguments of one case; the same ones on every run. A third of them are edges.
pub struct Draw {
    case: u32,
    index: u32,
}

/// Bits of floats about which things change: signed zeros, the least and the largest subnormal, the least normal, one and its
/// neighbours, the largest.
const EDGES: [u32; 12] = [
    0,
    0x8000_0000,
    0x0000_0001,
    0x807f_ffff,
    0x0080_0000,
    0x3f7f_ffff,
    0x3f80_0000,
    0x3f80_0001,
    0xbf80_0000,
    0x4b80_0000,
    0x7f7f_ffff,
    0xff7f_ffff,
];

impl Draw {
    /// The case with a number.
    pub fn of(case: u32) -> Self {
        Self { case, index: 0 }
    }

    /// Its number.
    pub fn case(&self) -> u32 {
        self.case
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        self.index += 1;
        hash::hash3(self.case, self.index, 0x7477_696e)
    }

    /// A number below another one, every one about as often.
    pub fn below(&mut self, end: u32) -> u32 {
        ((u64::from(self.bits()) * u64::from(end)) >> 32) as u32
    }

    /// One of some values.
    pub fn one_of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len() as u32) as usize]
    }

    /// True once in so many times.
    pub fn once_in(&mut self, times: u32) -> bool {
        self.below(times) == 0
    }

    /// 0 or 1.
    pub fn flag(&mut self) -> u32 {
        self.below(2)
    }

    /// A word: edges of integers, few bits, many.
    pub fn word(&mut self) -> u32 {
        match self.below(6) {
            0 => self.one_of(&[0, 1, 2, 0x7fff_ffff, 0x8000_0000, 0xffff_fffe, 0xffff_ffff]),
            1 => (1u32 << self.below(32))
                .wrapping_add(self.below(3))
                .wrapping_sub(1),
            2 => self.bits() >> self.below(32),
            _ => self.bits(),
        }
    }

    /// In `[0, 1)`.
    pub fn plain(&mut self) -> f32 {
        hash::unit(self.bits())
    }

    /// Between two numbers.
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        (low + (high - low) * self.plain()).clamp(low, high)
    }

    /// In `[0, 1)`, with what lies beside its ends.
    pub fn unit(&mut self) -> f32 {
        match self.below(6) {
            0 => self.one_of(&[0.0, hash::ALMOST_ONE, 1.0 / 16_777_216.0, 0.5, 0.25, 0.125]),
            1 => self.magnitude(-60, 0).min(hash::ALMOST_ONE),
            _ => self.plain(),
        }
    }

    /// Positive, with an exponent in `[low, high)`: as many small ones as large ones.
    pub fn magnitude(&mut self, low: i32, high: i32) -> f32 {
        let exponent = low + self.below((high - low) as u32) as i32;
        f32::from_bits(((exponent + 127) as u32) << 23 | (self.bits() >> 9))
    }

    /// The same, of either sign.
    pub fn signed(&mut self, low: i32, high: i32) -> f32 {
        let x = self.magnitude(low, high);
        if self.flag() == 0 { x } else { -x }
    }

    /// The same, or zero of either sign.
    pub fn number(&mut self, low: i32, high: i32) -> f32 {
        if self.once_in(10) {
            return self.one_of(&[0.0, -0.0]);
        }
        self.signed(low, high)
    }

    /// Any normal float or zero, edges among them.
    pub fn float(&mut self) -> f32 {
        match self.below(3) {
            0 => f32::from_bits(self.one_of(&EDGES)),
            _ => self.signed(-126, 128),
        }
    }

    /// A threshold, one of its neighbours, or a number near it.
    pub fn around(&mut self, threshold: f32) -> f32 {
        match self.below(5) {
            0 => threshold,
            1 => threshold.next_up(),
            2 => threshold.next_down(),
            3 => threshold * self.between(0.999, 1.001),
            _ => threshold * self.between(-2.0, 2.0),
        }
    }

    /// A unit vector: axes, diagonals, near poles and the planes between octants, and any.
    pub fn direction(&mut self) -> Vec3 {
        let part = |d: &mut Self| match d.below(4) {
            0 => d.one_of(&[0.0, -0.0, 1.0, -1.0]),
            1 => d.signed(-40, 0),
            _ => d.between(-1.0, 1.0),
        };
        let v = Vec3::new(part(self), part(self), part(self));
        v.try_normalize().unwrap_or(Vec3::NEG_Z)
    }

    /// A unit vector of the upper hemisphere.
    pub fn upward(&mut self) -> Vec3 {
        let d = self.direction();
        Vec3::new(d.x, d.y, d.z.abs())
    }

    /// Components of either sign with exponents in `[low, high)`, some of them zero.
    pub fn vector(&mut self, low: i32, high: i32) -> Vec3 {
        Vec3::new(
            self.number(low, high),
            self.number(low, high),
            self.number(low, high),
        )
    }

    /// Light: components that are not negative, some of them zero.
    pub fn light(&mut self, low: i32, high: i32) -> Vec3 {
        if self.once_in(16) {
            return Vec3::ZERO;
        }
        self.vector(low, high).abs()
    }

    /// Two numbers in `[0, 1)`.
    pub fn units(&mut self) -> Vec2 {
        Vec2::new(self.unit(), self.unit())
    }
}
