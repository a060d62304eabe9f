//! The numbers that train.

use rijke_numerics::C64;
use std::ops::Range;

/// The numbers of one response that train.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// What they are called.
    pub(super) label: String,
    /// Loads of one session share the errors of the head; those of one excitation, which is a session of its
    /// own, the sources.
    pub(super) session: usize,
    /// From how many sources of unknown strength its pressures are; 0 of all other responses.
    pub(super) sources: usize,
    pub(super) frequency_hz: Vec<f64>,
    pub(super) values: Vec<C64>,
    /// Empty if no standard deviations were measured.
    pub(super) sd: Vec<f64>,
    /// Of unknown sources: by what the values were divided; empty of all others.
    pub(super) level: Vec<f64>,
    /// Variance of the noise of each number over that of the noise of the stage; empty if all have the same.
    pub(super) factor: Vec<f64>,
}

impl Measured {
    /// The variance of the noise of number `i` over that of the noise of the stage.
    pub(super) fn factor(&self, i: usize) -> f64 {
        self.factor.get(i).copied().unwrap_or(1.0)
    }
}

/// The places of the loads of each session.
pub(super) fn sessions(measured: &[Measured]) -> Vec<Range<usize>> {
    let mut first = 0;
    let range = |loads: &[Measured]| {
        let range = first..first + loads.len();
        first = range.end;
        range
    };
    measured.chunk_by(|a, b| a.session == b.session).map(range).collect()
}
