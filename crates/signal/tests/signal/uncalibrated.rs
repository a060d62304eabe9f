//! A set of records without calibration clicks: growth rate and frequency are had, shapes stand on what is stated.

use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Streams};
use rijke_rig::{
    Arrays, Campaign, DataKind, Day, PointRecords, Record, RecordSet, RecordSource, Rig, RigError, Stretch,
};
use rijke_signal::{ProcessOptions, StatedChannels, process};

/// Pings at two points of the paper's rig; nothing else.
struct Pings {
    set: RecordSet,
    rate_hz: f64,
}

const S: C64 = C64::new(-9.0, 1085.0);

impl Pings {
    fn new(rate_hz: f64, repeats: usize) -> Self {
        let quiet = (0.2 * rate_hz) as usize;
        let campaign = Campaign::juniper_yoko_2022();
        let point = |k: usize| PointRecords {
            point: campaign.points[k].clone(),
            day: 0,
            pings: (0..repeats).map(|n| format!("ping-{k}-{n}")).collect(),
            clicks: Vec::new(),
        };
        let set = RecordSet {
            acquisition: rijke_rig::Acquisition::default(),
            rig: Rig::juniper_yoko_2022(),
            kind: DataKind::Measured,
            source: "a rig without clicks".into(),
            channels: (0..8).map(Some).collect(),
            arrays: Arrays::default(),
            full_scale: 50.0,
            ping: Stretch { rate_hz, quiet },
            click: Stretch { rate_hz: 62_500.0, quiet: 1250 },
            days: vec![Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 }],
            points: vec![point(0), point(1)],
            calibrations: Vec::new(),
        };
        Self { set, rate_hz }
    }
}

impl RecordSource for Pings {
    fn set(&self) -> &RecordSet {
        &self.set
    }

    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        let mut stream = Streams::new(1).stream(&format!("uncalibrated {point} {repeat}"));
        let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
        let (quiet, end) = (self.set.ping.quiet, (0.4 * self.rate_hz) as usize);
        // The loudspeaker is nearly tuned; draughts move the frequency from record to record.
        let s = S + C64::new(0.0, 0.05 * normal());
        let channels = (0..8)
            .map(|m| {
                let shape = (std::f64::consts::PI * (0.25 + 0.1 * f64::from(m))).sin();
                (0..(1.4 * self.rate_hz) as usize)
                    .map(|n| {
                        let t = (n as f64 - end as f64) / self.rate_hz;
                        let exponent = if t < 0.0 { C64::new(0.0, 1088.0) } else { s };
                        let sound = if n < quiet { 0.0 } else { 5.0 * shape * (exponent * t).exp().re };
                        sound + 0.01 * normal()
                    })
                    .collect()
            })
            .collect();
        Ok(Record { rate_hz: self.rate_hz, quiet, full_scale: f64::INFINITY, channels })
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        self.ping(point, repeat)
    }

    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError> {
        self.ping(which, repeat)
    }
}

#[test]
fn behaviour_growth_rate_and_frequency_need_no_click() {
    for rate_hz in [1e4, 5e3] {
        let done = process(&Pings::new(rate_hz, 5), &ProcessOptions::default(), &|| ()).unwrap();
        let observations = &done.observations;
        assert_eq!(done.records, 10);
        assert_eq!(observations.rig.microphones.positions, [0.75]);
        for point in &observations.points {
            let ping = point.ping.as_ref().unwrap();
            assert_eq!((ping.pressures.len(), ping.covariance.rows(), point.pings.len()), (1, 2, 5));
            for (error, i) in [(ping.s.re - S.re, 0), (ping.s.im - S.im, 1)] {
                assert!(error.abs() < 4.0 * ping.covariance[(i, i)].sqrt(), "{error}");
            }
            assert!(ping.covariance[(1, 1)].sqrt() < 0.15, "{}", ping.covariance[(1, 1)].sqrt());
        }
        let note = &done.notes[0];
        assert!(note.starts_with(&format!("there are no calibration clicks at {rate_hz} Hz")), "{note}");
        assert!(note.contains("mode shapes are left out"), "{note}");
        // What is written can be read.
        let folder =
            std::env::temp_dir().join(format!("rijke-uncalibrated-{rate_hz}-{}", std::process::id()));
        observations.write(&folder).unwrap();
        let read = rijke_rig::Observations::read(&folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(read.points[1].ping, observations.points[1].ping);
    }
}

#[test]
fn behaviour_stated_channels_carry_the_shapes() {
    let stated = Some(StatedChannels { gain_sd: 0.02, delay_sd: 1e-5 });
    let options = ProcessOptions { stated, ..ProcessOptions::default() };
    let done = process(&Pings::new(1e4, 3), &options, &|| ()).unwrap();
    assert!(done.notes[0].contains("gains as equal to 2.0 % and all delays to 10 us"), "{:?}", done.notes);
    let ping = done.observations.points[0].ping.as_ref().unwrap();
    assert_eq!(ping.pressures.len(), 8);
    // Two gains of 2 % each: the sd of a relative pressure is its size times 0.028.
    let sd = ping.covariance[(2, 2)].sqrt() / ping.pressures[0].norm();
    assert!((0.02..0.04).contains(&sd), "{sd}");
}
