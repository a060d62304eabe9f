//! Files as laboratories write them: names, units, decimal commas, time, headings, dead microphones,
//! sensitivities; and a clear refusal of what could be taken for something else.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_rig::{Arrays, Column, Layout, Reading, Record, RigError, TextForm, Unit, inspect, read_record};
use std::collections::BTreeMap;
use std::path::PathBuf;

const RATE: f64 = 1000.0;
/// Two microphones, in the order of the columns b, a.
const SWAPPED: [Option<usize>; 2] = [Some(1), Some(0)];

/// Writes a file, reads it, removes it.
fn read_as(
    name: &str,
    bytes: &[u8],
    channels: &[Option<usize>],
    reading: &Reading,
) -> Result<Record, RigError> {
    let path = path(name);
    std::fs::write(&path, bytes).unwrap();
    let arrays = Arrays::default();
    let layout =
        Layout { channels, full_scale: f64::INFINITY, rate_hz: RATE, quiet: 1, arrays: &arrays, reading };
    let record = read_record(&path, layout);
    std::fs::remove_file(path).unwrap();
    record
}

fn path(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("rijke-written-{}-{name}", std::process::id()))
}

fn names(list: &[(&str, i64)]) -> BTreeMap<String, Option<usize>> {
    list.iter().map(|(name, m)| ((*name).to_owned(), usize::try_from(*m).ok())).collect()
}

fn wave() -> Vec<Vec<f64>> {
    vec![vec![10.5, -20.25, 30.0, 4.0], vec![-1.5, 2.5, -3.0, 0.125]]
}

/// The same record, however it is written.
#[test]
fn exact_one_record_in_many_hands() {
    let by_name = Reading { names: names(&[("b", 1), ("a", 0), ("drive", -1)]), ..Reading::default() };
    let plain = Reading::default();
    let place = |n: usize| [&SWAPPED[..], &[None; 2]].concat()[..n].to_vec();
    let files: [(&str, &str, Vec<Option<usize>>, &Reading); 16] = [
        ("plain.csv", "-1.5,10.5\n2.5,-20.25\n-3,30\n0.125,4\n", place(2), &plain),
        ("trailing.csv", "b,a,\n-1.5,10.5,\n2.5,-20.25,\n-3,30,\n0.125,4,\n", place(2), &plain),
        ("blanks.txt", "  -1.5   10.5\n  2.5 -20.25\n-3 30\n0.125 4\n", place(2), &plain),
        ("comma.csv", "b;a\n-1,5;10,5\n2,5;-20,25\n-3;30\n0,125;4\n", place(2), &plain),
        ("comma.txt", "-1,5 10,5\n2,5 -20,25\n-3 30\n0,125 4\n", place(2), &plain),
        // numpy.savetxt: the names are a comment.
        ("numpy.dat", "# b a\n-1.5 10.5\n2.5 -20.25\n-3 30\n0.125 4\n", place(2), &plain),
        (
            "time.csv",
            "time,b,a\n0,-1.5,10.5\n0.001,2.5,-20.25\n0.002,-3,30\n0.003,0.125,4\n",
            place(2),
            &plain,
        ),
        ("unit.csv", "clock [ms],b,a\n5,-1.5,10.5\n6,2.5,-20.25\n7,-3,30\n8,0.125,4\n", place(2), &plain),
        (
            "drive.csv",
            "drive,b,a\n9,-1.5,10.5\n9,2.5,-20.25\n9,-3,30\n9,0.125,4\n",
            vec![None, Some(1), Some(0)],
            &plain,
        ),
        ("named.csv", "a,drive,b\n10.5,9,-1.5\n-20.25,9,2.5\n30,9,-3\n4,9,0.125\n", vec![], &by_name),
        (
            "pascal.csv",
            "a [kPa],b [Pa],drive [V]\n0.0105,-1.5,9\n-0.02025,2.5,9\n0.03,-3,9\n0.004,0.125,9\n",
            vec![],
            &by_name,
        ),
        (
            "units.txt",
            "Rig 3\nSamples\t4\n\nt\ta\tb\tdrive\ns\tkPa\tPa\tV\n0,000\t0,0105\t-1,5\t9\n0,001\t-0,02025\t2,5\t9\n0,002\t0,03\t-3\t9\n0,003\t0,004\t0,125\t9\n",
            vec![],
            &by_name,
        ),
        (
            "slash.csv",
            "t/s;a/kPa;b, Pa;drive/V\n0;0.0105;-1.5;9\n0.001;-0.02025;2.5;9\n0.002;0.03;-3;9\n0.003;0.004;0.125;9\n",
            vec![],
            &by_name,
        ),
        (
            "measured.lvm",
            "LabVIEW Measurement\t\nDecimal_Separator\t,\nDate\t2026/11/18\n***End_of_Header***\t\n\t\nChannels\t3\t\t\t\n\
             Samples\t4\t4\t4\nY_Unit_Label\tkPa\tPa\tVolts\nX0\t0,0\t0,0\t0,0\n***End_of_Header***\t\t\t\n\
             X_Value\ta\tb\tdrive\tComment\n0,000\t0,0105\t-1,5\t9\n0,001\t-0,02025\t2,5\t9\n0,002\t0,03\t-3\t9\n0,003\t0,004\t0,125\t9\n",
            vec![],
            &by_name,
        ),
        // A temperature is not time.
        (
            "warm.csv",
            "T,b,a\n20,-1.5,10.5\n20,2.5,-20.25\n20,-3,30\n20,0.125,4\n",
            vec![None, Some(1), Some(0)],
            &plain,
        ),
        ("gap.csv", "b,a\n\n-1.5,10.5\n# knocked at the table\n2.5,-20.25\n-3,30\n0.125,4", place(2), &plain),
    ];
    for (name, text, channels, reading) in files {
        let record =
            read_as(name, text.as_bytes(), &channels, reading).unwrap_or_else(|e| panic!("{name}: {e}"));
        for (have, want) in record.channels.iter().flatten().zip(wave().iter().flatten()) {
            assert!((have - want).abs() < 1e-14 * want.abs(), "{name}: {have} {want}");
        }
        assert_eq!((record.len(), record.channels.len(), record.full_scale), (4, 2, f64::INFINITY), "{name}");
    }
}

