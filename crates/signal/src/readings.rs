//! Decays that can be read in two ways.

/// Two readings of one decay, whose growth rates differ.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TwoReadings {
    /// A second mode so near, Hz, and a drift, rad/s^2, together: a forcing that goes on may be fitted by
    /// both.
    #[error(
        "the decay is fitted only by a second mode {0:.2} Hz from the first together with a frequency that drifts, by {1:.1} rad/s^2: \
         a loudspeaker that goes on looks like that. Switch it off suddenly, by a relay, and record for longer"
    )]
    Drifting(f64, f64),
    /// A second mode so near, Hz, explains the decay better than a frequency and a damping that change.
    #[error(
        "the decay is of two modes {0:.2} Hz apart, or of one whose frequency and damping change in an implausible way; the two \
         give different growth rates. Excite one of the modes alone, or record more microphones at less noise"
    )]
    TwoModes(f64),
    /// Two components of one shape, with these growth rates, 1/s, and nearly one frequency.
    #[error(
        "the decay is of two parts of one frequency and one shape, with the growth rates {0:.2} and {1:.2} 1/s: one of them is a loudspeaker that \
         dies away slowly, and the record does not show which. Switch it off by a relay"
    )]
    OneShape(f64, f64),
    /// The damping at the end of the forcing is by this share, with its standard deviation, below that at
    /// small amplitude.
    #[error(
        "the amplitude falls more slowly at first than later: the damping at the end of the forcing is {:.1} +- {:.1} % below that at small amplitude. A loudspeaker that \
         dies away slowly does that, and so does a microphone that saturates; then no growth rate can be determined: switch the loudspeaker off by a relay, and excite more weakly",
        100.0 * .0, 100.0 * .1
    )]
    SlowAtFirst(f64, f64),
}
