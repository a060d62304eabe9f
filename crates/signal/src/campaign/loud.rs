//! Pressures that hardly any rig has: then numbers are in another unit than the manifest says.

use rijke_rig::Record;
use std::sync::{Mutex, PoisonError};

/// A ping of more than 140 dB, and a click of more than 160 dB, Pa: beyond, the unit is suspected.
const LARGEST: [f64; 2] = [200.0, 2000.0];

/// The loudest ping and the loudest click: pressure (Pa) and name.
#[derive(Debug, Default)]
pub(super) struct Loudest(Mutex<[(f64, String); 2]>);

impl Loudest {
    /// Another record, from any thread.
    pub(super) fn hear(&self, name: &str, record: &Record, is_ping: bool) {
        let peak = record.channels.iter().map(|c| peak(c)).fold(0.0, f64::max);
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

/// The largest distance from the mean.
fn peak(channel: &[f64]) -> f64 {
    let mean = channel.iter().sum::<f64>() / channel.len().max(1) as f64;
    channel.iter().map(|p| (p - mean).abs()).fold(0.0, f64::max)
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
        loudest.hear("quiet", &record(150.0), true);
        loudest.hear("click", &record(1500.0), false);
        assert!(Loudest(Mutex::new(loudest.0.lock().unwrap().clone())).in_words().is_empty());
        loudest.hear("b", &record(2100.0), true);
        loudest.hear("a", &record(2100.0), true);
        loudest.hear("loud", &record(2100.0), false);
        let said = loudest.in_words();
        assert_eq!(said.len(), 2);
        assert!(said[0].contains("ping a reaches 2100 Pa") && said[0].contains("`unit`"), "{}", said[0]);
        assert!(said[1].contains("click loud reaches 2100 Pa"), "{}", said[1]);
    }
}
