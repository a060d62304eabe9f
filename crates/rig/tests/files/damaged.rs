//! No damage makes a reader panic: each file that the project can read, cut, turned, spliced and filled with
//! hostile numbers, a thousand times each. The fuzz targets of the repository search further, with coverage.
#![allow(clippy::unwrap_used, reason = "a test may fail by panicking")]

use rijke_numerics::{Streams, check::damaged};
use rijke_rig::{
    Apparatus, Arrays, Column, Columns, Decimal, Heading, Layout, Observations, Quantity, Reading,
    RecordFolder, TextForm, Unit, inspect, read_record,
};
use std::{
    fs,
    path::{Path, PathBuf},
};

const RIG: &str = include_str!("../../data/rig.toml");
const CAMPAIGN: &str = include_str!("../../data/campaign.csv");

const MANIFEST: &str = "rig = 'rig.toml'\ncampaign = 'campaign.csv'\nkind = 'measured'\nsource = 'a test'\nfull_scale_pa = 20.0\n\
    channels = [0, 1, 2, 3, 4, 5, 6, 7]\nping = { rate_hz = 10000.0, quiet_samples = 1000 }\n\
    click = { rate_hz = 62500.0, quiet_samples = 1000 }\n[arrays]\nnames = ['p']\nrate = 'fs'\n[[day]]\nid = 'one'\n\
    ambient_temperature_k = 293.15\nambient_temperature_sd_k = 0.1\n[[point]]\nid = 'C3-E'\nday = 'one'\n\
    pings = ['rig.toml']\nclicks = ['campaign.csv']\nway = { hot = true, stretches = [{ from = 0.0, to = 0.5, wetted_per_m = 60.0 }] }\n[[calibration]]\nday = 'one'\nrate_hz = 10000.0\nquiet_samples = 1000\n\
    clicks = ['rig.toml']\n";

