//! Seeds with records: pings in four formats, noise, sweeps, blows.

use super::{
    bench::{Bench, edit, own, write},
    samples::{self, Samples},
};
use crate::mangle::stream::Stream;
use crate::workspace::Outcome;
use std::{fs, path::Path};

const PROCESS: [&str; 4] =
    ["process . --out out", "process . --out out", "process . --out out --plot", "check ."];

/// A Kundt tube with two pings of one point, which `save` writes with this ending.
fn pings(
    bench: &mut Bench<'_>,
    kind: &'static str,
    name: &str,
    ending: &str,
    lines: &str,
    save: impl Fn(&Samples) -> Result<Vec<u8>, String>,
) -> Outcome {
    let folder = bench.template(kind, "kundt-tube", name)?;
    fs::remove_dir_all(folder.join("observations")).map_err(|e| e.to_string())?;
    let mut stream = Stream::new(1, name);
    for k in 0..2 {
        write(&folder.join(format!("records/p70-{k}.{ending}")), save(&samples::ping(242.0, &mut stream))?)?;
    }
    let manifest = format!(
        "kind = \"virtual\"\nsource = \"cargo xtask mangle\"\n{lines}channels = [0, 1, 2]\nband_hz = [150, 350]\n\
         ping = {{ rate_hz = 10000.0, quiet_samples = 1000 }}\n\n[microphones]\ngain_sd = \"2 %\"\ndelay_sd = \"5 us\"\n\n\
         [[day]]\nid = \"1\"\nambient_temperature_k = 293.15\nambient_temperature_sd_k = 0.2\n\n\
         [[point]]\nid = \"p70\"\nday = \"1\"\npings = [\"p70-0.{ending}\", \"p70-1.{ending}\"]\n"
    );
    write(&folder.join("records/manifest.toml"), manifest)?;
    let inspect = format!("inspect records/p70-0.{ending}");
    let commands = [&PROCESS[..], &[&inspect]].concat();
    bench.add(kind, folder, &commands, &["records"]);
    Ok(())
}

/// One record of forty samples in the formats of the fixtures, for `inspect`.
fn fixtures(bench: &mut Bench<'_>, kind: &'static str, names: &[&str]) -> Outcome {
    for name in names {
        let folder = bench.folder(kind, &format!("fixture-{name}"))?;
        own(&format!("fixtures/records/{name}"), &folder.join(name))?;
        bench.add(kind, folder, &[&format!("inspect {name}")], &[]);
    }
    Ok(())
}

pub(super) fn wav(bench: &mut Bench<'_>) -> Outcome {
    pings(bench, "records-wav", "floats", "wav", "", |s| Ok(samples::wav(s, 10_000, None)))?;
    let scale = "full_scale_pa = 5.0\n";
    pings(bench, "records-wav", "integers", "wav", scale, |s| Ok(samples::wav(s, 10_000, Some(5.0))))?;
    let folder = bench.folder("records-wav", "laboratory")?;
    write(&folder.join("lab.toml"), include_str!("tube/lab.toml"))?;
    bench.run(&folder, "lab --out records --campaign lab.toml")?;
    bench.add("records-wav", folder, &["process records --out out", "check records"], &["records"]);
    fixtures(bench, "records-wav", &["wave.wav"])
}

pub(super) fn text(bench: &mut Bench<'_>) -> Outcome {
    pings(bench, "records-text", "commas", "csv", "", |s| {
        Ok(samples::csv("p1 [Pa],p2 [Pa],p3 [Pa]\n", s).into_bytes())
    })?;
    let lines = "unit = \"mV\"\ntext = { header_lines = 1, decimal = \",\" }\n";
    let text = |s: &Samples| samples::csv("a,b,c\n", s).replace(',', ";").replace('.', ",").into_bytes();
    pings(bench, "records-text", "volts", "txt", lines, |s| Ok(text(s)))?;
    if let Some(seed) = bench.seeds.last() {
        let manifest = seed.folder.join("records/manifest.toml");
        edit(
            &manifest,
            &[("gain_sd = ", "sensitivity = [\"50 mV/Pa\", \"51 mV/Pa\", \"49 mV/Pa\"]\ngain_sd = ")],
        )?;
    }
    fixtures(bench, "records-text", &["text.csv"])
}

pub(super) fn mat(bench: &mut Bench<'_>) -> Outcome {
    pings(bench, "records-mat", "doubles", "mat", "arrays = { names = [\"p\"] }\n", |s| Ok(samples::mat(s)))?;
    fixtures(bench, "records-mat", &["v5.mat", "v7.mat", "struct.mat", "int16.mat"])
}

