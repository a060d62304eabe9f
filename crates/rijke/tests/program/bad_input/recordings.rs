//! Folders of records.

use super::{Case, case, edit};
use crate::records;
use std::{
    fs,
    path::{Path, PathBuf},
};

const CHECK: &str = "check records";

pub(super) const CASES: [Case; 42] = [
    case(
        "channel that is not listed",
        |d| write_float(&file(d), 10_000, 9, None),
        CHECK,
        [records::PING, "9 channels, the manifest's `channels` lists 8; surplus: 9", "list every channel"],
    ),
    case(
        "missing channel",
        |d| write_float(&file(d), 10_000, 7, None),
        CHECK,
        [records::PING, "7 channels", "record all channels"],
    ),
    case(
        "truncated WAV",
        |d| {
            let path = file(d);
            let bytes = fs::read(&path).unwrap();
            fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        },
        CHECK,
        [records::PING, "truncated", "copy or record it again"],
    ),
    case(
        "empty WAV",
        |d| fs::write(file(d), b"").unwrap(),
        CHECK,
        [records::PING, "not a WAV file", "use 16, 24 or 32 bit"],
    ),
    case(
        "text instead of WAV",
        |d| fs::write(file(d), b"time,pressure\n0,1\n").unwrap(),
        CHECK,
        [records::PING, "not a WAV file", "use 16, 24 or 32 bit"],
    ),
    case(
        "wrong sampling rate",
        |d| write_float(&file(d), 44_100, 8, None),
        CHECK,
        [records::PING, "sampled at 44100 Hz, expected 10000 Hz", "correct the rate"],
    ),
    case(
        "NaN",
        |d| write_float(&file(d), 10_000, 8, Some((8 * 50 + 3, f32::NAN))),
        CHECK,
        [records::PING, "sample 50 is NaN", "export it again"],
    ),
    case(
        "infinite sample",
        |d| write_float(&file(d), 10_000, 8, Some((8 * 7, f32::INFINITY))),
        CHECK,
        [records::PING, "sample 7 is inf", "export it again"],
    ),
    case(
        "absent file",
        |d| fs::remove_file(d.join("records/C3-E/click-1.wav")).unwrap(),
        CHECK,
        ["manifest.toml", "`C3-E/click-1.wav`", "copy it there"],
    ),
    case(
        "no manifest",
        |d| fs::remove_file(d.join("records/manifest.toml")).unwrap(),
        CHECK,
        ["records", "holds no study.toml", "docs/study-folder.md"],
    ),
    case(
        "unknown key",
        |d| edit(d, "records/manifest.toml", "\nfull_scale_pa", "\nful_scale_pa"),
        CHECK,
        ["manifest.toml:", "ful_scale_pa", "full_scale_pa"],
    ),
    case(
        "broken TOML",
        |d| edit(d, "records/manifest.toml", "kind = ", "kind == "),
        CHECK,
        ["manifest.toml:8:7:", "extra `=`", "expected"],
    ),
    case(
        "microphone outside the tube",
        |d| edit(d, "records/rig.toml", "0.95]", "1.95]"),
        CHECK,
        ["rig.toml", "microphones.positions", "positions are metres"],
    ),
    case(
        "reference microphone that does not exist",
        |d| edit(d, "records/rig.toml", "reference = 5", "reference = 8"),
        CHECK,
        ["rig.toml", "microphones.reference", "counted from 0"],
    ),
    case(
        "empty campaign",
        |d| fs::write(d.join("records/campaign.csv"), "point,row,repeats\n").unwrap(),
        CHECK,
        ["campaign.csv", "is empty", "give at least one operating point"],
    ),
    case(
        "unknown operating point",
        |d| edit(d, "records/manifest.toml", "id = \"C3-E\"", "id = \"C9-E\""),
        CHECK,
        ["manifest.toml", "C9-E", "known: C3-E"],
    ),
    case(
        "day that is not declared",
        |d| edit(d, "records/manifest.toml", "day = \"one\"", "day = \"two\""),
        CHECK,
        ["manifest.toml", "`two` is not known", "known: one"],
    ),
    case(
        "8 bit WAV",
        |d| {
            write_float(&file(d), 10_000, 8, None);
            let mut bytes = fs::read(file(d)).unwrap();
            // Integers; bytes per second, per frame; bits per sample.
            bytes[20] = 1;
            bytes[28..32].copy_from_slice(&80_000u32.to_le_bytes());
            bytes[32] = 8;
            bytes[34] = 8;
            fs::write(file(d), bytes).unwrap();
        },
        CHECK,
        [records::PING, "not a WAV file that can be read", "use 16, 24 or 32 bit"],
    ),
    case(
        "word in a CSV record",
        |d| text(d, "ping.csv", "0,0,0,0,0,0,0,0\n0,0,clipped,0,0,0,0,0\n"),
        CHECK,
        ["C3-E/ping.csv", "line 2, column 3: `clipped`", "a number with a decimal point"],
    ),
    case(
        "decimal comma below a decimal point in a CSV record",
        |d| text(d, "ping.csv", "0.5;0;0;0;0;0;0;0\n0,1;0;0;0;0;0;0;0\n"),
        CHECK,
        ["C3-E/ping.csv", "line 2, column 1: `0,1`", "decimal point"],
    ),
    case(
        "short line in a CSV record",
        |d| text(d, "ping.csv", "0,0,0,0,0,0,0,0\n0,0,0\n"),
        CHECK,
        ["C3-E/ping.csv", "line 2: 3 columns", "every row needs as many"],
    ),
    case(
        "NaN in a CSV record",
        |d| text(d, "ping.csv", &("0,0,0,0,0,0,0,0\n".repeat(30) + "0,0,0,0,0,0,0,nan\n")),
        CHECK,
        ["C3-E/ping.csv", "microphone 7: sample 30 is NaN", "export it again"],
    ),
    case(
        "CSV record shorter than its quiet stretch",
        |d| text(d, "ping.csv", "0,0,0,0,0,0,0,0\n"),
        CHECK,
        ["C3-E/ping.csv", "1 samples", "correct the quiet length"],
    ),
    case(
        "array that a MATLAB file does not have",
        |d| array_file(d, "v5.mat", "arrays = { names = [\"q\"] }"),
        CHECK,
        ["C3-E/v5.mat", "no numeric array `q`; the file holds p (40 x 2)", "correct `arrays`"],
    ),
    case(
        "MATLAB file with two channels for eight microphones",
        |d| array_file(d, "v7.mat", "arrays = { names = [\"p\"] }"),
        CHECK,
        ["C3-E/v7.mat", "2 channels", "record all channels or correct the list"],
    ),
    case(
        "HDF5 file of which nothing says what is the record",
        |d| array_file(d, "packed.h5", ""),
        CHECK,
        ["C3-E/packed.h5", "the file holds left (40 x 1), right (40 x 1)", "say which of them"],
    ),
    case(
        "wrong sampling rate in a MATLAB 7.3 file",
        |d| array_file(d, "v73.mat", "arrays = { names = [\"p\"], rate = \"p\" }"),
        CHECK,
        ["C3-E/v73.mat", "p: sampled at", "correct the rate"],
    ),
    case(
        "truncated HDF5",
        |d| {
            array_file(d, "packed.h5", "arrays = { names = [\"left\", \"right\"] }");
            let path = d.join("records/C3-E/packed.h5");
            let bytes = fs::read(&path).unwrap();
            fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        },
        CHECK,
        ["C3-E/packed.h5", "not a MATLAB or HDF5 file that can be read", "save it again"],
    ),
    case(
        "truncated MATLAB file",
        |d| {
            array_file(d, "v5.mat", "");
            let path = d.join("records/C3-E/v5.mat");
            let bytes = fs::read(&path).unwrap();
            fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        },
        CHECK,
        ["C3-E/v5.mat", "it is truncated", "save it again"],
    ),
    case(
        "text that is called .mat",
        |d| {
            array_file(d, "v5.mat", "");
            fs::write(d.join("records/C3-E/v5.mat"), "0 0 0\n").unwrap();
        },
        CHECK,
        ["C3-E/v5.mat", "begins neither as MATLAB 5 nor as HDF5", "export WAV or CSV"],
    ),
    case(
        "temperature in Celsius",
        |d| edit(d, "records/manifest.toml", "ambient_temperature_k = 293", "ambient_temperature_k = 20"),
        CHECK,
        [
            "manifest.toml",
            "day[0] `one`: ambient_temperature_k: 20 K is outside 150 to 500 K",
            "give SI units",
        ],
    ),
    case(
        "no day",
        |d| edit(d, "records/manifest.toml", "[[day]]", "[[days]]"),
        CHECK,
        ["manifest.toml:", "there is no key `days`; ", "nown here: "],
    ),
    case(
        "full scale of zero",
        |d| edit(d, "records/manifest.toml", "full_scale_pa = 20.0", "full_scale_pa = 0.0"),
        CHECK,
        ["manifest.toml", "full_scale_pa: 0 Pa is outside", "give SI units"],
    ),
    case(
        "quiet stretch longer than the record",
        |d| edit(d, "records/manifest.toml", "quiet_samples = 20", "quiet_samples = 2000"),
        CHECK,
        [records::PING, "200 samples, but the quiet stretch alone is 2000", "correct the quiet length"],
    ),
    case(
        "microphone without a channel",
        |d| edit(d, "records/manifest.toml", "6, 7]", "6, -1]"),
        CHECK,
        ["manifest.toml", "channels: microphone 7 is recorded by 0 channels", "each microphone once"],
    ),
    case(
        "channel of a microphone that does not exist",
        |d| edit(d, "records/manifest.toml", "6, 7]", "6, 8]"),
        CHECK,
        ["manifest.toml", "channels: 8 does not exist", "counted from 0"],
    ),
    case(
        "operating point listed twice",
        |d| edit(d, "records/manifest.toml", "id = \"C3-05\"", "id = \"C3-E\""),
        CHECK,
        ["manifest.toml", "`C3-E` appears twice", "every name must be different"],
    ),
    case(
        "no rig",
        |d| fs::remove_file(d.join("records/rig.toml")).unwrap(),
        CHECK,
        ["rig.toml", "cannot be read", "check the name"],
    ),
    case(
        "microphones out of order",
        |d| edit(d, "records/rig.toml", "0.25, 0.35", "0.35, 0.25"),
        CHECK,
        ["rig.toml", "microphones.positions[1]: 0.25 m follows 0.35 m", "from the bottom of the tube upward"],
    ),
    case(
        "plates wider than the tube",
        |d| edit(d, "records/tube.toml", "outer_diameter = 0.047", "outer_diameter = 0.47"),
        CHECK,
        ["tube.toml", "plates.outer_diameter: 0.47 m does not fit", "check both diameters"],
    ),
    case(
        "pressure in bar",
        |d| edit(d, "records/rig.toml", "pressure = 101325.0", "pressure = 1.01325"),
        CHECK,
        ["rig.toml", "pressure: 1.01325 Pa is outside", "give SI units"],
    ),
    case(
        "column of the campaign that is no factor",
        |d| edit(d, "records/campaign.csv", "X_h [m]", "position_m"),
        CHECK,
        [
            "campaign.csv: line 1, column `position_m`",
            "is no column of this table",
            "has its unit in the heading",
        ],
    ),
];

