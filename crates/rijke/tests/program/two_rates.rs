//! Pings of one campaign at two sampling rates, of which the calibration knows one.

use rijke_flow::{TubeCampaign, TubeRig};
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::{Exception, Record, RecordSet, RecordSource, RigError};
use rijke_signal::{ChannelPriors, ProcessOptions, process};

/// The laboratory's records; those of the last point with every second sample left out.
struct Halved {
    laboratory: VirtualRig,
    set: RecordSet,
}

impl RecordSource for Halved {
    fn set(&self) -> &RecordSet {
        &self.set
    }

    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        let whole = self.laboratory.ping(point, repeat)?;
        let timing = self.set.ping_timing(point, repeat);
        if timing.rate_hz == whole.rate_hz {
            return Ok(whole);
        }
        let halved = |c: &Vec<f64>| c.iter().step_by(2).copied().collect();
        let channels = whole.channels.iter().map(halved).collect();
        Ok(Record { rate_hz: timing.rate_hz, quiet: timing.quiet, channels, ..whole })
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        self.laboratory.click(point, repeat)
    }

    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError> {
        self.laboratory.calibration(which, repeat)
    }
}

fn records(halve: bool) -> Halved {
    let (rig, mut campaign, mut truth) =
        (TubeRig::juniper_yoko_2022(), TubeCampaign::juniper_yoko_2022(), Truth::standard());
    campaign.points.retain(|p| ["C3-E", "C3-25"].contains(&p.id.as_str()));
    campaign.ramps.clear();
    (truth.faults.clicks, truth.faults.pings) = (0.0, 0.0);
    let laboratory = VirtualRig::new(&rig, &campaign, &truth, &[], Some(3), 5).unwrap();
    let mut set = laboratory.set().clone();
    set.points.iter_mut().for_each(|p| p.clicks.clear());
    if halve {
        let files = set.points[1].pings.clone();
        let (channels, rate_hz) = (set.channels.clone(), Some(0.5 * set.ping.rate_hz));
        set.acquisition.exceptions.push(Exception { files, channels, rate_hz, ..Exception::default() });
        set.validate().unwrap();
    }
    Halved { laboratory, set }
}

#[test]
fn behaviour_pings_at_a_second_rate_have_growth_rate_and_frequency() {
    let options = ProcessOptions::default();
    let whole = process(&records(false), &options, &|| ()).unwrap();
    let halved = process(&records(true), &options, &|| ()).unwrap();
    let ping = |p: &rijke_signal::Processed, k: usize| p.observations.points[k].ping.clone().unwrap();
    // What is at the rate of the calibration stays as it is, but for the drift that all points teach.
    let (a, b) = (ping(&halved, 0).pressures, ping(&whole, 0).pressures);
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).norm() < 1e-7), "{a:?} {b:?}");
    let (own, other) = (ping(&whole, 1), ping(&halved, 1));
    for (i, difference) in [own.s.re - other.s.re, own.s.im - other.s.im].into_iter().enumerate() {
        let sd = other.covariance[(i, i)].sqrt();
        assert!(sd > 0.0 && difference.abs() < 2.0 * sd, "{i}: {difference} {sd}");
    }
    // No delay of this rate is known: no shape, and that is said.
    assert_eq!(other.pressures.len(), own.pressures.len());
    let heard = |p: &rijke_rig::Ping| p.pressures.iter().filter(|z| z.re.is_finite()).count();
    assert_eq!((heard(&own), heard(&other)), (own.pressures.len(), 1));
    let said =
        |p: &rijke_signal::Processed| p.notes.iter().any(|n| n.contains("the pings of 1 point (C3-25)"));
    assert!(said(&halved) && !said(&whole), "{:?}", halved.notes);
}

#[test]
fn behaviour_stated_channels_hold_at_every_rate() {
    let mut records = records(true);
    records.set.calibrations.clear();
    let stated = Some(ChannelPriors { gain_sd: 0.02, delay_sd: 1e-5 });
    let done = process(&records, &ProcessOptions { stated, ..ProcessOptions::default() }, &|| ()).unwrap();
    for point in &done.observations.points {
        assert!(point.ping.as_ref().unwrap().pressures.iter().all(|z| z.re.is_finite()));
    }
}
