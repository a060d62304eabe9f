//! Sentences of faults that depend on what was found.

/// Of a silence that is none: `stated` samples are said to be silent, `found` are.
pub(crate) fn not_quiet(stated: usize, found: usize, at: f64, ratio: f64) -> String {
    if found == 0 {
        return format!(
            "the first {stated} samples are said to be silent, and they are {ratio:.0} times as loud as silence, from the first sample on. \
             Set quiet_samples to 0"
        );
    }
    format!(
        "the first {stated} samples are said to be silent, and from sample {found} ({at:.4} s) on they are up to {ratio:.0} times as loud as \
         before. Set quiet_samples to {found} or less"
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
    format!(
        "second excitation at {at:.3} s: the amplitude grows {factor:.2} times while it should decay. The loudspeaker acts twice \
         or is not quite off, the mode grows by itself, or samples are missing there: look after the switch, the stability of the rig, and \
         for lost blocks in the acquisition"
    )
}
