//! The posterior of a stage's model for some sets of microphones (Figs. 3 and 12 of Juniper & Yoko 2022).

use super::super::course::Run;
use super::super::frame::{Frame, FrameColumn, FrameRow, finite};
use super::super::parameter::parameters;
use super::answer::{AnswerPanel, Found, Layer, LayerLook};
use super::axes::axis_label;
use super::kinds::Ask;
use crate::noise::Noise;
use crate::{EngineError, Training, train};
use rayon::prelude::*;
use rijke_inference::{NoiseMode, Prior};
use rijke_numerics::InOrder;
use rijke_study::plan::Question;
use rijke_study::{Study, StudyProblem};
use serde::Deserialize;

/// Asks for the posterior of the model of a stage for some sets of microphones.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Contours {
    /// Names of microphones; an empty set is all of them. Every set that holds the reference if empty.
    sets: Vec<Vec<String>>,
}

impl Ask for Contours {
    const KIND: &'static str = "contours";

    fn check(&self, study: &Study) -> Result<(), StudyProblem> {
        self.sets.iter().try_for_each(|set| study.rig.microphones.have(set))
    }

    fn answer(&self, run: &Run, question: &Question) -> Result<Found, EngineError> {
        let names = &run.rig.microphones.names;
        let place = |name: &String| names.iter().position(|n| n == name);
        let places = |set: &Vec<String>| set.iter().filter_map(place).collect();
        run.contours(question, &self.sets.iter().map(places).collect::<Vec<_>>())
    }
}

impl Run {
    fn contours(&self, question: &Question, sets: &[Vec<usize>]) -> Result<Found, EngineError> {
        let no_stage = || EngineError::NoPoint { stage: question.stage.clone() };
        let chosen = self.chosen(&question.stage).ok_or_else(no_stage)?;
        let cases = self.of_sets(&question.stage, sets)?;
        let names = &self.rig.microphones.names;
        let free = chosen.assembly.parameters();
        let p = free.len();
        let most = cases.iter().max_by_key(|(m, _)| m.len()).ok_or_else(no_stage)?;
        let widest = most.1.sd();
        let mut columns = vec![
            FrameColumn::new("microphones", "Number of microphones", "1"),
            FrameColumn::new("width", "sd over that of all microphones, worst parameter", "1"),
        ];
        for q in free {
            columns.push(FrameColumn::new(&q.name, &q.symbol, &q.unit));
            columns.push(FrameColumn::new(&format!("{}_sd", q.name), &format!("{}, sd", q.symbol), &q.unit));
        }
        let pairs: Vec<(usize, usize)> = (0..p).flat_map(|i| (i + 1..p).map(move |j| (i, j))).collect();
        let triple = |(i, j): &(usize, usize)| {
            let (a, b) = (&free[*i].name, &free[*j].name);
            [format!("var_{a}|{b}"), format!("var_{b}|{a}"), format!("cov_{a}_{b}"), format!("corr_{a}_{b}")]
        };
        columns.extend(pairs.iter().flat_map(triple).map(|name| FrameColumn::new(&name, &name, "1")));
        let row = |(microphones, trained): &(Vec<usize>, crate::Trained)| {
            let (c, sd) = (&trained.covariance, trained.sd());
            let width = (0..p).map(|i| sd[i] / widest[i]).fold(0.0, f64::max);
            let values = [microphones.len() as f64, width]
                .into_iter()
                .chain((0..p).flat_map(|i| [trained.values[i], sd[i]]))
                .chain(pairs.iter().flat_map(|&(i, j)| {
                    [c[(i, i)], c[(j, j)], c[(i, j)], c[(i, j)] / (c[(i, i)] * c[(j, j)]).sqrt()]
                }))
                .map(finite)
                .collect();
            let label = microphones.iter().map(|m| names[*m].as_str()).collect::<Vec<_>>().join(" ");
            let n = microphones.len();
            let series = if n == 1 { "1 microphone".to_owned() } else { format!("{n} microphones") };
            FrameRow { label, series, values, ..FrameRow::default() }
        };
        let rows = cases.iter().map(row).collect();
        let prior = |q: &rijke_inference::Parameter| match q.prior {
            Prior::Normal { mean, .. } => [Some(mean), None],
            _ => [None; 2],
        };
        let expected = FrameRow {
            label: "prior".into(),
            series: "prior mean".into(),
            values: [None, None].into_iter().chain(free.iter().flat_map(prior)).collect(),
            ..FrameRow::default()
        };
        // Ellipses of the sets, and dots of the prior.
        let panel = |(k, &(i, j)): (usize, &(usize, usize))| {
            let (x, y) = (2 + 2 * i, 2 + 2 * j);
            let layer = |frame, look, sd| Layer { frame, look, x, y, sd, mode: None };
            let covariance = 2 + 2 * p + 4 * k + 2;
            AnswerPanel {
                x: axis_label(&columns[x]),
                y: axis_label(&columns[y]),
                layers: vec![layer(0, LayerLook::Ellipse, Some(covariance)), layer(1, LayerLook::Dots, None)],
            }
        };
        let panels = pairs.iter().enumerate().map(panel).collect();
        let columns_of_prior = columns[..2 + 2 * p].to_vec();
        let frames = vec![Frame { columns, rows }, Frame { columns: columns_of_prior, rows: vec![expected] }];
        let caption = format!(
            "Posterior of {} for sets of microphones: ellipses of one and two standard deviations.",
            chosen.assembly.ids().join(", ")
        );
        Ok((frames, panels, parameters(&most.1, free), caption))
    }