pub(super) fn hdf5(bench: &mut Bench<'_>) -> Outcome {
    pings(bench, "records-hdf5", "doubles", "h5", "arrays = { names = [\"p\"] }\n", |s| samples::hdf5(s, 0))?;
    pings(bench, "records-hdf5", "matlab", "mat", "arrays = { names = [\"p\"] }\n", |s| {
        samples::hdf5(s, 512)
    })?;
    fixtures(bench, "records-hdf5", &["v73.mat", "plain.h5", "packed.h5"])
}

/// The empty tube of the laboratory as a study that trains on pressures, without records.
fn tube(folder: &Path) -> Outcome {
    for (file, text) in [
        ("lab.toml", include_str!("tube/lab.toml")),
        ("rig.toml", include_str!("tube/rig.toml")),
        ("campaign.csv", "point,row\nC3-E,empty\n"),
        ("candidates/tube.toml", include_str!("tube/candidates.toml")),
        ("study.toml", include_str!("tube/study.toml")),
    ] {
        write(&folder.join(file), text)?;
    }
    Ok(())
}

pub(super) fn sweep(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("sweep", "laboratory")?;
    tube(&folder)?;
    bench.run(&folder, "lab --out records --campaign lab.toml --sweep 100 700")?;
    bench.add("sweep", folder, &PROCESS[..2], &["records"]);
    Ok(())
}

/// What `rijke process` makes of sweeps, as responses.
pub(super) fn pressures(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("responses", "pressures")?;
    tube(&folder)?;
    bench.run(&folder, "lab --out records --campaign lab.toml --sweep 100 700")?;
    bench.run(&folder, "process .")?;
    fs::remove_dir_all(folder.join("records")).map_err(|e| e.to_string())?;
    bench.add("responses", folder, &["check .", "rank . --one-start"], &["observations"]);
    Ok(())
}

pub(super) fn random(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("random", "noise")?;
    tube(&folder)?;
    let at = "at = [0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95]";
    edit(&folder.join("rig.toml"), &[(at, "at = [0.25, 0.37, 0.61, 0.82]")])?;
    let mut stream = Stream::new(1, "noise");
    for (name, places) in [
        ("straight", [0.25, 0.37, 0.61, 0.82]),
        ("switched-1", [0.37, 0.25, 0.61, 0.82]),
        ("switched-2", [0.61, 0.37, 0.25, 0.82]),
        ("switched-3", [0.82, 0.37, 0.61, 0.25]),
    ] {
        let text = samples::csv("a,b,c,d\n", &samples::noise(&places, &mut stream));
        write(&folder.join(format!("records/{name}.csv")), text)?;
    }
    let switched = [1, 2, 3]
        .map(|k| format!("[[random.switched]]\nfile = \"switched-{k}.csv\"\nchannel = {k}\n"))
        .concat();
    let manifest = format!(
        "kind = \"virtual\"\nsource = \"cargo xtask mangle\"\nrate_hz = 4096\nband_hz = [200, 900]\n[random]\nsegment = 512\npolynomials = 2\n\
         straight = \"straight.csv\"\n{switched}[random.points]\nC3-E = \"straight.csv\"\n[random.transmission]\npoints = [\"C3-E\"]\n\
         between = [0.4, 0.5]\nplace_sd = 0.002\nsound_speed_sd = 0.005\n"
    );
    write(&folder.join("records/manifest.toml"), manifest)?;
    bench.add("random", folder, &PROCESS[..2], &["records"]);
    Ok(())
}

pub(super) fn blow(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("blow", "pipe")?;
    own("examples/struck-pipe", &folder)?;
    let mut stream = Stream::new(1, "blow");
    for k in [1, 2] {
        write(
            &folder.join(format!("records/hit-{k}.csv")),
            samples::csv("p\n", &samples::blow(&mut stream)),
        )?;
    }
    let manifest = folder.join("records/manifest.toml");
    let text = fs::read_to_string(&manifest).map_err(|e| e.to_string())?;
    let parts =
        text.split_once("[measured]").and_then(|(head, rest)| Some((head, rest.split_once("\n[")?.1)));
    let (head, tail) = parts.ok_or("examples/struck-pipe/records/manifest.toml: no [measured]")?;
    write(
        &manifest,
        format!("{head}\n[{tail}")
            .replace(".wav", ".csv")
            .replace("48000", "8000")
            .replace("\"measured\"", "\"virtual\""),
    )?;
    bench.add("blow", folder, &PROCESS, &["records"]);
    Ok(())
}