#[test]
fn exact_volts_become_pascals_by_the_sensitivity_of_each_microphone() {
    let volts = Reading { sensitivities: vec![0.05, 0.01], ..Reading::default() };
    let text = "b [mV],a [V]\n-15,0.525\n25,-1.0125\n-30,1.5\n1.25,0.2\n";
    let record = read_as("mv.csv", text.as_bytes(), &SWAPPED, &volts).unwrap();
    for (have, want) in record.channels.iter().flatten().zip(wave().iter().flatten()) {
        assert!((have - want).abs() < 1e-14 * want.abs(), "{have} {want}");
    }
    // Without units in the file the manifest says what they are.
    let stated = Reading { unit: Some(Unit::parse("mV").unwrap()), ..volts.clone() };
    let bare = "-15,525\n25,-1012.5\n-30,1500\n1.25,200\n";
    let record = read_as("bare.csv", bare.as_bytes(), &SWAPPED, &stated).unwrap();
    assert!((record.channels[0][1] + 20.25).abs() < 1e-13);
    // Neither is a guess.
    let said = read_as("guess.csv", bare.as_bytes(), &SWAPPED, &volts).unwrap_err().to_string();
    assert!(said.contains("nothing says whether the numbers are volts or Pa; give `unit = \"V\"`"), "{said}");
}

#[test]
fn exact_integers_in_volts() {
    let path = path("volts.wav");
    let samples = rijke_rig::Samples24 { rate_hz: 1000, interleaved: vec![0, 0, 1 << 22, -(1 << 21), 5, 7] };
    samples.write(2, &path).unwrap();
    let arrays = Arrays::default();
    let read = |sensitivities: &[f64], full_scale: f64| {
        let reading = Reading {
            sensitivities: sensitivities.to_vec(),
            full_scale_in_volts: true,
            ..Reading::default()
        };
        read_record(
            &path,
            Layout {
                channels: &SWAPPED,
                full_scale,
                rate_hz: RATE,
                quiet: 1,
                arrays: &arrays,
                reading: &reading,
            },
        )
    };
    let record = read(&[0.05, 0.05], 10.0).unwrap();
    assert_eq!((record.channels[1][1], record.channels[0][1], record.full_scale), (100.0, -50.0, 200.0));
    // Microphones that clip at different pressures have no limit in common.
    let record = read(&[0.05, 0.1], 10.0).unwrap();
    assert_eq!((record.channels[1][1], record.full_scale), (50.0, f64::INFINITY));
    let said = read(&[], 10.0).unwrap_err().to_string();
    assert!(said.contains("the numbers are volts, and microphone 1 has no `sensitivity`"), "{said}");
    let said = read(&[0.05, 0.05], f64::INFINITY).unwrap_err().to_string();
    assert!(said.contains("the manifest states no full scale"), "{said}");
    std::fs::remove_file(path).unwrap();
}

