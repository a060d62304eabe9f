//! What a model says before it has seen data: growth rate and frequency over draws from the priors.

use super::stages::Stage;
use crate::failure::{Classify, Failure};
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use rijke_inference::{Parameters, normal_cdf};
use rijke_model::{Assembly, Conditions, PointModel, Workspace};
use rijke_numerics::{C64, Order, Streams};
use rijke_report::{PriorFigure, PriorModel, PriorSeries};
use rijke_rig::DataKind;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Draws from the priors of each model: the quantiles at two standard deviations are then known to 0.14 of one.
const DRAWS: usize = 400;
/// Models in one figure.
const ROWS: usize = 8;

/// The figures of one stage, each with its file name; and how many of all draws had no mode near that of the centre.
pub(crate) fn figures(
    stage: &Stage,
    measured: &BTreeMap<String, C64>,
    kind: Option<DataKind>,
    advance: &(dyn Fn() + Sync),
) -> Result<(Vec<(String, PriorFigure)>, usize), Failure> {
    let shown: Vec<&Conditions> = stage.points.iter().collect();
    let (mut models, mut lost) = (Vec::new(), 0);
    for (id, assembly) in &stage.models {
        let (bands, without) = bands(assembly, &shown)?;
        lost += without;
        models.push(PriorModel { name: id.clone(), series: series(&shown, &bands, measured) });
        advance();
    }
    let name = |k: usize| if k == 0 { stage.role.to_owned() } else { format!("{}-{}", stage.role, k + 1) };
    let over_power = over_power(&shown);
    let title = format!("What the priors of {} allow: median and central 95 %", stage.role);
    let figure = |(k, models): (usize, &[PriorModel])| {
        (
            format!("{}.svg", name(k)),
            PriorFigure { title: title.clone(), data: kind, over_power, models: models.to_vec() },
        )
    };
    Ok((models.chunks(ROWS).enumerate().map(figure).collect(), lost))
}

/// Growth rate (1/s) and frequency (Hz) at one point: lower end, median and upper end of the central 95.4 %, which is mean and two
/// standard deviations of a Gaussian.
type Band = [[f64; 3]; 2];

/// The bands at every point, and the number of draws without an eigenvalue near that of the centre of the priors.
fn bands(assembly: &Assembly, points: &[&Conditions]) -> Result<(Vec<Band>, usize), Failure> {
    let parameters = Parameters::new(assembly.parameters().to_vec()).or_bad_input()?;
    let centre = parameters.physical(&parameters.centre());
    // A stream for every parameter, so that models which share it share its draws.
    let stream = |name: &str| Streams::new(0).stream(&format!("check/{name}"));
    let mut streams: Vec<_> = parameters.list().iter().map(|p| stream(&p.name)).collect();
    let mut draw = || {
        let xi: Vec<f64> = streams.iter_mut().map(|stream| StandardNormal.sample(stream)).collect();
        parameters.physical(&parameters.from_standard_normal(&xi))
    };
    let draws: Vec<Vec<f64>> = (0..DRAWS).map(|_| draw()).collect();
    let at = |conditions: &&Conditions| -> Result<(Band, usize), Failure> {
        let model =
            PointModel::new(assembly, conditions, &[assembly.rig.microphones.reference]).or_bad_input()?;
        let work = &mut Workspace::default();
        let start = model.respond(&centre, Order::Value, work).or_bad_input()?.s.value();
        let model = model.starting_from(start);
        let found: Vec<C64> = draws
            .iter()
            .filter_map(|values| Some(model.respond(values, Order::Value, work).ok()?.s.value()))
            .filter(|s| s.is_finite())
            .collect();
        let band = |part: fn(&C64) -> f64| {
            let mut values: Vec<f64> = found.iter().map(part).collect();
            values.sort_by(f64::total_cmp);
            [-2.0, 0.0, 2.0].map(|z| quantile(&values, normal_cdf(z)))
        };
        Ok(([band(|s| s.re), band(|s| s.im / TAU)], draws.len() - found.len()))
    };
    let all: Vec<(Band, usize)> = points.par_iter().map(at).collect::<Result<_, _>>()?;
    let (bands, lost): (Vec<Band>, Vec<usize>) = all.into_iter().unzip();
    Ok((bands, lost.iter().sum()))
}

