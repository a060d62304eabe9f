//! `rijke process`: from raw records to observations with uncertainties.

use crate::{lab::Laboratory, number, ui::Ui};
use rijke_engine::folder::open_study;
use rijke_intake::{Excited, Intake, ObserveOptions, Out};
use rijke_numerics::words::counted;
use rijke_numerics::{C64, Failed};
use rijke_report::Gallery;
use rijke_rig::PointObservations;
use rijke_signal::{ChannelDelays, ChannelPriors, PointScatter, Processed};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Turn raw records into observations. Of pings and clicks: growth rate, frequency and mode shape of every
/// ping, arrival times of every click, with uncertainties, corrected for the delays of the channels. Bad
/// records are rejected with a reason.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke process records --out observations\n  \
    rijke process --virtual-rig --rows C3,H7 --repeats 10 --out observations")]
pub(crate) struct Args {
    /// Folder of a study, or of records with their manifest.toml.
    #[arg(value_name = "DIR", required_unless_present = "virtual_rig", conflicts_with = "virtual_rig")]
    records: Option<PathBuf>,
    /// Process the records that `rijke lab` would write, without writing them.
    #[arg(long, requires = "out")]
    virtual_rig: bool,
    /// Folder to write [default: DIR/observations].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Frequencies between which the mode of interest is sought, Hz [default: `band_hz` of the manifest, else
    /// `band_hz` of `[recording]` or `frequency_hz` of `[search]` in the study's rig.toml, else 80 300].
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], value_parser = number::positive)]
    band: Option<Vec<f64>>,
    /// Nominal frequency of the mains, Hz [default: `mains_hz` of the manifest, else of `[recording]` in the
    /// study's rig.toml, else 50].
    #[arg(long, value_name = "HZ", value_parser = number::positive)]
    mains: Option<f64>,
    /// Standard deviations of the relative gains and of the delays (s) of the channels, for pings without
    /// calibration clicks at their sampling rate. The errors of the mode shapes follow from them [default:
    /// `[microphones]` of the manifest].
    #[arg(long, num_args = 2, value_names = ["GAIN_SD", "DELAY_SD"], value_parser = positive)]
    channels: Option<Vec<f64>>,
    /// Largest allowed deviation of a channel's gain from the median gain, relative to the median. A
    /// calibration with a gain beyond it is refused.
    #[arg(long, value_name = "SHARE", default_value_t = 0.3, value_parser = positive)]
    gain_spread: f64,
    /// Draw the first accepted ping and click of every operating point, every rejected record and the delays
    /// of the channels: plots/index.html in the output folder.
    #[arg(long)]
    plot: bool,
    /// Replace the output folder if it exists.
    #[arg(long)]
    force: bool,
    #[command(flatten, next_help_heading = "Virtual rig")]
    laboratory: Laboratory,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let band_hz = args.band.as_deref().map(|band| [band[0], band[1]]);
    if let Some([low, high]) = band_hz
        && low >= high
    {
        return Err(Failed::bad_input(format!(
            "--band {low} {high}: the first frequency must be the lower one"
        ))
        .remedy("Give the lower frequency first, such as --band 80 300."));
    }
    let name = args.records.clone().unwrap_or_else(|| PathBuf::from("virtual rig"));
    if !args.virtual_rig
        && let Some(excited) = Excited::open(&name, &open_study)?
    {
        return ui.result(&excited.observe(args.out.as_deref(), args.force, ui)?);
    }
    let intake = if args.virtual_rig {
        let laboratory = args.laboratory.open()?;
        let tube = laboratory.tube().clone();
        Intake::of_laboratory(Box::new(laboratory), tube)
    } else if args.laboratory.is_described() {
        return Err(Failed::bad_input(format!(
            "{}: rows, repeats, seed, rig, campaign and truth describe a virtual rig, not a folder of records",
            name.display()
        ))
        .remedy("Leave these options out, or give --virtual-rig instead of the folder."));
    } else {
        Intake::open(&name, &open_study)?
    };
    let stated = |sds: &Vec<f64>| ChannelPriors { gain_sd: sds[0], delay_sd: sds[1] };
    let options = ObserveOptions {
        band_hz,
        mains_hz: args.mains,
        channels: args.channels.as_ref().map(stated),
        gain_spread: Some(args.gain_spread),
    };
    let out = args.out.clone().unwrap_or_else(|| name.join("observations"));
    observe(&intake, &options, &out, args.force, args.plot, ui)
}

/// Processes the records of a folder with the usual options.
pub(crate) fn records(records: &Path, out: &Path, force: bool, ui: &Ui) -> Result<(), Failed> {
    if let Some(excited) = Excited::open(records, &open_study)? {
        return ui.result(&excited.observe(Some(out), force, ui)?);
    }
    let intake = Intake::open(records, &open_study)?;
    observe(&intake, &ObserveOptions::default(), out, force, false, ui)
}

fn observe(
    intake: &Intake,
    options: &ObserveOptions,
    out: &Path,
    force: bool,
    plot: bool,
    ui: &Ui,
) -> Result<(), Failed> {
    let plots = |processed: &Processed, folder: &Path| match plot {
        true => plots(intake, processed, &folder.join("plots")),
        false => Ok(()),
    };
    let processed = intake.observe(options, None, &Out { folder: out, force, beside: &plots }, ui)?;
    tell(&processed, out, ui)
}

