//! `rijke check-model`: can the evidence and the standard deviations of one model be trusted on these observations?

use crate::{
    failure::{Classify, Failure},
    number,
    staging::write_whole,
    ui::Ui,
};
use rijke_inference::{
    AssessOptions, Assessment, Draws, MapOptions, Parameters, Posterior, Record, RefereeKind,
};
use rijke_model::{Assembly, Conditions, Noise, Observed, PointModel, Predictor, data_of};
use rijke_numerics::Streams;
use rijke_rig::{Observations, Rig};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Check one model on observations: its evidence by other methods, and its estimates on data that it simulates itself.
#[derive(clap::Args)]
#[command(name = "check-model")]
#[command(
    after_help = "Example:\n  rijke check-model virtual-rig --model wall.rayleigh,ends.calibrated,prongs.6\n  \
    rijke check-model virtual-rig --referee nested --referee-error 0.3\n\n\
    Fits the cold points without heater and thermocouples, all parameters at once, with floating noise. Then: starts\n\
    elsewhere, importance sampling, doubled priors; on demand nested sampling or NUTS; and refits of simulated data, for bias\n\
    and for the share of stated intervals that hold the truth."
)]
pub(crate) struct Args {
    /// Folder of records with their observations, or of observations.
    dir: PathBuf,
    /// Candidates that make the model, one per role.
    #[arg(long, value_delimiter = ',', default_value = "wall.rayleigh,ends.calibrated,prongs.6")]
    model: Vec<String>,
    /// Data sets to simulate and refit; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 100)]
    sets: usize,
    /// Compare the evidence with a slow method that needs no Gaussian approximation.
    #[arg(long)]
    referee: Option<Judge>,
    /// Statistical error of the referee, nats; its cost grows with the inverse square.
    #[arg(long, value_name = "NATS", default_value_t = 0.3, value_parser = number::positive)]
    referee_error: f64,
    /// Write all results of the checks as JSON to this file.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Write 1000 draws of the posterior (Laplace's Gaussian) to this file, for `arviz.from_json` in Python.
    #[arg(long, value_name = "FILE")]
    draws: Option<PathBuf>,
    /// Seed of every random number.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// The slow methods on offer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Judge {
    /// Nested sampling.
    Nested,
    /// The gradient sampler NUTS with bridge sampling; only if the program was built with the feature `nuts`.
    Nuts,
}

impl Judge {
    /// The referee, or what to do to get it.
    pub(crate) fn kind(self) -> Result<RefereeKind, Failure> {
        match self {
            Self::Nested => Ok(RefereeKind::Nested),
            Self::Nuts if cfg!(feature = "nuts") => Ok(RefereeKind::Nuts),
            Self::Nuts => Err(Failure::bad_input("--referee nuts: this program was built without NUTS")
                .remedy("Build it with `cargo build --release -p rijke-cli --features nuts`, or use --referee nested.")),
        }
    }
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let referee = args.referee.map(|judge| Ok((judge.kind()?, args.referee_error))).transpose()?;
    let below = args.dir.join("observations");
    let folder = if below.is_dir() { &below } else { &args.dir };
    let observations = Observations::read(folder)
        .or_bad_input()
        .map_err(|f| f.remedy(format!("Run `rijke process {}` first.", args.dir.display())))?;
    let observed = observed(&observations).map_err(|f| f.at(folder))?;
    let assembly = assembly(&observations.rig, &args.model)?;
    let microphones: Vec<usize> = (0..observations.rig.microphones.positions.len()).collect();
    let points = observed
        .iter()
        .map(|o| Ok(PointModel::new(&assembly, &o.conditions, &microphones)?.starting_from(o.ping.s)))
        .collect::<Result<Vec<_>, rijke_model::ModelError>>()
        .or_bad_input()?;
    let predictor = Predictor::new(points, assembly.parameters().len());
    let data = data_of(&observed, &microphones, &Noise::FLOATED).or_bad_input()?;
    let parameters = Parameters::new(assembly.parameters().to_vec()).or_bad_input()?;
    let posterior = Posterior::new(&predictor, &data, &parameters).or_failed()?;
    let streams = Streams::new(args.seed);

    let progress = ui.progress("checks", 2);
    let options = AssessOptions { streams, referee, ..AssessOptions::default() };
    let found = posterior.assess(&options).or_failed()?;
    progress.advance(1);
    let check = match args.sets {
        0 => None,
        sets => Some(posterior.check(&found.fit, &MapOptions::default(), sets, streams).or_failed()?),
    };
    drop(progress);

