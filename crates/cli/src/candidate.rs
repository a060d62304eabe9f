//! `rijke candidate`: checks a file of candidate models before anybody trains one.

mod derivatives;

use crate::{
    failure::{Classify, Failure},
    ui::Ui,
};
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use derivatives::{LEAST_SLOPE, TOLERANCE, taylor_slope};
use rijke_candidates::{Candidate, Catalogue, Effect, Here, Place, SYMBOLS, Surroundings, unit_fault};
use rijke_numerics::{C64, Jet, JetSpace, Order};
use rijke_rig::{Campaign, OperatingPoint, Rig};
use std::path::PathBuf;

/// Check candidate models: formulas, units, derivatives, finiteness over the campaign, and analyticity in s.
#[derive(clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(
    after_help = "Examples:\n  rijke candidate my-rig/candidates.toml\n  rijke candidate --symbols\n\n\
    Derivatives are compared with differences of the formula; units are those of the symbols and of the parameters."
)]
pub(crate) struct Args {
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    verb: Option<Verb>,
}

#[derive(clap::Subcommand)]
enum Verb {
    /// The same as `rijke candidate` with a file.
    Check(Options),
}

#[derive(clap::Args)]
struct Options {
    /// The file of candidates.
    #[arg(required_unless_present = "symbols")]
    file: Option<PathBuf>,
    /// List what a formula may name, with units, instead.
    #[arg(long, conflicts_with = "file")]
    symbols: bool,
    /// Rig file [default: the rig of Juniper & Yoko 2022].
    #[arg(long, value_name = "FILE")]
    rig: Option<PathBuf>,
    /// Campaign file [default: Table 1 of Juniper & Yoko 2022].
    #[arg(long, value_name = "FILE")]
    campaign: Option<PathBuf>,
}

/// The state at which laws are tried: a mode of the paper's tube, gas of a heated tube, its flow.
const S: C64 = C64::new(-12.0, 1070.0);
const AMBIENT_K: f64 = 293.15;
const HOT_K: f64 = 420.0;
const VELOCITY: f64 = 0.3;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let args = args.verb.as_ref().map_or(&args.options, |Verb::Check(options)| options);
    let Some(file) = args.file.as_deref().filter(|_| !args.symbols) else {
        return symbols(ui);
    };
    let catalogue = Catalogue::read(file)
        .or_bad_input()
        .map_err(|f| f.remedy("`rijke candidate --symbols` lists what a formula may name."))?;
    let rig = args.rig.as_deref().map_or(Ok(Rig::juniper_yoko_2022()), Rig::read).or_bad_input()?;
    let campaign = args.campaign.as_deref().map_or(Ok(Campaign::juniper_yoko_2022()), Campaign::read);
    let campaign = campaign.or_bad_input()?;
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY);
    table.set_header([
        "candidate",
        "parameters",
        "points",
        "first derivatives",
        "second",
        "analytic in s",
        "Taylor slope",
    ]);
    let (mut faults, mut answers) = (Vec::new(), Vec::new());
    for candidate in catalogue.candidates() {
        let found = examine(candidate, &rig, &campaign.points);
        answers.push(serde_json::json!({
            "id": candidate.id, "role": candidate.role, "parameters": candidate.parameters.len(), "points": found.points,
            "error_of_first_derivatives": found.errors[0], "error_of_second_derivatives": found.errors[1],
            "breach_of_analyticity": found.errors[2], "taylor_slope": found.taylor_slope,
        }));
        let [first, second, analytic] = found.errors.map(|e| format!("{e:.0e}"));
        let (id, count) = (candidate.id.clone(), candidate.parameters.len().to_string());
        let slope = found.taylor_slope.map_or_else(|| "exact".to_owned(), |s| format!("{s:.3}"));
        table.add_row([id, count, found.points.to_string(), first, second, analytic, slope]);
        faults.extend(found.faults.iter().map(|fault| format!("{}: {fault}", candidate.id)));
    }
    ui.say(table.to_string());
    if faults.is_empty() {
        ui.result(&answers)?;
        ui.say(
            "all in order; relative differences from difference quotients, and the order of the Taylor remainder (3 or more is right)",
        );
        return Ok(());
    }
    Err(Failure::bad_input(format!("{} faults\n{}", faults.len(), faults.join("\n")))
        .at(file)
        .remedy("Correct the formulas; where a law is not defined, choose another form or a prior that excludes the place."))
}

fn symbols(ui: &Ui) -> Result<(), Failure> {
    for meaning in &SYMBOLS {
        ui.say(format!("{:<10} {:<12} {}", meaning.name, meaning.unit, meaning.text));
    }
    let all =
        SYMBOLS.iter().map(|m| serde_json::json!({ "name": m.name, "unit": m.unit, "meaning": m.text }));
    ui.result(&all.collect::<Vec<_>>())
}

/// What was found of a candidate.
#[derive(Default)]
pub(crate) struct Found {
    /// Number of operating points at which it was tried.
    points: usize,
    /// Largest relative error of gradient and Hessian, and the largest breach of the Cauchy-Riemann equations.
    errors: [f64; 3],
    /// Smallest order of a Taylor remainder; none where two derivatives leave nothing.
    taylor_slope: Option<f64>,
    pub(crate) faults: Vec<String>,
}

