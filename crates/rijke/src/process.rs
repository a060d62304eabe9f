//! `rijke process`: from raw records to pings and clicks with uncertainties.

mod compared;
mod driven;
mod excited;
mod made;
mod plot;
mod stated;
mod switched;

use crate::failure::{Classify, Failure};
use crate::{lab::Laboratory, number, ui::Ui};
pub(crate) use excited::{Checked, checked};
use rijke_flow::{HeatedTube, Ramp};
use rijke_numerics::StagedFolder;
use rijke_rig::{Described, OperatingPoint, PointObservations, RecordFolder, RecordSource, Rejection};
use rijke_signal::{
    ChannelDelays, ChannelPriors, Kept, PointScatter, ProcessError, ProcessOptions, Processed, process_again,
    record_count,
};
use rijke_study::{MadeOf, Study};
use serde_json::json;
pub(crate) use stated::said_of_twins;
use std::path::{Path, PathBuf};

/// Turn raw records into observations. Of pings and clicks: growth rate, frequency and mode shape of every
/// ping, arrival times of every click, with uncertainties, corrected for the delays of the channels. Bad
/// records are rejected with a reason.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke process records --out observations\n  \
    rijke process --virtual-rig --rows C3,H7 --repeats 10 --out observations")]
pub(crate) struct Args {
    /// Folder of records, with its manifest.toml.
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
    /// How equal the channels are where there are no calibration clicks at the pings' rate: the relative
    /// standard deviation of their gains, and the standard deviation of their delays, s. The errors of the
    /// mode shapes follow from it [default: `[microphones]` of the manifest].
    #[arg(long, num_args = 2, value_names = ["GAIN_SD", "DELAY_SD"], value_parser = positive)]
    channels: Option<Vec<f64>>,
    /// Largest distance of a channel's gain from the median of all, relative to the median. A calibration
    /// with a gain beyond it is refused.
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

/// Processes the records of a folder with the usual options.
pub(crate) fn records(records: &Path, out: &Path, force: bool, ui: &Ui) -> Result<(), Failure> {
    run(&usual(records, out, force)?, ui)
}

/// Processes the records of a study that are there so far, of which some fits are kept; with a figure of the
/// record called `shown`.
pub(crate) fn so_far(
    mut records: RecordFolder,
    study: Study,
    out: &Path,
    kept: &Kept,
    shown: Option<&str>,
) -> Result<(Processed, Option<String>), Failure> {
    let args = usual(records.folder(), out, true)?;
    let of_the_study = !records.has_own_campaign();
    let tube = tube(&mut records)?;
    let (source, twins) = (Box::new(records), Vec::new());
    // Records still come.
    let given = Given { source, tube, study: Some(study), of_the_study, twins, folder: None };
    let processed = make(&args, out, &given, Some(kept), &Ui::silent())?;
    let figure = match shown {
        Some(name) => plot::of_record(&*given.source, &processed, name)?,
        None => None,
    };
    Ok((processed, figure))
}

fn usual(records: &Path, out: &Path, force: bool) -> Result<Args, Failure> {
    let words =
        ["process".into(), records.as_os_str().to_owned(), "--out".into(), out.as_os_str().to_owned()];
    let force = force.then(|| "--force".into());
    let matches = <Args as clap::Args>::augment_args(clap::Command::new("process"))
        .get_matches_from(words.into_iter().chain(force));
    <Args as clap::FromArgMatches>::from_arg_matches(&matches).or_failed()
}

/// Records, and what is known of them.
struct Given {
    source: Box<dyn RecordSource>,
    /// The heated tube in which they were taken, if it was one.
    tube: Option<HeatedTube>,
    study: Option<Study>,
    /// Whether rig and campaign are those of the study.
    of_the_study: bool,
    /// Files of the same content.
    twins: Vec<(String, String)>,
    /// The folder of the records, to be named by what is made of them.
    folder: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    if let Some([low, high]) = args.band.as_deref()
        && low >= high
    {
        return Err(Failure::bad_input(format!(
            "--band {low} {high}: the first frequency must be the lower one"
        ))
        .remedy("Give the lower frequency first, such as --band 80 300."));
    }
    let name = args.records.clone().unwrap_or_else(|| PathBuf::from("virtual rig"));
    let out = args.out.clone().unwrap_or_else(|| name.join("observations"));
    if !args.virtual_rig
        && let Some((records, study)) = excited::open(&name)?
    {
        return excited::run(&records, &study, args.out.as_deref(), args.force, ui);
    }
    let (mut study, mut of_the_study) = (None, false);
    let (mut twins, mut folder) = (Vec::new(), None);
    let heated;
    let source: Box<dyn RecordSource> = if args.virtual_rig {
        let laboratory = args.laboratory.open()?;
        heated = Some(laboratory.tube().clone());
        Box::new(laboratory)
    } else if args.laboratory.is_described() {
        return Err(Failure::bad_input(format!(
            "{}: rows, repeats, seed, rig, campaign and truth describe a virtual rig, not a folder of records",
            name.display()
        ))
        .remedy("Leave these options out, or give --virtual-rig instead of the folder."));
    } else {
        let opened = open(&name)?;
        heated = opened.tube;
        twins = opened.records.twins().or_bad_input()?;
        folder = Some(opened.records.folder().to_owned());
        of_the_study = !opened.records.has_own_campaign();
        study = opened.study;
        Box::new(opened.records)
    };
    let given = Given { source, tube: heated, study, of_the_study, twins, folder };
    let processed = make(args, &out, &given, None, ui)?;
    tell(&processed, &out, ui)
}

/// Writes the observations that records give.
fn make(
    args: &Args,
    out: &Path,
    Given { source, tube, study, of_the_study, twins, folder: records }: &Given,
    kept: Option<&Kept>,
    ui: &Ui,
) -> Result<Processed, Failure> {
    let name = args.records.clone().unwrap_or_else(|| PathBuf::from("virtual rig"));
    // A tube and ramps that stand beside observations whose records have none were put there by hand.
    let by_hand = match tube {
        None => 2,
        Some(tube) if tube.ramps.is_empty() => 1,
        Some(_) => 0,
    };
    let own = &WRITTEN[by_hand..];
    let folder = ui.started(StagedFolder::beside_others(out, "observations.toml", own, args.force)?);
    let mut options = ProcessOptions::default();
    let mut said = stated::said_of_twins(twins);
    let (band, why) = stated::band(args.band.as_deref(), source.set(), study.as_ref());
    said.extend(why);
    options.ping.band_hz = band;
    // Neighbours are looked for beyond the band.
    options.ping.highest_hz = options.ping.highest_hz.max(1.4 * band.1);
    let mains = stated::mains(args.mains, source.set(), study.as_ref());
    options.ping.mains_hz = mains.unwrap_or(options.ping.mains_hz);
    options.gain_spread = Some(args.gain_spread);
    options.stated = args.channels.as_ref().map(|sds| ChannelPriors { gain_sd: sds[0], delay_sd: sds[1] });
    let progress = ui.progress("processing", record_count(source.set()) as u64);
    let processed = process_again(&**source, &options, kept, &|| progress.advance(1));
    drop(progress);
    let mut processed = processed.map_err(|error| match error {
        ProcessError::Record(error) => Failure::of_input(&error),
        other => Failure::of_input(&other).at(&name),
    })?;
    // Records with a campaign of their own know their days better than the plan of the study.
    if let Some(study) = study.as_ref().filter(|_| *of_the_study) {
        said.extend(study.give_temperatures(&mut processed.observations));
    }
    processed.notes.splice(0..0, said);
    processed.observations.write(folder.path()).or_failed()?;
    if let Some(tube) = tube {
        let points = &processed.observations.points;
        tube.write_within(folder.path(), &|id| points.iter().any(|p| p.point.id == id)).or_failed()?;
    }
    Rejection::write_all(&processed.corrections, &folder.path().join("corrections.csv")).or_failed()?;
    if args.plot {
        plot::write(&**source, &processed, folder.path())?;
    }
    if let Some(records) = records {
        let of = MadeOf::records(records).or_bad_input().map_err(|f| f.at(records))?;
        of.write(folder.path()).or_failed()?;
    }
    folder.commit()?;
    Ok(processed)
}

/// Says what was measured.
fn tell(processed: &Processed, out: &Path, ui: &Ui) -> Result<(), Failure> {
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
        n => format!(", {n} put right (corrections.csv)"),
    };
    let shown = out.display();
    let why = processed.observations.main_reason().map_or_else(String::new, |(count, first)| {
        format!("; {count} of these for one reason, first {}: {}", first.record, first.reason)
    });
    ui.note(format!(
        "{shown}: {}, {rejected} rejected (reasons in rejections.csv){corrected}{why}",
        number::counted(records, "record")
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

/// What `rijke process` writes; other files in its folder are kept.
static WRITTEN: [&str; 14] = [
    Ramp::FILE,
    HeatedTube::FILE,
    "rig.toml",
    "points.csv",
    "pings.csv",
    "clicks.csv",
    "ping-repeats.csv",
    "click-repeats.csv",
    "rejections.csv",
    "corrections.csv",
    "channels.toml",
    "observations.toml",
    MadeOf::FILE,
    "plots",
];

/// A folder of records, and the study that it belongs to, if any.
pub(crate) struct Opened {
    pub(crate) records: RecordFolder,
    pub(crate) study: Option<Study>,
    tube: Option<HeatedTube>,
}

/// Opens a folder of records, or of a study whose records lie in DIR/records.
pub(crate) fn open(dir: &Path) -> Result<Opened, Failure> {
    let below = dir.join("records");
    let (folder, study) =
        if dir.join("study.toml").exists() { (below.as_path(), Some(dir)) } else { (dir, dir.parent()) };
    let study = study.filter(|s| s.join("study.toml").exists()).map(crate::study::open).transpose()?;
    if let Some(study) = &study {
        study.is_the_rig_of(folder).or_bad_input()?;
    }
    let described = described(folder, study.as_ref())?;
    let mut records = RecordFolder::open_of(folder, described).or_bad_input()?;
    let tube = tube(&mut records)?;
    if let Some(study) = &study {
        records.name_microphones(&study.rig.microphones.names);
    }
    Ok(Opened { records, study, tube })
}

/// What is known of the records in `folder` where their manifest names no files: of a heated tube its
/// `tube.toml` says what the rig is, and else the study.
pub(crate) fn described(folder: &Path, study: Option<&Study>) -> Result<Described, Failure> {
    let Some(study) = study else { return Ok(Described::default()) };
    let points = study.campaign.operating_points();
    let tube = HeatedTube::read_within(folder, points.iter()).or_bad_input()?;
    let rig = match tube {
        Some(tube) => tube.rig.apparatus(),
        None => study.apparatus().or_bad_input()?,
    };
    Ok(Described { rig: Some(rig), points: Some(points) })
}

/// The heated tube of a folder of records, if it describes one; its points know what sound passes there.
fn tube(records: &mut RecordFolder) -> Result<Option<HeatedTube>, Failure> {
    let points: Vec<OperatingPoint> = records.set().points.iter().map(|p| p.point.clone()).collect();
    let tube = HeatedTube::read_within(records.folder(), points.iter()).or_bad_input()?;
    if let Some(tube) = &tube {
        records.fill_ways(|point| tube.way(point));
    }
    Ok(tube)
}

/// A positive finite number.
fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| v.is_finite() && *v > 0.0);
    value.ok_or_else(|| "not a positive number".to_owned())
}

fn table(processed: &Processed, ui: &Ui) {
    let head = [
        "point",
        "pings",
        "growth rate (1/s)",
        "+-",
        "frequency (rad/s)",
        "+-",
        "between repeats",
        "drift",
        "clicks",
        "top arrival (ms)",
        "+- (us)",
    ];
    // As many decimals as show the smallest error.
    let sds = |k: usize| {
        let pings = processed.observations.points.iter().filter_map(|p| p.ping.as_ref());
        pings.map(move |p| p.covariance[(k, k)].sqrt()).fold(1.0, f64::min)
    };
    let [n, m] = [0, 1].map(|k| (-sds(k).log10()).ceil().clamp(3.0, 7.0) as usize);
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
            repeats.map_or_else(String::new, |r| {
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
    ui.table(head, processed.observations.points.iter().zip(&processed.scatter).map(row));
}

fn ping(point: &PointObservations, show: impl Fn(rijke_numerics::C64, (f64, f64)) -> String) -> String {
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