#[test]
fn exact_a_dead_microphone_costs_its_channel_only() {
    let text = "b,a\n-1.5,10.5\n2.5,-20.25\n-3,30\n0.125,4\n";
    let dead = Reading { dead: vec![1], ..Reading::default() };
    let record = read_as("dead.csv", text.as_bytes(), &SWAPPED, &dead).unwrap();
    assert_eq!((record.channels[0].as_slice(), record.channels[1].len()), (&wave()[0][..], 0));
    assert_eq!((record.len(), record.dead()), (4, vec![1]));
    // Its column may be missing, or hold what is no number at all.
    let named = Reading { names: names(&[("a", 0), ("b", 1)]), ..dead.clone() };
    assert_eq!(
        read_as("gone.csv", b"a\n10.5\n-20.25\n30\n4\n", &[], &named).unwrap().channels,
        record.channels
    );
    let spoilt = text.replace("2.5,", "nan,").replace("\n0.125,", "\noverload,");
    assert_eq!(read_as("spoilt.csv", spoilt.as_bytes(), &SWAPPED, &dead).unwrap().channels, record.channels);
    // One that nobody declared shows itself.
    let still =
        read_as("still.csv", b"b,a\n3,10.5\n3,-20.25\n3,30\n3,4\n", &SWAPPED, &Reading::default()).unwrap();
    assert_eq!((still.dead(), still.channels[0].as_slice()), (vec![1], &wave()[0][..]));
}

/// Every row: name of the file, its text, and what is said of it; two channels are listed by place unless the
/// name says else.
#[test]
fn message_of_records_that_could_be_taken_for_something_else() {
    let by_name = Reading { names: names(&[("a", 0), ("b", 1)]), ..Reading::default() };
    let time = |column| Reading { time: Some(column), ..Reading::default() };
    let plain = Reading::default();
    let (by_second, by_word) = (time(Column::Number(9)), time(Column::Name("clock".into())));
    let table: [(&str, &str, &Reading, &[&str]); 24] = [
        (
            "surplus.csv",
            "b,a,drive\n1,2,3\n",
            &plain,
            &["header: 3 channels", "lists 2; surplus: 3 `drive`; list every channel", "-1"],
        ),
        (
            "unnamed.csv",
            "1,2,3,4\n",
            &plain,
            &["4 channels, the manifest's `channels` lists 2; surplus: 3, 4;"],
        ),
        ("decimal.csv", "1,5,2,5\n", &plain, &["4 channels", "surplus: 3, 4"]),
        ("few.csv", "1\n2\n", &plain, &["1 channels, the manifest's `channels` lists 2"]),
        ("listed.csv", "a,b,drive\n1,2,3\n", &by_name, &["surplus: 3 `drive`"]),
        ("absent.csv", "a,c\n1,2\n", &by_name, &["channels: there is no column `b`; the file has `a`, `c`"]),
        ("twice.csv", "a,b,a\n1,2,3\n", &by_name, &["`a` appears twice"]),
        ("anonymous.csv", "1,2\n", &by_name, &["the file has no names of columns", "channels = [0, 1, -1]"]),
        ("heading.csv", "b,a\n1,2,3\n", &plain, &["line 2: 3 columns, the rows before have 2"]),
        ("ragged.csv", "b,a\n1,2\n3,4,5\n", &plain, &["line 3: 3 columns, the rows before have 2"]),
        (
            "word.csv",
            "b,a\n1,2\n3,four\n",
            &plain,
            &["line 3, column 2: `four` is not a number with a decimal point"],
        ),
        (
            "first.csv",
            "1,O.5\n1,2\n",
            &plain,
            &["line 1, column 2: `O.5` is not a number; if the line belongs to the heading", "header_lines"],
        ),
        (
            "mixed.csv",
            "b;a\n1,5;2\n1.5;2\n",
            &plain,
            &["line 3, column 1: `1.5` is not a number with a decimal comma"],
        ),
        (
            "thousands.csv",
            "b;a\n1,5;2\n1.234,5;2\n",
            &plain,
            &["`1.234,5` is not a number with a decimal comma"],
        ),
        (
            "words.csv",
            "b,a\nx,y\n",
            &plain,
            &["no row of numbers in the first 2 lines, which begin with `b,a`", "header_lines"],
        ),
        (
            "unit.csv",
            "b [mm],a\n1,2\n3,4\n",
            &plain,
            &["column 1 `b [mm]`: `mm` is not a unit of this quantity, which is in Pa"],
        ),
        (
            "typo.csv",
            "b (mbr),a\n1,2\n3,4\n",
            &plain,
            &["column 1 `b (mbr)`: `mbr` in `mbr` is not a unit; known: 1, %"],
        ),
        (
            "volts.csv",
            "b [V],a [V]\n1,2\n3,4\n",
            &plain,
            &["the numbers are volts, and microphone 1 has no `sensitivity`"],
        ),
        (
            "jump.csv",
            "t,b,a\n0,1,2\n0.001,1,2\n0.003,1,2\n",
            &plain,
            &["time: the time of sample 2 is 0.002 s after the one before, 0.001 s were expected"],
        ),
        (
            "rate.csv",
            "t [ms],b,a\n0,1,2\n1.4,1,2\n2.8,1,2\n4.2,1,2\n",
            &plain,
            &["time: sampled at 714.28", "expected 1000 Hz"],
        ),
        ("two.csv", "t,time,b,a\n0,0,1,2\n", &plain, &["`t` and `time` could each be time; say which"]),
        (
            "mic.csv",
            "time,a\n0,1\n0.001,2\n",
            &plain,
            &["the column is time, and `channels` lists it as microphone 1"],
        ),
        ("ninth.csv", "1,2\n", &by_second, &["time: there is no column 9: the file has 2, counted from 1"]),
        ("clock.csv", "b,a\n1,2\n", &by_word, &["time: there is no column `clock`; the file has `b`, `a`"]),
    ];
    for (name, text, reading, says) in table {
        let channels = if reading.names.is_empty() { &SWAPPED[..] } else { &[] };
        let said =
            read_as(name, text.as_bytes(), channels, reading).map(|r| r.channels).unwrap_err().to_string();
        for part in [name].iter().chain(says) {
            assert!(said.contains(part), "{name}: no `{part}` in: {said}");
        }
    }
    // What `header_lines` passes over is not looked at.
    let skip = Reading { text: TextForm { header_lines: Some(2), decimal: None }, ..Reading::default() };
    let text = b"1,2,3\nSamples,4\nb,a\n1,2\n3,4\n";
    assert_eq!(read_as("skip.csv", text, &SWAPPED, &skip).unwrap().channels, [[2.0, 4.0], [1.0, 3.0]]);
}