fn file(folder: &Path) -> PathBuf {
    folder.join("records").join(records::PING)
}

/// Puts a record in text in the place of the first ping.
fn text(folder: &Path, name: &str, content: &str) {
    edit(folder, "records/manifest.toml", records::PING, &format!("C3-E/{name}"));
    fs::write(folder.join("records/C3-E").join(name), content).unwrap();
}

/// Puts a fixture in the place of the first ping, and a line into the manifest.
fn array_file(folder: &Path, name: &str, line: &str) {
    edit(folder, "records/manifest.toml", records::PING, &format!("C3-E/{name}"));
    edit(folder, "records/manifest.toml", "\nfull_scale_pa", &format!("\n{line}\nfull_scale_pa"));
    let fixtures = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/records");
    fs::copy(fixtures.join(name), folder.join("records/C3-E").join(name)).unwrap();
}

/// Writes 32-bit float samples with one value changed.
fn write_float(path: &Path, rate_hz: u32, channels: u16, change: Option<(usize, f32)>) {
    let mut bytes = Vec::new();
    let samples = 200 * usize::from(channels);
    let data = u32::try_from(4 * samples).unwrap();
    bytes.extend(b"RIFF");
    bytes.extend((36 + data).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16u32.to_le_bytes());
    bytes.extend(3u16.to_le_bytes()); // IEEE float
    bytes.extend(channels.to_le_bytes());
    bytes.extend(rate_hz.to_le_bytes());
    bytes.extend((rate_hz * 4 * u32::from(channels)).to_le_bytes());
    bytes.extend((4 * channels).to_le_bytes());
    bytes.extend(32u16.to_le_bytes());
    bytes.extend(b"data");
    bytes.extend(data.to_le_bytes());
    for k in 0..samples {
        let value = change.filter(|(at, _)| *at == k).map_or((k % 97) as f32 * 0.01, |(_, value)| value);
        bytes.extend(value.to_le_bytes());
    }
    fs::write(path, bytes).unwrap();
}
