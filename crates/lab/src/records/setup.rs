//! Setting the laboratory up: days, points, channels.

use super::click::Clicks;
use super::noise::Colour;
use super::ping::Ping;
use super::source::source;
use super::virtual_rig::{CalibrationTruth, Channel, PointTruth, VirtualRig, normal};
use crate::acoustics::radiation::OpenEnd;
use crate::apparatus::base::{base_state, moving_state};
use crate::apparatus::open_ends::open_ends;
use crate::apparatus::tube;
use crate::truth::{LabError, Truth};
use rayon::prelude::*;
use rijke_flow::{BaseState, HeatedTube, Ramp, TubeCampaign, TubePoint, TubeRig};
use rijke_numerics::{InOrder, Streams};
use rijke_rig::{Calibration, DataKind, Day, PointRecords, RecordSet, RecordTiming};

impl VirtualRig {
    /// Sets the laboratory up for the rows `rows` of a campaign (all, if empty), `repeats` records of each
    /// kind per point (the campaign's own number, if none).
    ///
    /// # Errors
    /// A row does not exist, or a point's modes cannot be found.
    pub fn new(
        rig: &TubeRig,
        campaign: &TubeCampaign,
        truth: &Truth,
        rows: &[String],
        repeats: Option<u32>,
        seed: u64,
    ) -> Result<Self, LabError> {
        let known = campaign.rows();
        if let Some(row) = rows.iter().find(|row| !known.contains(row)) {
            return Err(LabError::NoSuchRow { row: row.clone(), known });
        }
        let streams = Streams::new(seed);
        let (mut days, mut temperatures, mut points) = (Vec::new(), Vec::new(), Vec::new());
        let mut day_of = |id: &str| {
            days.iter().position(|day: &Day| day.id == id).unwrap_or_else(|| {
                let (day, temperature) = day(truth, id, streams);
                days.push(day);
                temperatures.push(temperature);
                days.len() - 1
            })
        };
        let calibration_day = day_of("calibration-day");
        for row in known.iter().filter(|row| rows.is_empty() || rows.contains(row)) {
            for (k, point) in campaign.row(row).enumerate() {
                let point = TubePoint { repeats: repeats.unwrap_or(point.repeats), ..point.clone() };
                let day = day_of(&day_name(truth, &point, k));
                points.push((entry(rig, &point, day), point));
            }
        }
        let (ping, click) = (stretch(rig.recording.ping_rate_hz), stretch(rig.recording.click_rate_hz));
        let ping = ping(truth.recorder.ping_quiet_s);
        let click = click(truth.recorder.click_quiet_s);
        let slow_click = stretch(rig.recording.ping_rate_hz)(truth.recorder.click_quiet_s);
        let calibrations = [("ping-rate", slow_click), ("click-rate", click)].map(|(name, stretch)| {
            let file = |k| format!("calibration/{name}-{k:02}.wav");
            Calibration {
                day: calibration_day,
                stretch,
                clicks: (0..truth.recorder.calibration_clicks).map(file).collect(),
            }
        });
        let set = RecordSet {
            rig: rig.apparatus(),
            kind: DataKind::Virtual,
            source: source(&campaign.name, seed),
            channels: (0..rig.microphones.positions.len()).map(Some).collect(),
            arrays: rijke_rig::Arrays::default(),
            acquisition: rijke_rig::Acquisition::default(),
            full_scale: truth.recorder.full_scale_pa,
            ping,
            click,
            days,
            points: points.iter().map(|(entry, _)| entry.clone()).collect(),
            calibrations: calibrations.to_vec(),
        };
        let ramps = Ramp::restricted(&campaign.ramps, &|id| points.iter().any(|(_, p)| p.id == id));
        let truths = |(entry, point): &(PointRecords, TubePoint)| {
            let ends = open_ends(rig, truth, point, seed);
            let base = match ramps.iter().find(|ramp| ramp.time_of(&point.id).is_some()) {
                Some(ramp) => moving_state(rig, truth, point, temperatures[entry.day], ramp)?,
                None => base_state(rig, truth, point, temperatures[entry.day])?,
            };
            point_truth(rig, truth, point, temperatures[entry.day], base, ends)
        };
        let points = points.par_iter().map(truths).in_order::<Result<_, _>>()?;
        let empty = empty_tube();
        let calibration = |c: &Calibration| {
            let temperature = temperatures[c.day];
            let base = base_state(rig, truth, &empty, temperature)?;
            let duct = tube::duct(rig, truth, &empty, &base, open_ends(rig, truth, &empty, seed));
            Ok(CalibrationTruth { duct, temperature })
        };
        let calibrations = set.calibrations.iter().map(calibration).collect::<Result<_, LabError>>()?;
        let channels = (0..set.channels.len()).map(|m| channel(truth, m, streams)).collect();
        let colour = [ping.rate_hz, click.rate_hz].map(|rate| Colour::new(&truth.noise, rate));
        let (truth, clicks) = (truth.clone(), Clicks::default());
        let tube = HeatedTube { rig: rig.clone(), ramps };
        Ok(Self { set, tube, truth, streams, points, calibrations, channels, colour, clicks })
    }
}