    /// The model of a stage trained with each of the sets. All assume the noise of the pressures that the
    /// stage found with all microphones: a set of two measures no more than it fits, and could not choose
    /// any.
    fn of_sets(
        &self,
        id: &str,
        sets: &[Vec<usize>],
    ) -> Result<Vec<(Vec<usize>, crate::Trained)>, EngineError> {
        let no_stage = || EngineError::NoPoint { stage: id.to_owned() };
        let (_, stage) = self.study.plan.stage(id).ok_or_else(no_stage)?;
        let chosen = self.chosen(id).ok_or_else(no_stage)?;
        let found = crate::Misfit::of(&chosen.trained.noise).measured;
        let noise = self.noise(&stage.noise)?;
        let noise = Noise {
            law: self.law_of(stage, &stage.noise, &chosen.choice())?,
            of_a_point: [0, 1, 2].map(|k| match noise.of_a_point[k] {
                fixed @ NoiseMode::Fixed { .. } => fixed,
                _ => NoiseMode::Fixed { sd: found[k] },
            }),
            ..noise
        };
        let known = chosen.known.to_vec();
        let mut training = self.training(stage, noise, known, super::super::Trusted::Laplace);
        training.search.start = Some(chosen.trained.best().to_vec());
        let heard = &self.rig.microphones;
        let all: Vec<usize> = (0..heard.names.len()).collect();
        let every = if sets.is_empty() { subsets(all.len(), heard.reference) } else { Vec::new() };
        let wanted: Vec<&Vec<usize>> = sets.iter().chain(&every).collect();
        let one = |set: &&Vec<usize>| {
            let microphones = if set.is_empty() { all.clone() } else { (*set).clone() };
            let training = Training { microphones: microphones.clone(), ..training.clone() };
            let trained = train(&chosen.assembly, &chosen.observed, &training)?;
            Ok((microphones, trained))
        };
        wanted.par_iter().map(one).in_order()
    }
}

/// Every set of `count` microphones that holds `reference`, small sets first.
fn subsets(count: usize, reference: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = (0_u64..1 << count.min(16))
        .filter(|bits| bits >> reference & 1 == 1)
        .map(|bits| (0..count).filter(|m| bits >> m & 1 == 1).collect())
        .collect();
    all.sort_by_key(Vec::len);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_eight_microphones_have_the_sets_of_figure_12() {
        let all = subsets(8, 5);
        let counts: Vec<usize> = (1..=8).map(|k| all.iter().filter(|s| s.len() == k).count()).collect();
        assert_eq!(counts, [1, 7, 21, 35, 35, 21, 7, 1]);
        assert!(all.iter().all(|s| s.contains(&5)));
    }
}
