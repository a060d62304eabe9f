//! No damage makes a reader panic: each file that the project can read, cut, turned, spliced and filled with hostile numbers, a thousand
//! times each. The fuzz targets of the repository search further, with coverage.
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use rijke_numerics::{Streams, check::damaged};
use rijke_rig::{Arrays, Campaign, Layout, Observations, RecordFolder, Rig, inspect, read_record};
use std::{
    fs,
    path::{Path, PathBuf},
};

const RIG: &str = include_str!("../fixtures/rigs/juniper-yoko-2022.toml");
const CAMPAIGN: &str = include_str!("../fixtures/campaigns/juniper-yoko-2022.toml");

const MANIFEST: &str = "rig = 'rig.toml'\ncampaign = 'campaign.toml'\nkind = 'measured'\nsource = 'a test'\nfull_scale_pa = 20.0\n\
    channels = [0, 1, 2, 3, 4, 5, 6, 7]\nping = { rate_hz = 10000.0, quiet_samples = 1000 }\n\
    click = { rate_hz = 62500.0, quiet_samples = 1000 }\n[arrays]\nnames = ['p']\nrate = 'fs'\n[[day]]\nid = 'one'\n\
    ambient_temperature_k = 293.15\nambient_temperature_sd_k = 0.1\n[[point]]\nid = 'C3-E'\nday = 'one'\n\
    pings = ['rig.toml']\nclicks = ['rig.toml']\n[[calibration]]\nday = 'one'\nrate_hz = 10000.0\nquiet_samples = 1000\n\
    clicks = ['rig.toml']\n";

/// Calls `read` with `times` damaged versions of a file, written to the same place under `folder`.
fn each(folder: &Path, name: &str, whole: &[u8], times: u64, mut read: impl FnMut(&Path)) {
    let path = folder.join(name);
    let streams = Streams::new(0);
    for k in 0..times {
        // A file that is cut and written again goes to the disk at once, which takes longer than all the rest.
        let _ = fs::remove_file(&path);
        fs::write(&path, damaged(whole, &mut streams.stream(&format!("{name}/{k}")))).unwrap();
        read(&path);
    }
}

fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("rijke-{name}-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn exact_no_damaged_record_makes_a_reader_panic() {
    let folder = scratch("damaged-records");
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/records");
    let mut count = 0;
    for entry in fs::read_dir(fixtures).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if name.ends_with("md") {
            continue;
        }
        count += 1;
        let channels = [Some(0), Some(1)];
        each(&folder, &name, &fs::read(&path).unwrap(), 1000, |path| {
            for names in [&[][..], &["p"], &["left", "right"]] {
                let arrays = Arrays { names: names.iter().map(|n| (*n).to_owned()).collect(), rate: None };
                let layout =
                    Layout { channels: &channels, full_scale: 20.0, rate_hz: 1e4, quiet: 2, arrays: &arrays };
                let _ = read_record(path, layout);
            }
            let _ = inspect(path);
        });
    }
    // MATLAB 5 (v5, compressed, integers, structure) and 7.3, HDF5 (two), text, WAV.
    assert_eq!(count, 9);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exact_no_damaged_description_makes_a_reader_panic() {
    let folder = scratch("damaged-descriptions");
    each(&folder, "r.toml", RIG.as_bytes(), 1000, |path| drop(Rig::read(path)));
    each(&folder, "c.toml", CAMPAIGN.as_bytes(), 1000, |path| {
        if let Ok(campaign) = Campaign::read(path) {
            let _ = campaign.to_toml();
        }
    });
    fs::write(folder.join("rig.toml"), RIG).unwrap();
    fs::write(folder.join("campaign.toml"), CAMPAIGN).unwrap();
    fs::write(folder.join("manifest.toml"), MANIFEST).unwrap();
    RecordFolder::open(&folder).unwrap();
    each(&folder, "manifest.toml", MANIFEST.as_bytes(), 1000, |_| drop(RecordFolder::open(&folder)));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exact_no_damaged_table_of_observations_makes_the_reader_panic() {
    let folder = scratch("damaged-observations");
    let page = include_str!("../fixtures/records-format.txt");
    let example = |name: &str| {
        let (_, rest) = page.split_once(&format!(" {name}\n")).unwrap();
        rest.split_once("```").unwrap().0.to_owned()
    };
    let (head, rest) = RIG.split_once("positions = [").unwrap();
    let rest = rest.split_once(']').unwrap().1.replacen("reference = 5", "reference = 0", 1);
    fs::write(folder.join("rig.toml"), format!("{head}positions = [0.75]{rest}")).unwrap();
    let files = ["observations.toml", "points.csv", "pings.csv"];
    files.iter().for_each(|file| fs::write(folder.join(file), example(file)).unwrap());
    Observations::read(&folder).unwrap();
    for file in files {
        each(&folder, file, example(file).as_bytes(), 1000, |_| drop(Observations::read(&folder)));
        fs::write(folder.join(file), example(file)).unwrap();
    }
    // The tables that the project writes itself: covariances, repeats, clicks.
    Observations::read(&folder).unwrap().write(&folder).unwrap();
    fs::write(folder.join("clicks.csv"), "point,arrival1_s,cov_arrival1_s_arrival1_s\nempty,1e-3,1e-12\n")
        .unwrap();
    let two = head.to_owned() + "positions = [0.25, 0.75]" + &rest;
    fs::write(folder.join("rig.toml"), &two).unwrap();
    let channels = "delay_covariance_s2 = [[1e-14]]\ngain_covariance = [[1e-6]]\n";
    each(&folder, "channels.toml", channels.as_bytes(), 1000, |_| drop(Observations::read(&folder)));
    fs::remove_file(folder.join("channels.toml")).unwrap();
    fs::write(folder.join("rig.toml"), two.replace("0.25, ", "")).unwrap();
    for file in ["pings.csv", "clicks.csv", "rejections.csv"] {
        let whole = fs::read(folder.join(file)).unwrap();
        each(&folder, file, &whole, 1000, |_| drop(Observations::read(&folder)));
        fs::write(folder.join(file), whole).unwrap();
    }
    fs::remove_dir_all(folder).unwrap();
}