/// A page with the first accepted ping and click of every operating point, and every rejected record.
fn plots(intake: &Intake, processed: &Processed, folder: &Path) -> Result<(), Failed> {
    let first =
        "<p>The first accepted ping and click of every operating point, and every rejected record.</p>\n";
    let mut gallery = Gallery::new(folder, first);
    gallery.show("delays", &intake.plot_of_delays(processed))?;
    gallery.begin_list("Records");
    intake.plots(processed, &mut |(name, reason, plot)| gallery.list(name, reason, &plot))?;
    gallery.write("Records and fits", "</ul>\n")
}

/// Says what was measured.
fn tell(processed: &Processed, out: &Path, ui: &Ui) -> Result<(), Failed> {
    let records = processed.records;
    table(processed, ui);
    for (what, delays) in [("pings", &processed.ping_delays), ("clicks", &processed.click_delays)] {
        if let Some(delays) = delays.as_ref().filter(|d| d.clicks > 0) {
            ui.say(describe(what, delays));
        }
    }
    for note in &processed.notes {
        ui.note(note);
    }
    let rejected = processed.observations.rejections.len();
    let corrected = match processed.corrections.len() {
        0 => String::new(),
        n => format!(", {n} put right or without a channel (corrections.csv)"),
    };
    let shown = out.display();
    let why = processed.observations.main_reason().map_or_else(String::new, |(count, first)| {
        format!("; {count} of these for one reason, first {}: {}", first.record, first.reason)
    });
    ui.note(format!(
        "{shown}: {}, {rejected} rejected (reasons in rejections.csv){corrected}{why}",
        counted(records, "record")
    ));
    let of_point = |p: &PointObservations| {
        let ping = p.ping.as_ref();
        let [growth_rate, angular_frequency] =
            [0, 1].map(|k| ping.map(|p| [if k == 0 { p.s.re } else { p.s.im }, p.covariance[(k, k)].sqrt()]));
        json!({
            "point": p.point.id, "pings": p.ping_count, "clicks": p.click_count,
            "growth_rate": growth_rate, "angular_frequency": angular_frequency,
        })
    };
    let points: Vec<_> = processed.observations.points.iter().map(of_point).collect();
    ui.result(&json!({ "dir": out, "records": records, "rejected": rejected, "notes": processed.notes, "points": points }))
}

/// A positive finite number.
fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    value.ok_or_else(|| "not a positive number".to_owned())
}

fn table(processed: &Processed, ui: &Ui) {
    let head = "point,pings,growth rate (1/s),+-,frequency (rad/s),+-,between repeats,drift,clicks,top arrival (ms),+- (us)";
    // As many decimals as show the smallest error.
    let sds = |k: usize| {
        let pings = processed.observations.points.iter().filter_map(|p| p.ping.as_ref());
        pings.map(move |p| p.covariance[(k, k)].sqrt()).fold(1.0, f64::min)
    };
    let [n, m] = [0, 1].map(|k| (-sds(k).log10()).ceil().clamp(3.0, 7.0) as usize);
    // Points of one ping have the scatter of the others, if these have several.
    let repeated = processed.observations.points.iter().any(|p| p.ping_count > 1);
    let row = |(point, scatter): (&PointObservations, &PointScatter)| {
        let repeats = scatter.ping.as_ref();
        let drift =
            repeats.map_or(0.0, |r| r.drift.iter().take(2).map(|d| (d.0 / d.1).abs()).fold(0.0, f64::max));
        [
            point.point.id.clone(),
            format!("{}", point.ping_count),
            ping(point, |s, _| format!("{:.n$}", s.re)),
            ping(point, |_, sd| format!("{:.n$}", sd.0)),
            ping(point, |s, _| format!("{:.m$}", s.im)),
            ping(point, |_, sd| format!("{:.m$}", sd.1)),
            repeats.filter(|_| repeated).map_or_else(String::new, |r| {
                format!("{:.n$}, {:.m$}", r.between[0].sqrt(), r.between[1].sqrt())
            }),
            if drift > 4.0 { format!("{drift:.1} sd") } else { "none".to_owned() },
            format!("{}", point.click_count),
            point.click.as_ref().map_or_else(String::new, |c| {
                c.arrival_times.last().map_or_else(String::new, |t| format!("{:.5}", 1e3 * t))
            }),
            point.click.as_ref().map_or_else(String::new, |c| {
                let last = c.arrival_times.len() - 1;
                format!("{:.2}", 1e6 * c.covariance[(last, last)].sqrt())
            }),
        ]
    };
    ui.table(head.split(','), processed.observations.points.iter().zip(&processed.scatter).map(row));
}

fn ping(point: &PointObservations, show: impl Fn(C64, (f64, f64)) -> String) -> String {
    point
        .ping
        .as_ref()
        .map_or_else(String::new, |p| show(p.s, (p.covariance[(0, 0)].sqrt(), p.covariance[(1, 1)].sqrt())))
}

fn describe(what: &str, delays: &ChannelDelays) -> String {
    let first = delays.delays.first().copied().unwrap_or(0.0);
    let relative: Vec<String> = delays.delays.iter().map(|d| format!("{:.2}", 1e6 * (d - first))).collect();
    let gains: Vec<String> = delays.gains.iter().map(|g| format!("{g:.4}")).collect();
    format!(
        "{what}: {} calibration clicks at {} Hz; channel delays less the first (us): {}; gains: {}",
        delays.clicks,
        delays.rate_hz,
        relative.join(" "),
        gains.join(" ")
    )
}
