//! Where a trained model says that the rig is stable: growth rates over a grid of two factors.

use super::super::frame::{Frame, FrameColumn, FrameRow, finite};
use super::super::points::predicted::Forecast;
use super::answer::{Answer, AnswerPanel, Layer, LayerLook};
use super::axes::{axis_label, factor_column};
use crate::SavedModel;
use rijke_numerics::words::with_sd;
use rijke_study::plan::{MapGrid, MapQuestion};
use rijke_study::{Study, unit_behind};
use std::collections::BTreeMap;

/// Standard deviations of the band about the boundary, and of what is called certain.
const CERTAIN: f64 = 2.0;

/// What is said of the rows that are no nodes of the map.
const TRAINED: &str = "trained";

/// A map from what `model` foresees at the nodes of its grid, whose `places` in the campaign are given row
/// after row; and what it shows, in a sentence or two. Deviations are those of the model, those of growth
/// rates with the misfit that its training found, without the errors of a measurement; over the models that
/// the evidence leaves open too, where all nodes have that average. At a node that lacks a mode the map is
/// blank.
#[must_use]
pub fn stability(
    study: &Study,
    asked: &MapQuestion,
    places: &[usize],
    found: &[Forecast],
    model: &SavedModel,
) -> (Answer, String) {
    let campaign = &study.campaign;
    let MapGrid { factors, values } = &asked.grid;
    let averaged = !found.is_empty() && found.iter().all(|f| f.averaged.is_some());
    let mut modes: Vec<&str> = found.iter().map(|f| f.mode.as_str()).collect();
    modes.sort_unstable();
    modes.dedup();
    let (rows, nodes) = of_grid(study, values, places, (found, &modes, averaged));
    let columns = factors.map(|k| factor_column(&campaign.factors[k]));
    let labels = [0, 1].map(|k| axis_label(&columns[k]));
    let numbers = [
        ("growth_rate", "Growth rate", "1/s"),
        ("growth_rate_sd", "Growth rate, sd of the model and its misfit", "1/s"),
        ("angular_frequency", "Angular frequency", "rad/s"),
        ("angular_frequency_sd", "Angular frequency, sd of the model", "rad/s"),
        ("probability_of_instability", "Probability of instability", "1"),
    ];
    let numbers = numbers.map(|(name, label, unit)| FrameColumn::new(name, label, unit));
    let others = others(found);
    let verdict = Verdict::of(&nodes, places.len(), !others.is_empty(), &columns);
    let empty = Frame { columns: columns.to_vec(), rows: Vec::new() };
    let extreme = verdict.at.map(|at| FrameRow {
        label: verdict.mark.clone(),
        values: at.map(Some).to_vec(),
        ..FrameRow::default()
    });
    let points = trained_at(study, factors, model);
    let said =
        [verdict.sentence, fixed(study, asked, places), beyond(&points, values, &columns), others].concat();
    let frames = vec![
        Frame { columns: columns.into_iter().chain(numbers).collect(), rows },
        Frame { rows: points, ..empty.clone() },
        Frame { rows: extreme.into_iter().collect(), ..empty },
    ];
    let layer = |frame, look, sd| Layer { frame, look, x: 0, y: 1, sd, mode: None };
    let panels = [LayerLook::GrowthMap, LayerLook::ChanceMap].map(|look| AnswerPanel {
        x: labels[0].clone(),
        y: labels[1].clone(),
        layers: vec![
            layer(0, look, Some(3)),
            layer(1, LayerLook::Dots, None),
            layer(2, LayerLook::Cross, None),
        ],
    });
    let answer = Answer {
        id: asked.id.clone(),
        title: asked.title.clone(),
        caption: format!("{said} {}", whose(asked, model, modes.len(), averaged)),
        parameters: Vec::new(),
        frames,
        panels: if nodes.is_empty() { Vec::new() } else { panels.to_vec() },
    };
    (answer, said)
}

/// The rows of a map over `values` of two factors, and its nodes at which every one of the `modes` is known.
fn of_grid(
    study: &Study,
    values: &[Vec<f64>; 2],
    places: &[usize],
    (found, modes, averaged): (&[Forecast], &[&str], bool),
) -> (Vec<FrameRow>, Vec<Node>) {
    let of: BTreeMap<(&str, &str), &Forecast> =
        found.iter().map(|f| ((f.point.as_str(), f.mode.as_str()), f)).collect();
    let growth = |f: &Forecast| match &f.averaged {
        Some(a) if averaged => [a.growth_rate[0], a.stability_sd],
        _ => [f.growth_rate[0], f.stability_sd],
    };
    let shown = |f: &Forecast| {
        let ([frequency, _, of_it], chance) = match &f.averaged {
            Some(a) if averaged => (a.angular_frequency, a.unstable),
            _ => (f.angular_frequency, f.unstable),
        };
        let [growth, sd] = growth(f);
        [growth, sd, frequency, of_it, chance].map(finite)
    };
    let (mut rows, mut nodes) = (Vec::new(), Vec::new());
    for (k, &place) in places.iter().enumerate() {
        let at = [values[0][k % values[0].len()], values[1][k / values[0].len()]];
        let id = study.campaign.points[place].id.as_str();
        let here: Vec<Option<&Forecast>> = modes.iter().map(|mode| of.get(&(id, *mode)).copied()).collect();
        for (mode, forecast) in modes.iter().zip(&here) {
            let values = at.iter().map(|v| Some(*v)).chain(forecast.map_or([None; 5], shown)).collect();
            let (label, mode) = (id.to_owned(), (*mode).to_owned());
            rows.push(FrameRow { label, mode, values, ..FrameRow::default() });
        }
        let all: Option<Vec<[f64; 2]>> = here.iter().map(|f| f.map(growth)).collect();
        nodes.extend(all.filter(|all| !all.is_empty()).map(|modes| Node { at, modes }));
    }
    (rows, nodes)
}

