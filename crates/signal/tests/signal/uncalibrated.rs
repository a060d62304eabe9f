//! A set of records without calibration clicks: growth rate and frequency are had, shapes stand on what is
//! stated.

use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Streams};
use rijke_rig::{
    Apparatus, Arrays, DataKind, Day, OperatingPoint, PointRecords, Record, RecordSet, RecordSource,
    RecordTiming, RigError,
};
use rijke_signal::{ChannelPriors, Kept, ProcessOptions, process, process_again};

/// Pings at two points; nothing else.
struct Pings {
    set: RecordSet,
    rate_hz: f64,
}

const S: C64 = C64::new(-9.0, 1085.0);

impl Pings {
    fn new(rate_hz: f64, repeats: usize) -> Self {
        let quiet = (0.2 * rate_hz) as usize;
        let rig = include_str!("../../../rig/data/rig.toml");
        let point = |k: usize| PointRecords {
            point: OperatingPoint { id: format!("point-{k}"), ..OperatingPoint::default() },
            day: 0,
            pings: (0..repeats).map(|n| format!("ping-{k}-{n}")).collect(),
            clicks: Vec::new(),
            way: None,
        };
        let set = RecordSet {
            acquisition: rijke_rig::Acquisition::default(),
            rig: Apparatus::parse(rig, std::path::Path::new("rig.toml")).unwrap(),
            kind: DataKind::Measured,
            source: "a rig without clicks".into(),
            channels: (0..8).map(Some).collect(),
            arrays: Arrays::default(),
            full_scale: 50.0,
            ping: RecordTiming { rate_hz, quiet },
            click: RecordTiming { rate_hz: 62_500.0, quiet: 1250 },
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
fn oracle_points_share_what_their_repeats_scatter() {
    // Two repeats of each of ten points: alone, one whose two happen to agree would state next to no error.
    let mut pings = Pings::new(5e3, 2);
    let first = pings.set.points[0].clone();
    let point = |k: usize| PointRecords {
        point: OperatingPoint { id: format!("point-{k}"), ..first.point.clone() },
        pings: (0..2).map(|n| format!("ping-{k}-{n}")).collect(),
        ..first.clone()
    };
    pings.set.points = (0..10).map(point).collect();
    let done = process(&pings, &ProcessOptions::default(), &|| ()).unwrap();
    for point in &done.observations.points {
        let sd = point.ping.as_ref().unwrap().covariance[(1, 1)].sqrt();
        let ratio = sd / (0.05 / 2.0_f64.sqrt());
        assert!((0.7..1.8).contains(&ratio), "{ratio}");
    }
}

#[test]
fn behaviour_stated_channels_carry_the_shapes() {
    let stated = Some(ChannelPriors { gain_sd: 0.02, delay_sd: 1e-5 });
    let options = ProcessOptions { stated, ..ProcessOptions::default() };
    let done = process(&Pings::new(1e4, 3), &options, &|| ()).unwrap();
    assert!(done.notes[0].contains("gains as equal to 2.0 % and all delays to 10 us"), "{:?}", done.notes);
    let ping = done.observations.points[0].ping.as_ref().unwrap();
    assert_eq!(ping.pressures.len(), 8);
    // Two gains of 2 % each: the sd of a relative pressure is its size times 0.028.
    let sd = ping.covariance[(2, 2)].sqrt() / ping.pressures[0].norm();
    assert!((0.02..0.04).contains(&sd), "{sd}");
}

#[test]
fn behaviour_channels_that_the_manifest_states_carry_the_shapes() {
    let mut pings = Pings::new(1e4, 3);
    let plain = |value: f64| vec![value; 8];
    let stated = rijke_rig::StatedChannels {
        gains: (0..8).map(|m| 1.0 + 0.1 * f64::from(m)).collect(),
        gain_sds: plain(0.02),
        delays: plain(0.0),
        delay_sds: plain(1e-5),
    };
    pings.set.acquisition.stated = Some(stated);
    let done = process(&pings, &ProcessOptions::default(), &|| ()).unwrap();
    assert!(
        done.notes[0].contains("[microphones] of the manifest, known to 2.0 % and 10 us"),
        "{:?}",
        done.notes
    );
    let ping = done.observations.points[0].ping.as_ref().unwrap();
    let sd = ping.covariance[(2, 2)].sqrt() / ping.pressures[0].norm();
    assert!((0.02..0.04).contains(&sd), "{sd}");
    // The records have no gains: they are taken out all the same.
    let shape = |m: f64| (std::f64::consts::PI * (0.25 + 0.1 * m)).sin() / (1.0 + 0.1 * m);
    let expected = shape(0.0) / shape(5.0);
    assert!((ping.pressures[0].re / expected - 1.0).abs() < 1e-3, "{}", ping.pressures[0]);
    assert_eq!(done.observations.channels.as_ref().unwrap().gains.rows(), 7);
    // The command line counts first.
    let own = Some(ChannelPriors { gain_sd: 0.01, delay_sd: 1e-5 });
    let done = process(&pings, &ProcessOptions { stated: own, ..ProcessOptions::default() }, &|| ()).unwrap();
    assert!(done.notes[0].contains("as equal to 1.0 %"), "{:?}", done.notes);
}

/// The same records, in some of which a microphone has no samples.
struct Dead {
    pings: Pings,
    /// Whether microphone 3 is dead in a ping: its point and repeat.
    dead: fn(usize, usize) -> bool,
}

impl RecordSource for Dead {
    fn set(&self) -> &RecordSet {
        &self.pings.set
    }

    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        let mut record = self.pings.ping(point, repeat)?;
        if (self.dead)(point, repeat) {
            record.channels[3].clear();
        }
        // Microphones that are not in the rig of the set are not read.
        let numbers = self.pings.set.acquisition.numbers(self.pings.set.rig.microphones.positions.len());
        record.channels = numbers.iter().map(|m| record.channels[*m].clone()).collect();
        Ok(record)
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        self.ping(point, repeat)
    }

    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError> {
        self.ping(which, repeat)
    }
}

#[test]
fn behaviour_a_dead_microphone_costs_its_channel_only_and_moves_no_number() {
    let stated = Some(ChannelPriors { gain_sd: 0.02, delay_sd: 1e-5 });
    let options = ProcessOptions { stated, ..ProcessOptions::default() };
    let whole = process(&Pings::new(1e4, 3), &options, &|| ()).unwrap();
    // Dead on one day only, in one repeat only, and, by the manifest, in all records.
    let everywhere = || {
        let mut pings = Pings::new(1e4, 3);
        let position = pings.set.rig.microphones.positions.remove(3);
        pings.set.rig.microphones.reference = 4;
        pings.set.acquisition.removed = vec![(3, position)];
        Dead { pings, dead: |_, _| false }
    };
    let some = |dead| Dead { pings: Pings::new(1e4, 3), dead };
    for (records, without) in [
        (some(|p, _| p == 1), [1].as_slice()),
        (some(|p, r| p == 0 && r == 2), &[0]),
        (everywhere(), &[0, 1]),
    ] {
        let done = process(&records, &options, &|| ()).unwrap();
        assert!(done.observations.rejections.is_empty(), "{:?}", done.observations.rejections);
        assert_eq!(done.observations.rig.microphones, whole.observations.rig.microphones);
        assert_eq!(done.observations.channels.as_ref().unwrap().gains.rows(), 7);
        for (k, (point, full)) in done.observations.points.iter().zip(&whole.observations.points).enumerate()
        {
            let (ping, full) = (point.ping.as_ref().unwrap(), full.ping.as_ref().unwrap());
            assert_eq!((point.ping_count, ping.reference), (3, 5));
            for m in 0..8 {
                if m == 3 && without.contains(&k) {
                    assert!(ping.pressures[m].re.is_nan());
                    continue;
                }
                let off = (ping.pressures[m] - full.pressures[m]).norm();
                assert!(off < 2e-3, "point {k}, microphone {m}: {off}");
            }
        }
        // The table has empty cells for it, and every other column keeps its name.
        let folder =
            std::env::temp_dir().join(format!("rijke-dead-{}-{}", without.len(), std::process::id()));
        done.observations.write(&folder).unwrap();
        let text = std::fs::read_to_string(folder.join("pings.csv")).unwrap();
        let lines: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let column = |name: &str| lines[0].iter().position(|c| *c == name).unwrap();
        for k in 0..2 {
            assert_eq!(lines[k + 1][column("p4_re")].is_empty(), without.contains(&k));
            assert!(!lines[k + 1][column("p5_re")].is_empty() && !lines[k + 1][column("p8_im")].is_empty());
        }
        let read = rijke_rig::Observations::read(&folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        // A reader of the whole gets the rig without what is dead in all.
        let heard = if without.len() == 2 { 7 } else { 8 };
        assert_eq!(read.rig.microphones.positions.len(), heard);
        assert_eq!(read.channels.unwrap().gains.rows(), heard - 1);
    }
}

/// The same records in another unit.
struct Loud(Pings);

impl RecordSource for Loud {
    fn set(&self) -> &RecordSet {
        &self.0.set
    }

    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        let mut record = self.0.ping(point, repeat)?;
        record.channels.iter_mut().flatten().for_each(|p| *p *= 1e3);
        Ok(record)
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        self.ping(point, repeat)
    }

    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError> {
        self.ping(which, repeat)
    }
}

#[test]
fn message_a_wrong_unit_is_told_as_long_as_the_records_are_there() {
    let (kept, records) = (Kept::default(), Loud(Pings::new(1e4, 2)));
    let notes = || process_again(&records, &ProcessOptions::default(), Some(&kept), &|| ()).unwrap().notes;
    let first = notes();
    assert!(first.iter().any(|note| note.contains("Pa: look whether `unit`")), "{first:?}");
    // From fits that were kept.
    assert_eq!(notes(), first);
}
