//! The truth of the virtual laboratory: every value that its physics and its instruments use, each with a
//! source in `crates/lab/data/truth.toml`. None of them is written into records.

use crate::toml_file::{self, TruthFault};
use serde::{Deserialize, Serialize};
use std::path::Path;
use thiserror::Error;

/// All values of the truth file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// The open ends of the tube.
    pub ends: Ends,
    /// The tube's wall.
    pub wall: WallTruth,
    /// Prongs and feed wires.
    pub prongs: ProngSurface,
    /// The heater.
    pub heater: HeaterTruth,
    /// The thermocouples.
    pub thermocouples: Thermocouples,
    /// The slow flow.
    pub flow: Flow,
    /// The loudspeaker.
    pub loudspeaker: Loudspeaker,
    /// The recording.
    pub recorder: Recorder,
    /// The channels.
    pub channels: Channels,
    /// Noise.
    pub noise: NoiseLevels,
    /// Days and drift.
    pub ambient: TrueTemperatures,
    /// Bad records.
    pub faults: Faults,
}

/// What the open ends lose beyond radiation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ends {
    /// Fraction of the reflected amplitude lost at the bottom.
    pub absorption_bottom: f64,
    /// Fraction of the reflected amplitude lost at the top.
    pub absorption_top: f64,
    /// Scatter of both fractions together from one installation of the rig to the next.
    pub absorption_sd: f64,
    /// Scatter of both end corrections together from one installation of the rig to the next, in inner radii.
    pub extension_sd: f64,
}

/// The tube's wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallTruth {
    /// Factor on the boundary layers of a smooth wall.
    pub roughness: f64,
}

/// Surfaces of what enters from the bottom, relative to smooth cylinders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProngSurface {
    /// Threaded rods.
    pub rod_roughness: f64,
    /// Fabric-coated wires.
    pub wire_roughness: f64,
}

/// The heater, cold and hot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeaterTruth {
    /// Length of wire in the stream, m.
    pub wire_length_m: f64,
    /// Velocity at the wire over velocity in the tube.
    pub wire_speed_up: f64,
    /// Drag of the windings over that of a single smooth wire.
    pub wire_crowding: f64,
    /// Share of the power that leaves through the wire's boundary layer and follows the velocity.
    pub wire_share: f64,
    /// Lag of the heat release over Lighthill's 0.2 d/U.
    pub lag_factor: f64,
    /// Share of the steady loss C_d G u that an oscillation sees.
    pub steady_drag_share: f64,
    /// A law of the paper's Table 4 in the place of the wire's own heat release: to see which model wins
    /// where it is true.
    pub law: Option<LawOfTable4>,
}

/// One of the nine models of heat release of Table 4, as the truth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawOfTable4 {
    /// Its number in the table, 1 to 9.
    pub model: u8,
    /// k_1 to k_6 in the units of the table, as many as the model has; the others 0.
    pub k: [f64; 6],
}

/// Thermocouples across the tube.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Thermocouples {
    /// Diameter of the sheath, m.
    pub sheath_diameter_m: f64,
    /// How far it reaches into the tube, m.
    pub depth_m: f64,
}

/// The slow flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// The six parameters of the pipe flow.
    pub parameters: rijke_flow::TubeParameters,
    /// Closures, richer than a candidate's.
    pub closures: rijke_flow::Closures,
}

/// The loudspeaker under the bottom end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Loudspeaker {
    /// Amplitude of a ping at the reference microphone at the end of forcing, Pa.
    pub ping_pa: f64,
    /// Forcing frequency relative to the resonance of the point.
    pub detuning: f64,
    /// Peak of the source pressure of a click, Pa.
    pub click_pa: f64,
    /// Centre frequency of the click, Hz.
    pub click_hz: f64,
    /// From the trigger to the middle of the click at the bottom end, s.
    pub latency_s: f64,
    /// Relative scatter of amplitudes from record to record.
    pub amplitude_sd: f64,
    /// Scatter of the moment at which forcing ends, s.
    pub stop_sd_s: f64,
    /// Number of modes that ring after a ping.
    pub modes: usize,
    /// Largest pressure at any microphone during a sweep, Pa.
    #[serde(default = "ten")]
    pub sweep_pa: f64,
    /// Length of a sweep, s.
    #[serde(default = "three")]
    pub sweep_s: f64,
}

