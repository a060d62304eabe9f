//! One exponential of the model of a ring-down.

use rijke_numerics::C64;

/// What is known about a component beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    /// A mode: growth rate and frequency are both free.
    Mode,
    /// A steady tone: growth rate zero, frequency free.
    Tone,
    /// A multiple of the mains: growth rate zero; all of them share one free fundamental frequency.
    Mains(u32),
    /// A mode known from elsewhere: nothing is free but its amplitudes.
    Known,
}

/// One exponential of the model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Component {
    /// Growth rate and angular frequency, 1/s.
    pub(crate) s: C64,
    /// Which of the two are free.
    pub(crate) kind: Kind,
}
