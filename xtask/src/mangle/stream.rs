//! Random numbers by name: the same seed and name give the same numbers, whatever else was drawn.

use sha2::{Digest, Sha256};

/// A sequence of random numbers: SplitMix64 (Steele, Lea and Flood 2014) from the hash of its seed and name.
pub(super) struct Stream(u64);

impl Stream {
    pub(super) fn new(seed: u64, name: &str) -> Self {
        let hash = Sha256::new().chain_update(seed.to_le_bytes()).chain_update(name).finalize();
        Self(hash.iter().take(8).fold(0, |word, byte| word << 8 | u64::from(*byte)))
    }

    pub(super) fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number from 0 to `count` - 1; 0 if there is none.
    pub(super) fn below(&mut self, count: usize) -> usize {
        (self.word() % count.max(1) as u64) as usize
    }

    /// True in `percent` of 100 cases.
    pub(super) fn chance(&mut self, percent: u64) -> bool {
        self.word() % 100 < percent
    }

    /// One of several; nothing of nothing.
    pub(super) fn pick<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len()))
    }

    /// From -1/2 to 1/2.
    pub(super) fn centred(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    }
}