/// Tries a candidate at every operating point where it acts.
pub(crate) fn examine(candidate: &Candidate, rig: &Rig, points: &[OperatingPoint]) -> Found {
    let mut found = Found::default();
    let quantiles = |p: f64| candidate.parameters.iter().map(|a| a.prior.quantile(p)).collect::<Vec<_>>();
    // Off the middle of the priors, where a parameter of mean zero would hide those that it multiplies.
    let (centre, low, high) = (quantiles(0.7), quantiles(0.025), quantiles(0.975));
    let mut used = vec![false; centre.len()];
    let (mut undefined, mut defined_hot) = (Vec::new(), false);
    for point in points {
        let effects: Vec<&Effect> = candidate.effects.iter().filter(|e| acts(e.place, point)).collect();
        if effects.is_empty() {
            continue;
        }
        found.points += 1;
        let temperature = if point.power > 0.0 { HOT_K } else { AMBIENT_K };
        let velocity = if point.power > 0.0 { VELOCITY } else { 0.0 };
        let gas = rig.gas.at(temperature, rig.pressure);
        let around = Surroundings::new(rig, point, &gas, AMBIENT_K, [velocity, velocity * gas.density]);
        for effect in effects {
            let at = |values: &[f64], s: C64| evaluate(effect, &around, values, s);
            // One parameter at a time at the ends of what its prior holds likely.
            let corners = (0..centre.len()).flat_map(|k| {
                [low[k], high[k]].map(|value| {
                    let mut values = centre.clone();
                    values[k] = value;
                    values
                })
            });
            let finite = |values: &[f64]| is_finite(&at(values, S));
            if !finite(&centre) || corners.into_iter().any(|values| !finite(&values)) {
                undefined.push((point, effect));
                continue;
            }
            defined_hot |= point.power > 0.0;
            let jet = at(&centre, S);
            for (k, used) in used.iter_mut().enumerate() {
                *used |= jet.gradient()[k] != C64::ZERO;
            }
            let errors = derivatives::errors(&jet, &centre, &at);
            found.errors = std::array::from_fn(|i| found.errors[i].max(errors[i]));
            if let Some(slope) = taylor_slope(&jet, &centre, &at) {
                found.taylor_slope = Some(found.taylor_slope.map_or(slope, |s| s.min(slope)));
            }
        }
    }
    for effect in &candidate.effects {
        if let Some(fault) = unit_fault(candidate, effect) {
            found.faults.push(format!("`{}`: {fault}", effect.law.text()));
        }
    }
    // A law of the hot heater may be undefined without power or flow, where it is not used.
    undefined.retain(|(point, _)| !(defined_hot && point.power == 0.0));
    if let Some((point, effect)) = undefined.first() {
        found.faults.push(format!(
            "`{}` is not finite at {} points, first at {}, within two standard deviations of the priors",
            effect.law.text(),
            undefined.len(),
            point.id
        ));
    }
    let names = ["first derivatives", "second derivatives", "the derivatives along and across the axis of s"];
    for (error, name) in found.errors.iter().zip(names).filter(|(e, _)| **e > TOLERANCE) {
        found.faults.push(format!("{name} differ by {error:.1e} (relative) from those of the formula"));
    }
    if let Some(slope) = found.taylor_slope.filter(|slope| *slope < LEAST_SLOPE) {
        found
            .faults
            .push(format!("what two derivatives leave falls with the power {slope:.2} of the step, not 3"));
    }
    let idle = candidate.parameters.iter().zip(&used).filter(|(_, used)| !**used);
    for (parameter, _) in idle.filter(|_| found.points > 0 && undefined.is_empty()) {
        found.faults.push(format!("the parameter {} has no effect at any operating point", parameter.name));
    }
    found
}

/// Whether an effect acts at an operating point.
fn acts(place: Place, point: &OperatingPoint) -> bool {
    match place {
        Place::Heater | Place::HeaterMiddle => point.heater,
        Place::Thermocouples => point.thermocouples,
        Place::Prongs | Place::ProngEnd => point.position.is_some(),
        Place::Tube | Place::UpstreamEnd | Place::DownstreamEnd | Place::BothEnds => true,
    }
}

/// The law with all its derivatives; s is the last seed. Wall and ends, which other candidates give, are those of
/// simple laws with the same dependence on s.
fn evaluate(effect: &Effect, around: &Surroundings, values: &[f64], s: C64) -> Jet {
    let space = JetSpace::new(values.len() + 1, Order::Second);
    let seeds: Vec<Jet> = values.iter().enumerate().map(|(k, v)| space.seed(k, C64::new(*v, 0.0))).collect();
    let s = space.seed(values.len(), s);
    let (mu, ep) = (s.sqrt().scale(C64::new(0.4, 0.0)), s.sqrt().scale(C64::new(1e-6, 0.0)));
    let reflection = s.scale(C64::new(1e-6, 0.0)).shift(C64::new(-0.997, 0.08));
    let wall = (effect.place != Place::Tube).then_some([&mu, &ep]);
    let here = Here { space, surroundings: around, s: &s, wall, levine_schwinger: Some(&reflection) };
    effect.law.evaluate(&here, &seeds)
}

fn is_finite(jet: &Jet) -> bool {
    let finite = |v: &C64| v.re.is_finite() && v.im.is_finite();
    finite(&jet.value()) && jet.gradient().iter().all(finite) && jet.hessian_packed().iter().all(finite)
}
