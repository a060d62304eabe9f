//! `rijke predict`: what a trained model says of operating points, measured or not.

mod responses;

use crate::{figure, ui::Ui};
use rijke_engine::folder::{
    Forecasts, Ranked, RankedResponses, condition, forecast_csv, grid, how_many, of_the_engine, surroundings,
};
use rijke_engine::run::{AskedPoint, Unpredicted, forecast, nearest, over_map, stability, with_points};
use rijke_intake::foresee;
use rijke_numerics::{Failed, write_output};
use rijke_report::answer_svg;
use rijke_study::plan::MapQuestion;
use rijke_study::{Point, Study};
use serde_json::json;
use std::path::PathBuf;

/// Predict growth rate and frequency with their uncertainty, and the probability of instability, at any
/// values of the factors; of a stage of responses reflection, absorption and transfer at any frequencies.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke predict examples/quarter-wave\n  \
    rijke predict examples/quarter-wave --at x_g=0.15,Q=12 --at x_g=0.25,Q=12\n  \
    rijke predict examples/quarter-wave --map x_g,Q --plot stability.pdf\n  \
    rijke predict examples/quarter-wave --map x_g=0.05:0.6,Q=0:80 --plot beyond.pdf --out beyond.csv\n  \
    rijke predict examples/side-hole-tube --at-hz 100:2000:10\n\n\
    Prints CSV, a row per operating point and mode that the stage was trained on: points given with --at, else those of the stage. Factors that --at leaves out are those of\n\
    the nearest point of the stage. A condition that is no point of the campaign has an error of T_amb of its own, with the sd T_amb_sd, or else that of the campaign; with day=...\n\
    it shares the error of that day. Its factors are as they are set, unless X_sd=... states an error of X, or all points share it (common_errors). Numbers are in SI units. The first standard deviation is that of a new measurement in a\n\
    new installation, the second that of the model alone; the probability takes the growth rate as normal with\n\
    the second and the misfit of growth rates that the stage found.\n\
    Where the evidence leaves other models open, here or in earlier stages, columns averaged_... count them too.\n\n\
    Of a stage of responses: what its best model predicts of every kind of response that trained it, and of the reflection of every end that has a law, a row per frequency.\n\
    Standard deviations are those of the model and of the stated errors of the point; noise and misfit of a measurement are not in them. The absorption is 1 - |R|^2.")]
