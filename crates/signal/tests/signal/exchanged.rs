//! Channels that are exchanged in clicks, clicks that are copies, and modes outside the band of clicks: whole
//! sets of records.

use crate::clicking::Clicking;
use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Streams};
use rijke_rig::{
    Acquisition, Apparatus, Arrays, Calibration, DataKind, Day, OperatingPoint, PointRecords, Record,
    RecordSet, RecordSource, RecordTiming, RigError,
};
use rijke_signal::{ProcessOptions, Processed, process};

/// Eight microphones, two pairs of which are near each other.
const PLACES: [f64; 8] = [0.25, 0.33, 0.45, 0.49, 0.65, 0.72, 0.85, 0.95];
const CALIBRATIONS: usize = 4;

/// Clicks of a calibration and of two points, pings of the first point; all as the rig is, but for what a
/// test changes.
struct Clicks {
    set: RecordSet,
    clicking: Clicking,
    clean: Vec<Vec<f64>>,
    /// Channels exchanged in the clicks of the calibration from this one on, and in those of the second
    /// point.
    in_calibration: Option<([usize; 2], usize)>,
    at_point: Option<[usize; 2]>,
    /// Gains with which the calibration clicks are one click.
    copies: Option<[f64; CALIBRATIONS]>,
}

impl Clicks {
    fn new(kind: DataKind) -> Self {
        let text = include_str!("../../../rig/data/rig.toml");
        let mut rig = Apparatus::parse(text, std::path::Path::new("rig.toml")).unwrap();
        rig.microphones.positions = PLACES.to_vec();
        let sound_speed = rig.gas.at(293.0, rig.pressure).sound_speed;
        let clicking = Clicking {
            positions: PLACES.to_vec(),
            sound_speed,
            delays: [0.0, -8e-6, 5e-6, 3e-6, -1e-6, 2e-6, 0.0, 4e-6].to_vec(),
            gains: [1.0, 0.97, 1.02, 0.99, 1.05, 1.0, 0.95, 1.01].to_vec(),
            reflection: 0.97,
            ..Clicking::tube(100.0)
        };
        let point = |k: usize, pings: usize| PointRecords {
            point: OperatingPoint { id: format!("point-{k}"), ..OperatingPoint::default() },
            day: 0,
            pings: (0..pings).map(|n| format!("ping-{k}-{n}")).collect(),
            clicks: (0..2).map(|n| format!("click-{k}-{n}")).collect(),
            way: None,
        };
        let rate_hz = clicking.rate_hz;
        let set = RecordSet {
            acquisition: Acquisition::default(),
            rig,
            kind,
            source: "clicks".into(),
            channels: (0..8).map(Some).collect(),
            arrays: Arrays::default(),
            full_scale: 50.0,
            ping: RecordTiming { rate_hz: 1e4, quiet: 2000 },
            click: RecordTiming { rate_hz, quiet: clicking.quiet },
            days: vec![Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 }],
            points: vec![point(0, 0), point(1, 0)],
            calibrations: vec![Calibration {
                day: 0,
                stretch: RecordTiming { rate_hz, quiet: clicking.quiet },
                clicks: (0..CALIBRATIONS).map(|n| format!("cal-{n}")).collect(),
            }],
        };
        let clean = clicking.clean();
        Self { set, clicking, clean, in_calibration: None, at_point: None, copies: None }
    }

    fn recorded(&self, name: &str, exchanged: Option<[usize; 2]>) -> Record {
        let mut channels = self.clicking.noisy(&self.clean, 1, name);
        if let Some([a, b]) = exchanged {
            channels.swap(a, b);
        }
        let Clicking { rate_hz, quiet, .. } = self.clicking;
        Record { rate_hz, quiet, full_scale: f64::INFINITY, channels }
    }

    fn process(&self) -> Result<Processed, String> {
        process(self, &ProcessOptions::default(), &|| ()).map_err(|fault| fault.to_string())
    }
}

impl RecordSource for Clicks {
    fn set(&self) -> &RecordSet {
        &self.set
    }

    fn ping(&self, _: usize, repeat: usize) -> Result<Record, RigError> {
        let mut stream = Streams::new(1).stream(&format!("ping {repeat}"));
        let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
        let mut of = |x: f64| -> Vec<f64> {
            let sound = |n: usize| {
                let t = (n as f64 - 4000.0) * 1e-4;
                let exponent = if t < 0.0 { C64::new(0.0, 1088.0) } else { C64::new(-9.0, 1085.0) };
                if n < 2000 { 0.0 } else { 5.0 * (3.1 * x).sin() * (exponent * t).exp().re }
            };
            (0..14_000).map(|n| sound(n) + 0.01 * normal()).collect()
        };
        let channels = PLACES.iter().map(|x| of(*x)).collect();
        Ok(Record { rate_hz: 1e4, quiet: 2000, full_scale: f64::INFINITY, channels })
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        let exchanged = self.at_point.filter(|_| point == 1);
        Ok(self.recorded(&format!("click {point} {repeat}"), exchanged))
    }

    fn calibration(&self, _: usize, repeat: usize) -> Result<Record, RigError> {
        let exchanged = self.in_calibration.filter(|(_, from)| repeat >= *from).map(|(channels, _)| channels);
        let Some(gains) = self.copies else {
            return Ok(self.recorded(&format!("calibration {repeat}"), exchanged));
        };
        let mut record = self.recorded("calibration 0", exchanged);
        record.channels.iter_mut().flatten().for_each(|v| *v *= gains[repeat]);
        Ok(record)
    }
}

