//! Files on disk: round trips, and one clear message for every kind of bad input.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use proptest::prelude::*;
use rijke_numerics::{C64, Matrix};
use rijke_rig::{
    Apparatus, Calibration, ChannelErrors, Click, DataKind, Day, FactorValue, Observations, OperatingPoint,
    Ping, PointObservations, PointRecords, RecordFolder, RecordSet, RecordSource, RecordTiming, Rejection,
    RigError, Samples24, Stretch, Way, inspect, read_record,
};
use std::path::{Path, PathBuf};

/// A folder that is removed when the test ends.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("rijke-rig-{}-{name}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const FRAMES: usize = 12;

fn rig() -> Apparatus {
    Apparatus::parse(include_str!("../../data/rig.toml"), Path::new("rig.toml")).unwrap()
}

/// A point with two factors, one of which may be absent.
fn point(id: &str, x: Option<f64>) -> OperatingPoint {
    let factor =
        |name: &str, value: f64, unit: &str| (name.to_owned(), FactorValue { value, unit: unit.to_owned() });
    let factors =
        x.map(|x| factor("x_h", x, "m")).into_iter().chain([factor("flow", 1e-4 / 3.0, "m^3 s^-1")]);
    OperatingPoint { id: id.into(), row: "C3".into(), repeats: 40, factors: factors.collect() }
}

/// Two operating points, one ping and one click each, one calibration click; channels in reverse order.
fn small_set() -> RecordSet {
    let stretch = Stretch { from: 0.0, to: 1.0 / 3.0, wetted: 63.25, excess_sd: 0.5 };
    let points = [
        (point("C3-E", None), None),
        (point("C3-05", Some(0.05)), Some(Way { hot: true, stretches: vec![stretch] })),
    ];
    let stretch = |rate_hz| RecordTiming { rate_hz, quiet: 3 };
    RecordSet {
        rig: rig(),
        kind: DataKind::Virtual,
        source: "a test".into(),
        channels: (0..8).rev().map(Some).collect(),
        arrays: rijke_rig::Arrays::default(),
        full_scale: 20.0,
        ping: stretch(10_000.0),
        click: stretch(62_500.0),
        days: vec![Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 }],
        points: points
            .into_iter()
            .map(|(point, way)| PointRecords {
                way,
                day: 0,
                pings: vec![format!("{}-ping.wav", point.id)],
                clicks: vec![format!("{}-click.wav", point.id)],
                point,
            })
            .collect(),
        calibrations: vec![Calibration {
            day: 0,
            stretch: stretch(10_000.0),
            clicks: vec!["cal.wav".into()],
        }],
        acquisition: rijke_rig::Acquisition { may_be_silent: true, ..rijke_rig::Acquisition::default() },
    }
}

fn samples(rate_hz: u32) -> Samples24 {
    let interleaved = (0..FRAMES as i32 * 8).map(|k| (k * 174_763) % 8_388_607 - 4_000_000).collect();
    Samples24 { rate_hz, interleaved }
}

fn write_small(folder: &Path) -> RecordSet {
    let set = small_set();
    for point in &set.points {
        samples(10_000).write(8, &folder.join(&point.pings[0])).unwrap();
        samples(62_500).write(8, &folder.join(&point.clicks[0])).unwrap();
    }
    samples(10_000).write(8, &folder.join("cal.wav")).unwrap();
    set.write(folder).unwrap();
    set
}

#[test]
fn exact_records_survive_the_disk_bit_for_bit() {
    let scratch = Scratch::new("records");
    let set = write_small(&scratch.0);
    let folder = RecordFolder::open(&scratch.0).unwrap();
    assert_eq!(folder.set().points, set.points);
    assert_eq!(folder.set().calibrations, set.calibrations);
    assert_eq!(folder.set().rig, set.rig);
    assert_eq!(folder.set().acquisition.may_be_silent, set.acquisition.may_be_silent);
    let direct = samples(62_500).record(set.layout(set.click));
    assert_eq!(folder.click(1, 0).unwrap(), direct);
    assert_eq!(folder.calibration(0, 0).unwrap(), samples(10_000).record(set.layout(set.ping)));
    // Channel 7 of the file is microphone 0; the unit is full scale over 2^23.
    let raw = f64::from(samples(62_500).interleaved[7]);
    assert_eq!(direct.channels[0][0], raw * 20.0 / 8_388_608.0);
}

#[track_caller]
fn refused(error: RigError, place: &str, remedy: &str) {
    let text = error.to_string();
    assert!(text.contains(place) && text.contains(remedy), "{text}");
}

