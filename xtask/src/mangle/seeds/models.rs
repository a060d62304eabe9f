//! Seeds without records: networks, studies, observations, responses.

use super::{
    bench::{Bench, edit, own, write},
    samples,
};
use crate::workspace::{Outcome, at, entries, root};
use std::{fmt::Write as _, fs};

const CHECK: [&str; 2] = ["check .", "rank . --one-start"];

pub(super) fn networks(bench: &mut Bench<'_>) -> Outcome {
    let commands = [
        "modes network.toml",
        "response network.toml --csv --step-hz 50",
        "modes network.toml --sensitivity --format json",
        "modes network.toml --plot modes.svg --along along.csv",
        "response network.toml --step-hz 50 --plot response.pdf",
    ];
    let folder = root().join("fixtures/networks");
    for file in entries(&folder)? {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let folder = bench.folder("network", &name)?;
        fs::copy(&file, folder.join("network.toml")).map_err(at(&file))?;
        bench.add("network", folder, &commands, &[]);
    }
    let folder = bench.folder("network", "everything")?;
    write(&folder.join("network.toml"), include_str!("everything.toml"))?;
    bench.add("network", folder, &commands, &[]);
    Ok(())
}

pub(super) fn oscilos(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("oscilos", "combustor")?;
    own("examples/helmholtz-combustor/oscilos", &folder)?;
    bench.add("oscilos", folder, &["modes --oscilos .", "modes --oscilos . --format json"], &[]);
    let folder = bench.folder("oscilos", "study")?;
    own("examples/helmholtz-combustor", &folder)?;
    bench.add("oscilos", folder, &["check ."], &["oscilos", "rig.toml"]);
    Ok(())
}

/// The swirl flame with a measured transfer function of its own: with headings, and without.
pub(super) fn flame_tables(bench: &mut Bench<'_>) -> Outcome {
    let columns =
        "columns = { \"f [Hz]\" = \"freq_exp\", \"abs [1]\" = \"gain_exp\", \"arg [rad]\" = \"phase_exp\" }";
    for (name, head, told) in [
        ("headings", "freq_exp,gain_exp,phase_exp\n", columns),
        ("plain", "", "columns = [\"f [Hz]\", \"abs [1]\", \"arg [rad]\"]"),
    ] {
        let folder = bench.folder("flame-table", name)?;
        own("examples/swirl-flame", &folder)?;
        let path = folder.join("observations/observations.toml");
        let text = fs::read_to_string(&path).map_err(|e| e.to_string())?;
        let parts =
            text.split_once("[measured]").and_then(|(a, b)| Some((a, b.split_once("[[response]]")?.1)));
        let (before, after) =
            parts.ok_or("examples/swirl-flame/observations/observations.toml: no [measured]")?;
        let text = format!("{before}[[response]]{after}").replace("\"measured\"", "\"virtual\"");
        write(&path, text.replace("ftf.mat", "ftf.csv").replace(columns, told))?;
        let mut table = String::from(head);
        for k in 1..=30 {
            let f = 15.0 * f64::from(k);
            let (gain, phase) = (1.0 / (f / 150.0).hypot(1.0), -(f / 150.0).atan() - 0.03 * f);
            let _ = writeln!(
                table,
                "{f},{:.4},{:.4}",
                gain + 0.01 * (3.0 * f).sin(),
                phase + 0.01 * (5.0 * f).cos()
            );
        }
        write(&folder.join("observations/ftf.csv"), table)?;
        edit(
            &folder.join("study.toml"),
            &[
                ("compete = [\"flame\"]", "with = { flame = \"flame.one\" }"),
                ("checked = true", "checked = false"),
            ],
        )?;
        bench.add("flame-table", folder, &CHECK, &["observations", "study.toml"]);
    }
    Ok(())
}

pub(super) fn studies(bench: &mut Bench<'_>) -> Outcome {
    let parts = ["rig.toml", "campaign.csv", "study.toml", "candidates"];
    for template in ["kundt-tube", "burner"] {
        let folder = bench.template("study", template, template)?;
        bench.add(
            "study",
            folder,
            &["check .", "rank . --one-start", "run . --one-start", "check . --names"],
            &parts,
        );
    }
    for template in ["heated-tube", "quarter-wave"] {
        let folder = bench.template("study", template, template)?;
        bench.add("study", folder, &["check ."], &parts);
    }
    let folder = bench.folder("study", "juniper-yoko-2022")?;
    own("examples/juniper-yoko-2022", &folder)?;
    bench.add("study", folder, &["check ."], &[]);
    Ok(())
}