#[test]
fn exact_clicks_of_channels_in_order_are_all_used() {
    let done = Clicks::new(DataKind::Measured).process().unwrap();
    assert!(done.observations.rejections.is_empty(), "{:?}", done.observations.rejections);
    assert_eq!(done.click_delays.unwrap().clicks, CALIBRATIONS);
    assert!(done.observations.points.iter().all(|p| p.click_count == 2));
}

/// Before, a pair nearer to each other than others was taken as it was, without a word.
#[test]
fn message_channels_exchanged_in_the_calibration_are_named() {
    for ([a, b], travel) in [([2, 3], "117"), ([0, 1], "233"), ([1, 4], "932")] {
        let records = Clicks { in_calibration: Some(([a, b], 0)), ..Clicks::new(DataKind::Measured) };
        let said = records.process().map(|done| done.notes).unwrap_err();
        let named = format!(
            "microphone {a} (p{}) and microphone {b} (p{}) are exchanged in 4 of 4 calibration clicks",
            a + 1,
            b + 1
        );
        assert!(said.contains(&named), "{said}");
        assert!(said.contains(&format!("sound takes {travel} us from the one to the other")), "{said}");
        assert!(said.contains("give the right `channels` in the manifest"), "{said}");
    }
    // In some of the clicks: the first of them is named.
    let records = Clicks { in_calibration: Some(([2, 3], 2)), ..Clicks::new(DataKind::Measured) };
    let said = records.process().map(|_| ()).unwrap_err();
    assert!(said.contains("are exchanged in 2 of 4 calibration clicks, the first of them cal-2"), "{said}");
}

/// Before, their arrival times were taken as they were: wrong by hundreds of microseconds.
#[test]
fn message_channels_exchanged_in_the_clicks_of_a_point_are_named() {
    for [a, b] in [[2, 3], [1, 2], [4, 6]] {
        let records = Clicks { at_point: Some([a, b]), ..Clicks::new(DataKind::Measured) };
        let done = records.process().unwrap();
        let points = &done.observations.points;
        assert_eq!((points[0].click_count, points[1].click_count), (2, 0));
        assert!(points[1].click.is_none());
        for rejection in &done.observations.rejections {
            let named =
                format!("microphone {a} (p{}) and microphone {b} (p{}) are exchanged: ", a + 1, b + 1);
            assert!(rejection.reason.starts_with(&named), "{}", rejection.reason);
            assert!(rejection.reason.contains("`channels` of these files in an [[exception]]"));
        }
        assert_eq!(done.observations.rejections.len(), 2);
    }
}

/// Before, such clicks were refused as too long, and as noise.
#[test]
fn message_a_closed_end_and_a_click_at_the_other_end_are_named() {
    let of = |change: &dyn Fn(&mut Clicking)| {
        let mut records = Clicks::new(DataKind::Measured);
        change(&mut records.clicking);
        records.clean = records.clicking.clean();
        records.process()
    };
    let done = of(&|clicking| clicking.reflection = -0.97).unwrap();
    let closed =
        |r: &rijke_rig::Rejection| r.reason.contains("It has the sign of the impulse, as at a closed end");
    let rejections = &done.observations.rejections;
    assert!(!rejections.is_empty() && rejections.iter().all(closed), "{rejections:?}");
    assert!(rejections[0].reason.contains("an open end without a flange"), "{rejections:?}");
    let said = of(&|clicking| clicking.positions = PLACES.map(|x| 1.0 - x).to_vec()).map(|_| ()).unwrap_err();
    let named =
        "sound comes to microphone 7 (p8) first and to microphone 0 (p1) last in 4 of 4 calibration clicks";
    assert!(said.contains(named), "{said}");
}

/// Before, four copies counted as four clicks.
#[test]
fn behaviour_copies_among_the_calibration_clicks_count_once() {
    for gains in [[1.0; CALIBRATIONS], [1.0, 0.95, 0.9, 0.85]] {
        let done = Clicks { copies: Some(gains), ..Clicks::new(DataKind::Measured) }.process().unwrap();
        assert!(done.click_delays.is_none());
        let of_copies = |r: &&rijke_rig::Rejection| r.reason.starts_with("a copy of cal-0: ");
        assert_eq!(done.observations.rejections.iter().filter(of_copies).count(), 3);
        let said = |part: &str| done.notes.iter().any(|note| note.contains(part));
        assert!(said("3 of 4 calibration clicks are copies of others"), "{:?}", done.notes);
        assert!(said("of the calibration clicks at 62500 Hz 1 can be used"), "{:?}", done.notes);
    }
}

#[test]
fn message_a_mode_outside_the_band_of_the_clicks_is_said() {
    let notes = |kind: DataKind| {
        let mut records = Clicks::new(kind);
        records.set.points[0].pings = (0..2).map(|n| format!("ping-{n}")).collect();
        records.process().unwrap().notes
    };
    let found = notes(DataKind::Measured);
    let said = found.iter().find(|note| note.contains("lies below the band of the calibration clicks"));
    let said = said.unwrap_or_else(|| panic!("{found:?}"));
    assert!(said.starts_with("the mode (172.7 Hz) ") && said.contains("Hz): gains and delays"), "{said}");
    // Channels of the virtual laboratory are gains and delays at all frequencies.
    assert!(!notes(DataKind::Virtual).iter().any(|note| note.contains("the band of the calibration clicks")));
}
