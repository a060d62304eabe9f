//! `rijke infer`: unknown numbers of network files from measured modes, and which file explains them best.

mod modes;
mod network;

use crate::{
    failure::{Classify, Failure},
    staging::write_whole,
    ui::Ui,
};
use modes::Measured;
use network::Template;
use rijke_inference::{
    Data, Forward, ForwardError, Laplace, MapOptions, NoiseGroup, Observation, Posterior, Prediction,
};
use rijke_numerics::{Matrix, Order};
use serde_json::json;
use std::path::PathBuf;

/// Infer unknown numbers of acoustic networks (a flame's gain and delay, an end's loss, a length) from measured growth rates and
/// frequencies, and rank the networks by evidence.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  rijke infer examples/ducted-flame/n-tau.toml examples/ducted-flame/second-order.toml \
    --data examples/ducted-flame/modes.csv --fitted fitted.toml\n\n\
    A network file (docs/network-file.md) with \"$name\" in the place of numbers. A name is an unknown, with [unknown.name] and its prior, or a column\n\
    of the data, in which each row is one measured mode with its standard deviations. Derivatives are central differences; noise\n\
    is the stated one plus a model error that floats, one for growth rates and one for frequencies."
)]
pub(crate) struct Args {
    /// Network files that compete.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Measured modes: growth_rate_per_s, growth_rate_sd_per_s, frequency_hz, frequency_sd_hz, and a column for every $name that
    /// is no unknown.
    #[arg(long, value_name = "CSV")]
    data: PathBuf,
    /// Write the file with the most evidence, its unknowns at their most probable values (columns of the data as in the row with the highest growth rate).
    #[arg(long, value_name = "FILE")]
    fitted: Option<PathBuf>,
}

/// A network file and what was inferred of it.
struct Found {
    template: Template,
    values: Vec<f64>,
    laplace: Laplace,
    /// Model error of growth rates, 1/s, and of frequencies, Hz.
    noise: [f64; 2],
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let measured = Measured::read(&args.data)?;
    let templates = args.files.iter().map(|f| Template::read(f, &measured)).collect::<Result<Vec<_>, _>>()?;
    let progress = ui.progress("networks", templates.len() as u64);
    let mut found = Vec::new();
    for template in templates {
        found.push(infer(template, &measured)?);
        progress.advance(1);
    }
    drop(progress);
    found.sort_by(|a, b| b.laplace.evidence.ln_marginal.total_cmp(&a.laplace.evidence.ln_marginal));
    ui.say(format!("{} measured modes", measured.rows.len()));
    ui.say(format!("{:>10} {:>10} {:>10}   network", "ln BFL", "ln OF", "ln ML"));
    for f in &found {
        let e = f.laplace.evidence;
        let file = f.template.path.display();
        ui.say(format!("{:>10.2} {:>10.2} {:>10.2}   {file}", e.ln_best_fit, e.ln_occam, e.ln_marginal));
        for ((p, value), sd) in f.template.unknowns.iter().zip(&f.values).zip(f.laplace.sd()) {
            ui.say(format!("{:>34} = {value:.5e} +- {sd:.1e} {}", p.name, p.unit));
        }
        let [growth, frequency] = f.noise;
        ui.say(format!("{:>34} = {growth:.3} 1/s, {frequency:.3} Hz", "model error"));
    }
    if let (Some(path), Some(best)) = (&args.fitted, found.first()) {
        let row = measured.rows.iter().max_by(|a, b| a.mode[0].total_cmp(&b.mode[0]));
        let text = best.template.text(&best.values, row.unwrap_or(&measured.rows[0]))?;
        write_whole(path, text.as_bytes())?;
        ui.note(format!("wrote {}", path.display()));
    }
    let answers = found.iter().map(|f| {
        let e = f.laplace.evidence;
        let unknowns = f.template.unknowns.iter().zip(&f.values).zip(f.laplace.sd());
        let unknowns = unknowns.map(|((p, value), sd)| json!({ "name": p.name, "unit": p.unit, "value": value, "sd": sd }));
        json!({
            "file": f.template.path, "ln_best_fit": e.ln_best_fit, "ln_occam": e.ln_occam, "ln_marginal": e.ln_marginal,
            "unknowns": unknowns.collect::<Vec<_>>(), "model_error": f.noise,
        })
    });
    ui.result(&answers.collect::<Vec<_>>())
}

fn infer(template: Template, measured: &Measured) -> Result<Found, Failure> {
    let observation = |(k, row): (usize, &modes::Row)| {
        let [growth, frequency] = row.sd;
        Observation::new(format!("row {}", k + 1), row.mode.to_vec())
            .with_floor(Matrix::diagonal(&[growth * growth, frequency * frequency]))
            .with_independent_noise(0, &[0])
            .with_independent_noise(1, &[1])
    };
    let observations = measured.rows.iter().enumerate().map(observation).collect();
    let groups = vec![NoiseGroup::floated("growth rate", "1/s"), NoiseGroup::floated("frequency", "Hz")];
    let data = Data::new(observations, groups).or_bad_input()?;
    let parameters = template.parameters()?;
    let model = Model { template: &template, measured };
    let at = |f: Failure| f.at(&template.path);
    let posterior = Posterior::new(&model, &data, &parameters).or_bad_input().map_err(at)?;
    let fit = posterior.map(&MapOptions::default()).or_failed().map_err(at)?;
    if !fit.stop.converged() {
        return Err(at(Failure::failed(format!("the most probable unknowns were not found: {}", fit.stop))
            .remedy("Give priors nearer to the truth, or fewer unknowns.")));
    }
    let mut laplace = posterior.laplace(&fit).or_failed().map_err(at)?;
    laplace.evidence.datapoints = measured.rows.len();
    let noise = [0, 1].map(|g| fit.noise.get(g).map_or(f64::NAN, |n| n.sd));
    Ok(Found { values: fit.parameters, laplace, noise, template })
}

/// The modes of every row as functions of the unknowns.
struct Model<'a> {
    template: &'a Template,
    measured: &'a Measured,
}

/// Step of the central differences, in prior standard deviations: their error is some 1e-8 of the value.
const STEP: f64 = 1e-4;

impl Forward for Model<'_> {
    fn predict(&self, unknowns: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let all = |values: &[f64]| -> Result<Vec<f64>, ForwardError> {
            let modes = self.measured.rows.iter().map(|row| self.template.mode(values, row));
            let modes: Result<Vec<[f64; 2]>, _> = modes.collect();
            modes.map(|m| m.concat()).map_err(ForwardError::recoverable)
        };
        let values = all(unknowns)?;
        let mut jacobian = Matrix::default();
        if order >= Order::First {
            jacobian = Matrix::zeros(values.len(), unknowns.len());
            for (i, parameter) in self.template.unknowns.iter().enumerate() {
                let width = parameter.prior.quantile(0.84) - parameter.prior.quantile(0.16);
                let step = 0.5 * STEP * width;
                let side = |sign: f64| {
                    let mut moved = unknowns.to_vec();
                    moved[i] += sign * step;
                    all(&moved)
                };
                let (up, down) = (side(1.0)?, side(-1.0)?);
                for (row, (up, down)) in up.iter().zip(&down).enumerate() {
                    jacobian[(row, i)] = (up - down) / (2.0 * step);
                }
            }
        }
        Ok(Prediction { values, jacobian, curvature: Vec::new() })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}