#[test]
fn message_of_what_is_no_file_or_has_no_end() {
    let arrays = Arrays::default();
    let reading = Reading::default();
    let layout = Layout {
        channels: &SWAPPED,
        full_scale: 1.0,
        rate_hz: RATE,
        quiet: 1,
        arrays: &arrays,
        reading: &reading,
    };
    let mut refused = vec![(std::env::temp_dir(), "it is a folder, not a file; give a file on disk")];
    #[cfg(unix)]
    {
        refused.push((PathBuf::from("/dev/zero"), "it is a device, not a file"));
        let pipe = path("pipe.csv");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        refused.push((pipe, "it is a pipe, not a file"));
    }
    for (path, says) in &refused {
        let said = read_record(path, layout).unwrap_err().to_string();
        assert!(said.contains(says) && !said.contains("permissions"), "{said}");
        assert!(inspect(path).unwrap_err().to_string().contains(says));
    }
    if let Some((pipe, _)) = refused.get(2) {
        std::fs::remove_file(pipe).unwrap();
    }
    // A line without end in a file that takes no room on the disk.
    let long = path("long.csv");
    std::fs::File::create(&long).unwrap().set_len(1 << 40).unwrap();
    let said = read_record(&long, layout).unwrap_err().to_string();
    assert!(said.contains("line 1: is longer than 1048576 bytes"), "{said}");
    let large = path("large.mat");
    std::fs::rename(&long, &large).unwrap();
    let said = read_record(&large, layout).unwrap_err().to_string();
    assert!(said.contains("it is larger than 1024 MiB"), "{said}");
    std::fs::remove_file(large).unwrap();
}

#[test]
fn exact_message_of_a_nan_in_a_float_file() {
    let path = path("nan.wav");
    let spec = hound::WavSpec {
        channels: 2,
        sample_rate: 10_000,
        bits_per_sample: 32,
        sample_format: hound::SampleFormat::Float,
    };
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for sample in [0.5_f32, 1.0, 0.25, f32::NAN] {
        writer.write_sample(sample).unwrap();
    }
    writer.finalize().unwrap();
    let (arrays, reading) = (Arrays::default(), Reading::default());
    let read = |channels: &[Option<usize>]| {
        let layout =
            Layout { channels, full_scale: 1.0, rate_hz: 1e4, quiet: 0, arrays: &arrays, reading: &reading };
        read_record(&path, layout).unwrap_err().to_string()
    };
    let said = read(&SWAPPED);
    assert!(said.contains("microphone 0: sample 1 is NaN; remove the file"), "{said}");
    let said = read(&SWAPPED[1..]);
    assert!(
        said.contains("header: 2 channels, the manifest's `channels` lists 1; surplus: 2; list every"),
        "{said}"
    );
    std::fs::remove_file(path).unwrap();
}
