//! `rijke response`: what a network answers when it is driven at given frequencies.

use crate::{figure, number, ui::Ui};
use rijke_engine::folder::frequencies as asked_frequencies;
use rijke_network::file::{Built, DrivenQuantity as Quantity, read};
use rijke_numerics::{C64, Classify, Failed};
use rijke_report::{ResponseCurve, ResponseFigure};
use rijke_rig::files::csv_table;
use std::f64::consts::PI;
use std::path::PathBuf;

/// Drive a network at given frequencies: impedance and reflection at a port, transfer between places,
/// scattering.
///
/// Without further options: the impedance p/(rho c u) and the reflection g/f that the chain has at its
/// upstream end. A place is the name of an element that stands between ducts, a position in m where one
/// stands or where ducts meet, or `upstream` or `downstream`. A `feedback` element without coefficients marks
/// a place for a microphone.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke response tube.toml --max-hz 700 --plot response.svg\n  \
                  rijke response tube.toml --scattering upstream downstream --csv")]
pub(crate) struct Args {
    /// Network file (TOML).
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Lowest frequency, Hz.
    #[arg(long, value_name = "F", default_value_t = 20.0, value_parser = number::positive)]
    min_hz: f64,
    /// Highest frequency, Hz [default: the file's].
    #[arg(long, value_name = "F", value_parser = number::positive)]
    max_hz: Option<f64>,
    /// Distance of the frequencies, Hz [default: a hundredth of the range].
    #[arg(long, value_name = "F", value_parser = number::positive)]
    step_hz: Option<f64>,
    /// These frequencies instead, Hz, each a number or from:to:step.
    #[arg(long, value_name = "F", num_args = 1.., conflicts_with_all = ["min_hz", "max_hz", "step_hz"])]
    at_hz: Vec<String>,
    /// Impedance and reflection of what lies downstream of this place, seen from just before it.
    #[arg(long, value_name = "PLACE")]
    port: Option<String>,
    /// Ratio of the pressure at the second place to that at the first, the chain being driven by a wave at
    /// its upstream end.
    #[arg(long, value_names = ["FROM", "TO"], num_args = 2)]
    transfer: Vec<String>,
    /// Reflection and transmission of pressure waves by what lies between two places, from either side.
    #[arg(long, value_names = ["FROM", "TO"], num_args = 2)]
    scattering: Vec<String>,
    /// Print comma-separated values: real and imaginary parts.
    #[arg(long)]
    csv: bool,
    /// Draw modulus and phase into this file, which ends in .svg or .pdf.
    #[arg(long, value_name = "FILE", value_parser = figure::file)]
    plot: Option<PathBuf>,
}