#[test]
fn exact_messages_of_bad_records() {
    let scratch = Scratch::new("bad");
    let set = write_small(&scratch.0);
    let file = scratch.0.join(&set.points[0].pings[0]);
    let good = std::fs::read(&file).unwrap();
    let read = |layout| read_record(&file, layout).unwrap_err();

    refused(
        read(set.layout(set.click)),
        "header: sampled at 10000 Hz, expected 62500 Hz",
        "correct the rate",
    );
    let nine = RecordSet { channels: vec![None; 9], ..set.clone() };
    refused(
        read(nine.layout(set.ping)),
        "8 channels, the manifest's `channels` lists 9",
        "record all channels",
    );
    let late = RecordTiming { quiet: 12, ..set.ping };
    refused(
        read(set.layout(late)),
        "12 samples, but the quiet stretch alone is 12",
        "correct the quiet length",
    );

    std::fs::write(&file, &good[..good.len() - 30]).unwrap();
    refused(read(set.layout(set.ping)), "ends after sample 10 of 12", "record it again");
    for (cut, place, remedy) in [
        (0, "not a WAV file", "use 16, 24 or 32 bit"),
        (3, "not a WAV file", "use 16, 24 or 32 bit"),
        (40, "chunk `fmt ` at byte 12 should have 40 bytes, 20 are left", "copy or record it again"),
    ] {
        std::fs::write(&file, &good[..cut]).unwrap();
        refused(read(set.layout(set.ping)), place, remedy);
    }
    std::fs::remove_file(&file).unwrap();
    refused(RecordFolder::open(&scratch.0).unwrap_err(), "there is no file", "copy it there");
    refused(RecordFolder::open(Path::new("/nowhere")).unwrap_err(), "/nowhere/manifest.toml", "rijke lab");
}

#[test]
fn exact_text_and_wav_give_the_same_record() {
    let scratch = Scratch::new("text");
    let (set, samples) = (small_set(), samples(10_000));
    let from_wav = samples.record(set.layout(set.ping));
    let path = scratch.0.join("ping.csv");
    // Rows in the order of the file's channels: microphone 7 first.
    let row = |n: usize, by: &str| {
        let cells: Vec<String> = (0..8).rev().map(|m| from_wav.channels[m][n].to_string()).collect();
        cells.join(by)
    };
    for (by, header, end) in
        [(",", "a,b,c,d,e,f,g,h\n", "\n"), (";", "", "\r\n"), ("\t", "\u{feff}p\t\t\t\t\t\t\t\n", "\n")]
    {
        let rows: String = (0..FRAMES).map(|n| row(n, by) + end).collect();
        std::fs::write(&path, format!("{header}{rows}\n")).unwrap();
        let record = read_record(&path, set.layout(set.ping)).unwrap();
        assert_eq!((record.channels, record.full_scale), (from_wav.channels.clone(), f64::INFINITY));
    }
    let good: String = (0..FRAMES).map(|n| row(n, ",") + "\n").collect();
    let lines: Vec<&str> = good.lines().collect();
    let with = |line: &str| {
        let mut changed = lines.clone();
        changed[4] = line;
        std::fs::write(&path, changed.join("\n")).unwrap();
        read_record(&path, set.layout(set.ping)).unwrap_err()
    };
    refused(with("1,2,3"), "line 5: 3 columns, the rows before have 8", "every row needs as many");
    refused(with("1,2,3,x,5,6,7,8"), "line 5, column 4: `x` is not a number", "decimal point");
    refused(with("1,2,3,4,5,6,inf,8"), "microphone 1: sample 4 is inf", "remove the file");
    std::fs::write(&path, "").unwrap();
    refused(read_record(&path, set.layout(set.ping)).unwrap_err(), "0 samples", "export it again");
}

