//! A record whose noise is white.

/// White samples, one row of channels per sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct White<'a> {
    pub(crate) samples: &'a [f64],
    pub(crate) channels: usize,
    /// Time between samples, s.
    pub(crate) step: f64,
}

impl<'a> White<'a> {
    pub(crate) fn rows(&self) -> usize {
        self.samples.len() / self.channels
    }

    /// The rows from one to before another; fewer if there are not so many.
    pub(crate) fn slice(&self, from: usize, to: usize) -> Self {
        let to = to.min(self.rows());
        Self { samples: &self.samples[from.min(to) * self.channels..to * self.channels], ..*self }
    }

    pub(crate) fn energy(&self) -> f64 {
        self.samples.iter().map(|v| v * v).sum()
    }
}
