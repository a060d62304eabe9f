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

/// How the damping beyond that at small amplitude grows with the amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Law {
    /// As the amplitude: sound that separates at a hole or an open end.
    #[default]
    Linear,
    /// As its square: the first term of any law that is smooth and the same for both signs.
    Square,
}

impl Law {
    /// The power of the amplitude.
    pub(crate) fn power(self) -> i32 {
        match self {
            Self::Linear => 1,
            Self::Square => 2,
        }
    }

    pub(crate) fn other(self) -> Self {
        match self {
            Self::Linear => Self::Square,
            Self::Square => Self::Linear,
        }
    }
}

/// One exponential of the model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Component {
    /// Growth rate and angular frequency, 1/s.
    pub(crate) s: C64,
    /// Which of the two are free.
    pub(crate) kind: Kind,
    /// Change of the angular frequency with time, rad/s^2, counted from the first row of a fit: free where it
    /// is there, else the frequency is steady.
    pub(crate) chirp: Option<f64>,
    /// By what share the damping at the first row of a fit exceeds that at small amplitude, which is -Re s:
    /// free where it is there, else the damping is the same at any amplitude. The envelope with the excess x,
    /// which grows as the power p of the amplitude, is e^{ct} / (1 + x (1 - e^{pct}))^{1/p}, c = Re s.
    pub(crate) excess: Option<f64>,
    /// How that grows with the amplitude.
    pub(crate) law: Law,
}

impl Component {
    /// A component whose frequency and damping are steady.
    pub(crate) fn new(s: C64, kind: Kind) -> Self {
        Self { s, kind, chirp: None, excess: None, law: Law::Linear }
    }

    /// Whether it is no plain exponential.
    pub(crate) fn is_curved(&self) -> bool {
        self.chirp.is_some() || self.excess.is_some()
    }
}

/// The fundamental of the mains, 1/s, if they are among the components.
pub(crate) fn fundamental(components: &[Component]) -> Option<f64> {
    components.iter().find_map(|c| match c.kind {
        Kind::Mains(h) => Some(c.s.im / f64::from(h)),
        _ => None,
    })
}

/// The same components with another fundamental of the mains.
pub(crate) fn with_fundamental(mut components: Vec<Component>, omega: f64) -> Vec<Component> {
    for component in &mut components {
        if let Kind::Mains(h) = component.kind {
            component.s.im = omega * f64::from(h);
        }
    }
    components
}
