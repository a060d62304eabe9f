//! What is said of a record that was not taken as a record must be.

/// What went wrong when a record was taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Mishap {
    /// The loudspeaker drove two modes at once.
    #[error(
        "two modes near {:.1} and {:.1} Hz decay at the same time and beat, and the record does not show when the forcing of both ends: drive the \
         loudspeaker at the frequency of one of them, for a few decay times, so that it is much the louder one when the forcing ends",
        hertz[0], hertz[1]
    )]
    Beat {
        /// Their frequencies, ascending, Hz.
        hertz: [f64; 2],
    },
    /// The silence is quieter than the decay.
    #[error(
        "the noise from {from:.3} s to the end of the record is {times:.1} times as loud as in the silence, alike in all of this time: what is to be \
         measured beside it is not known from the silence. Let what makes it (a blower, a relay) run during the silence, too, or set \
         `quiet_samples = 0`: the noise is then learnt from what the decay leaves"
    )]
    Louder {
        /// Its amplitude over that of the silence.
        times: f64,
        /// Begin of the decay, s.
        from: f64,
    },
    /// What should ring after a blow does not become quieter.
    #[error(
        "from {:.3} to {:.3} s the record does not become quieter below {highest_hz:.0} Hz, as it would after a blow: it holds noise, a tone that goes on, or a \
         time before the blow. Look for the blow in the record, and state `stretch_s` after it",
        seconds[0], seconds[1]
    )]
    NoBlow {
        /// The stretch that was looked at, s.
        seconds: [f64; 2],
        /// The highest frequency that was looked at, Hz.
        highest_hz: f64,
    },
    /// A small jump of the decay.
    #[error(
        "the decay jumps at {at:.3} s: its amplitude changes by {:+.2} % and its phase by {degrees:+.2} degrees there, at once and in all channels. Neither a drift of the gas nor damping does that: the rig was struck, the loudspeaker acted again, or samples are missing there",
        100.0 * (factor - 1.0)
    )]
    Jumps {
        /// When, s.
        at: f64,
        /// The amplitude behind it over what it would be.
        factor: f64,
        /// By how much the phase advances, degrees.
        degrees: f64,
    },
    /// The acquisition lost samples, or repeated some, in the decay.
    #[error("{}", lost(*at, *samples, *seconds, *frequency_hz))]
    LostSamples {
        /// When, s.
        at: f64,
        /// How many are missing; those that are there twice count negative.
        samples: isize,
        /// The time that this is, s.
        seconds: f64,
        /// Frequency of the mode, Hz.
        frequency_hz: f64,
    },
}

fn lost(at: f64, samples: isize, seconds: f64, frequency_hz: f64) -> String {
    let (many, is) = match samples {
        1 => ("1 sample is missing".to_owned(), "lost a sample"),
        -1 => ("1 sample is there twice".to_owned(), "repeated a sample"),
        2.. => (format!("{samples} samples are missing"), "lost samples"),
        _ => (format!("{} samples are there twice", -samples), "repeated samples"),
    };
    format!(
        "at {at:.4} s {many}: the phase of all channels jumps there by {:.1} degrees of the mode at {frequency_hz:.1} Hz, at once, and from then on they are what \
         the decay before would be {:.3} ms {}. The acquisition {is}: record again with a larger buffer, or a lower sampling rate",
        (360.0 * frequency_hz * seconds).abs() % 360.0,
        1e3 * seconds.abs(),
        if samples > 0 { "later" } else { "earlier" }
    )
}
