//! A small folder of records, to be spoilt by the tests.

use rijke_flow::{HeatedTube, TubeCampaign, TubeRig};
use rijke_rig::{Calibration, DataKind, Day, PointRecords, RecordSet, RecordTiming, Samples24};
use std::path::Path;

pub(crate) const PING: &str = "C3-E/ping-0.wav";

/// Writes two operating points with two pings and two clicks each, and one calibration click per rate:
/// readable, and without meaning.
pub(crate) fn write(folder: &Path) {
    let points = TubeCampaign::juniper_yoko_2022().points.into_iter().filter(|p| p.row == "C3").take(2);
    let stretch = |rate_hz| RecordTiming { rate_hz, quiet: 20 };
    let named = |id: &str, kind: &str| (0..2).map(|r| format!("{id}/{kind}-{r}.wav")).collect::<Vec<_>>();
    let tube = HeatedTube { rig: TubeRig::juniper_yoko_2022(), ramps: Vec::new() };
    let set = RecordSet {
        rig: tube.rig.apparatus(),
        kind: DataKind::Virtual,
        source: "a test".into(),
        channels: (0..8).map(Some).collect(),
        arrays: rijke_rig::Arrays::default(),
        acquisition: rijke_rig::Acquisition::default(),
        full_scale: 20.0,
        ping: stretch(10_000.0),
        click: stretch(62_500.0),
        days: vec![Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 }],
        points: points
            .map(|point| {
                let (pings, clicks) = (named(&point.id, "ping"), named(&point.id, "click"));
                let way = Some(tube.rig.way(&point));
                PointRecords { day: 0, pings, clicks, point: (&point).into(), way }
            })
            .collect(),
        calibrations: [10_000.0, 62_500.0]
            .map(|rate_hz| Calibration {
                day: 0,
                stretch: stretch(rate_hz),
                clicks: vec![format!("calibration/{rate_hz}.wav")],
            })
            .to_vec(),
    };
    let save = |name: &String, rate_hz: f64| {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let interleaved = (0..8 * 200).map(|k| (k * 174_763) % 8_388_607 - 4_000_000).collect();
        Samples24 { rate_hz: rate_hz as u32, interleaved }.write(8, &path).unwrap();
    };
    for point in &set.points {
        point.pings.iter().for_each(|n| save(n, 10_000.0));
        point.clicks.iter().for_each(|n| save(n, 62_500.0));
    }
    for calibration in &set.calibrations {
        calibration.clicks.iter().for_each(|n| save(n, calibration.stretch.rate_hz));
    }
    tube.write_within(folder, &|_| true).unwrap();
    set.write(folder).unwrap();
}
