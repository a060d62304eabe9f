//! Pings at another sampling rate than that of the calibration.

use rijke_numerics::words::counted;
use rijke_rig::RecordSet;

/// Points whose pings have another sampling rate than the set's.
pub(super) fn of_other_rates(set: &RecordSet) -> Vec<usize> {
    let other =
        |k: &usize| !set.points[*k].pings.is_empty() && set.ping_timing(*k, 0).rate_hz != set.ping.rate_hz;
    (0..set.points.len()).filter(other).collect()
}

/// What to say of them, of which there is one.
pub(super) fn without_shapes(set: &RecordSet, others: &[usize]) -> String {
    let ids: Vec<&str> = others.iter().map(|k| set.points[*k].point.id.as_str()).collect();
    format!(
        "the pings of {} ({}{}) are not sampled at {} Hz, at which the channels were calibrated, and the delays of the channels hold only at that \
         rate: these pings give growth rates and frequencies, but no mode shapes; for shapes process these points as a set of their own, with clicks \
         at their rate, or state gains and delays in [microphones] of the manifest in place of the [[calibration]]",
        counted(ids.len(), "point"),
        ids[..ids.len().min(3)].join(", "),
        if ids.len() > 3 { ", ..." } else { "" },
        set.ping.rate_hz
    )
}
