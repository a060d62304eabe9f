//! Seeds of what the program makes itself: states of the gas, results, searches; and the numbers of `rijke
//! infer`.

use super::bench::{Bench, edit, own, write};
use crate::workspace::Outcome;
use std::fs;

pub(super) fn states(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.template("base-states", "kundt-tube", "kundt-tube")?;
    edit(&folder.join("study.toml"), &[("base = \"ambient\"", "base = \"states\"")])?;
    let state = |point: &str| {
        format!(
            "\"{point}\": {{\"mass_flow\": 1e-4, \"numbers\": {{\"U_h\": [0.3, 0.02]}}, \"places\": [0.0, 0.7],\n \"temperature\": [293.0, 300.0],\n \
             \"kinks\": [[0.3, 0.31]],\n \"errors\": [{{\"cause\": \"room\", \"mass_flow\": 0.0, \"numbers\": {{}}, \"temperature\": [0.2, 0.2]}}]}}"
        )
        .replace("{\"U_h\": [0.3, 0.02]}", "{}")
    };
    let all = ["p70", "p80", "p90", "p100", "s70", "s80", "s90", "s100"].map(state).join(",\n");
    write(&folder.join("base/states.json"), format!("{{\"points\": {{\n{all}\n}}}}\n"))?;
    bench.add("base-states", folder, &["check .", "rank . --one-start", "modes . --point p70"], &["base"]);
    Ok(())
}

pub(super) fn infer(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("infer", "ducted-flame")?;
    for file in ["n-tau.toml", "modes.csv"] {
        own(&format!("examples/ducted-flame/{file}"), &folder.join(file))?;
    }
    // Every third row.
    let path = folder.join("modes.csv");
    let text = fs::read_to_string(&path).map_err(|e| e.to_string())?;
    let kept = text
        .lines()
        .enumerate()
        .filter(|(k, _)| *k < 2 || k % 3 == 2)
        .map(|(_, l)| l)
        .collect::<Vec<_>>()
        .join("\n");
    write(&path, kept + "\n")?;
    let command = "infer n-tau.toml --data modes.csv --one-start";
    bench.add("infer", folder, &[command, &format!("{command} --study out --fitted fitted.toml")], &[]);
    Ok(())
}

pub(super) fn results(bench: &mut Bench<'_>) -> Outcome {
    for template in ["kundt-tube", "burner"] {
        let folder = bench.template("results", template, template)?;
        bench.run(&folder, "rank . --one-start")?;
        let kundt = [
            "predict .",
            "next .",
            "next . --microphones",
            "next . --models",
            "report .",
            "modes . --point p70",
            "predict . --map length,sample",
        ];
        let commands: &[&str] =
            if template == "burner" { &["predict .", "report .", "modes . --point c350"] } else { &kundt };
        bench.add("results", folder, commands, &["results/models", "results/numbers"]);
    }
    Ok(())
}

pub(super) fn search(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.template("search", "kundt-tube", "shards")?;
    for part in ["1/2", "2/2"] {
        bench.run(&folder, &format!("search . --one-start --shard {part}"))?;
    }
    let merge = "merge search/parts/1-of-2.json search/parts/2-of-2.json";
    bench.add("search", folder, &[merge, merge, "search . --one-start"], &["search"]);
    Ok(())
}
