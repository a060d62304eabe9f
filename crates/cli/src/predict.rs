//! `rijke predict`: what the chosen model says of operating points.

use crate::{
    failure::{Classify, Failure},
    staging::write_whole,
    ui::Ui,
};
use rayon::prelude::*;
use rijke_flow::BaseStates;
use rijke_inference::normal_cdf;
use rijke_model::{Conditions, Misfit, SavedModel};
use rijke_report::StabilityMap;
use rijke_rig::{Campaign, OperatingPoint};
use serde::Serialize;
use std::{fmt::Write as _, path::PathBuf};

/// Predict growth rate and frequency with their uncertainty, and the probability of instability, with a trained model.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  rijke predict my-rig/results/model.json --flow my-rig/base-flow --campaign my-rig/campaign.toml\n  \
    rijke predict my-rig/results/model.json --flow my-rig/base-flow --out stability.csv --map stability.svg\n\n\
    Prints CSV: one row per hot operating point of the campaign whose base flow is known. Standard deviations are those of a\n\
    new measurement: parameters, base flow, noise and model error. The growth rate is taken as normal. The map is bilinear\n\
    between these points."
)]
pub(crate) struct Args {
    #[command(flatten)]
    trained: Trained,
    /// File to write instead of printing.
    #[arg(long, value_name = "CSV")]
    out: Option<PathBuf>,
    /// Draw the stability map, contours of growth rate and probability over position and power, into this SVG file.
    #[arg(long, value_name = "SVG")]
    map: Option<PathBuf>,
}

/// A trained model and the operating points at which it is asked.
#[derive(clap::Args)]
pub(crate) struct Trained {
    /// The model, as `rijke rank` saved it.
    model: PathBuf,
    /// Folder that `rijke flow` wrote: the base flow of the operating points.
    #[arg(long, value_name = "FLOWDIR")]
    flow: PathBuf,
    /// Campaign file with the operating points [default: Table 1 of Juniper & Yoko 2022].
    #[arg(long, value_name = "FILE")]
    campaign: Option<PathBuf>,
}

/// The same, read.
pub(crate) struct Opened {
    pub(crate) model: SavedModel,
    states: BaseStates,
    /// Those with power and a base flow.
    pub(crate) points: Vec<OperatingPoint>,
}

/// What is predicted at one operating point; a value, then its standard deviation.
#[derive(Serialize)]
pub(crate) struct Row {
    pub(crate) point: String,
    position_m: Option<f64>,
    power_w: f64,
    pub(crate) growth_rate: [f64; 2],
    angular_frequency: [f64; 2],
    probability_of_instability: f64,
}

const HEAD: &str = "point,position_m,power_w,growth_rate_per_s,growth_rate_sd_per_s,angular_frequency_rad_per_s,\
    angular_frequency_sd_rad_per_s,probability_of_instability\n";

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let opened = args.trained.open()?;
    let rows = opened.predictions()?;
    let mut text = HEAD.to_owned();
    for row in &rows {
        let position = row.position_m.map_or_else(String::new, |x| x.to_string());
        let _ = write!(text, "{},{position},{}", row.point, row.power_w);
        for number in [row.growth_rate, row.angular_frequency].concat() {
            let _ = write!(text, ",{number}");
        }
        let _ = writeln!(text, ",{:e}", row.probability_of_instability);
    }
    if let Some(path) = &args.map {
        write_whole(path, map(&opened, &rows)?.svg().as_bytes())?;
    }
    match &args.out {
        None => ui.say(text.trim_end()),
        Some(path) => write_whole(path, text.as_bytes())?,
    }
    ui.result(&rows)
}

impl Trained {
    pub(crate) fn open(&self) -> Result<Opened, Failure> {
        let model = SavedModel::read(&self.model)
            .or_bad_input()
            .map_err(|f| f.remedy("Give the model.json that `rijke rank --flow` writes."))?;
        let states = BaseStates::read(&self.flow)
            .or_bad_input()
            .map_err(|f| f.remedy("Give the folder that `rijke flow` writes."))?;
        let campaign = self.campaign.as_deref().map_or(Ok(Campaign::juniper_yoko_2022()), Campaign::read);
        let wanted = |p: &OperatingPoint| p.power > 0.0 && states.points.contains_key(&p.id);
        let points: Vec<_> = campaign.or_bad_input()?.points.into_iter().filter(wanted).collect();
        if points.is_empty() {
            let problem = format!("{}: has no hot operating point of the campaign", self.flow.display());
            return Err(Failure::bad_input(problem)
                .remedy("Give the campaign whose points the base flow was inferred for, with --campaign."));
        }
        Ok(Opened { model, states, points })
    }
}

impl Opened {
    pub(crate) fn conditions(&self, point: &OperatingPoint) -> Conditions {
        let base = self.states.points[&point.id].clone();
        Conditions { point: point.clone(), ambient: base.temperature[0], base }
    }

    /// The prediction at every point, in the order of the campaign.
    pub(crate) fn predictions(&self) -> Result<Vec<Row>, Failure> {
        let misfit = Misfit::of(&self.model.noise);
        let row = |point: &OperatingPoint| {
            let microphones = [self.model.rig.microphones.reference];
            let found = self.model.predict(&self.conditions(point), &microphones).or_failed()?;
            let [growth_rate, angular_frequency] = [0, 1].map(|k| [found.values[k], found.sd(k, &misfit)]);
            let [mean, sd] = growth_rate;
            Ok(Row {
                point: point.id.clone(),
                position_m: point.position,
                power_w: point.power,
                growth_rate,
                angular_frequency,
                probability_of_instability: normal_cdf(mean / sd),
            })
        };
        self.points.par_iter().map(row).collect()
    }
}

/// The rows on the grid of all their positions and powers.
fn map(opened: &Opened, rows: &[Row]) -> Result<StabilityMap, Failure> {
    let sorted = |values: Vec<f64>| {
        let mut values = values;
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let positions = sorted(rows.iter().filter_map(|r| r.position_m).collect());
    let powers = sorted(rows.iter().map(|r| r.power_w).collect());
    if positions.len() < 2 || powers.len() < 2 {
        let problem = format!("{} positions and {} powers make no map", positions.len(), powers.len());
        return Err(Failure::bad_input(format!("--map: {problem}"))
            .remedy("Leave out --map, or give a base flow of two positions and two powers at least."));
    }
    let grid = |value: fn(&Row) -> f64| {
        let at = |power: f64, x: f64| {
            rows.iter().find(|r| r.power_w == power && r.position_m == Some(x)).map(value)
        };
        let row = |power: &f64| positions.iter().map(|x| at(*power, *x).unwrap_or(f64::NAN)).collect();
        powers.iter().map(row).collect()
    };
    Ok(StabilityMap {
        title: format!("Stability of {}", opened.model.rig.name),
        data: opened.model.kind,
        growth_rate: grid(|r| r.growth_rate[0]),
        probability: grid(|r| r.probability_of_instability),
        positions,
        powers,
    })
}