fn ten() -> f64 {
    10.0
}

fn three() -> f64 {
    3.0
}

/// What the recorder keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recorder {
    /// Pressure of the largest integer, Pa.
    pub full_scale_pa: f64,
    /// Quiet stretch of a ping, s.
    pub ping_quiet_s: f64,
    /// Last part of the forcing that is kept, s.
    pub ping_forced_s: f64,
    /// Length of a ping record, s.
    pub ping_s: f64,
    /// Quiet stretch of a click, s.
    pub click_quiet_s: f64,
    /// Length of a click record, s.
    pub click_s: f64,
    /// Calibration clicks per sampling rate.
    pub calibration_clicks: usize,
}

/// Differences between channels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channels {
    /// Relative scatter of the gains.
    pub gain_sd: f64,
    /// Scatter of the delays at the sampling rate of pings, s.
    pub ping_delay_sd_s: f64,
    /// Scatter of the delays at the sampling rate of clicks, s.
    pub click_delay_sd_s: f64,
}

/// Noise of every channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseLevels {
    /// White noise at high frequency, one-sided density, Pa/sqrt(Hz).
    pub white_pa_rt_hz: f64,
    /// Frequency below which the density rises as 1/f, Hz.
    pub corner_hz: f64,
    /// Mains frequency, Hz.
    pub mains_hz: f64,
    /// Amplitudes of the mains' harmonics 1, 2, 3, ..., Pa.
    pub mains_pa: Vec<f64>,
}

/// TrueTemperatures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrueTemperatures {
    /// Mean ambient temperature, K.
    pub mean_k: f64,
    /// Scatter between days, K.
    pub day_sd_k: f64,
    /// Scatter from record to record, K.
    pub record_sd_k: f64,
    /// Standard deviation of the thermometer's error, one draw per day, K; the manifest states it.
    pub thermometer_sd_k: f64,
    /// Operating points measured in one day.
    pub points_per_day: usize,
}

/// How often a record is bad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Faults {
    /// Fraction of pings.
    pub pings: f64,
    /// Fraction of clicks.
    pub clicks: f64,
}