    let model = args.model.join(" + ");
    if let Some(file) = &args.record {
        write(file, &Record::new(&model, &parameters, &found))?;
    }
    if let (Some(file), Ok(laplace)) = (&args.draws, &found.laplace) {
        write(file, &Draws::new(&parameters, laplace, 1000, streams).or_failed()?)?;
    }
    ui.result(&Record::new(&model, &parameters, &found))?;
    ui.say(format!("{model} on {} operating points", observed.len()));
    say_evidence(ui, &found);
    if let Some(check) = check {
        ui.say(format!("{} simulated data sets, {} without a fit", check.sets, check.failed));
        ui.say(format!(
            "{:<12} {:>12} {:>12} {:>10} {:>12} {:>12} {:>8} {:>8}",
            "parameter", "value", "bias", "+-", "scatter", "stated sd", "in 1 sd", "in 2 sd"
        ));
        for p in &check.parameters {
            ui.say(format!(
                "{:<12} {:>12.5e} {:>12.2e} {:>10.1e} {:>12.3e} {:>12.3e} {:>8.2} {:>8.2}",
                p.name, p.truth, p.bias, p.bias_error, p.scatter, p.stated_sd, p.within_1_sd, p.within_2_sd
            ));
        }
    }
    Ok(())
}

fn observed(observations: &Observations) -> Result<Vec<Observed>, Failure> {
    let cold = |p: &rijke_rig::OperatingPoint| p.power == 0.0 && !p.heater && !p.thermocouples;
    let mut all = Vec::new();
    for point in observations.points.iter().filter(|p| cold(&p.point)) {
        if let Some(ping) = point.ping.clone() {
            let conditions = Conditions::of_the_day(&observations.rig, point).or_bad_input()?;
            all.push(Observed { conditions, ping });
        }
    }
    if all.is_empty() {
        let none = "holds no ping of a cold point without heater and thermocouples";
        return Err(Failure::bad_input(none)
            .remedy("Record and process row C3 of the campaign: `rijke lab --row C3`."));
    }
    Ok(all)
}

fn assembly(rig: &Rig, ids: &[String]) -> Result<Assembly, Failure> {
    let catalogue = rijke_studies::catalogue().or_failed()?;
    let mut chosen = Vec::new();
    for id in ids {
        let candidate = catalogue.get(id).ok_or_else(|| {
            Failure::bad_input(format!("--model: there is no candidate '{id}'")).remedy(
                "Name one candidate per role, such as wall.rayleigh,ends.calibrated,prongs.6 (files in fixtures/candidates).",
            )
        })?;
        chosen.push(candidate.clone());
    }
    Assembly::new(rig.clone(), chosen).or_bad_input()
}

fn write(file: &Path, what: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(what).or_failed()?;
    write_whole(
        file,
        (text
            + "
")
        .as_bytes(),
    )
}

fn say_evidence(ui: &Ui, found: &Assessment) {
    match &found.laplace {
        Ok(laplace) => {
            let e = laplace.evidence;
            ui.say(format!(
                "Laplace: ln ML {:.3} = ln BFL {:.3} + ln OF {:.3} nats; second derivatives are {:.1e} of the Hessian",
                e.ln_marginal,
                e.ln_best_fit,
                e.ln_occam,
                laplace.curvature_ratio()
            ));
        }
        Err(reason) => ui.say(format!("no evidence: {reason}")),
    }
    if let Some(verdict) = &found.health.referee {
        ui.say(verdict.to_string());
    }
    if let Some(i) = found.health.importance {
        ui.say(format!(
            "importance sampling: ln ML {:.3} +- {:.3} nats, Pareto k-hat {:.2} (good below {:.2})",
            i.ln_marginal,
            i.standard_error,
            i.k_hat,
            i.k_limit()
        ));
    }
    for (name, change) in &found.health.doubled_prior {
        let change = change.map_or("no maximum".to_owned(), |c| format!("{c:+.2} nats"));
        ui.say(format!("prior sd of {name} doubled: {change}"));
    }
    for (direction, left) in &found.health.unidentified {
        ui.say(format!(
            "the data say little of {direction}: {:.0} % of the prior variance is left",
            100.0 * left
        ));
    }
    let verdict = match &found.health.warnings[..] {
        [] => "trusted".to_owned(),
        warnings => warnings.join("; "),
    };
    ui.say(format!("verdict: {verdict} ({} model calls)", found.health.calls.total()));
}
