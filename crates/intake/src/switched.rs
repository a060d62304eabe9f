//! What is said of records in which channels changed places, where they contradict each other.

use rijke_numerics::{Failed, Tell};
use rijke_rig::Driven;
use rijke_signal::{SwitchedDoubt, SwitchedFault, SwitchedGains};

/// Records that contradict each other, with what brings them together.
pub(crate) fn failure(doubt: &SwitchedDoubt, driven: &Driven, names: &[String]) -> Failed {
    let SwitchedDoubt { fault, before, after } = doubt;
    let file = |record: usize| file(driven, record);
    let less = format!("brings the distance of the estimates of the gains from {before:.2} to {after:.4}");
    let (what, remedy) = match *fault {
        SwitchedFault::Records([a, b]) => (
            format!("exchanging the files {} and {} {less}", file(a), file(b)),
            "Exchange the two in the manifest, or look in which order they were recorded.",
        ),
        SwitchedFault::Channels { record, channels: [a, b] } => (
            format!("exchanging the microphones {} and {} in {} {less}", names[a], names[b], file(record)),
            "Look which microphone stood where in this record. Record it again, or exchange its columns.",
        ),
        SwitchedFault::Inverted { record: Some(record), channel } => (
            format!("turning microphone {} upside down in {} {less}", names[channel], file(record)),
            "Look at its wires in this record. Record it again, or change the sign of its column.",
        ),
        SwitchedFault::Inverted { record: None, channel } => (
            format!(
                "microphone {} is inverted in one of {} and {}: the phase of its gain is near a right angle",
                names[channel],
                file(0),
                file(channel)
            ),
            "Look at its wires. Record both again, or change the sign of its column in one.",
        ),
    };
    Failed::bad_input(what).remedy(remedy)
}

/// The file in which channel `record` changed places with channel 0; of 0, those in which none did.
fn file(driven: &Driven, record: usize) -> String {
    match driven.switched.iter().find(|s| s.channel == record) {
        Some(switched) if record > 0 => switched.file.clone(),
        _ => driven.straight.join(", "),
    }
}

/// Warns of channels that are inverted in all records.
pub(crate) fn say_inverted(gains: &SwitchedGains, driven: &Driven, names: &[String], tell: &dyn Tell) {
    for c in gains.inverted() {
        tell.note(format!(
            "warning: the gain of microphone {} is near -1: is it inverted in all records, or one of them in {} alone? Look at the wires. \
             What is written takes it for inverted in all",
            names[c],
            file(driven, c)
        ));
    }
}