/// Why the laboratory cannot work.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LabError {
    /// The truth file cannot be read, or does not parse.
    #[error(transparent)]
    Truth(#[from] TruthFault),
    /// A value of the truth that makes no sense.
    #[error("truth: {key} = {value} is outside {low} to {high}")]
    OutOfRange {
        /// Key.
        key: &'static str,
        /// Value found.
        value: f64,
        /// Lowest allowed.
        low: f64,
        /// Highest allowed.
        high: f64,
    },
    /// No operating point of the campaign is asked for.
    #[error("no row is called `{row}`; the campaign has {}", known.join(", "))]
    NoSuchRow {
        /// The row asked for.
        row: String,
        /// The rows that exist.
        known: Vec<String>,
    },
    /// A mode that the laboratory's solver did not find.
    #[error("mode {number} of operating point {point} was not found")]
    NoMode {
        /// Which operating point.
        point: String,
        /// Which mode, from 1.
        number: usize,
    },
    /// The slow flow was not found.
    #[error("operating point {point}: no steady flow ({cause})")]
    Flow {
        /// Which operating point.
        point: String,
        /// Why.
        cause: rijke_flow::FlowError,
    },
    /// Files could not be written.
    #[error(transparent)]
    Rig(#[from] rijke_rig::RigError),
}

impl Truth {
    /// The truth file of the project, `crates/lab/data/truth.toml`.
    #[must_use]
    #[allow(clippy::expect_used, reason = "the text is part of the program and a test parses it")]
    pub fn standard() -> Self {
        let text = include_str!("../data/truth.toml");
        Self::parse(text, Path::new("truth.toml")).expect("the laboratory's own truth is valid")
    }

    /// Reads another truth.
    ///
    /// # Errors
    /// The file, the line, and the known keys if one is unknown.
    pub fn read(path: &Path) -> Result<Self, LabError> {
        toml_file::read::<Self>(path)?.validated()
    }

    fn parse(text: &str, path: &Path) -> Result<Self, LabError> {
        toml_file::parse::<Self>(text, path)?.validated()
    }

    fn validated(self) -> Result<Self, LabError> {
        self.validate()?;
        Ok(self)
    }

    /// Checks the values whose folly would show only as nonsense in the records.
    fn validate(&self) -> Result<(), LabError> {
        let (speaker, recorder) = (&self.loudspeaker, &self.recorder);
        let kept = recorder.ping_s - recorder.ping_quiet_s - recorder.ping_forced_s;
        for (key, value, low, high) in [
            ("ends.absorption_bottom", self.ends.absorption_bottom, 0.0, 0.5),
            ("ends.absorption_top", self.ends.absorption_top, 0.0, 0.5),
            ("ends.absorption_sd", self.ends.absorption_sd, 0.0, 0.1),
            ("ends.extension_sd", self.ends.extension_sd, 0.0, 0.5),
            ("wall.roughness", self.wall.roughness, 0.1, 10.0),
            ("prongs.rod_roughness", self.prongs.rod_roughness, 0.1, 10.0),
            ("prongs.wire_roughness", self.prongs.wire_roughness, 0.1, 10.0),
            ("heater.wire_length_m", self.heater.wire_length_m, 0.01, 100.0),
            ("heater.wire_share", self.heater.wire_share, 0.0, 1.0),
            ("heater.wire_speed_up", self.heater.wire_speed_up, 0.1, 10.0),
            ("heater.law.model", self.heater.law.map_or(1.0, |law| f64::from(law.model)), 1.0, 9.0),
            ("thermocouples.sheath_diameter_m", self.thermocouples.sheath_diameter_m, 1e-5, 0.01),
            ("loudspeaker.click_hz", speaker.click_hz, 100.0, 4000.0),
            ("loudspeaker.modes", speaker.modes as f64, 1.0, 12.0),
            ("loudspeaker.sweep_pa", speaker.sweep_pa, 1e-3, self.recorder.full_scale_pa),
            ("loudspeaker.sweep_s", speaker.sweep_s, 0.1, 60.0),
            ("recorder.full_scale_pa", recorder.full_scale_pa, 1e-3, 1e6),
            ("recorder.ping_s less quiet and forced parts", kept, 0.05, 60.0),
            ("recorder.click_s", recorder.click_s, recorder.click_quiet_s + 0.01, 1.0),
            ("ambient.mean_k", self.ambient.mean_k, 200.0, 400.0),
            ("ambient.points_per_day", self.ambient.points_per_day as f64, 1.0, 1e6),
            ("noise.corner_hz", self.noise.corner_hz, 0.1, 1000.0),
            ("faults.pings", self.faults.pings, 0.0, 1.0),
            ("faults.clicks", self.faults.clicks, 0.0, 1.0),
        ] {
            if !(value >= low && value <= high) {
                return Err(LabError::OutOfRange { key, value, low, high });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_messages_of_a_wrong_truth() {
        let text = include_str!("../data/truth.toml");
        assert_eq!(Truth::parse(text, Path::new("t")).unwrap(), Truth::standard());
        let message = |old: &str, new: &str| {
            assert!(text.contains(old), "{old}");
            Truth::parse(&text.replacen(old, new, 1), Path::new("t")).unwrap_err().to_string()
        };
        assert!(message("gain_sd", "gian_sd").contains("there is no key `gian_sd`; did you mean `gain_sd`?"));
        assert!(message("mean_k = 29", "mean_k = -29").contains("ambient.mean_k = -29"));
    }
}
