//! What a manifest may say of files and channels, and what is said of a bad one.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_rig::{RecordFolder, RecordSource};
use std::path::PathBuf;

/// A folder that is removed when the test ends.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const RIG: &str = include_str!("../../data/rig.toml");
const CAMPAIGN: &str = include_str!("../../data/campaign.csv");

/// Three microphones, the middle one of which is the reference; two days; one ping each.
const MANIFEST: &str = "rig = 'rig.toml'\ncampaign = 'campaign.csv'\nkind = 'measured'\nsource = 'a test'\n\
    ping = { rate_hz = 1000, quiet_samples = 1 }\n\
    [channels]\nlow = 0\nmiddle = 1\nhigh = 2\ndrive = -1\n\
    [microphones]\nsensitivity = ['50 mV/Pa', '40 mV/Pa', '20 mV/Pa']\nsensitivity_sd = '1 %'\ngain_sd = 0.0\ndelay_sd = '5 us'\n\
    [[day]]\nid = 'mon'\nambient_temperature_k = 293.15\nambient_temperature_sd_k = 0.1\n\
    [[day]]\nid = 'tue'\nambient_temperature_k = 294.15\nambient_temperature_sd_k = 0.1\n\
    [[exception]]\ndays = ['tue']\ndead = [2]\nchannels = [2, 0, 1]\nunit = 'V'\nrate_hz = 4000\nquiet_samples = 1\n\
    [[point]]\nid = 'C3-E'\nday = 'mon'\npings = ['mon.csv']\n\
    [[point]]\nid = 'C3-05'\nday = 'tue'\npings = ['tue.csv']\n";
const MON: &str =
    "t [ms];low [mV];middle [mV];high [mV];drive [V]\n0;50;40;20;1\n1;100;80;40,5;1\n2;50;40;20;1\n";
const TUE: &str = "9,0.05,0.04\n9,0.10,0.08\n9,0.05,0.04\n";

