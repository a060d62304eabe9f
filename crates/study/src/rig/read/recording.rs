//! The table `[recording]` of a rig.

use crate::StudyProblem;
use crate::source::Outcome;
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;

/// How records are taken and fitted; the rates are for the laboratory.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Recording {
    #[serde(rename = "ping_rate_hz")]
    _ping_rate_hz: Option<IgnoredAny>,
    #[serde(rename = "click_rate_hz")]
    _click_rate_hz: Option<IgnoredAny>,
    arrival_setting_sd_s: Option<Spanned<f64>>,
    ping_decay_times: Option<Spanned<f64>>,
    band_hz: Option<Spanned<Vec<f64>>>,
    mains_hz: Option<Spanned<f64>>,
}

impl Recording {
    /// Standard deviation of a common shift of all arrival times between two settings, s.
    pub(super) fn setting_sd(&self) -> Outcome<f64> {
        let Some(sd) = &self.arrival_setting_sd_s else { return Ok(0.0) };
        let (at, value) = (sd.span(), *sd.get_ref());
        if (0.0..=1e-2).contains(&value) {
            return Ok(value);
        }
        let need = "from 0 to 0.01 s: what a click comes sooner or later after the rig was set anew";
        Err((at, StudyProblem::Value { key: "arrival_setting_sd_s".into(), value: value.to_string(), need }))
    }

    /// Decay times of a ring-down that the fit of a ping uses.
    pub(super) fn decay_times(&self) -> Outcome<Option<f64>> {
        let Some(times) = &self.ping_decay_times else { return Ok(None) };
        let (at, value) = (times.span(), *times.get_ref());
        if (2.0..=16.0).contains(&value) {
            return Ok(Some(value));
        }
        let need =
            "from 2 to 16 decay times: leave it out for 7, or take less if what comes late is not free decay";
        Err((at, StudyProblem::Value { key: "ping_decay_times".into(), value: value.to_string(), need }))
    }

    /// Frequencies between which the mode of the pings is sought, Hz.
    pub(super) fn band(&self) -> Outcome<Option<[f64; 2]>> {
        let Some(band) = &self.band_hz else { return Ok(None) };
        let allowed = |f: &f64| (1e-3..=1e6).contains(f);
        match band.get_ref()[..] {
            [low, high] if low < high && [low, high].iter().all(allowed) => Ok(Some([low, high])),
            _ => {
                let (key, value) = ("band_hz".into(), format!("{:?}", band.get_ref()));
                let need = "two frequencies from 0.001 to 1e6 Hz, the lower one first, such as [80, 300]";
                Err((band.span(), StudyProblem::Value { key, value, need }))
            }
        }
    }

    /// Frequency of the mains, Hz.
    pub(super) fn mains(&self) -> Outcome<Option<f64>> {
        let Some(mains) = &self.mains_hz else { return Ok(None) };
        let value = *mains.get_ref();
        if (1.0..=1e3).contains(&value) {
            return Ok(Some(value));
        }
        let need = "from 1 to 1000 Hz: 50 or 60 where there is a grid";
        Err((mains.span(), StudyProblem::Value { key: "mains_hz".into(), value: value.to_string(), need }))
    }
}