/// The points that trained a model, where the two factors have values.
fn trained_at(study: &Study, factors: &[usize; 2], model: &SavedModel) -> Vec<FrameRow> {
    let row = |id: &String| {
        let (_, p) = study.campaign.point(id)?;
        let at = factors.map(|k| p.factors[k]);
        let row = FrameRow {
            label: p.id.clone(),
            series: TRAINED.to_owned(),
            values: at.map(|v| Some(v).filter(|v| v.is_finite())).to_vec(),
            ..FrameRow::default()
        };
        row.values.iter().all(Option::is_some).then_some(row)
    };
    model.trained_on.iter().filter_map(row).collect()
}

/// A node of which every mode is known: growth rate and its deviation.
struct Node {
    at: [f64; 2],
    modes: Vec<[f64; 2]>,
}

impl Node {
    /// The growth rate of the mode that is largest, so many deviations above its mean.
    fn largest(&self, sds: f64) -> [f64; 2] {
        let at = |m: &[f64; 2]| m[0] + sds * m[1];
        self.modes.iter().copied().max_by(|a, b| at(a).total_cmp(&at(b))).unwrap_or([f64::NAN; 2])
    }
}

/// What the map shows, in words.
struct Verdict {
    sentence: String,
    /// Of the place that the words name.
    mark: String,
    at: Option<[f64; 2]>,
}

impl Verdict {
    /// `asked` is the number of all nodes; `others` whether a mode grows that the map does not show.
    fn of(nodes: &[Node], asked: usize, others: bool, columns: &[FrameColumn]) -> Self {
        let mean = |n: &Node| n.largest(0.0)[0];
        let (Some(most), Some(least)) = (
            nodes.iter().max_by(|a, b| mean(a).total_cmp(&mean(b))),
            nodes.iter().min_by(|a, b| mean(a).total_cmp(&mean(b))),
        ) else {
            return Self {
                sentence: "The model says nothing of any point of the map.".into(),
                mark: String::new(),
                at: None,
            };
        };
        let bound = |sds: f64| nodes.iter().map(move |n| n.largest(sds)).map(move |[m, sd]| m + sds * sd);
        let is_stable = bound(CERTAIN).all(|v| v < 0.0);
        let is_unstable = bound(-CERTAIN).all(|v| v > 0.0);
        let (node, which) = if mean(least) > 0.0 { (least, "smallest") } else { (most, "largest") };
        let gone = asked - nodes.len();
        let what = if is_stable {
            match (others, gone) {
                (true, _) => "The measured modes are stable where the model says something",
                (false, 0) => "Stable everywhere",
                (false, _) => "Stable where the model says something",
            }
        } else if is_unstable {
            if gone == 0 { "Unstable everywhere" } else { "Unstable where the model says something" }
        } else if mean(most) <= 0.0 {
            "Nowhere more probably unstable than stable, but not everywhere stable within two standard deviations"
        } else if mean(least) > 0.0 {
            "Everywhere more probably unstable than stable, but not everywhere unstable within two standard deviations"
        } else {
            "The boundary of stability crosses the map"
        };
        let [value, sd] = node.largest(0.0);
        let shown = |k: usize| {
            let unit = unit_behind(columns[k].shown_unit());
            let value = format!("{:.4}", columns[k].shown_of(node.at[k]));
            let value = value.trim_end_matches('0').trim_end_matches('.');
            format!("{} = {value}{unit}", columns[k].name)
        };
        let growth = with_sd(value, sd).replace("+-", "\u{b1}");
        let mark = format!("{which} growth rate {growth} 1/s");
        let known = match gone {
            0 => String::new(),
            _ => format!(" Of {gone} of {asked} points the model says nothing: the map is blank there."),
        };
        let sentence = format!("{what}: {mark} at {}, {}.{known}", shown(0), shown(1));
        Self { sentence, mark, at: Some(node.at) }
    }
}

