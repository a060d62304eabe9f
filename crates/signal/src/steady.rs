//! What is said of a steady tone beside the mode.

/// A tone that sounds all the time, so near the mode that no fit beside it is sound.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a tone at {frequency_hz:.1} Hz sounds in the silence, {apart_hz:.1} Hz from the mode, and what it leaves of the decay is not that of one mode, even \
     where it is fitted as a steady tone. {}",
    remedy(*apart_hz, *silence_s)
)]
pub struct SteadyTone {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Its distance from the tone of the forcing, Hz.
    pub apart_hz: f64,
    /// How long the silence lasts, s.
    pub silence_s: f64,
}

/// What to do about a tone so far from the mode: within a resolution of the silence it may be the mode
/// itself.
fn remedy(apart_hz: f64, silence_s: f64) -> String {
    let remedy = "witch off what makes it, a fan or another machine, or drive the mode louder";
    if apart_hz * silence_s > 1.0 {
        return format!("S{remedy}");
    }
    format!(
        "It may be the mode itself, which a flow rings: a silence of {silence_s:.2} s does not tell. Record ten decay times of silence; if it is a tone, s{remedy}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_a_short_silence_does_not_tell_a_tone_from_a_mode_that_a_flow_rings() {
        let of = |silence_s: f64| SteadyTone { frequency_hz: 171.0, apart_hz: 2.0, silence_s }.to_string();
        assert!(of(0.2).contains("a silence of 0.20 s does not tell. Record ten decay times"), "{}", of(0.2));
        assert!(of(1.0).contains("as a steady tone. Switch off what makes it"), "{}", of(1.0));
    }
}
