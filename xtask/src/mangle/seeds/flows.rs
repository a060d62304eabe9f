//! Seeds of the laboratory and of the flow.

use super::bench::{Bench, from, own, write};
use crate::workspace::Outcome;
use std::fs;

pub(super) fn lab(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("lab", "empty-tube")?;
    write(&folder.join("campaign.toml"), include_str!("tube/lab.toml"))?;
    own("crates/flow/data/rigs/juniper-yoko-2022.toml", &folder.join("tube.toml"))?;
    own("crates/lab/data/truth.toml", &folder.join("truth.toml"))?;
    let command = "lab --out out --rig tube.toml --campaign campaign.toml --truth truth.toml";
    bench.add("lab", folder, &[command, &format!("{command} --sweep 100 700")], &[]);
    let folder = bench.folder("lab", "ramp")?;
    write(&folder.join("campaign.toml"), include_str!("tube/hot.toml"))?;
    write(&folder.join("ramps.csv"), include_str!("tube/ramps.csv"))?;
    bench.add("lab", folder, &["lab --out out --campaign campaign.toml --row R7"], &[]);
    Ok(())
}

/// Observations for the flow: clicks, a ramp, readings, profiles, and samples over time.
pub(super) fn flow(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("flow", "settled")?;
    write(&folder.join("campaign.toml"), include_str!("tube/hot.toml"))?;
    write(&folder.join("ramps.csv"), include_str!("tube/ramps.csv"))?;
    bench.run(&folder, "process --virtual-rig --campaign campaign.toml --out observations")?;
    for file in ["campaign.toml", "ramps.csv"] {
        fs::remove_file(folder.join(file)).map_err(|e| e.to_string())?;
    }
    // What the laboratory writes beside what the flow reads.
    for file in
        ["ping-repeats.csv", "click-repeats.csv", "corrections.csv", "rejections.csv", "channels.toml"]
    {
        fs::remove_file(folder.join("observations").join(file)).map_err(|e| format!("{file}: {e}"))?;
    }
    let flow = "flow . --out out";
    for (name, file, text) in [
        (
            "readings",
            "readings.csv",
            "point,at [m],temperature [K],sd [K]\nH30-25,0.30,331.0,2.0\nH30-25,0.60,310.5,0.8\n",
        ),
        (
            "profiles",
            "profiles.csv",
            "point,at [m],temperature [K],sd [K]\nH30-25,0.1,294.1,0.5\nH30-25,0.3,351.0,1.0\nH30-25,0.9,338.0,1.0\n",
        ),
        ("closures", "closures.toml", "entrance_loss = 0.6\nemissivity = 0.8\nheater_lag = 30.0\n"),
    ] {
        let other = bench.folder("flow", name)?;
        from(&folder, &other)?;
        let at = if name == "closures" { other.join(file) } else { other.join("observations").join(file) };
        write(&at, text)?;
        if name == "profiles" {
            let text = "point,velocity [m/s],sd [m/s]\nH30-25,0.31,0.02\n";
            write(&other.join("observations/velocities.csv"), text)?;
        }
        match name {
            "closures" => bench.add("flow", other, &["flow . --out out --closures closures.toml"], &[file]),
            _ => bench.add("flow", other, &[flow], &["observations"]),
        }
    }
    bench.add(
        "flow",
        folder,
        &[flow, "flow . --out out --separate", "flow . --out out --plot"],
        &["observations"],
    );
    let folder = bench.folder("flow", "over-time")?;
    bench.run(&folder, "flow --twin --places 0.25 --out clicks")?;
    let path = folder.join("clicks/heater-250mm.csv");
    let text = fs::read_to_string(&path).map_err(|e| e.to_string())?;
    write(&path, text.lines().take(101).collect::<Vec<_>>().join("\n") + "\n")?;
    bench.add(
        "flow",
        folder,
        &["flow clicks --out out", "flow clicks --out out", "flow clicks --method paper --out out"],
        &[],
    );
    Ok(())
}
