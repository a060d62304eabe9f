//! `rijke sensitivity`: which small change would make an operating point of a trained model more stable.

use crate::{
    failure::{Classify, Failure},
    modes::{along, best, curves_of, print_advice},
    predict::Trained,
    staging::write_whole,
    ui::Ui,
};
use rijke_model::{PointModel, Response, Workspace};
use rijke_numerics::Order;
use rijke_report::ModesFigure;
use serde_json::json;
use std::path::PathBuf;

/// Say where a small device or change of the tube would stabilise an operating point most, and which parameters its growth rate
/// hangs on, by a trained model.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  rijke sensitivity results/model.json --flow base-flow --campaign campaign.toml\n  \
    rijke sensitivity results/model.json --flow base-flow --point H180-25,H180-75 --plot sensitivity.svg --along along.csv\n\n\
    To first order, each change alone. The effect of a parameter is that of one of its standard deviations."
)]
pub(crate) struct Args {
    #[command(flatten)]
    trained: Trained,
    /// Operating points [default: the one with the highest predicted growth rate].
    #[arg(long = "point", value_name = "ID", value_delimiter = ',')]
    points: Vec<String>,
    /// Draw the mode shapes and the sensitivities along x into this SVG file.
    #[arg(long, value_name = "SVG")]
    plot: Option<PathBuf>,
    /// Write them into this CSV file.
    #[arg(long, value_name = "CSV")]
    along: Option<PathBuf>,
}

/// Stations in each segment of the tube.
const SAMPLES: usize = 12;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let opened = args.trained.open()?;
    let known = || opened.points.iter().map(|p| p.id.as_str()).collect::<Vec<_>>().join(", ");
    let wanted = if args.points.is_empty() {
        let rows = opened.predictions()?;
        let worst = rows.iter().max_by(|a, b| a.growth_rate[0].total_cmp(&b.growth_rate[0]));
        worst.map(|row| row.point.clone()).into_iter().collect()
    } else {
        args.points.clone()
    };
    let assembly = opened.model.assembly().or_failed()?;
    let knowledge = opened.model.knowledge();
    let (mut curves, mut answers) = (Vec::new(), Vec::new());
    for id in &wanted {
        let point = opened.points.iter().find(|p| p.id == *id).ok_or_else(|| {
            Failure::bad_input(format!("--point {id}: no hot operating point of that name has a base flow"))
                .remedy(format!("Give one of {}.", known()))
        })?;
        let conditions = opened.conditions(point);
        let model =
            PointModel::new(&assembly, &conditions, &[assembly.rig.microphones.reference]).or_failed()?;
        let work = &mut Workspace::default();
        let values: Vec<f64> = assembly
            .parameters()
            .iter()
            .map(|p| {
                knowledge.names.iter().position(|n| *n == p.name).map_or(f64::NAN, |k| knowledge.mean[k])
            })
            .collect();
        let (root, stations) = model.along(&values, SAMPLES, work).or_failed()?;
        let Response { s, .. } = model.respond(&values, Order::First, work).or_failed()?;
        let effect = |(i, name): (usize, &String)| {
            let sd =
                knowledge.names.iter().position(|n| n == name).map(|k| knowledge.covariance[(k, k)].sqrt());
            (name.clone(), sd.unwrap_or(f64::NAN) * s.gradient()[i].re)
        };
        let names: Vec<String> = assembly.parameters().iter().map(|p| p.name.clone()).collect();
        let mut effects: Vec<(String, f64)> = names.iter().enumerate().map(effect).collect();
        effects.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        curves.push(curves_of(root.s, &stations));
        answers.push((id, effects));
    }
    let advice = best(&curves);
    for ((id, effects), curve) in answers.iter().zip(&curves) {
        ui.say(format!("{id}: growth rate {:.3} 1/s at {:.2} Hz", curve.growth_rate, curve.frequency_hz));
        let shown = effects.iter().take(6).map(|(name, effect)| format!("{name} {effect:+.3}"));
        ui.say(format!("  one sd of a parameter, 1/s: {}", shown.collect::<Vec<_>>().join(", ")));
    }
    print_advice(&curves, &advice, ui);
    let points = answers.iter().zip(&curves).map(|((id, effects), c)| {
        json!({ "point": id, "growth_rate_per_s": c.growth_rate, "frequency_hz": c.frequency_hz, "effect_of_one_sd_per_s": effects })
    });
    ui.result(&json!({ "points": points.collect::<Vec<_>>(), "changes": advice }))?;
    if let Some(path) = &args.along {
        let rows = answers.iter().zip(&curves).map(|((id, _), mode)| ((*id).clone(), mode));
        let text = along("point", rows);
        write_whole(path, text.as_bytes())?;
        ui.note(format!("wrote {}", path.display()));
    }
    if let Some(path) = &args.plot {
        let range = |of: fn(&rijke_report::ModeCurves) -> f64, margin: f64| {
            let values = curves.iter().map(of);
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            [low - margin, high + margin]
        };
        let devices = wanted.iter().filter_map(|id| opened.points.iter().find(|p| p.id == *id)?.position);
        let figure = ModesFigure {
            title: format!("What small changes do to {}", wanted.join(", ")),
            growth_rate: range(|c| c.growth_rate, 2.0),
            frequency_hz: range(|c| c.frequency_hz, 5.0),
            modes: curves.clone(),
            poles: Vec::new(),
            devices: devices.collect(),
        };
        write_whole(path, figure.svg().as_bytes())?;
        ui.note(format!("wrote {}", path.display()));
    }
    Ok(())
}