/// The channel of microphone `m`: the same in every record of a seed.
fn channel(truth: &Truth, m: usize, streams: Streams) -> Channel {
    let mut stream = streams.stream(&format!("lab/channel/{m}"));
    let sds = &truth.channels;
    Channel {
        gain: 1.0 + sds.gain_sd * normal(&mut stream),
        ping_delay: sds.ping_delay_sd_s * normal(&mut stream),
        click_delay: sds.click_delay_sd_s * normal(&mut stream),
    }
}

/// A day as the manifest describes it, and the temperature that is really there.
fn day(truth: &Truth, id: &str, streams: Streams) -> (Day, f64) {
    let (ambient, mut stream) = (&truth.ambient, streams.stream(&format!("lab/day/{id}")));
    let temperature = ambient.mean_k + ambient.day_sd_k * normal(&mut stream);
    let reading = temperature + ambient.thermometer_sd_k * normal(&mut stream);
    let day = Day {
        id: id.to_owned(),
        // A thermometer shows hundredths.
        ambient_temperature: (reading * 100.0).round() / 100.0,
        ambient_temperature_sd: ambient.thermometer_sd_k,
    };
    (day, temperature)
}

/// The day on which a point is measured: cold rows take several points a day in the order of their positions;
/// with thermocouples in place all powers at one position are run on one day (paper, section 3: an hour
/// each).
fn day_name(truth: &Truth, point: &TubePoint, index: usize) -> String {
    match (point.thermometers, point.id.rsplit_once('-')) {
        (true, Some((_, position))) => format!("hot-day-{position}"),
        _ => format!("{}-day-{}", point.row, index / truth.ambient.points_per_day + 1),
    }
}

fn entry(rig: &TubeRig, point: &TubePoint, day: usize) -> PointRecords {
    let files = |kind: &str| (0..point.repeats).map(|k| format!("{}/{kind}-{k:02}.wav", point.id)).collect();
    let way = Some(rig.way(point));
    PointRecords { day, pings: files("ping"), clicks: files("click"), point: point.into(), way }
}

fn point_truth(
    rig: &TubeRig,
    truth: &Truth,
    point: &TubePoint,
    temperature: f64,
    base: BaseState,
    ends: [OpenEnd; 2],
) -> Result<PointTruth, LabError> {
    let duct = tube::duct(rig, truth, point, &base, ends);
    let (speaker, reference) = (&truth.loudspeaker, rig.microphones.reference);
    let modes = tube::modes(&duct, rig, point, &base, speaker.modes)?;
    let ping = Ping::new(modes.clone(), speaker.detuning, reference, speaker.ping_pa);
    Ok(PointTruth { duct, base, modes, ping, temperature })
}

/// How records of one sampling rate are taken, given the length of their quiet stretch in s.
fn stretch(rate_hz: f64) -> impl Fn(f64) -> RecordTiming {
    move |quiet_s| RecordTiming { rate_hz, quiet: (quiet_s * rate_hz).round() as usize }
}

/// The tube in which channels are calibrated.
fn empty_tube() -> TubePoint {
    TubePoint {
        id: "calibration".into(),
        row: "calibration".into(),
        position: None,
        plates: false,
        thermometers: false,
        power: 0.0,
        repeats: 0,
    }
}
