//! What is said of a rig that sounds by itself, so that no decay can be measured.

/// What a rig does by itself.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unstable {
    /// A mode beside the wanted one grows.
    #[error(
        "another mode grows by itself when the loudspeaker is off: near {frequency_hz:.0} Hz, at about {growth_rate:.1} 1/s. The rig is unstable \
         there, and no decay can be measured beside it: leave this point out, or damp that mode"
    )]
    Another {
        /// Its frequency, Hz.
        frequency_hz: f64,
        /// Its growth rate, to some tens of per cent, 1/s.
        growth_rate: f64,
    },
    /// The wanted mode grows to the last sample.
    #[error(
        "the tone at {frequency_hz:.1} Hz grows until the end of the record: a mode that is unstable grows by itself, and has no decay that could \
         be measured; or the record ends while the loudspeaker still drives it"
    )]
    Grows {
        /// Its frequency, Hz.
        frequency_hz: f64,
    },
    /// A tone hardly falls after the forcing.
    #[error(
        "no decay: a tone at {frequency_hz:.2} Hz falls by {:.2} % within {seconds:.2} s; a loudspeaker that is not off or a rig that sounds by \
         itself goes on like this. A mode that does decay so slowly needs a longer record",
        100.0 * fall
    )]
    GoesOn {
        /// Its frequency, Hz.
        frequency_hz: f64,
        /// Time for which it was fitted, s.
        seconds: f64,
        /// Share of its amplitude that it loses within that time.
        fall: f64,
    },
    /// A tone is as loud before the forcing as at the end.
    #[error(
        "a tone at {frequency_hz:.1} Hz is as loud before the forcing as at the end of the record: the rig oscillates by itself, \
         or the loudspeaker is never off. No decay can be measured there; the frequency of a limit cycle goes into modes.csv, without a growth rate"
    )]
    Oscillates {
        /// Its frequency, Hz.
        frequency_hz: f64,
    },
    /// A tone outside the band is as loud at the end of the record as while the loudspeaker acts.
    #[error(
        "a tone at {frequency_hz:.1} Hz sounds all the time, as loud at the end of the record as during the forcing: it is not the loudspeaker. \
         Another mode oscillates by itself, and no decay from {:.0} to {:.0} Hz can be measured beside it: leave this point out, or damp that \
         mode. If it is the loudspeaker, switch it off by a relay", band_hz.0, band_hz.1
    )]
    Beside {
        /// Its frequency, Hz.
        frequency_hz: f64,
        /// Where the wanted mode was sought, Hz.
        band_hz: (f64, f64),
    },
}