/// What is the same at all nodes.
fn fixed(study: &Study, asked: &MapQuestion, places: &[usize]) -> String {
    let Some(point) = places.first().map(|k| &study.campaign.points[*k]) else { return String::new() };
    let factors = study.campaign.factors.iter().zip(&point.factors).enumerate();
    let others = factors.filter(|(k, (_, v))| !asked.grid.factors.contains(k) && v.is_finite());
    let mut all: Vec<String> = others.map(|(_, (factor, v))| factor.said_to(*v, 5)).collect();
    all.extend(point.ambient.map(|[kelvin, _]| format!("T_amb = {kelvin} K")));
    if all.is_empty() { String::new() } else { format!(" Everywhere {}.", all.join(", ")) }
}

/// Where the map goes beyond the points that trained the model.
fn beyond(points: &[FrameRow], values: &[Vec<f64>; 2], columns: &[FrameColumn]) -> String {
    let far = |k: usize| {
        let trained = || points.iter().filter_map(|row| row.values[k]);
        let (low, high) = (trained().reduce(f64::min)?, trained().reduce(f64::max)?);
        let (first, last) = (values[k].first()?, values[k].last()?);
        let unit = unit_behind(columns[k].shown_unit());
        let [from, to] = [low, high].map(|v| columns[k].shown_of(v));
        (*first < low || *last > high).then(|| format!("{} {from} to {to}{unit}", columns[k].name))
    };
    let all: Vec<String> = (0..2).filter_map(far).collect();
    if all.is_empty() {
        return String::new();
    }
    format!(" Beyond the points that trained the model ({}) its laws are extrapolated.", all.join(", "))
}

/// That a mode grows which the map does not show.
fn others(found: &[Forecast]) -> String {
    let growing: BTreeMap<&str, f64> = found
        .iter()
        .filter_map(|f| f.other.filter(|o| o[0] > 0.0).map(|o| (f.point.as_str(), o[1])))
        .collect();
    match growing.iter().next() {
        Some((point, hertz)) => format!(
            " At {} points a mode grows that was not measured and is not shown, at {point} one of {hertz:.1} Hz.",
            growing.len()
        ),
        None => String::new(),
    }
}

/// Whose map it is, and how to read it.
fn whose(asked: &MapQuestion, model: &SavedModel, modes: usize, averaged: bool) -> String {
    let ids: Vec<&str> = model.candidates.values().map(String::as_str).collect();
    let open = if averaged { ", averaged with the models that the evidence leaves open" } else { "" };
    let [across, up] = [0, 1].map(|k| asked.grid.values[k].len());
    let mode = if modes > 1 { "of the mode that grows fastest" } else { "of the mode" };
    format!(
        "Growth rate {mode} and probability that it is positive, by the model of {} ({}){open}, at {across} by {up} nodes and linear between them. The line is the boundary of stability; its band is where \
         zero lies within two standard deviations of the model and its misfit, that is where the probability of instability is 2.3 % to 97.7 %. Dots are the points \
         that trained the model.",
        asked.stage,
        ids.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(nodes: &[[f64; 4]], asked: usize) -> (String, Option<[f64; 2]>) {
        let columns = [FrameColumn::new("x_g", "", "m"), FrameColumn::new("Q", "", "W")];
        let node = |n: &[f64; 4]| Node { at: [n[0], n[1]], modes: vec![[n[2], n[3]], [n[2] - 1.0, n[3]]] };
        let verdict = Verdict::of(&nodes.iter().map(node).collect::<Vec<_>>(), asked, false, &columns);
        (verdict.sentence, verdict.at)
    }

    #[test]
    fn exact_a_map_without_a_boundary_says_what_it_shows() {
        let (stable, at) = said(&[[0.1, 0.0, -5.0, 0.4], [0.41, 12.5, -3.1, 0.4]], 2);
        assert_eq!(
            stable,
            "Stable everywhere: largest growth rate -3.10 \u{b1} 0.40 1/s at x_g = 0.41 m, Q = 12.5 W."
        );
        assert_eq!(at, Some([0.41, 12.5]));
        let (near, _) = said(&[[0.1, 0.0, -5.0, 0.4], [0.4, 10.0, -0.3, 0.4]], 2);
        assert!(near.starts_with("Nowhere more probably unstable than stable, but not"), "{near}");
        let (unstable, at) = said(&[[0.1, 0.0, 5.0, 0.4], [0.4, 10.0, 3.0, 0.4]], 3);
        assert!(
            unstable.starts_with("Unstable where the model says something: smallest growth rate 3.00"),
            "{unstable}"
        );
        assert!(unstable.contains("Of 1 of 3 points the model says nothing") && at == Some([0.4, 10.0]));
        let (both, _) = said(&[[0.1, 0.0, -5.0, 0.4], [0.4, 10.0, 3.0, 0.4]], 2);
        assert!(both.starts_with("The boundary of stability crosses the map: largest"), "{both}");
        assert!(said(&[], 2).1.is_none());
    }
}
