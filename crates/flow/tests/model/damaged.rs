//! No damage makes a reader panic: the files of a heated tube, cut, turned, spliced and filled with hostile
//! numbers, a thousand times each.

use proptest::prelude::*;
use rijke_flow::{HeatedTube, TubeCampaign, TubeObservations, TubePoint, TubeRig};
use rijke_numerics::{Streams, check::damaged};
use rijke_rig::{DataKind, Day, Observations, OperatingPoint, PointObservations, Problem, RigError};
use std::fs;
use std::path::{Path, PathBuf};

const RIG: &str = include_str!("../../data/rigs/juniper-yoko-2022.toml");
const CAMPAIGN: &str = include_str!("../../data/campaigns/juniper-yoko-2022.toml");
const RAMPS: &str =
    "ramp,time [s],power [W],point\nup,0,7,\nup,900,7,H7-25\nup,1500,30,\nup,2400,30,H30-25\n";

/// Observations of points of the paper, in which nothing was measured, beside the tube and a ramp.
fn folder(name: &str) -> (PathBuf, Observations) {
    let folder = std::env::temp_dir().join(format!("rijke-flow-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(HeatedTube::FILE), RIG).unwrap();
    fs::write(folder.join("ramps.csv"), RAMPS).unwrap();
    let day = Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 };
    let points = TubeCampaign::juniper_yoko_2022().points.into_iter();
    let of = |p: TubePoint| PointObservations::unmeasured(OperatingPoint::from(&p), day.clone());
    let observations = Observations {
        rig: TubeRig::juniper_yoko_2022().apparatus(),
        kind: DataKind::Virtual,
        source: "a test".into(),
        points: points.filter(|p| p.id.ends_with("-25") || p.id == "C3-E").map(of).collect(),
        rejections: Vec::new(),
        channels: None,
    };
    (folder, observations)
}

/// Calls `read` with a thousand damaged versions of a file, written to the same place under `folder`.
fn each(folder: &Path, name: &str, whole: &str, mut read: impl FnMut(&Path)) {
    let (path, streams) = (folder.join(name), Streams::new(0));
    for k in 0..1000 {
        let _ = fs::remove_file(&path);
        fs::write(&path, damaged(whole.as_bytes(), &mut streams.stream(&format!("{name}/{k}")))).unwrap();
        read(&path);
    }
    fs::write(&path, whole).unwrap();
}

#[test]
fn exact_no_damaged_file_of_the_tube_makes_a_reader_panic() {
    let (folder, observations) = folder("damaged");
    each(&folder, HeatedTube::FILE, RIG, |_| drop(TubeObservations::of(&observations, &folder)));
    each(&folder, "ramps.csv", RAMPS, |_| drop(TubeObservations::of(&observations, &folder)));
    each(&folder, "c.toml", CAMPAIGN, |path| {
        if let Ok(campaign) = TubeCampaign::read(path) {
            let _ = campaign.to_toml();
        }
    });
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exact_observations_know_their_tube_and_refuse_another() {
    let (folder, good) = folder("refused");
    let read = TubeObservations::of(&good, &folder).unwrap();
    assert_eq!((read.rig.clone(), read.points.len()), (TubeRig::juniper_yoko_2022(), good.points.len()));
    assert_eq!(read.ramps[0].time_of("H30-25"), Some(2400.0));
    assert!(read.points.iter().all(|p| p.is_planned));
    // A microphone that was dead is missing in the observations, and then in the tube.
    let mut fewer = good.clone();
    fewer.rig.microphones.positions.remove(0);
    fewer.rig.microphones.reference = 4;
    assert_eq!(TubeObservations::of(&fewer, &folder).unwrap().rig.microphones, fewer.rig.microphones);

    let refused = |change: &dyn Fn(&mut Observations), says: &str| {
        let mut other = good.clone();
        change(&mut other);
        let said = TubeObservations::of(&other, &folder).unwrap_err().to_string();
        assert!(said.contains(says), "{said}");
    };
    refused(&|o| o.rig.duct.length = 1.1, "tube.toml: tube.length: is not that of rig.toml beside it");
    refused(&|o| o.rig.pressure = 1e5, "tube.toml: pressure: is not that of rig.toml");
    refused(&|o| o.rig.gas.molar_mass *= 1.01, "tube.toml: gas: is not that of rig.toml");
    refused(&|o| o.rig.microphones.positions[2] = 0.46, "microphones.positions: is not that of rig.toml");
    let rename = |from: &str, to: &str, o: &mut Observations| {
        for p in &mut o.points {
            if let Some(factor) = p.point.factors.remove(from) {
                p.point.factors.insert(to.into(), factor);
            }
        }
    };
    refused(
        &|o| rename("Q_h", "power", o),
        "points.csv: factors: there is no column `Q_h`; the file has `X_h`, `heater`, `power`, `thermometers`",
    );
    refused(&|o| rename("X_h", "x", o), "there is no column `X_h`");
    refused(
        &|o| o.points[1].point.factors.get_mut("X_h").unwrap().value = 1.5,
        "x = 1.5 m is outside the tube (0 to 1 m)",
    );
    refused(
        &|o| o.points[1].point.factors.get_mut("Q_h").unwrap().unit = "K".into(),
        "`K` is not a unit of this quantity, which is in W",
    );
    fs::remove_file(folder.join(HeatedTube::FILE)).unwrap();
    refused(&|_| (), "tube.toml: no such file: put the geometry of the heated tube there");
    fs::remove_dir_all(folder).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// A rig that is read makes sense, whatever number is written into it.
    #[test]
    fn behaviour_a_tube_that_is_read_makes_sense(value in prop_oneof![any::<f64>(), -2.0..2.0_f64], line in 0..40_usize) {
        let mut lines: Vec<String> = RIG.lines().map(String::from).collect();
        if let Some(text) = lines.get_mut(line) && let Some((key, _)) = text.clone().split_once('=') {
            *text = format!("{key}= {value:?}");
        }
        match TubeRig::parse(&lines.join("\n"), Path::new("x")) {
            Ok(rig) => {
                prop_assert!(rig.plates.outer_diameter < rig.tube.inner_diameter);
                prop_assert!(rig.microphones.positions.iter().all(|x| *x > 0.0 && *x < rig.tube.length));
                prop_assert!(rig.apparatus().validate().is_ok());
            }
            Err(RigError::Invalid { problem, .. }) => {
                let named = !matches!(problem, Problem::Keys { .. });
                prop_assert!(named);
            }
            Err(error) => prop_assert!(matches!(error, RigError::Syntax { .. }), "{error}"),
        }
    }
}
