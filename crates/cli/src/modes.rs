//! `rijke modes`: every acoustic mode of a network file.

use crate::{
    failure::{Classify, Failure},
    ui::Ui,
};
use comfy_table::{Table, presets};
use rijke_network::file::{Built, OscilosTexts, read, read_oscilos};
use rijke_network::{Mode, Modes, Places, Root, Sensitivities, Workspace};
use serde::Serialize;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// Find every acoustic mode of a network in a region of growth rate and frequency, counted by a contour integral, with
/// its residual, its condition number and where its energy goes.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke modes fixtures/networks/rig-tube.toml --max-hz 700")]
pub(crate) struct Args {
    /// Network file (TOML).
    #[arg(value_name = "FILE", required_unless_present = "oscilos", conflicts_with = "oscilos")]
    file: Option<PathBuf>,
    /// Folder of OSCILOS_lite text inputs (Geometry.txt and so on), or one that holds them in Inputs.
    #[arg(long, value_name = "DIR")]
    oscilos: Option<PathBuf>,
    /// Lowest frequency, Hz [default: the file's].
    #[arg(long, value_name = "F")]
    min_hz: Option<f64>,
    /// Highest frequency, Hz [default: the file's].
    #[arg(long, value_name = "F")]
    max_hz: Option<f64>,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// A table for reading.
    Table,
    /// Comma-separated values with units in the header.
    Csv,
    /// JSON.
    Json,
}

/// One mode as printed. Shares of the growth rate are half the power over the energy of the mode; they add up to it.
#[derive(Serialize)]
struct Line {
    frequency_hz: f64,
    growth_rate: f64,
    residual: f64,
    condition: f64,
    multiplicity: usize,
    by_upstream_end: f64,
    by_downstream_end: f64,
    by_viscous_loss: f64,
    by_thermal_loss: f64,
    by_elements: Vec<(String, f64)>,
}

#[derive(Serialize)]
struct Answer {
    name: Option<String>,
    counted: usize,
    found: usize,
    poles: usize,
    modes: Vec<Line>,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    if let Some(folder) = &args.oscilos {
        return oscilos(args, folder, ui);
    }
    let Some(file) = &args.file else {
        return Err(Failure::bad_input("no network file is named"));
    };
    let text = std::fs::read_to_string(file).or_bad_input().map_err(|failure| {
        failure.at(file).remedy("Name a network file; fixtures/networks holds examples.")
    })?;
    let mut built = read(&text).or_bad_input().map_err(|failure| failure.at(file))?;
    let hertz = 2.0 * PI;
    for (limit, given) in built.region.omega.iter_mut().zip([args.min_hz, args.max_hz]) {
        *limit = given.map_or(*limit, |f| hertz * f);
    }
    let mut work = Workspace::default();
    let modes =
        built.network.modes(&built.laws, &built.region, &mut work).or_bad_input().map_err(|failure| {
            failure
                .at(file)
                .remedy("Change the region with [search], --min-hz or --max-hz, or the element named.")
        })?;
    let lines =
        modes.modes.iter().map(|mode| line(&built, mode, &mut work)).collect::<Result<Vec<_>, _>>()?;
    for warning in &built.warnings {
        ui.note(format!("warning: {}: {warning}", file.display()));
    }
    if let Some(growing) = lines.iter().find(|l| built.passive && l.growth_rate > 1e-9 * l.frequency_hz) {
        ui.note(format!(
            "warning: {}: the mode at {:.2} Hz grows although nothing in the file feeds energy: an end or a \
             coefficient of it is not what it should be (see the column that is positive)",
            file.display(),
            growing.frequency_hz
        ));
    }
    match args.format {
        Format::Table => table(&built, &modes, &lines, ui),
        Format::Csv => csv(&lines, ui),
        Format::Json => {
            let answer = Answer {
                name: built.name,
                counted: modes.counted,
                found: modes.modes.iter().map(|m| m.multiplicity).sum(),
                poles: modes.poles,
                modes: lines,
            };
            ui.say(serde_json::to_string_pretty(&answer).or_failed()?);
        }
    }
    Ok(())
}

/// The modes of a folder of OSCILOS_lite inputs: frequency, growth rate and residual.
fn oscilos(args: &Args, folder: &Path, ui: &Ui) -> Result<(), Failure> {
    let inputs = folder.join("Inputs");
    let inputs = if inputs.is_dir() { inputs } else { folder.to_path_buf() };
    let text = |name: &str| {
        let path = inputs.join(name);
        std::fs::read_to_string(&path).or_bad_input().map_err(|failure| {
            failure.at(&path).remedy("Name the folder that holds the inputs of OSCILOS_lite.")
        })
    };
    let texts = OscilosTexts {
        geometry: text("Geometry.txt")?,
        mean_flow: text("Mean_flow.txt")?,
        flame: text("Flame.txt").ok(),
        inlet: text("Inlet.txt")?,
        outlet: text("Outlet.txt")?,
        scan_range: text("Scan_range.txt")?,
    };
    let (chain, mut region) = read_oscilos(&texts).or_bad_input().map_err(|failure| failure.at(&inputs))?;
    for (limit, given) in region.omega.iter_mut().zip([args.min_hz, args.max_hz]) {
        *limit = given.map_or(*limit, |f| 2.0 * PI * f);
    }
    let modes = chain.modes(&region).or_bad_input().map_err(|failure| {
        failure.at(&inputs).remedy("Change Scan_range.txt, or give --min-hz and --max-hz.")
    })?;
    if matches!(args.format, Format::Json) {
        let rows: Vec<_> = modes
            .modes
            .iter()
            .map(|m| {
                let frequency_hz = m.s.im / (2.0 * PI);
                serde_json::json!({ "frequency_hz": frequency_hz, "growth_rate": m.s.re, "residual": m.residual })
            })
            .collect();
        let answer = serde_json::json!({ "counted": modes.counted, "modes": rows });
        ui.say(serde_json::to_string_pretty(&answer).or_failed()?);
        return Ok(());
    }
    ui.say("frequency_hz,growth_rate_per_s,residual");
    for mode in &modes.modes {
        ui.say(format!("{},{},{:e}", mode.s.im / (2.0 * PI), mode.s.re, mode.residual));
    }
    if matches!(args.format, Format::Table) {
        ui.say(format!("{} of {} modes found.", modes.modes.len(), modes.counted));
    }
    Ok(())
}

