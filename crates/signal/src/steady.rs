//! What is said of a steady tone beside the mode.

/// A tone that sounds all the time, so near the mode that no fit beside it is sound.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "a tone at {frequency_hz:.1} Hz sounds in the silence, {apart_hz:.1} Hz from the mode, and what it leaves of the decay is not that of one mode, even \
     where it is fitted as a steady tone. Switch off what makes it, a fan or another machine, or drive the mode louder"
)]
pub struct SteadyTone {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Its distance from the tone of the forcing, Hz.
    pub apart_hz: f64,
}