#[test]
fn exact_messages_of_a_bad_manifest() {
    let scratch = Scratch::new("manifest");
    write_small(&scratch.0);
    let path = scratch.0.join("manifest.toml");
    let good = std::fs::read_to_string(&path).unwrap();
    for (old, new, place, remedy) in [
        ("kind =", "kynd =", "there is no key `kynd`; did you mean `kind`?", "Known here: rig, campaign"),
        ("id = \"C3-E\"", "id = \"C4-E\"", "point[0].id: `C4-E` is not known", "known: C3-E, C3-05"),
        ("id = \"C3-05\"", "id = \"C3-E\"", "point: `C3-E` appears twice", "must be different"),
        ("day = \"one\"", "day = \"two\"", "`two` is not known", "known: one"),
        (
            "channels = [7,",
            "channels = [6,",
            "channels: microphone 6 is recorded by 2 channels",
            "each microphone once",
        ),
        ("temperature_k = 293", "temperature_k = 20", "20 K is outside 150 to 500 K", "give SI units"),
        ("to = 0.333", "to = 3.333", "point `C3-05`: way.stretches[0].to: 3.33", "give SI units"),
        ("wetted_per_m = 63", "wetted_per_m = -63", "wetted_per_m: -63.25 1/m is outside", "give SI units"),
        (
            "excess_sd",
            "excess_ds",
            "there is no key `excess_ds`; did you mean `excess_sd`?",
            "Known here: from",
        ),
        ("full_scale_pa = 20", "full_scale_pa = 0", "full_scale_pa: 0 Pa is outside", "give SI units"),
    ] {
        assert!(good.contains(old), "{old} in {good}");
        std::fs::write(&path, good.replacen(old, new, 1)).unwrap();
        refused(RecordFolder::open(&scratch.0).unwrap_err(), place, remedy);
    }
    let cut = good.find("[[point]]").unwrap();
    std::fs::write(&path, format!("point = []\n{}", &good[..cut])).unwrap();
    refused(RecordFolder::open(&scratch.0).unwrap_err(), "point: is empty", "one [[point]]");
}

fn observations() -> Observations {
    let (rig, point) = (rig(), point("C3-35", Some(0.35)));
    let covariance = |n: usize| {
        Matrix::from_fn(n, n, |i, j| if i == j { 0.125 + i as f64 } else { 1e-3 / (1.0 + (i + j) as f64) })
    };
    let pressures = (0..8).map(|m| C64::new(if m == 5 { 1.0 } else { 0.1 * f64::from(m) }, 0.0)).collect();
    let ping =
        Ping { s: C64::new(-11.25, 1078.1 / 3.0), pressures, reference: 5, covariance: covariance(16) };
    let click = Click {
        arrival_times: (1..9).map(|k| f64::from(k) * 1e-4 / 3.0).collect(),
        covariance: covariance(8),
    };
    let scaled = |by: f64| Matrix::zeros(7, 7).plus(by, &covariance(7));
    Observations {
        kind: DataKind::Virtual,
        source: "a test, with \"quotes\"".into(),
        points: vec![PointObservations {
            point,
            ambient: Day { id: "one".into(), ambient_temperature: 293.1, ambient_temperature_sd: 0.1 },
            ping: Some(ping.clone()),
            drift_sd: 0.031,
            ping_count: 2,
            click: Some(click.clone()),
            click_count: 1,
            pings: vec![(0, ping.clone()), (3, ping)],
            clicks: vec![(0, click)],
        }],
        rejections: vec![Rejection { record: "a, b".into(), reason: "clipped\ntwice".into() }],
        channels: Some(ChannelErrors { delays: scaled(1e-14), gains: scaled(1e-6), contained: true }),
        rig,
    }
}