/// Linear between the ordered values; NaN of none.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * sorted.len().saturating_sub(1) as f64;
    let (low, high) = (place.floor() as usize, place.ceil() as usize);
    match (sorted.get(low), sorted.get(high)) {
        (Some(a), Some(b)) => a + (b - a) * place.fract(),
        _ => f64::NAN,
    }
}

/// Whether the points differ in power alone.
fn over_power(points: &[&Conditions]) -> bool {
    let first = points.first().and_then(|c| c.point.position);
    points.iter().all(|c| c.point.position == first) && points.iter().any(|c| c.point.power > 0.0)
}

/// One series per power, over the position; or one over the power, where there is one position.
fn series(points: &[&Conditions], bands: &[Band], measured: &BTreeMap<String, C64>) -> Vec<PriorSeries> {
    let over_power = over_power(points);
    let mut powers: Vec<f64> = points.iter().map(|c| c.point.power).collect();
    powers.sort_by(f64::total_cmp);
    powers.dedup();
    let groups: Vec<Option<f64>> =
        if over_power { vec![None] } else { powers.iter().copied().map(Some).collect() };
    let one = |power: &Option<f64>| {
        let place = |c: &Conditions| if over_power { c.point.power } else { c.point.position.unwrap_or(0.0) };
        let mut members: Vec<(&Conditions, &Band)> = points.iter().copied().zip(bands).collect();
        members.retain(|(c, _)| power.is_none_or(|p| c.point.power == p));
        members.sort_by(|a, b| place(a.0).total_cmp(&place(b.0)));
        let dot = |c: &Conditions| measured.get(&c.point.id).map(|s| [place(c), s.re, s.im / TAU]);
        PriorSeries {
            name: power.filter(|p| *p > 0.0).map_or_else(String::new, |p| format!("{p} W")),
            bands: members.iter().map(|(c, band)| (place(c), **band)).collect(),
            measured: members.iter().filter_map(|(c, _)| dot(c)).collect(),
        }
    };
    groups.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::stages::stages;
    use rijke_rig::{Campaign, Rig};

    /// Two routes to the spread of the prior prediction: draws, and the first derivatives.
    #[test]
    fn oracle_draws_spread_as_the_derivatives_say() {
        let rig = Rig::juniper_yoko_2022();
        let campaign = Campaign::juniper_yoko_2022();
        let points: Vec<_> = campaign.row("C3").take(12).map(|p| (p.clone(), 293.15)).collect();
        let (stages, _) = stages(&rig, &points, &[]).unwrap();
        let (_, assembly) = stages[0].models.iter().find(|(id, _)| id == "prongs.6").unwrap();
        let conditions = stages[0].points.last().unwrap();
        let (found, lost) = bands(assembly, &[conditions]).unwrap();
        assert_eq!(lost, 0);
        let parameters = Parameters::new(assembly.parameters().to_vec()).unwrap();
        let centre = parameters.physical(&parameters.centre());
        let model = PointModel::new(assembly, conditions, &[rig.microphones.reference]).unwrap();
        let s = model.respond(&centre, Order::First, &mut Workspace::default()).unwrap().s;
        let sd = |part: fn(C64) -> f64| {
            let moves = s.gradient().iter().zip(parameters.scales()).map(|(g, scale)| part(*g) * scale);
            moves.map(|m| m * m).sum::<f64>().sqrt()
        };
        let expected = [[s.value().re, sd(|z| z.re)], [s.value().im / TAU, sd(|z| z.im) / TAU]];
        for ([low, middle, high], [mean, sd]) in found[0].iter().zip(expected) {
            // 400 draws know the median to 0.063 sd, each end to 0.14 sd and half their distance to 0.05 of itself: three of these.
            assert!((middle - mean).abs() < 0.19 * sd, "{middle}, {mean} +- {sd}");
            assert!(((high - low) / (4.0 * sd) - 1.0).abs() < 0.15, "{low} to {high}, sd {sd}");
        }
    }

    #[test]
    fn exact_quantiles_are_linear_between_values() {
        assert_eq!([0.0, 0.25, 1.0].map(|p| quantile(&[1.0, 2.0, 4.0], p)), [1.0, 1.5, 4.0]);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