/// Calls `read` with `times` damaged versions of a file, written to the same place under `folder`.
fn each(folder: &Path, name: &str, whole: &[u8], times: u64, mut read: impl FnMut(&Path)) {
    let path = folder.join(name);
    let streams = Streams::new(0);
    for k in 0..times {
        // A file that is cut and written again goes to the disk at once, which takes longer than all the
        // rest.
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
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/records");
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
                let layout = Layout {
                    channels: &channels,
                    full_scale: 20.0,
                    rate_hz: 1e4,
                    quiet: 2,
                    arrays: &arrays,
                    reading: &Reading::default(),
                };
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
    each(&folder, "r.toml", RIG.as_bytes(), 1000, |path| drop(Apparatus::read(path)));
    fs::write(folder.join("rig.toml"), RIG).unwrap();
    fs::write(folder.join("campaign.csv"), CAMPAIGN).unwrap();
    fs::write(folder.join("manifest.toml"), MANIFEST).unwrap();
    RecordFolder::open(&folder).unwrap();
    each(&folder, "campaign.csv", CAMPAIGN.as_bytes(), 1000, |_| {
        if let Ok(opened) = RecordFolder::open(&folder) {
            // What is read can be written, and read again.
            let again = folder.join("again");
            rijke_rig::RecordSource::set(&opened).write(&again).unwrap();
        }
    });
    fs::write(folder.join("campaign.csv"), CAMPAIGN).unwrap();
    each(&folder, "manifest.toml", MANIFEST.as_bytes(), 1000, |_| drop(RecordFolder::open(&folder)));
    // Every key that may be there, and the table that one of them names.
    let (first, rest) = MANIFEST.split_once("[[day]]").unwrap();
    let full = first.replace(
        "full_scale_pa = 20.0",
        "full_scale = '10 V'\nunit = 'mV'\ndead = [1]\ntime = 2\ntext = { decimal = ',' }",
    ) + "[microphones]\ntable = 'mics.csv'\ngain_sd = '2 %'\ndelay = 1e-6\n[[exception]]\ndays = ['one']\n\
           channels = { a = 0, b = 2, c = 3, d = 4, e = 5, f = 6, g = 7, h = -1 }\ndead = [7]\n[[day]]"
        + rest;
    let rows: String = (0..8).map(|m| format!("{m},{}.5,{m}\n", 49 + m)).collect();
    let table = format!("microphone,sensitivity [mV/Pa],delay_sd [us]\n{}", rows.replacen(",0\n", ",3\n", 1));
    fs::write(folder.join("mics.csv"), &table).unwrap();
    fs::write(folder.join("manifest.toml"), &full).unwrap();
    RecordFolder::open(&folder).unwrap();
    each(&folder, "mics.csv", table.as_bytes(), 1000, |_| drop(RecordFolder::open(&folder)));
    fs::write(folder.join("mics.csv"), &table).unwrap();
    each(&folder, "manifest.toml", full.as_bytes(), 1000, |_| drop(RecordFolder::open(&folder)));
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exact_no_damaged_table_of_observations_makes_the_reader_panic() {
    let folder = scratch("damaged-observations");
    let page = include_str!("../../../../docs/records-format.md");
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
    fs::write(
        folder.join("clicks.csv"),
        "point,arrival1 [s],cov_arrival1_arrival1 [s^2]\nempty,1e-3,1e-12\n",
    )
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

/// Text as laboratories write it, read with everything that a manifest may say of it.
#[test]
fn exact_no_damaged_text_makes_a_reader_panic() {
    let folder = scratch("damaged-texts");
    let texts = [
        "# rig 3\nSamples\t3\n\nt\ta\tb\tdrive\ns\tkPa\tmV\tV\n0,000\t0,01\t-1,5\t9\n0,001\t-0,02\t2,5\t9\n0,002\t0,03\t-3\t9\n",
        "a [Pa],b [mV],drive [V]\n1,2,3\n4,5,6\n7,8,9\n1,2,3\n",
        "\u{feff}t [ms]; a; b\r\n0;1,5;2,5\r\n1;1,5;2,5\r\n2;1,5;2,5\r\n",
        "a b\n1.5 2.5e-3\n3 4\n5 6\n",
    ];
    let names =
        |list: &[(&str, Option<usize>)]| list.iter().map(|(name, m)| ((*name).to_owned(), *m)).collect();
    let readings = [
        Reading::default(),
        Reading {
            names: names(&[("a", Some(0)), ("b", Some(1)), ("drive", None)]),
            sensitivities: vec![0.05; 2],
            unit: Unit::parse("V").ok(),
            ..Reading::default()
        },
        Reading {
            time: Some(Column::Number(1)),
            text: TextForm { header_lines: Some(1), decimal: Some(Decimal::Comma) },
            dead: vec![1],
            ..Reading::default()
        },
    ];
    let (channels, arrays) = ([Some(0), Some(1)], Arrays::default());
    for (k, text) in texts.into_iter().enumerate() {
        let mut read = 0;
        each(&folder, &format!("{k}.csv"), text.as_bytes(), 1000, |path| {
            for reading in &readings {
                let layout = Layout {
                    channels: &channels,
                    full_scale: 1.0,
                    rate_hz: 1e3,
                    quiet: 1,
                    arrays: &arrays,
                    reading,
                };
                read += usize::from(read_record(path, layout).is_ok());
            }
            let _ = inspect(path);
            if let Ok(columns) = Columns::read(path) {
                for name in columns.headings() {
                    let _ = (columns.keys(name, "Pa"), columns.numbers(name, "s"), columns.words(name));
                }
            }
        });
        // Some damage does no harm; what is read is not only what is refused.
        assert!(read > 0, "no damaged version of text {k} was read");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn exact_no_damaged_unit_makes_the_parser_panic() {
    let streams = Streams::new(1);
    let texts = ["12.5e-3 W/(m^2 degC)", "x [mV/Pa]", "T (°C) / K", "kg·s⁻¹ m³", "p[0]", "-3 µs^-9 / (m*s)"];
    for (k, text) in texts.into_iter().enumerate() {
        for n in 0..2000 {
            let bytes = damaged(text.as_bytes(), &mut streams.stream(&format!("{k}/{n}")));
            let text = String::from_utf8_lossy(&bytes);
            if let Ok(unit) = Unit::parse(&text) {
                // What is read has a size, and its own words mean the same again.
                assert!(unit.factor() > 0.0 && unit.factor().is_finite(), "{text}");
                assert_eq!(Unit::parse(unit.text()).as_ref(), Ok(&unit), "{text}");
            }
            let _ = (Quantity::parse(&text), Heading::parse(&text));
        }
    }
}
