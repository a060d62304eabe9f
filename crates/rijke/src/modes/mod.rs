//! `rijke modes`: every acoustic mode of a network file.
//!
//! Knows options and what is printed; modes and their derivatives are found in `rijke-network`.

mod print;

use crate::{figure, number, ui::Ui};
use rijke_engine::folder::{ModeCase, warn_of_study};
use rijke_network::ModeCurves;
use rijke_numerics::{Failed, write_output};
use rijke_report::ModesFigure;
use std::f64::consts::PI;
use std::path::PathBuf;

/// Find every acoustic mode of a network in a region of growth rate and frequency. A contour integral counts
/// them. Each mode comes with its residual, its condition number and its energy budget.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  rijke modes tube.toml --max-hz 700\n  rijke modes examples/quarter-wave --point e1-0\n  \
                  rijke modes heated-tube.toml --sensitivity --plot modes.svg --along along.csv"
)]
pub(crate) struct Args {
    /// Network file or rig.toml of a study; with --point the folder of a study.
    #[arg(value_name = "FILE", required_unless_present = "oscilos", conflicts_with = "oscilos")]
    file: Option<PathBuf>,
    /// Folder of OSCILOS_lite text inputs (Geometry.txt and so on), or one that holds them in Inputs.
    #[arg(long, value_name = "DIR")]
    oscilos: Option<PathBuf>,
    /// Operating point of a study. The modes are those of the ranked model; before ranking, those of the
    /// first candidate of each role at the centres of the priors.
    #[arg(long, value_name = "ID", conflicts_with = "oscilos")]
    point: Option<String>,
    /// The stage whose model is taken [default: the last ranked one that has the point; where none has it,
    /// the last of all].
    #[arg(long, value_name = "STAGE", requires = "point")]
    stage: Option<String>,
    /// Lowest frequency, Hz [default: the file's].
    #[arg(long, value_name = "F", value_parser = number::not_negative)]
    min_hz: Option<f64>,
    /// Highest frequency, Hz [default: the file's].
    #[arg(long, value_name = "F", value_parser = number::not_negative)]
    max_hz: Option<f64>,
    /// What to print.
    #[arg(long, value_enum, default_value_t = Format::Table)]
    format: Format,
    /// Say where a small device or change would stabilise each mode most, and by how much.
    #[arg(long)]
    sensitivity: bool,
    /// Draw the s-plane, the mode shapes and the sensitivities along x into this file, which ends in .svg or
    /// .pdf.
    #[arg(long, value_name = "FILE", value_parser = figure::file)]
    plot: Option<PathBuf>,
    /// Write the mode shapes and the sensitivities along x into this CSV file.
    #[arg(long, value_name = "CSV")]
    along: Option<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// A table for reading.
    Table,
    /// Comma-separated values with units in the header.
    Csv,
    /// JSON.
    Json,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let mut case = match (&args.oscilos, &args.file) {
        (Some(folder), _) => ModeCase::oscilos(folder)?,
        (None, Some(dir)) if args.point.is_some() => {
            let id = args.point.as_deref().unwrap_or_default();
            // The file of a study's rig names its folder too.
            let dir = if dir.is_file() { dir.parent().unwrap_or(dir) } else { dir };
            warn_of_study(dir, ui);
            ModeCase::point(dir, id, args.stage.as_deref(), [args.min_hz, args.max_hz])?
        }
        (None, Some(dir)) if dir.is_dir() => {
            let remedy = "Name a network file; of a study name an operating point too, with --point ID.";
            return Err(Failed::bad_input("is a folder, not a network file").at(dir).remedy(remedy));
        }
        (None, Some(file)) => ModeCase::file(file, [args.min_hz, args.max_hz])?,
        (None, None) => return Err(Failed::bad_input("no network file is named")),
    };
    for (limit, given) in case.region.omega.iter_mut().zip([args.min_hz, args.max_hz]) {
        *limit = given.map_or(*limit, |f| 2.0 * PI * f);
    }
    let mut found = case.find(ui)?;
    let curves = if args.sensitivity || args.plot.is_some() || args.along.is_some() {
        found.all.iter().map(|mode| case.curves(mode)).collect::<Result<Vec<_>, _>>()?
    } else {
        Vec::new()
    };
    if args.sensitivity {
        found.sensitivity = curves.iter().flat_map(ModeCurves::advice).collect();
    }
    match if ui.is_json() { Format::Json } else { args.format } {
        Format::Table => {
            print::table(&case, &found, ui);
            print::advice(curves.len(), &found.sensitivity, ui);
        }
        Format::Csv => ui.say(found.csv()?.trim_end()),
        Format::Json => ui.json(&found)?,
    }
    if let Some(path) = &args.along {
        write_output(path, ModeCurves::csv(&curves).as_bytes())?;
        ui.note(format!("wrote {}", path.display()));
    }
    if let Some(path) = &args.plot {
        let drawn = ModesFigure {
            title: case.title.clone().unwrap_or_else(|| "Acoustic modes".to_owned()),
            growth_rate: case.region.sigma,
            frequency_hz: case.region.omega.map(|w| w / (2.0 * PI)),
            modes: curves,
            poles: case.poles()?,
            devices: case.devices.clone(),
        };
        figure::write(path, &drawn.svg(), ui)?;
    }
    Ok(())
}
