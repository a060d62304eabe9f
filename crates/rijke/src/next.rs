//! `rijke next`: what to measure next, by the information that it would bring.

use crate::{figure, number, ui::Ui};
use rijke_draw::plot_svg;
use rijke_engine::folder::{Ranked, condition, grid, of_the_engine, warn_of_ranking};
use rijke_engine::run::{
    Aim, AskedPoint, MicrophoneChoice, MicrophoneTable, Next, Step, Suggestion, Wish, microphones, next,
    over_map, with_points,
};
use rijke_intake::foresee;
use rijke_numerics::{Failed, words::fixed};
use std::path::PathBuf;

/// Say what to measure next: the expected information of further operating points, and a plan of several.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke next examples/quarter-wave\n  \
    rijke next examples/quarter-wave --models --map x_g,Q --plot next.svg\n  \
    rijke next examples/quarter-wave --about x_g=0.24,Q=60 --points 4\n  \
    rijke next examples/quarter-wave --microphones\n\n\
    Possible points are those of the stage, measured (a repeat) or not, or those given with --at or --map. Each is judged by the\n\
    information in nats that it is expected to bring: about the parameters of the model that went on; about that model against\n\
    its rival (the expected logarithm of the Bayes factor if the first is right, and if the second is); about which of several\n\
    open models is right; about the growth rate that --about names. The table [cost] of study.toml says what a point and an\n\
    installation cost; with it points are ordered by nats per hour. docs/next.md says what the numbers mean.")]
pub(crate) struct Args {
    /// Folder of a study that was ranked.
    dir: PathBuf,
    /// The stage whose models are meant [default: the last].
    #[arg(long, value_name = "ID")]
    stage: Option<String>,
    /// How many points to plan.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=20))]
    points: u8,
    /// Plan the measurements that best determine the growth rate at this condition (SI units), which is not
    /// measured itself.
    #[arg(long, value_name = "FACTOR=VALUE,...", conflicts_with = "models")]
    about: Option<String>,
    /// Plan to tell the model from its rival or, where several models are open, which of them is right.
    #[arg(long)]
    models: bool,
    /// A point that may be measured, values in SI units; may be repeated.
    #[arg(long, value_name = "FACTOR=VALUE,...")]
    at: Vec<String>,
    /// Points that may be measured: a grid of two factors between the lowest and the highest value of each in
    /// the campaign.
    #[arg(long, value_name = "X,Y", conflicts_with = "at")]
    map: Option<String>,
    /// Assume that the new measurements give growth rates and frequencies only, even if mode shapes trained
    /// the model.
    #[arg(long)]
    without_pressures: bool,
    /// Judge microphones instead of points: what is lost without each, and what another would add, if every
    /// point is visited once more.
    #[arg(long, conflicts_with_all = ["plot", "without_pressures", "points"])]
    microphones: bool,
    /// Where a microphone may be added, m from the upstream end; may be repeated [default: every twentieth of
    /// each duct].
    #[arg(long, value_name = "M", requires = "microphones", value_parser = number::finite)]
    place: Vec<f64>,
    /// Draw the information over the factors into this file, which ends in .svg or .pdf.
    #[arg(long, value_name = "FILE", value_parser = figure::file)]
    plot: Option<PathBuf>,
}

/// Rows that are printed; `--json` has all.
const SHOWN: usize = 12;

/// Information on the choice of models below which a plan tells nothing of it, nats.
const NO_DIFFERENCE: f64 = 1e-3;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let dir = &args.dir;
    let ranked = Ranked::open(dir, args.stage.as_deref(), ui)?;
    let rivals = ranked.rivals()?;
    let Ranked { study, observed, stage, every, model } = ranked;
    let wrong = |e: rijke_engine::EngineError| of_the_engine(&e, dir);
    let asked = match &args.map {
        Some(text) => {
            let grid = grid(text, &study, &stage.points)?;
            over_map(&study, &stage.points, &grid, &AskedPoint::default()).map_err(wrong)?
        }
        None => args.at.iter().map(|text| condition("--at", text)).collect::<Result<_, _>>()?,
    };
    let about: Vec<_> = args.about.iter().map(|text| condition("--about", text)).collect::<Result<_, _>>()?;
    let among = stage.points.clone();
    let (mut study, places) = with_points(&study, &among, &[asked, about].concat()).map_err(wrong)?;
    foresee(&mut study, &places, ui)?;
    let (candidates, about) = places.split_at(places.len() - usize::from(args.about.is_some()));
    let wish = Wish {
        aim: match (args.models, about.first()) {
            (true, _) => Aim::Models,
            (false, Some(_)) => Aim::Quantity,
            (false, None) => Aim::Parameters,
        },
        candidates: if candidates.is_empty() { every } else { candidates.to_vec() },
        about: about.first().copied(),
        points: usize::from(args.points),
        without_pressures: args.without_pressures,
    };
    if args.microphones {
        let found = microphones(&study, &observed, &model, &rivals, &wish, &args.place).map_err(wrong)?;
        print_microphones(ui, &found);
        return ui.result(&found);
    }
    warn_of_ranking(dir, &stage.id, ui);
    let found = next(&study, &observed, &model, &rivals, &wish).map_err(wrong)?;
    if let Some(path) = &args.plot {
        figure::write(path, &plot_svg(&found.plot(&study.campaign, observed.kind)), ui)?;
    }
    print(ui, &found, args.about.as_deref());
    ui.result(&found)
}

