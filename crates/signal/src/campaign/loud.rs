//! Pressures that hardly any rig has: then numbers are in another unit than the manifest says.

use crate::dsp::kernels::peak;
use rijke_rig::Record;
use std::sync::{Mutex, PoisonError};

/// A ping of more than 140 dB, and a click of more than 160 dB, Pa: beyond, the unit is suspected.
const LARGEST: [f64; 2] = [200.0, 2000.0];

/// The largest pressure of a record, Pa.
pub(super) fn loudness(record: &Record) -> f64 {
    record.channels.iter().map(|c| peak(c)).fold(0.0, f64::max)
}

/// The loudest ping and the loudest click: pressure (Pa) and name.
#[derive(Debug, Default)]
pub(super) struct Loudest(Mutex<[(f64, String); 2]>);

impl Loudest {
    /// Another record, from any thread: its largest pressure, Pa.
    pub(super) fn hear(&self, name: &str, peak: f64, is_ping: bool) {
        let heard = &mut self.0.lock().unwrap_or_else(PoisonError::into_inner)[usize::from(!is_ping)];
        // The first name of those that are equally loud, whatever the order of the threads.
        if peak > heard.0 || (peak == heard.0 && name < heard.1.as_str()) {
            *heard = (peak, name.to_owned());
        }
    }

    /// What to say of them.
    pub(super) fn in_words(self) -> Vec<String> {
        let heard = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        let all = heard.into_iter().zip(LARGEST).zip(["ping", "click"]);
        all.filter(|(((peak, _), most), _)| peak > most)
            .map(|(((peak, name), most), kind)| {
                format!(
                    "warning: {kind} {name} reaches {peak:.0} Pa, and a {kind} hardly exceeds {most:.0} Pa: look whether `unit`, `full_scale` and \
                     the sensitivities of the manifest are right"
                )
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_records_in_another_unit_are_named() {
        let record = |size: f64| Record {
            rate_hz: 1e4,
            quiet: 0,
            full_scale: f64::INFINITY,
            channels: vec![vec![1000.0; 4], vec![1000.0, 1000.0 + size, 1000.0, 1000.0 - size]],
        };
        let loudest = Loudest::default();
        loudest.hear("quiet", loudness(&record(150.0)), true);
        loudest.hear("click", loudness(&record(1500.0)), false);
        assert!(Loudest(Mutex::new(loudest.0.lock().unwrap().clone())).in_words().is_empty());
        loudest.hear("b", loudness(&record(2100.0)), true);
        loudest.hear("a", loudness(&record(2100.0)), true);
        loudest.hear("loud", loudness(&record(2100.0)), false);
        let said = loudest.in_words();
        assert_eq!(said.len(), 2);
        assert!(said[0].contains("ping a reaches 2100 Pa") && said[0].contains("`unit`"), "{}", said[0]);
        assert!(said[1].contains("click loud reaches 2100 Pa"), "{}", said[1]);
    }
}
