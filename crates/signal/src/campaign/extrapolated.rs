//! Modes outside the band of the clicks from which gains and delays were learnt.

use crate::delays::ChannelDelays;
use rijke_numerics::words::counted;
use rijke_rig::DataKind;
use std::f64::consts::TAU;

/// What to say where modes, of angular frequencies 1/s, lie outside the band of the clicks. A gain and a
/// delay that hold there are not those of a channel at the mode: a high-pass that differs by df in its corner
/// frequency turns the phase at f by df/f, which is no delay. Channels of the virtual laboratory are nothing
/// but gains and delays.
pub(super) fn extrapolated(kind: DataKind, modes: &[f64], delays: Option<&ChannelDelays>) -> Option<String> {
    let (low, high) = delays?.band_hz.filter(|_| kind == DataKind::Measured)?;
    let hertz = || modes.iter().map(|omega| omega / TAU);
    let apart = |f: f64| (low / f).max(f / high);
    let outside = hertz().filter(|f| apart(*f) > 1.0);
    let count = outside.clone().count();
    let farthest = outside.max_by(|a, b| apart(*a).total_cmp(&apart(*b)))?;
    let side = if farthest < low { "below" } else { "above" };
    let points = match count {
        _ if modes.len() == 1 => String::new(),
        count if count == modes.len() => format!(", farthest of {}", counted(count, "point")),
        count => format!(", farthest of {count} of {}", counted(modes.len(), "point")),
    };
    Some(format!(
        "the mode ({farthest:.1} Hz{points}) lies {side} the band of the calibration clicks ({low:.0} to {high:.0} Hz): gains and delays of the channels are \
         extrapolated to it. AC couplings and vents of microphones that differ between channels change pressures there, by an error that no standard deviation \
         has. Use clicks that hold the frequency of the mode, or compare the microphones with each other there ([comparison])"
    ))
}