fn print(ui: &Ui, found: &Next, about: Option<&str>) {
    let names = |k: usize| {
        let of = |m: &std::collections::BTreeMap<String, String>| m.values().cloned().collect::<Vec<_>>();
        let (all, other) = (of(&found.models[k]), of(&found.models[1 - k.min(1)]));
        // The same candidates at another maximum of their posterior.
        let alike = all == other;
        let own: Vec<String> = all.into_iter().filter(|id| alike || !other.contains(id)).collect();
        format!("{}{}", own.join(" + "), if alike && k > 0 { " at another maximum" } else { "" })
    };
    if found.models.len() > 1 {
        ui.say(format!("{}: {} against {}", found.stage, names(0), names(1)));
    }
    if let Some(entropy) = found.entropy {
        ui.say(format!(
            "{} models are undecided (entropy {entropy:.3} nats). Column `which model` is the part of it that a point is expected to resolve",
            found.models.len()
        ));
    }
    let hours = |h: Option<f64>| h.map_or(String::new(), |h| format!("{h:.2}"));
    let number = |v: Option<f64>| v.map_or(String::new(), |v| fixed(v, 3));
    let row = |s: &Suggestion| {
        let [first, second] = [0, 1].map(|k| number(s.models.map(|m| m[k])));
        let (parameters, nats) = (number(Some(s.parameters)), number(Some(s.nats)));
        let point = format!("{}{}", s.point, if s.repeat { " (repeat)" } else { "" });
        [parameters, first, second, number(s.which), number(s.quantity), nats, hours(s.hours), point]
    };
    let head =
        ["parameters", "if first right", "if second right", "which model", "asked", "aim", "hours", "point"];
    let rows: Vec<_> = found.points.iter().take(SHOWN).map(row).collect();
    let filled: Vec<usize> = (0..head.len()).filter(|k| rows.iter().any(|r| !r[*k].is_empty())).collect();
    let rows = rows.into_iter().map(|row| filled.iter().map(move |k| row[*k].clone()).collect::<Vec<_>>());
    ui.table(filled.iter().map(|k| head[*k]), rows);
    if found.points.len() > SHOWN {
        ui.say(format!("  and {} more", found.points.len() - SHOWN));
    }
    for (point, why) in found.left_out.iter().take(SHOWN) {
        ui.note(format!("{point} is left out: {why}"));
    }
    let [plan, greedy] = found.total.map(|nats| fixed(nats, 3));
    ui.say(format!("Plan: {plan} nats together ({greedy} before points were exchanged)"));
    if found.aim == Aim::Models && found.total[0] < NO_DIFFERENCE {
        ui.say("No measurement at these points distinguishes the models: they predict the same");
    }
    let row = |step: &Step| [fixed(step.adds, 3), hours(step.hours), step.point.clone()];
    let kept = |k: &usize| *k != 1 || found.plan.iter().any(|step| step.hours.is_some());
    let filled: Vec<usize> = (0..3).filter(kept).collect();
    let rows =
        found.plan.iter().map(row).map(|row| filled.iter().map(move |k| row[*k].clone()).collect::<Vec<_>>());
    ui.table(filled.iter().map(|k| ["adds, nats", "hours", "point"][*k]), rows);
    if let Some(of) = found.factor.filter(|_| found.aim == Aim::Models) {
        let [first, second] = of.map(|[mean, sd]| format!("{mean:.1} +- {sd:.1}"));
        ui.say(format!("ln of the Bayes factor by the plan: {first} if the first model is right, {second} if the second is"));
    }
    if let (Some([now, then]), Some(about)) = (found.quantity_sd, about) {
        ui.say(format!("Growth rate at {about}: sd {now:.3} 1/s now, {then:.3} 1/s after the plan"));
    }
    if let Some((point, nats)) = &found.further {
        let nats = fixed(*nats, 3);
        ui.say(format!("After it, the best further point would add {nats} nats: {point}"));
    }
}

fn print_microphones(ui: &Ui, found: &MicrophoneTable) {
    let ([bare, all], points) = (found.total, found.points.len());
    ui.say(format!(
        "{}: measuring all {points} points once more gives an expected {bare:.3} nats by growth rates and frequencies",
        found.stage
    ));
    ui.say(format!("With the pressures of the microphones in use it gives {all:.3} nats"));
    let row = |m: &MicrophoneChoice| {
        let role = m.takes_its_role.as_ref();
        let note = role.map(|other| format!(" (the reference: without it, {other} takes its role)"));
        let name = format!("{}{}", m.microphone, note.unwrap_or_default());
        [format!("{:.3}", m.nats), format!("{:.3}", m.at), name]
    };
    ui.table(["nats lost", "x (m)", "microphone in use"], found.in_use.iter().map(row));
    ui.table(["nats added", "x (m)", "another microphone"], found.further.iter().take(SHOWN).map(row));
    if found.further.len() > SHOWN {
        ui.say(format!("  and {} more", found.further.len() - SHOWN));
    }
    for (point, why) in found.left_out.iter().take(SHOWN) {
        ui.note(format!("{point} is left out: {why}"));
    }
    if !found.further.first().is_some_and(|m| m.nats >= found.worth) {
        ui.say(format!("None is worth adding: each brings less than {} nats at these points", found.worth));
    }
}