pub(crate) struct Args {
    /// Folder of a study that was ranked.
    dir: PathBuf,
    /// The stage whose model predicts [default: the last].
    #[arg(long, value_name = "ID")]
    stage: Option<String>,
    /// Operating condition in SI units: factors (X=), their standard deviations (X_sd=), T_amb= and
    /// T_amb_sd=. With day=NAME it shares the error of T_amb of that day. May be repeated.
    #[arg(long, value_name = "FACTOR=VALUE,...")]
    at: Vec<String>,
    /// Predict over a grid of two factors, between the lowest and the highest value of each in the campaign,
    /// or, as x_g=0.1:0.6,Q, between others, in SI units. All else is what one --at says, else that of the
    /// point of the stage that is nearest to the middle.
    #[arg(long, value_name = "X,Y")]
    map: Option<String>,
    /// Draw the map, growth rate and probability with the boundary of stability, into this file, which ends
    /// in .svg or .pdf.
    #[arg(long, alias = "svg", value_name = "FILE", requires = "map", value_parser = figure::file)]
    plot: Option<PathBuf>,
    /// Of a stage of responses, these frequencies, Hz, each a number or from:to:step [default: 101 between
    /// those that trained].
    #[arg(long, value_name = "F", num_args = 1..)]
    at_hz: Vec<String>,
    /// File to write instead of printing.
    #[arg(long, value_name = "CSV", value_parser = crate::figure::any_file)]
    out: Option<PathBuf>,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let dir = &args.dir;
    if let Some(ranked) = RankedResponses::open(dir, args.stage.as_deref(), ui)? {
        if args.map.is_some() {
            let remedy = "Leave it out, or name a stage of modes with --stage.";
            let problem = "--map: this stage trains on responses, of which there is no growth rate";
            return Err(Failed::bad_input(problem).remedy(remedy));
        }
        return responses::run(&ranked, [&args.at, &args.at_hz], args.out.as_deref(), ui);
    }
    if !args.at_hz.is_empty() {
        let remedy = "Leave it out, or name a stage of responses with --stage.";
        let problem = "--at-hz: this stage trains on modes, which have frequencies of their own";
        return Err(Failed::bad_input(problem).remedy(remedy));
    }
    let ranked = Ranked::open(dir, args.stage.as_deref(), ui)?;
    let open = ranked.open_models();
    let Ranked { study, observed, stage, every, model } = ranked;
    let wrong = |e: rijke_engine::EngineError| of_the_engine(&e, dir);
    let map = args.map.as_deref().map(|text| grid(text, &study, &stage.points)).transpose()?;
    let among = stage.points.clone();
    let given = args.at.iter().map(|text| condition("--at", text)).collect::<Result<Vec<_>, _>>()?;
    let asked = match &map {
        Some(grid) => {
            if given.len() > 1 {
                let remedy = "Name what is the same at all nodes of the map in one --at.";
                return Err(Failed::bad_input("--map takes one --at").remedy(remedy));
            }
            over_map(&study, &among, grid, &given.into_iter().next().unwrap_or_default()).map_err(wrong)?
        }
        None => given,
    };
    let measured = study.campaign.points.len();
    let like = |asked: &AskedPoint| Ok(nearest(&study, &among, asked).map_err(wrong)?.id.clone());
    let likes = asked.iter().map(like).collect::<Result<Vec<String>, Failed>>()?;
    let (mut study, places) =
        if asked.is_empty() { (study, every) } else { with_points(&study, &among, &asked).map_err(wrong)? };
    foresee(&mut study, &places, ui)?;
    Asked { study: &study, places: &places, asked: &asked, likes: &likes, measured }.tell(map.is_some(), ui);
    // Where the evidence decides, no other model is open.
    let open = open?;
    let (found, mut left_out) = forecast(&study, &observed, &model, &open, &places).map_err(wrong)?;
    if found.is_empty() && !left_out.is_empty() {
        return Err(wrong(left_out.swap_remove(0).why));
    }
    // For a map the axes are named with it.
    let (held, axes) = match &map {
        Some(grid) => (&places[..1], &grid.factors[..]),
        None => (&places[..], &[][..]),
    };
    let predicted = Forecasts { study: &study, model: &model, open: &open, found: &found };
    predicted.tell_doubts(held, axes, ui);
    tell_left_out(&left_out, map.is_some().then_some(places.len()), ui);
    if let Some(grid) = map {
        let title = format!("Stability by the model of {}", stage.id);
        let asked = MapQuestion { id: "map".into(), title, stage: stage.id.clone(), grid };
        let (answer, said) = stability(&study, &asked, &places, &found, &model);
        ui.note(said);
        if let (Some(path), Some(svg)) = (&args.plot, answer_svg(Some(observed.kind), &answer)) {
            figure::write(path, &svg, ui)?;
        }
    }
    let text = forecast_csv(&study, &found)?;
    match &args.out {
        Some(path) => write_output(path, text.as_bytes())?,
        None => ui.say(text.trim_end()),
    }
    let factors: Vec<String> =
        study.campaign.factors.iter().map(|f| format!("{} [{}]", f.name, f.unit_in_print())).collect();
    let of = |unit: &str| [&format!("value [{unit}]"), NEW, responses::MODEL].map(|name| name.to_string());
    let columns = json!({
        "factors": factors, "growth_rate": of("1/s"), "angular_frequency": of("rad/s"),
        "other": ["growth rate [1/s]", "frequency [Hz]"],
    });
    ui.result(
        &json!({ "stage": stage.id, "candidates": model.candidates, "columns": columns, "points": found }),
    )
}

/// Conditions that were asked for, their places in the campaign of a study, of which the first ones were
/// `measured`, and the points that they are like.
struct Asked<'a> {
    study: &'a Study,
    places: &'a [usize],
    asked: &'a [AskedPoint],
    likes: &'a [String],
    measured: usize,
}

impl Asked<'_> {
    /// Says what was taken for what a condition leaves out, of the first node alone where they are those of a
    /// map; and which of them are points of the campaign.
    fn tell(&self, of_a_map: bool, ui: &Ui) {
        let points = &self.study.campaign.points;
        let new = |(_, (place, _)): &(usize, (&usize, &AskedPoint))| **place >= self.measured;
        let told = if of_a_map { 1 } else { usize::MAX };
        for (k, (place, asked)) in self.places.iter().zip(self.asked).enumerate().filter(new).take(told) {
            let like = self.likes.get(k).map_or("the campaign", String::as_str);
            let said = surroundings(asked, &points[*place], like);
            let whose = if of_a_map { "the map" } else { points[*place].id.as_str() };
            said.iter().for_each(|said| ui.note(format!("{whose}: {said}")));
        }
        let known = |place: &&usize| !of_a_map && !self.asked.is_empty() && **place < self.measured;
        for place in self.places.iter().filter(known) {
            let Point { id, .. } = &points[*place];
            ui.note(format!(
                "a condition of --at is point {id} of the campaign: it is predicted there, with the errors of its installation and day as they were found; \
                 give T_amb too for a new installation on another day"
            ));
        }
    }
}

/// Says what could not be predicted; `of_a_map` is the number of its nodes.
fn tell_left_out(left_out: &[Unpredicted], of_a_map: Option<usize>, ui: &Ui) {
    let Some(nodes) = of_a_map else {
        left_out.iter().for_each(|u| ui.note(format!("warning: left out: {}", u.why)));
        return;
    };
    if let Some(first) = left_out.first() {
        let (n, why) = (how_many(left_out.iter().map(|u| &u.point)), &first.why);
        ui.note(format!(
            "at {n} of {nodes} points of the map a mode, or all, is left out; the first, {}: {why}",
            first.point
        ));
    }
}

/// What the numbers of a prediction are, for a reader of its JSON.
const NEW: &str = "standard deviation of a new measurement";