#[test]
fn exact_observations_survive_the_disk_bit_for_bit() {
    let (scratch, written) = (Scratch::new("observations"), observations());
    written.write(&scratch.0).unwrap();
    assert_eq!(Observations::read(&scratch.0).unwrap(), written);
    // As a spreadsheet saves it: byte-order mark, carriage returns.
    let path = scratch.0.join("points.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("\u{feff}{}", text.replace('\n', "\r\n"))).unwrap();
    assert_eq!(Observations::read(&scratch.0).unwrap(), written);
}

#[test]
fn exact_messages_of_bad_channel_errors() {
    let scratch = Scratch::new("bad-channels");
    observations().write(&scratch.0).unwrap();
    let path = scratch.0.join("channels.toml");
    let good = std::fs::read_to_string(&path).unwrap();
    let gains = good.find("gain_covariance").unwrap();
    let text = |gains: &str| {
        format!("{}gain_covariance = {gains}\n", &good[..good.find("gain_covariance").unwrap()])
    };
    let diagonal = |sign: f64| {
        let row = |i: usize| (0..7).map(|j| if i == j { sign * 1e-6 } else { 0.0 }).collect::<Vec<f64>>();
        format!("{:?}", (0..7).map(row).collect::<Vec<_>>())
    };
    for (bad, place, remedy) in [
        (text("[[1e-6]]"), "gain_covariance: has 1 rows", "needs 7 of 7 numbers"),
        (
            text(&diagonal(-1.0)),
            "gain_covariance: the covariance is not positive definite",
            "variances above zero",
        ),
        (good[..gains].to_owned(), "the key `gain_covariance` is missing", ""),
    ] {
        std::fs::write(&path, bad).unwrap();
        refused(Observations::read(&scratch.0).map(|_| ()).unwrap_err(), place, remedy);
    }
    std::fs::write(&path, text(&diagonal(1.0))).unwrap();
    assert!(Observations::read(&scratch.0).unwrap().channels.is_some());
    std::fs::remove_file(&path).unwrap();
    assert_eq!(Observations::read(&scratch.0).unwrap().channels, None);
}

#[test]
fn exact_messages_of_bad_observations() {
    let scratch = Scratch::new("bad-observations");
    observations().write(&scratch.0).unwrap();
    let path = scratch.0.join("pings.csv");
    let good = std::fs::read_to_string(&path).unwrap();
    for (old, new, place, remedy) in [
        ("C3-35,", "C3-36,", "line 2, column `point`: `C3-36` is not known", "known: C3-35"),
        ("-1.125e1", "x", "line 2, column `growth_rate [1/s]`: `x` is not a finite number", ""),
        ("-1.125e1", "nan", "`nan` is not a finite number", ""),
        (
            "growth_rate [1/s]",
            "sigma",
            "column 2 is `sigma`, expected `growth_rate [1/s]`",
            "keep the header",
        ),
        (",1.25e-1,", ",-1.25e-1,", "covariance is not positive definite", "variances above zero"),
    ] {
        assert!(good.contains(old), "{old}");
        std::fs::write(&path, good.replacen(old, new, 1)).unwrap();
        refused(Observations::read(&scratch.0).map(|_| ()).unwrap_err(), place, remedy);
    }
    std::fs::write(&path, &good[..good.len() - 40]).unwrap();
    refused(Observations::read(&scratch.0).map(|_| ()).unwrap_err(), "pings.csv:2", "fields");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// No bytes whatever make the WAV reader panic.
    #[test]
    fn behaviour_no_bytes_make_the_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400), header: bool) {
        let scratch = Scratch::new("fuzz");
        let path = scratch.0.join("x.wav");
        samples(10_000).write(8, &path).unwrap();
        let mut file = std::fs::read(&path).unwrap();
        if header {
            for (k, byte) in bytes.iter().enumerate().take(60) {
                if byte % 5 == 0 && k < file.len() { file[k] = *byte; }
            }
        } else {
            file = bytes;
        }
        std::fs::write(&path, &file).unwrap();
        let set = small_set();
        let _ = read_record(&path, set.layout(set.ping));
        let _ = inspect(&path);
        let text = scratch.0.join("x.csv");
        std::fs::write(&text, &file).unwrap();
        let _ = read_record(&text, set.layout(set.ping));
    }

    /// A text record that is cut off or has wrong bytes is a record or an error.
    #[test]
    fn oracle_damaged_text_gives_a_record_or_an_error(
        cut in 0..400_usize, wrong in proptest::collection::vec((0..400_usize, any::<u8>()), 0..6), comma: bool,
    ) {
        let scratch = Scratch::new("damaged-text");
        let path = scratch.0.join("x.csv");
        let separator = if comma { "," } else { ";" };
        let row = |n: usize| (0..8).map(|c| format!("{}.5e-1", n + c)).collect::<Vec<_>>().join(separator);
        let mut bytes = (0..9).map(row).collect::<Vec<_>>().join("\r\n").into_bytes();
        for (place, byte) in wrong {
            if let Some(b) = bytes.get_mut(place) { *b = byte; }
        }
        bytes.truncate(cut);
        std::fs::write(&path, &bytes).unwrap();
        let set = small_set();
        if let Ok(record) = read_record(&path, set.layout(set.ping)) {
            prop_assert!(record.channels.iter().all(|c| c.len() == record.len() && c.iter().all(|p| p.is_finite())));
        }
        let _ = inspect(&path);
    }

    /// Nor does any text the TOML and CSV readers, and a rig that is accepted is inside its own limits.
    #[test]
    fn oracle_any_text_gives_a_rig_or_an_error(position in -10.0..10.0_f64, diameter in -1.0..2.0_f64, text in "\\PC*") {
        let paper = include_str!("../../data/rig.toml");
        let _ = Apparatus::parse(&text, Path::new("x"));
        let changed = paper.replace("0.25, 0.35", &format!("{position:?}, 0.35")).replace("0.0474", &format!("{diameter:?}"));
        if let Ok(rig) = Apparatus::parse(&changed, Path::new("x")) {
            prop_assert!(rig.microphones.positions.iter().all(|x| *x > 0.0 && *x < rig.duct.length));
            prop_assert!(rig.duct.inner_diameter <= rig.duct.length);
        }
    }
}