/// More frequencies than this are a slip of the step.
const MOST: f64 = 1e6;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let path = &args.file;
    let text = rijke_numerics::read_text(path)
        .or_bad_input()
        .map_err(|failure| failure.at(path).remedy("Name a network file; docs/network-file.md shows one."))?;
    let driven = read(&text).or_bad_input().map_err(|failure| {
        let failure = failure.at(path);
        if path.file_name().is_none_or(|name| name != "rig.toml") {
            return failure;
        }
        failure.remedy(
            "This is the rig of a study. `rijke modes DIR --point ID` computes its modes; for driven responses declare a stage with `responses`, and use \
             `rijke predict`.",
        )
    })?;
    for warning in &driven.warnings {
        ui.note(format!("warning: {}: {warning}", path.display()));
    }
    let frequencies = frequencies(args, driven.region.omega[1] / (2.0 * PI))?;
    let highest = frequencies.iter().copied().fold(0.0, f64::max);
    // A file whose search goes beyond has said so.
    if highest > driven.plane_below_hz && driven.region.omega[1] <= 2.0 * PI * driven.plane_below_hz {
        ui.note(format!(
            "warning: {}: from {:.0} Hz on a higher mode is cut on in its widest duct, and the sound is not in plane waves alone",
            path.display(),
            driven.plane_below_hz
        ));
    }
    let mut columns: Vec<(String, Vec<C64>)> = Vec::new();
    for quantity in wanted(args) {
        columns.extend(driven.driven(&quantity, &frequencies).map_err(|error| {
            let remedy = error.remedy();
            Failed::bad_input(error).at(path).remedy(remedy)
        })?);
    }
    if ui.is_json() {
        let numbers = columns.iter().map(|(name, values)| {
            let parts = |f: fn(&C64) -> f64| values.iter().map(f).collect::<Vec<_>>();
            serde_json::json!({ "name": name, "re": parts(|z| z.re), "im": parts(|z| z.im) })
        });
        let all: Vec<_> = numbers.collect();
        ui.json(&serde_json::json!({ "name": driven.name, "frequency_hz": frequencies, "responses": all }))?;
    } else if args.csv {
        let names = columns.iter().flat_map(|(name, _)| [format!("{name}_re"), format!("{name}_im")]);
        let head = std::iter::once("frequency [Hz]".to_owned()).chain(names).collect();
        let row = |(k, f): (usize, &f64)| {
            let numbers = columns.iter().flat_map(|(_, z)| [z[k].re, z[k].im]);
            std::iter::once(*f).chain(numbers).map(|v| v.to_string()).collect()
        };
        let rows = frequencies.iter().enumerate().map(row);
        ui.say(csv_table(std::iter::once(head).chain(rows))?.trim_end());
    } else {
        table(&driven, &frequencies, &columns, ui);
    }
    if let Some(path) = &args.plot {
        let curve = |(name, values): &(String, Vec<C64>)| ResponseCurve {
            label: name.clone(),
            modulus: values.iter().map(|z| z.norm()).collect(),
            phase_deg: values.iter().map(|z| z.arg().to_degrees()).collect(),
        };
        let drawn = ResponseFigure {
            title: driven.name.clone().unwrap_or_else(|| "Forced response".to_owned()),
            frequency_hz: frequencies,
            curves: columns.iter().map(curve).collect(),
        };
        figure::write(path, &drawn.svg(), ui)?;
    }
    Ok(())
}

/// What was asked for; impedance and reflection at the upstream end if nothing was.
fn wanted(args: &Args) -> Vec<Quantity> {
    let pair = |list: &[String]| match list {
        [from, to] => Some([from.clone(), to.clone()]),
        _ => None,
    };
    let transfer = pair(&args.transfer).map(Quantity::Transfer);
    let scattering = pair(&args.scattering).map(Quantity::Scattering);
    let silent = transfer.is_none() && scattering.is_none();
    let port = args.port.clone().or_else(|| silent.then(|| "upstream".to_owned()));
    port.map(Quantity::Port).into_iter().chain(transfer).chain(scattering).collect()
}

fn frequencies(args: &Args, highest: f64) -> Result<Vec<f64>, Failed> {
    if !args.at_hz.is_empty() {
        return Ok(args
            .at_hz
            .iter()
            .map(|text| asked_frequencies(text))
            .collect::<Result<Vec<_>, _>>()?
            .concat());
    }
    let (low, high) = (args.min_hz, args.max_hz.unwrap_or(highest));
    let step = args.step_hz.unwrap_or((high - low) / 100.0);
    if high <= low {
        return Err(Failed::bad_input(format!("no frequency lies from {low} to {high} Hz"))
            .remedy("Give --max-hz above --min-hz."));
    }
    let count = ((high - low) / step * (1.0 + 1e-12)).floor();
    if count > MOST {
        return Err(
            Failed::bad_input(format!("{count} frequencies are too many")).remedy("Give a larger --step-hz.")
        );
    }
    Ok((0..=count as usize).map(|k| low + step * k as f64).collect())
}

fn table(driven: &Built, frequencies: &[f64], columns: &[(String, Vec<C64>)], ui: &Ui) {
    if let Some(name) = &driven.name {
        ui.say(name);
    }
    let mut header = vec!["frequency\nHz".to_owned()];
    header.extend(columns.iter().flat_map(|(name, _)| [format!("|{name}|"), "phase\ndeg".to_owned()]));
    let rows = frequencies.iter().enumerate().map(|(k, f)| {
        let numbers = columns
            .iter()
            .flat_map(|(_, z)| [format!("{:.6}", z[k].norm()), format!("{:.3}", z[k].arg().to_degrees())]);
        std::iter::once(format!("{f:.3}")).chain(numbers).collect::<Vec<_>>()
    });
    ui.table(header, rows);
}