pub(super) fn observations(bench: &mut Bench<'_>) -> Outcome {
    for template in ["kundt-tube", "burner"] {
        let folder = bench.template("observations", template, template)?;
        let first = if template == "burner" { "c350" } else { "p70" };
        write(
            &folder.join("observations/points.csv"),
            format!("point,T_amb [K],T_amb_sd [K]\n{first},294.0,0.3\n"),
        )?;
        bench.add("observations", folder, &CHECK, &["observations"]);
    }
    let folder = bench.folder("observations", "quarter-wave")?;
    own("examples/quarter-wave", &folder)?;
    bench.add("observations", folder, &["check ."], &["observations"]);
    Ok(())
}

/// Observations of the virtual laboratory, with what the calibration leaves of the channels, in the study of
/// the paper.
pub(super) fn channels(bench: &mut Bench<'_>) -> Outcome {
    let folder = bench.folder("channels", "empty-tube")?;
    own("examples/juniper-yoko-2022", &folder)?;
    write(&folder.join("lab.toml"), include_str!("tube/lab.toml"))?;
    bench.run(&folder, "process --virtual-rig --campaign lab.toml --out observations")?;
    let read = ["pings.csv", "points.csv", "channels.toml", "observations.toml"]
        .map(|f| format!("observations/{f}"));
    let read = read.each_ref().map(String::as_str);
    bench.add("channels", folder, &["rank . --one-start --until empty-tube", "check ."], &read);
    Ok(())
}

/// The plain tube with impedances of a network file: as text, with headings, as MATLAB and as HDF5.
pub(super) fn responses(bench: &mut Bench<'_>) -> Outcome {
    let network = "[gas]\n[upstream]\ntype = \"anechoic\"\n[downstream]\ntype = \"unflanged\"\n[[element]]\ntype = \"duct\"\n\
                   length = 0.436\ndiameter = 0.0038\nwall = \"zwikker-kosten\"\n";
    let plain = "columns = [\"f [Hz]\", \"re [1]\", \"im [1]\"]";
    let named = "columns = { \"f [Hz]\" = \"f\", \"re [1]\" = \"a\", \"im [1]\" = \"b\" }";
    for (name, file, columns) in [
        ("plain", "z.txt", plain),
        ("headings", "z.csv", named),
        ("matlab", "z.mat", named),
        ("hdf5", "z.h5", named),
    ] {
        let folder = bench.folder("responses", name)?;
        own("examples/plain-tube", &folder)?;
        write(&folder.join("network.toml"), network)?;
        bench.run(&folder, "response network.toml --csv --min-hz 100 --max-hz 3000 --step-hz 100")?;
        let printed = fs::read_to_string(folder.with_extension("out")).map_err(|e| e.to_string())?;
        let mut rows: Vec<Vec<f64>> = printed
            .lines()
            .skip(1)
            .map(|l| l.split(',').filter_map(|v| v.parse().ok()).take(3).collect())
            .collect();
        rows.retain(|row| row.len() == 3);
        for (k, row) in rows.iter_mut().enumerate() {
            row[1] += 1e-3 * (k as f64 * 2.3).sin();
        }
        let path = folder.join("observations").join(file);
        let column = |k: usize| rows.iter().map(|r| r[k]).collect::<Vec<f64>>();
        match name {
            "matlab" => {
                write(&path, samples::named_mat(&[("f", column(0)), ("a", column(1)), ("b", column(2))]))?
            }
            "hdf5" => {
                write(&path, samples::named_hdf5(&[("f", column(0)), ("a", column(1)), ("b", column(2))])?)?
            }
            _ => {
                let (head, gap) = if name == "plain" { ("", " ") } else { ("f,a,b\n", ",") };
                let mut text = String::from(head);
                for row in &rows {
                    let _ = writeln!(text, "{}{gap}{}{gap}{}", row[0], row[1], row[2]);
                }
                write(&path, text)?;
            }
        }
        let toml = format!(
            "kind = \"virtual\"\nsource = \"network.toml\"\n[[response]]\nkind = \"impedance\"\nat = \"upstream\"\n{columns}\n\
             reference_diameter = \"3.8 mm\"\nband_hz = [60, 4000]\nfiles = {{ plain = \"{file}\" }}\n"
        );
        write(&folder.join("observations/observations.toml"), toml)?;
        let study = "name = \"n\"\n[[responses]]\nid = \"wall\"\nwith = { mouth = \"mouth.unflanged\", head = \"head.perfect\" }\n\
                     compete = [\"wall\"]\nnoise = { median = 1e-3, ln_sd = 1.0 }\n";
        write(&folder.join("study.toml"), study)?;
        bench.add(
            "responses",
            folder,
            &CHECK,
            &["observations", "study.toml", "candidates/head.toml", "rig.toml"],
        );
    }
    Ok(())
}
