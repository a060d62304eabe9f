//! The table `[recording]` of a rig.

use crate::StudyProblem;
use crate::source::Outcome;
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;

/// How records are taken and fitted; all but the last is for the laboratory.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Recording {
    #[serde(rename = "ping_rate_hz")]
    _ping_rate_hz: Option<IgnoredAny>,
    #[serde(rename = "click_rate_hz")]
    _click_rate_hz: Option<IgnoredAny>,
    #[serde(rename = "arrival_setting_sd_s")]
    _arrival_setting_sd_s: Option<IgnoredAny>,
    ping_decay_times: Option<Spanned<f64>>,
}

impl Recording {
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
}
