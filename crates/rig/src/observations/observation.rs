//! What signal processing makes of records.

use super::channels::ChannelErrors;
use crate::apparatus::geometry::Apparatus;
use crate::apparatus::point::OperatingPoint;
use crate::records::set::{DataKind, Day};
use rijke_numerics::words::{counted, with_sd};
use rijke_numerics::{C64, Matrix};
use std::collections::BTreeMap;

/// One ring-down: complex frequency and mode shape, with their covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Ping {
    /// s = sigma + i omega; growth rate in 1/s, angular frequency in rad/s.
    pub s: C64,
    /// Complex pressure at each microphone, relative to the reference microphone (whose entry is 1).
    pub pressures: Vec<C64>,
    /// Index of the reference microphone.
    pub reference: usize,
    /// Covariance of [`Ping::vector`]. Full: relative pressures share the noise of the reference microphone.
    pub covariance: Matrix,
}

impl Ping {
    /// The real numbers measured: sigma, omega, then real and imaginary part of every pressure but the
    /// reference's.
    #[must_use]
    pub fn vector(&self) -> Vec<f64> {
        let others = self.pressures.iter().enumerate().filter(|(m, _)| *m != self.reference);
        [self.s.re, self.s.im].into_iter().chain(others.flat_map(|(_, p)| [p.re, p.im])).collect()
    }

    /// The ping whose [`Ping::vector`] is `vector`.
    ///
    /// # Panics
    /// If `vector` has fewer than two numbers.
    #[must_use]
    pub fn from_vector(vector: &[f64], reference: usize, covariance: Matrix) -> Self {
        assert!(vector.len() >= 2, "a ping needs its growth rate and angular frequency");
        let mut pressures: Vec<C64> = vector[2..].chunks_exact(2).map(|p| C64::new(p[0], p[1])).collect();
        pressures.insert(reference.min(pressures.len()), C64::new(1.0, 0.0));
        Self { s: C64::new(vector[0], vector[1]), pressures, reference, covariance }
    }
}

/// One impulse: arrival time at each microphone, with covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Click {
    /// Arrival time at each microphone after the loudspeaker's trigger, s, channel delays removed.
    pub arrival_times: Vec<f64>,
    /// Covariance of the arrival times, s^2. The error of the channel delays is part of it, and is common to
    /// all clicks that were corrected with the same calibration.
    pub covariance: Matrix,
}

/// A record that is not used, and why. Rejections are counted and listed, never averaged in.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejection {
    /// Which record.
    pub record: String,
    /// Why, in words with numbers.
    pub reason: String,
}

impl Observations {
    /// The reason of at least half of three or more rejections: how many have it, and the first of them.
    /// Reasons are the same if they are up to their first colon.
    #[must_use]
    pub fn main_reason(&self) -> Option<(usize, &Rejection)> {
        let kind = |r: &Rejection| r.reason.split(':').next().unwrap_or_default().to_owned();
        let mut counts: BTreeMap<String, (usize, &Rejection)> = BTreeMap::new();
        for rejection in &self.rejections {
            counts.entry(kind(rejection)).or_insert((0, rejection)).0 += 1;
        }
        let all = self.rejections.len();
        let most = counts.into_values().max_by_key(|(count, _)| *count);
        most.filter(|(count, _)| all >= 3 && 2 * count >= all)
    }
}

/// What was observed over a campaign: the input of all inference.
#[derive(Clone, Debug, PartialEq)]
pub struct Observations {
    /// The rig.
    pub rig: Apparatus,
    /// Measured or virtual.
    pub kind: DataKind,
    /// Where the data come from.
    pub source: String,
    /// Operating point by operating point.
    pub points: Vec<PointObservations>,
    /// Records that were not used.
    pub rejections: Vec<Rejection>,
    /// What the pings share of the channels' calibration, if that is known.
    pub channels: Option<ChannelErrors>,
}

/// What was observed at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointObservations {
    /// The operating point.
    pub point: OperatingPoint,
    /// Day and ambient temperature.
    pub ambient: Day,
    /// Mean over the accepted pings, with the covariance of the mean.
    pub ping: Option<Ping>,
    /// Standard deviation of an error of its angular frequency that all points have in common, rad/s: what is
    /// not known of a drift of the frequency during their decays. The covariance contains it.
    pub drift_sd: f64,
    /// Number of pings in the mean.
    pub ping_count: u32,
    /// Mean over the accepted clicks, with the covariance of the mean.
    pub click: Option<Click>,
    /// Number of clicks in the mean.
    pub click_count: u32,
    /// Every accepted ping with its repeat; may be empty when only means are kept.
    pub pings: Vec<(u32, Ping)>,
    /// Every accepted click with its repeat; may be empty.
    pub clicks: Vec<(u32, Click)>,
}

impl PointObservations {
    /// What was measured, in words, for who measures: how many records count, and what their pings say
    /// together.
    #[must_use]
    pub fn said(&self) -> String {
        let (pings, clicks) = (self.ping_count as usize, self.click_count as usize);
        let counts =
            format!("{} has {} and {}", self.point.id, counted(pings, "ping"), counted(clicks, "click"));
        let Some(ping) = &self.ping else { return counts };
        let shown = |k: usize, value: f64| with_sd(value, ping.covariance[(k, k)].sqrt());
        let [growth, frequency] = [shown(0, ping.s.re), shown(1, ping.s.im)];
        format!("{counts}; growth rate {growth} 1/s, angular frequency {frequency} rad/s")
    }

    /// A point at which nothing was measured.
    #[must_use]
    pub fn unmeasured(point: OperatingPoint, ambient: Day) -> Self {
        Self {
            point,
            ambient,
            ping: None,
            drift_sd: 0.0,
            ping_count: 0,
            click: None,
            click_count: 0,
            pings: Vec::new(),
            clicks: Vec::new(),
        }
    }
}
