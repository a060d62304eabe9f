//! `rijke next`: what to measure next, by the information that it would bring.

use crate::{figure, number, ui::Ui};
use rijke_draw::plot_svg;
use rijke_engine::folder::{Ranked, condition, grid, of_the_engine, warn_of_ranking};
use rijke_engine::run::{Aim, AskedPoint, Wish, microphones, next, over_map, with_points};
use rijke_intake::foresee;
use rijke_numerics::Failed;
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
        found.tell(ui);
        return ui.result(&found);
    }
    warn_of_ranking(dir, &stage.id, ui);
    let found = next(&study, &observed, &model, &rivals, &wish).map_err(wrong)?;
    if let Some(path) = &args.plot {
        figure::write(path, &plot_svg(&found.plot(&study.campaign, observed.kind)), ui)?;
    }
    found.tell(args.about.as_deref(), ui);
    ui.result(&found)
}
