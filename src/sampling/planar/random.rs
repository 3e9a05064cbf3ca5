//! A stream of random numbers that is the same on every machine.

/// `SplitMix64`.
#[derive(Clone)]
pub(super) struct Random(pub(super) u64);

impl Random {
    #[inline]
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Three numbers in -1..1 of 21 bits each.
    #[inline]
    pub(super) fn triple(&mut self) -> [f64; 3] {
        let bits = self.bits();
        [0, 21, 42].map(|shift| ((bits >> shift) & 0x1f_ffff) as f64 / f64::from(1 << 20) - 1.0)
    }
}