fn line(built: &Built, mode: &Mode, work: &mut Workspace) -> Result<Line, Failure> {
    let root = Root { s: mode.s, steps: 0, residual: mode.residual };
    let budget = built.network.budget(&built.laws, &root, work);
    let mut all = Sensitivities::default();
    let loudest = Places { at: Vec::new(), reference: 0 };
    // No pressure is asked for, so that a silent reference does not matter.
    built.network.sensitivities(&built.laws, &root, &loudest, &mut all, work).or_failed()?;
    let by_elements = budget
        .places
        .iter()
        .map(|exchange| {
            let names: Vec<&str> = built
                .places
                .iter()
                .filter(|(place, _)| *place == exchange.place)
                .map(|(_, name)| name.as_str())
                .collect();
            let name = if names.is_empty() {
                "area changes and lumped losses".to_owned()
            } else {
                names.join(" + ")
            };
            (name, 0.5 * exchange.power.iter().sum::<f64>())
        })
        .fold(Vec::new(), |mut sums: Vec<(String, f64)>, (name, share)| {
            match sums.iter_mut().find(|(known, _)| *known == name) {
                Some((_, sum)) => *sum += share,
                None => sums.push((name, share)),
            }
            sums
        });
    Ok(Line {
        frequency_hz: mode.s.im / (2.0 * PI),
        growth_rate: mode.s.re,
        residual: mode.residual,
        condition: all.condition(&built.network, mode.s),
        multiplicity: mode.multiplicity,
        by_upstream_end: 0.5 * budget.upstream,
        by_downstream_end: 0.5 * budget.downstream,
        by_viscous_loss: 0.5 * budget.viscous,
        by_thermal_loss: 0.5 * budget.thermal,
        by_elements,
    })
}

fn table(built: &Built, modes: &Modes, lines: &[Line], ui: &Ui) {
    let [low, high] = built.region.omega.map(|w| w / (2.0 * PI));
    let [left, right] = built.region.sigma;
    if let Some(name) = &built.name {
        ui.say(name);
    }
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in lines.iter().flat_map(|l| &l.by_elements) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    let mut header = vec![
        "frequency\nHz",
        "growth\n1/s",
        "upstream\nend",
        "downstream\nend",
        "viscous\nwall",
        "thermal\nwall",
    ];
    header.extend(names.iter());
    header.extend(["condition", "residual"]);
    table.set_header(header);
    for l in lines {
        let number = |v: f64| if v.abs() < 1e-9 { "0".to_owned() } else { format!("{v:.4}") };
        let mut row = vec![format!("{:.4}", l.frequency_hz), format!("{:.4}", l.growth_rate)];
        row.extend(
            [l.by_upstream_end, l.by_downstream_end, l.by_viscous_loss, l.by_thermal_loss].map(number),
        );
        for name in &names {
            let share = l.by_elements.iter().find(|(n, _)| n == name);
            row.push(share.map_or_else(|| "0".to_owned(), |(_, v)| number(*v)));
        }
        row.extend([format!("{:.1}", l.condition), format!("{:.0e}", l.residual)]);
        table.add_row(row);
    }
    if !lines.is_empty() {
        ui.say(table.to_string());
        ui.say("The columns between growth and condition are its parts, in 1/s; they add up to it.");
    }
    let found: usize = modes.modes.iter().map(|m| m.multiplicity).sum();
    let poles = if modes.poles > 0 {
        format!(
            ", {} of laws told apart from them",
            if modes.poles == 1 { "1 pole".to_owned() } else { format!("{} poles", modes.poles) }
        )
    } else {
        String::new()
    };
    ui.say(format!(
        "{found} of {} modes found{poles} between {low:.1} and {high:.1} Hz, {left} and {right} 1/s.",
        modes.counted
    ));
}

fn csv(lines: &[Line], ui: &Ui) {
    ui.say(
        "frequency_hz,growth_rate_per_s,residual,condition,multiplicity,upstream_end_per_s,downstream_end_per_s,\
         viscous_wall_per_s,thermal_wall_per_s,elements_per_s",
    );
    for l in lines {
        let elements: f64 = l.by_elements.iter().map(|(_, v)| v).sum();
        ui.say(format!(
            "{},{},{:e},{},{},{},{},{},{},{}",
            l.frequency_hz,
            l.growth_rate,
            l.residual,
            l.condition,
            l.multiplicity,
            l.by_upstream_end,
            l.by_downstream_end,
            l.by_viscous_loss,
            l.by_thermal_loss,
            elements
        ));
    }
}