fn study(name: &str) -> Scratch {
    let folder = std::env::temp_dir().join(format!("rijke-manifest-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (head, rest) = RIG.split_once("positions = [").unwrap();
    let rest = rest.split_once(']').unwrap().1.replacen("reference = 5", "reference = 1", 1);
    std::fs::write(folder.join("rig.toml"), format!("{head}positions = [0.25, 0.5, 0.75]{rest}")).unwrap();
    for (file, text) in
        [("campaign.csv", CAMPAIGN), ("manifest.toml", &manifest("")), ("mon.csv", MON), ("tue.csv", TUE)]
    {
        std::fs::write(folder.join(file), text).unwrap();
    }
    Scratch(folder)
}

/// The manifest with something before its tables; errors of gains come from the sensitivities alone.
fn manifest(more: &str) -> String {
    format!("{more}{}", MANIFEST.replace("gain_sd = 0.0\n", ""))
}

#[test]
fn exact_names_days_and_volts() {
    let scratch = study("good");
    let folder = RecordFolder::open(&scratch.0).unwrap();
    let (mon, tue) = (folder.ping(0, 0).unwrap(), folder.ping(1, 0).unwrap());
    let close =
        |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    assert!(
        mon.channels[..2].iter().all(|c| close(c, &[1.0, 2.0, 1.0]))
            && close(&mon.channels[2], &[1.0, 2.025, 1.0])
    );
    // On the other day one microphone was dead, and columns had no names and another order.
    assert!(tue.channels[..2].iter().all(|c| close(c, &[1.0, 2.0, 1.0])) && tue.channels[2].is_empty());
    assert_eq!((mon.dead(), tue.dead()), (vec![], vec![2]));
    // It was another rate, too.
    assert_eq!([(mon.rate_hz, mon.quiet), (tue.rate_hz, tue.quiet)], [(1e3, 1), (4e3, 1)]);
    let stated = folder.set().acquisition.stated.clone().unwrap();
    assert_eq!((stated.gains, stated.gain_sds), (vec![1.0; 3], vec![0.01; 3]));
    assert_eq!((stated.delays, stated.delay_sds), (vec![0.0; 3], vec![5e-6; 3]));
    // What is written again is read again.
    let copy = scratch.0.join("copy");
    folder.set().write(&copy).unwrap();
    for file in ["mon.csv", "tue.csv"] {
        std::fs::copy(scratch.0.join(file), copy.join(file)).unwrap();
    }
    assert_eq!(RecordFolder::open(&copy).unwrap().set().acquisition, folder.set().acquisition);
}

#[test]
fn exact_a_microphone_that_is_always_dead_leaves_the_rig() {
    let scratch = study("dead");
    std::fs::write(scratch.0.join("manifest.toml"), manifest("dead = [0]\n")).unwrap();
    let folder = RecordFolder::open(&scratch.0).unwrap();
    let rig = &folder.set().rig.microphones;
    assert_eq!((rig.positions.as_slice(), rig.reference), (&[0.5, 0.75][..], 0));
    let (mon, tue) = (folder.ping(0, 0).unwrap(), folder.ping(1, 0).unwrap());
    assert_eq!((mon.channels.len(), mon.dead(), tue.dead()), (2, vec![], vec![1]));
    assert!((mon.channels[1][1] - 2.025).abs() < 1e-12 && (tue.channels[0][1] - 2.0).abs() < 1e-12);
    assert_eq!(folder.set().acquisition.stated.as_ref().unwrap().gains.len(), 2);
}

#[test]
fn exact_microphones_from_a_table() {
    let scratch = study("table");
    let write = |name: &str, text: &str| std::fs::write(scratch.0.join(name), text).unwrap();
    let (before, rest) = MANIFEST.split_once("[microphones]").unwrap();
    let with = |keys: &str| {
        format!("{before}[microphones]\n{keys}\n[[day]]{}", rest.split_once("[[day]]").unwrap().1)
    };
    write("manifest.toml", &with("table = 'mics.csv'\ndelay_sd = '5 us'"));
    let table = "microphone;sensitivity [mV/Pa];sensitivity_sd [mV/Pa];gain;gain_sd [%];delay [us]\n\
                 2;20;0,2;1;0;3\n0;50;0,5;1,02;0;1\n1;40;1,2;1;4;2\n";
    write("mics.csv", &table.replace(";0;", ";1e-4;"));
    let folder = RecordFolder::open(&scratch.0).unwrap();
    let stated = folder.set().acquisition.stated.clone().unwrap();
    assert_eq!(folder.set().acquisition.reading.sensitivities, [0.05, 0.04, 0.02]);
    assert_eq!((stated.gains, stated.delay_sds), (vec![1.02, 1.0, 1.0], vec![5e-6; 3]));
    // 3 % of the sensitivity and 4 % of the gain.
    assert!((stated.gain_sds[1] - 0.05).abs() < 1e-12 && (stated.gain_sds[0] - 0.01).abs() < 1e-9);
    assert!((stated.delays[2] - 3e-6).abs() < 1e-18);
    for (keys, table, says) in [
        (
            "table = 'mics.csv'\ndelay_sd = 1e-6",
            table.replace("\n0;", "\n3;"),
            "line 3, column `microphone`: `3` is not known; known: 0, 1, 2",
        ),
        (
            "table = 'mics.csv'\ndelay_sd = 1e-6",
            table.replace("\n0;", "\n1;"),
            "line 4, column `microphone`: `1` appears twice",
        ),
        (
            "table = 'mics.csv'\ndelay_sd = 1e-6",
            table.replace("2;20;0,2;1;0;3\n", ""),
            "lists 2 values for 3 microphones",
        ),
        (
            "table = 'mics.csv'\ngain = 1.0\ndelay_sd = 1e-6",
            table.to_owned(),
            "microphones.gain: stands in the manifest and in the table",
        ),
        (
            "table = 'mics.csv'",
            table.to_owned(),
            "microphones.delay_sd: gains and delays without errors say nothing; give `delay_sd`",
        ),
        ("table = 'nowhere.csv'", table.to_owned(), "nowhere.csv: cannot be read"),
        (
            "table = 'mics.csv'\ndelay_sd = 1e-6",
            table.replace("mV/Pa", "mm"),
            "mics.csv: line 3, column `sensitivity`: `mm` is not a unit of this quantity",
        ),
        (
            "table = 'mics.csv'\ndelay_sd = 1e-6",
            table.replace(";4;2\n", ";4;2e7\n"),
            "mics.csv: line 4, column `delay`",
        ),
        (
            "table = 'mics.csv'\ndelay_sd = 1e-6",
            table.replace("1;40;", "1;4e9;"),
            "mics.csv: line 4, column `sensitivity`",
        ),
        ("table = 'mics.csv'\ndelay_sd = 20", table.to_owned(), "manifest.toml: microphones.delay_sd"),
    ] {
        write("manifest.toml", &with(keys));
        write("mics.csv", &table);
        let said = RecordFolder::open(&scratch.0).map(|_| ()).unwrap_err().to_string();
        assert!(said.contains(says), "no `{says}` in: {said}");
    }
}

#[test]
fn message_of_bad_keys() {
    let scratch = study("bad");
    let refused = |old: &str, new: &str, says: &str| {
        let good = manifest("");
        assert!(good.contains(old), "{old}");
        std::fs::write(scratch.0.join("manifest.toml"), good.replacen(old, new, 1)).unwrap();
        let opened = RecordFolder::open(&scratch.0);
        let said =
            opened.and_then(|f| Ok((f.ping(0, 0)?, f.ping(1, 0)?))).map(|_| ()).unwrap_err().to_string();
        assert!(
            said.contains(says) && said.contains(&*scratch.0.to_string_lossy()),
            "no `{says}` in: {said}"
        );
    };
    refused("low = 0", "low = 7", "channels: 7 does not exist: there are 3, counted from 0");
    refused("low = 0", "low = 1", "channels: microphone 0 is recorded by 0 channels");
    refused("low = 0", "low = -2", "-2 is no microphone: count from 0, and write -1");
    refused("low = 0", "low = 'one'", "manifest.toml:");
    refused("low = 0", "bass = 0", "channels: there is no column `bass`; the file has `t [ms]`, `low [mV]`");
    refused("drive = -1\n", "", "surplus: 5 `drive [V]`");
    refused(
        "kind =",
        "dead = [1]\nkind =",
        "dead: microphone 1 is the rig's reference and is dead; choose another",
    );
    refused("kind =", "dead = [5]\nkind =", "dead: 5 does not exist: there are 3");
    let late = "[[exception]]\nfiles = ['late.csv']\nrate_hz = 2000\n[[point]]\nid = 'C3-E'\nday = 'mon'\n";
    refused(
        "[[point]]\nid = 'C3-E'\nday = 'mon'\npings = ['mon.csv']",
        &format!("{late}pings = ['mon.csv', 'late.csv']"),
        "point `C3-E`: pings[1] `late.csv`: has another sampling rate",
    );
    let clicks = "[[calibration]]\nday = 'mon'\nrate_hz = 1000\nquiet_samples = 1\nclicks = ['late.csv']\n";
    refused(
        "[[point]]\nid = 'C3-E'\nday = 'mon'\n",
        &format!("{clicks}{late}"),
        "exception[1].files `late.csv`: is a click",
    );
    refused("rate_hz = 4000", "rate_hz = 0", "exception[0].rate_hz");
    refused(
        "rate_hz = 1000, q",
        "rate_hz = 500, q",
        "give the rate of these in an [[exception]]: files = [...], rate_hz",
    );
    refused("dead = [2]", "dead = [3]", "exception[0].dead: 3 does not exist");
    refused("dead = [2]", "dead = [1]", "exception[0].dead: microphone 1 is the rig's reference");
    refused("days = ['tue']", "days = ['wed']", "exception[0].days: `wed` is not known; known: mon, tue");
    refused("days = ['tue']\n", "", "exception[0]: is empty; give at least one of `days` and `files`");
    refused(
        "channels = [2, 0, 1]",
        "channels = [2, 0, 0]",
        "exception[0].channels: microphone 0 is recorded by 2 channels",
    );
    refused(
        "unit = 'V'",
        "unit = 'Voltage'",
        "exception[0].unit: `Voltage` in `Voltage` is not a unit; known: 1, %",
    );
    refused("unit = 'V'", "unit = 'mm'", "`mm` is not a unit of this quantity, which is in Pa");
    refused("unit = 'V'", "", "nothing says whether the numbers are volts or Pa");
    refused("'40 mV/Pa', ", "", "microphones.sensitivity: lists 2 values for 3 microphones");
    refused(
        "'40 mV/Pa'",
        "'40 mV'",
        "microphones.sensitivity: `mV` is not a unit of this quantity, which is in V/Pa",
    );
    refused("'40 mV/Pa'", "'40,5 mV/Pa'", "`40,5 mV/Pa` is not a number with a unit");
    refused(
        "'40 mV/Pa'",
        "'-40 mV/Pa'",
        "microphones.sensitivity: -0.04 V/Pa is outside 0.000000001 to 1000 V/Pa",
    );
    refused(
        "delay_sd = '5 us'",
        "delay = '5 us'",
        "microphones.delay_sd: gains and delays without errors say nothing",
    );
    refused("delay_sd = '5 us'", "delay_sd = '0 us'", "microphones.delay_sd: 0 s is outside");
    refused("ping = {", "click = {", "ping: is missing; say how the listed records were taken");
    refused(
        "kind =",
        "full_scale = 10\nkind =",
        "full_scale: is a number without a unit; write it as in \"10 V\"",
    );
    refused(
        "kind =",
        "full_scale = '10 V'\nfull_scale_pa = 1\nkind =",
        "full_scale: stands beside `full_scale_pa`",
    );
    refused(
        "kind =",
        "full_scale = '10 m'\nkind =",
        "full_scale: `m` is not a unit of this quantity, which is in Pa",
    );
    refused("kind =", "text = { decimal = ';' }\nkind =", "`;` is not known; known here: ., ,");
    refused("kind =", "time = 'clock'\nkind =", "time: there is no column `clock`");
}
