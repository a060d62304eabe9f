//! `rijke predict`: what the chosen model says of operating points.

use crate::{
    failure::{Classify, Failure},
    ui::Ui,
};
use rayon::prelude::*;
use rijke_flow::BaseStates;
use rijke_model::{Conditions, Misfit, SavedModel};
use rijke_rig::{Campaign, OperatingPoint};
use std::{fmt::Write as _, path::PathBuf};

/// Predict growth rate and frequency with their uncertainty, and the probability of instability, with a trained model.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  rijke predict my-rig/results/model.json --flow my-rig/base-flow --campaign my-rig/campaign.toml\n\n\
    Prints CSV: one row per hot operating point of the campaign whose base flow is known. Standard deviations are those of a\n\
    new measurement: parameters, base flow, noise and model error. The growth rate is taken as normal."
)]
pub(crate) struct Args {
    /// The model, as `rijke rank` saved it.
    model: PathBuf,
    /// Folder that `rijke flow` wrote: the base flow of the operating points.
    #[arg(long, value_name = "FLOWDIR")]
    flow: PathBuf,
    /// Campaign file with the operating points [default: Table 1 of Juniper & Yoko 2022].
    #[arg(long, value_name = "FILE")]
    campaign: Option<PathBuf>,
    /// File to write instead of printing.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

const HEAD: &str = "point,position_m,power_w,growth_rate_per_s,growth_rate_sd_per_s,angular_frequency_rad_per_s,\
    angular_frequency_sd_rad_per_s,probability_of_instability\n";

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let model = SavedModel::read(&args.model)
        .or_bad_input()
        .map_err(|f| f.remedy("Give the model.json that `rijke rank --flow` writes."))?;
    let states = BaseStates::read(&args.flow)
        .or_bad_input()
        .map_err(|f| f.remedy("Give the folder that `rijke flow` writes."))?;
    let campaign =
        args.campaign.as_deref().map_or(Ok(Campaign::juniper_yoko_2022()), Campaign::read).or_bad_input()?;
    let wanted = |p: &&OperatingPoint| p.power > 0.0 && states.points.contains_key(&p.id);
    let points: Vec<&OperatingPoint> = campaign.points.iter().filter(wanted).collect();
    if points.is_empty() {
        return Err(Failure::bad_input(format!(
            "{}: has no hot operating point of the campaign",
            args.flow.display()
        ))
        .remedy("Give the campaign whose points the base flow was inferred for, with --campaign."));
    }
    let misfit = Misfit::of(&model.noise);
    let row = |point: &&OperatingPoint| {
        let base = states.points[&point.id].clone();
        let conditions = Conditions { point: (*point).clone(), ambient: base.temperature[0], base };
        let found = model.predict(&conditions, &[model.rig.microphones.reference]).or_failed()?;
        let [growth, frequency] = [0, 1].map(|k| (found.values[k], found.sd(k, &misfit)));
        let unstable = 0.5 * libm::erfc(-growth.0 / (growth.1 * std::f64::consts::SQRT_2));
        let position = point.position.map_or_else(String::new, |x| x.to_string());
        let mut line = format!("{},{position},{}", point.id, point.power);
        for number in [growth.0, growth.1, frequency.0, frequency.1, unstable] {
            let _ = write!(line, ",{number}");
        }
        Ok(line + "\n")
    };
    let rows: Result<Vec<String>, Failure> = points.par_iter().map(row).collect();
    let text = format!("{HEAD}{}", rows?.concat());
    match &args.out {
        None => ui.say(text.trim_end()),
        Some(path) => {
            let partial = path.with_extension("partial");
            let written = std::fs::write(&partial, text).and_then(|()| std::fs::rename(&partial, path));
            written.or_bad_input().map_err(|f| f.at(path).remedy("Give a place in which you may write."))?;
        }
    }
    Ok(())
}
