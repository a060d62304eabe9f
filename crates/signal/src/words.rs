//! Sentences of faults that depend on what was found.

use crate::Channel;

/// Growth of an amplitude, three decay times and more, from which a decay was over.
const ANEW: f64 = 30.0;

/// Of a silence that is none: `stated` samples are said to be silent, `found` are.
pub(crate) fn not_quiet(stated: usize, found: usize, at: f64, ratio: f64) -> String {
    if found == 0 {
        return format!(
            "quiet_samples = {stated}, but these samples are {ratio:.0} times as loud as silence, from the first one on. Set quiet_samples to 0"
        );
    }
    format!(
        "quiet_samples = {stated}, but from sample {found} ({at:.4} s) on these samples are up to {ratio:.0} times as loud as before. \
         Set quiet_samples to {found} or less"
    )
}

/// Of a decay of which fits that begin at two times, s, have two growth rates, 1/s.
pub(crate) fn not_free(from: [f64; 2], growth_rates: [f64; 2], distance: f64) -> String {
    format!(
        "the decay is not free: its growth rate is {:.2} 1/s from {:.4} s on and {:.2} 1/s from {:.4} s on, {distance:.1} standard \
         deviations apart. The loudspeaker goes on, or the decay is no exponential: switch the loudspeaker off suddenly, and record for longer",
        growth_rates[0], from[0], growth_rates[1], from[1]
    )
}

/// Of an amplitude that grows by a factor at a time, s.
pub(crate) fn second_excitation(at: f64, factor: f64) -> String {
    if factor > ANEW {
        return format!(
            "second excitation at {at:.3} s: the amplitude grows {factor:.0} times, from silence, after a decay. The file seems to hold more than one ping, \
             or samples are missing there: give every ping a file of its own"
        );
    }
    format!(
        "second excitation at {at:.3} s: the amplitude grows {factor:.2} times while it should decay. The loudspeaker acts twice \
         or is not quite off, the mode grows by itself, or samples are missing there: look after the switch, the stability of the rig, and \
         for lost blocks in the acquisition"
    )
}

/// Of what follows an impulse at a channel, within the window that was fitted, after a time `later`, s; and
/// whether it has the sign of the impulse.
pub(crate) fn strange_reflection(channel: &Channel, window: (f64, f64), later: f64, closed: bool) -> String {
    let sign = if closed { ". It has the sign of the impulse, as at a closed end" } else { "" };
    format!(
        "the impulse ({:.2} ms before to {:.2} ms after its peak) and its reflection {:.2} ms later do not fit {channel}: the reflection is not that \
         of an open end without a flange at the end of the duct, which the rig is taken to have{sign}. Open that end and take off its flange while clicks \
         are recorded, and look whether the length and the places in the rig are right; or use a click that is over before its reflection comes",
        1e3 * window.0,
        1e3 * window.1,
        1e3 * later
    )
}
