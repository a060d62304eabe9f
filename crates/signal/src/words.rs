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
