//! The rows of a stage's table: which candidates make each model, and what training finds of it.

use super::super::combined::{assembly_of, rows_of};
use super::super::course::{Chosen, Elsewhere, Found, Run, StandsOn, Trusted, microphones_of};
use super::super::parameter::parameters;
use super::super::record::{EvidenceRecord, ModelRecord, misfit};
use super::super::suspects::apart::Stated;
use super::super::suspects::doubts::{doubts, other_sign};
use super::super::suspects::ends::{Reflected, feeding};
use super::super::suspects::far::beyond_tables;
use super::super::suspects::matching::check_modes;
use super::super::suspects::shapes::{Shape, outlying};
use super::maxima::of_all;
use crate::noise::{Noise, floats, measured_sd};
use crate::observed::Used;
use crate::rows::{Choice, Row};
use crate::trained::OfSeveral;
use crate::{Assembly, EngineError, Misfit, NamedGaussian, Observed, PointModel, Trained, Training, train};
use rijke_inference::{AssessOptions, MapOptions, Parameter, TrustRegion};
use rijke_numerics::words::few;
use rijke_numerics::{C64, Streams};
use rijke_rig::ModeRows;
use rijke_study::Effect;
use rijke_study::names::MACH;
use rijke_study::plan::{NoiseSpec, Stage};
use std::collections::BTreeSet;
use std::sync::Arc;

impl Run {
    /// The rows of the table of a stage.
    pub(in crate::run) fn rows(&self, stage: &Stage) -> Vec<Row> {
        rows_of(&self.study, stage, &|id| match self.ground(id) {
            Some(ground) => ground.open().map(|m| m.candidates.clone()).collect(),
            None => self.stage_done(id).map(|done| done.choice.clone()).into_iter().collect(),
        })
    }

    /// What stages of responses on which `stage` stands say for a model of `choice`: its evidence less that
    /// of their best, ln best fit, ln Occam factor and ln marginal; and in words.
    fn of_the_responses(
        &self,
        stage: &Stage,
        choice: &Choice,
    ) -> Result<([f64; 3], Vec<String>), EngineError> {
        let (mut sum, mut words) = ([0.0; 3], Vec::new());
        for ground in stage.on.iter().filter_map(|id| self.ground(id)) {
            let (model, best) = (ground.with(choice, &stage.id)?, &ground.models[0]);
            let three = |e: &EvidenceRecord| [e.ln_best_fit, e.ln_occam, e.ln_marginal];
            let [own, most] = [three(&model.evidence), three(&best.evidence)];
            (0..3).for_each(|k| sum[k] += own[k] - most[k]);
            if model.id != best.id {
                words.push(format!("{:.1} nats of these are those of `{}`", own[2] - most[2], ground.id));
            }
        }
        Ok((sum, words))
    }

    /// Trains a row; a row that cannot be fitted has no evidence.
    pub(in crate::run) fn row(
        &self,
        stage: &Stage,
        row: &Row,
        stands_on: StandsOn,
        trusted: Trusted,
    ) -> Result<Found, EngineError> {
        self.go_on()?;
        let mut record = untrained(row);
        let found = match self.train_row(stage, row, stands_on, trusted) {
            Ok(found) => found,
            Err(error) => {
                record.remark = Some(error.to_string());
                return Ok((record, None));
            }
        };
        let Chosen { assembly, trained, .. } = &found;
        let ([best_fit, occam, marginal], counted) = self.of_the_responses(stage, &row.choice)?;
        let own = EvidenceRecord::of(trained);
        // Equation (9), with the evidence of the stages of responses.
        record.evidence = Some(EvidenceRecord {
            ln_best_fit: own.ln_best_fit + best_fit,
            ln_occam: own.ln_occam + occam,
            ln_marginal: own.ln_marginal + marginal,
            ..own
        });
        record.parameters = parameters(trained, assembly.parameters());
        record.misfit = misfit(trained);
        let values = trained.best();
        // Hot gas is cut at microphones: with the reference alone the mode is that which `predict` solves.
        let predicted = |o: &Observed| {
            let s = found.solved(o, self.reference().as_slice())?.s.value();
            Ok([s.re, s.im])
        };
        record.predicted = found.observed.iter().map(predicted).collect::<Result<_, EngineError>>()?;
        let solved = |(o, [sigma, omega]): (&Observed, &[f64; 2])| {
            Some((C64::new(*sigma, *omega), PointModel::new(assembly, &o.conditions, &[]).ok()?))
        };
        let models: Vec<Solved<'_>> =
            found.observed.iter().zip(&record.predicted).filter_map(solved).collect();
        let leaves = |o: &Observed| match assembly.mean_flow() {
            Some(_) => o.conditions.around(o.conditions.layout.length)[MACH],
            None => 0.0,
        };
        let mach = found.observed.iter().map(leaves).fold(0.0, f64::max);
        let reflections = models.iter().map(|(s, model)| Reflected {
            moduli: model.end_reflections(values, s.im),
            omega: s.im,
            mach,
        });
        let said: Vec<String> =
            trained.sampler.iter().map(ToString::to_string).chain(feeding(reflections)).collect();
        let doubled = match models.first() {
            Some((s, model)) => model.doubled(&assembly.centre()?, s.im),
            None => Vec::new(),
        };
        let (fitted, shapes) = self.fitted(stage, &found, &record.predicted);
        let mut doubts = self.doubts_of(stage, &found, &record, &models, (&fitted, &shapes));
        // Not in the first pass of a course whose evidence is checked further.
        if trusted != Trusted::Laplace || self.trusted == Trusted::Laplace {
            doubts.extend(self.mistakes(stage, row, &found)?);
        }
        let apart =
            |(a, b): (&[f64; 2], &[f64; 2])| (a[0] - b[0]).hypot(a[1] - b[1]) > 1e-6 * b[0].hypot(b[1]);
        if fitted.iter().zip(&record.predicted).any(apart) {
            record.fitted = fitted;
        }
        let remarks: Vec<String> = trained
            .warnings
            .iter()
            .cloned()
            .chain(doubled)
            .chain(self.meters(&found))
            .chain(self.one_sided(&found))
            .chain(idle_laws(assembly, values, &models))
            .chain(said)
            .chain(doubts)
            .chain(counted)
            .collect();
        record.remark = Some(remarks.join("\n")).filter(|w| !w.is_empty());
        Ok((record, Some(found)))
    }

    /// What residuals, tables, signs and mode shapes say against a model, with what it says by
    /// [`Run::fitted`].
    fn doubts_of(
        &self,
        stage: &Stage,
        found: &Chosen,
        record: &ModelRecord,
        models: &[Solved<'_>],
        (fitted, shapes): (&[[f64; 2]], &[Shape<'_>]),
    ) -> Vec<String> {
        let (assembly, trained) = (&found.assembly, &found.trained);
        let installations = stage.noise.installation.is_some() || !stage.noise.varying.is_empty();
        let stated = Stated { installations, gas: stage.base_errors };
        let mut all = doubts(&found.observed, fitted, record.misfit, floats(&trained.noise), stated);
        let beyond = models
            .iter()
            .filter(|_| assembly.has_tables())
            .filter_map(|(s, model)| Some((model.id(), model.beyond_a_table(trained.best(), *s)?)));
        all.extend(beyond_tables(beyond));
        all.extend(other_sign(&record.parameters, assembly.parameters()));
        let microphones = &self.rig.microphones;
        all.extend(outlying(shapes, microphones.reference, &microphones.names));
        all
    }

    /// What a mistake in the data, or a law that bends, would explain.
    fn mistakes(&self, stage: &Stage, row: &Row, found: &Chosen) -> Result<Vec<String>, EngineError> {
        let mut all = self.bent(stage, found);
        all.extend(self.turned(stage, row, found)?);
        all.extend(self.miswired(stage, row, found)?);
        all.extend(self.other_columns(stage, row, found)?);
        Ok(all)
    }

    /// What a model says of growth rates and frequencies, with the errors that training found beside its
    /// parameters, as `predicted` where a number was not measured; and of mode shapes.
    fn fitted<'a>(
        &self,
        stage: &Stage,
        found: &'a Chosen,
        predicted: &[[f64; 2]],
    ) -> (Vec<[f64; 2]>, Vec<Shape<'a>>) {
        let used = found.used(&self.rig, stage);
        let mut fitted = predicted.to_vec();
        let mut left: Vec<Vec<f64>> = used.iter().map(|u| vec![0.0; u.size()]).collect();
        // Errors that several points share may be noise of this training.
        let OfSeveral { learned, columns, .. } = &found.trained.told;
        let shared = |i: usize| columns.iter().zip(&learned.mean).map(|(c, e)| c[i] * e).sum::<f64>();
        let residuals = &found.trained.linear.0.residuals;
        for (i, ((k, row), residual)) in found.rows(&used).into_iter().zip(residuals).enumerate() {
            let mode = &found.observed[k].mode;
            let residual = residual - shared(i);
            left[k][row] = residual;
            if let Some(Some(measured)) = [mode.growth_rate, mode.angular_frequency].get(row) {
                fitted[k][row] = measured - residual;
            }
        }
        let shape = |((used, left), o): ((&Used, &Vec<f64>), &'a Observed)| {
            let heard = used.others.iter().zip(&used.pressures).enumerate().map(|(k, (m, z))| {
                let row = ModeRows::pressure(k);
                let place = used.rows.iter().position(|r| *r == row).unwrap_or_default();
                let sd = (used.covariance[(place, place)] + used.covariance[(place + 1, place + 1)]).sqrt();
                (*m, *z, C64::new(left[row], left[row + 1]), sd)
            });
            Shape { id: &o.conditions.id, mode: &o.mode.label, heard: heard.collect() }
        };
        let shapes = used.iter().zip(&left).zip(found.observed.iter()).map(shape).collect();
        (fitted, shapes)
    }

    /// The microphone to which pressures are relative, if there is one.
    pub(in crate::run) fn reference(&self) -> Option<usize> {
        Some(self.rig.microphones.reference).filter(|_| !self.rig.microphones.at.is_empty())
    }

    pub(in crate::run) fn train_row(
        &self,
        stage: &Stage,
        row: &Row,
        StandsOn { maxima, points }: StandsOn,
        trusted: Trusted,
    ) -> Result<Chosen, EngineError> {
        let on = |known: &Arc<Vec<NamedGaussian>>, trusted| {
            self.trained_on(stage, row, (known.clone(), points.clone()), trusted, maxima.len() == 1)
        };
        if let [(_, known)] = maxima.as_slice() {
            return on(known, trusted);
        }
        of_all(&maxima, trusted, &on)
    }

    /// Trains with one maximum of what earlier stages know; `alone` if it is the only one.
    fn trained_on(
        &self,
        stage: &Stage,
        row: &Row,
        (known, points): (Arc<Vec<NamedGaussian>>, Arc<Vec<Observed>>),
        trusted: Trusted,
        alone: bool,
    ) -> Result<Chosen, EngineError> {
        let assembly = assembly_of(&self.study, &row.choice, &stage.hold)?;
        let noise =
            Noise { law: self.law_of(stage, &stage.noise, &row.choice)?, ..self.noise(&stage.noise)? };
        let mut training = self.training(stage, noise, known.to_vec(), trusted);
        if let Some(found) = self.near.get(&[stage.id.clone(), row.id()]).filter(|_| alone) {
            let value = |p: &Parameter| {
                let same = found.iter().find(|q| q.name == p.name);
                same.map_or_else(|| p.prior.quantile(0.5), |q| q.value)
            };
            training.search.start = Some(assembly.parameters().iter().map(value).collect());
        }
        let trained = match train(&assembly, &points, &training) {
            Ok(trained) => trained,
            // If the rig as described has other modes, that is the reason, and not where the search then
            // stopped.
            Err(error) => {
                return Err(check_modes(&assembly, &points, &training.known).err().unwrap_or(error));
            }
        };
        check_modes(&assembly, &points, &[trained.gaussian()])?;
        let found = Misfit::of(&trained.noise).measured;
        let misfit = [0, 1, 2].map(|k| found[k].hypot(measured_sd(&points, k)));
        let other =
            |(odds, at): &(f64, Vec<f64>)| Elsewhere { odds: *odds, at: at.clone(), known: known.clone() };
        let maxima = trained.elsewhere.iter().map(other).collect();
        Ok(Chosen {
            assembly: Arc::new(assembly),
            trained: Arc::new(trained),
            observed: points,
            known,
            misfit,
            beside: None,
            maxima,
        })
    }

    /// A model trained again at one maximum of what earlier stages know, on `points` and with the noise
    /// `spec`; searched from `start`, parameters of the model, if it is given.
    pub(in crate::run) fn trained_again(
        &self,
        stage: &Stage,
        spec: &NoiseSpec,
        chosen: &Chosen,
        points: &[Observed],
        start: &[f64],
    ) -> Result<Trained, EngineError> {
        let noise = Noise { law: self.law_of(stage, spec, &chosen.choice())?, ..self.noise(spec)? };
        let mut training = self.training(stage, noise, chosen.known.to_vec(), Trusted::Laplace);
        training.search.start = Some(start.to_vec());
        train(&chosen.assembly, points, &training)
    }

    pub(in crate::run) fn training(
        &self,
        stage: &Stage,
        noise: Noise,
        known: Vec<NamedGaussian>,
        trusted: Trusted,
    ) -> Training {
        let search = gauss_newton();
        let sampler = if let Trusted::Sampled(kind, error) = trusted { Some((kind, error)) } else { None };
        let usual = AssessOptions {
            search: search.search,
            // One stream per candidate: a further row must not change the others.
            streams: Streams::new(u64::from_le_bytes(*b"evidence")),
            sampler,
            // A stage judges the residuals and widens the deviations itself.
            goodness_of_fit: false,
            few_data: false,
            ..AssessOptions::default()
        };
        let checks = match trusted {
            Trusted::Laplace => None,
            Trusted::Searched => {
                Some(AssessOptions { random_starts: 2, screened: 16, most_starts: 8, draws: 0, ..usual })
            }
            Trusted::Checked | Trusted::Sampled(..) => Some(usual),
        };
        Training {
            microphones: microphones_of(&self.rig, stage),
            noise,
            known,
            channels: self.channels.clone().filter(|_| stage.channels),
            search,
            base_errors: stage.base_errors,
            assemblies: self.assemblies(stage),
            causes: self.causes(stage),
            checks,
        }
    }
}

/// A row as it is before training.
fn untrained(row: &Row) -> ModelRecord {
    let effects = row.own.iter().flat_map(|c| &c.effects);
    let law =
        |e: &Effect| (format!("{} at {}", e.coefficient.name(), e.place_text), e.law.source().to_owned());
    ModelRecord {
        id: row.id(),
        label: if row.own.is_empty() {
            "the rig as rig.toml describes it".to_owned()
        } else {
            row.own.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join("; ")
        },
        candidates: row.choice.clone(),
        laws: effects.map(law).collect(),
        parameters: Vec::new(),
        misfit: [0.0; 3],
        evidence: None,
        predicted: Vec::new(),
        fitted: Vec::new(),
        remark: None,
    }
}

/// Newton's search, done with Gauss and Newton's matrix, to 1e-5 posterior standard deviations.
fn gauss_newton() -> MapOptions {
    let options = MapOptions::default();
    MapOptions { search: TrustRegion { tolerance: 1e-10, ..options.search }, ..options }
}

/// The eigenvalue of a model at a measured mode, and the model there.
type Solved<'a> = (C64, PointModel<'a>);

/// Laws that are zero at every point of a model, in a sentence: by such a law no candidate can be told from
/// another.
fn idle_laws(assembly: &Assembly, values: &[f64], models: &[Solved<'_>]) -> Option<String> {
    let zero = |(s, model): &Solved<'_>| model.zero_laws(values, s.im).into_iter().collect::<BTreeSet<_>>();
    let idle = models.iter().map(zero).reduce(|known, here| &known & &here)?;
    let candidates = assembly.candidates();
    let said = |[c, e]: [usize; 2]| {
        let (candidate, effect) = (&candidates[c], &candidates[c].effects[e]);
        format!("`{}` of `{}` at {}", effect.coefficient.name(), candidate.id, effect.place_text)
    };
    // Who writes a law of 0, or of 0*rho*s, without a parameter means it: nothing acts there.
    let meant = |[c, e]: &[usize; 2]| {
        let (candidate, law) = (&candidates[*c], &candidates[*c].effects[*e].law);
        let zero = law.source().split('*').any(|factor| factor.trim().parse::<f64>() == Ok(0.0));
        zero && !(0..candidate.parameters.len()).any(|k| law.uses_parameter(k))
    };
    let said: Vec<String> = idle.into_iter().filter(|law| !meant(law)).map(said).collect();
    (!said.is_empty()).then(|| {
        let [are, have, their] = if said.len() == 1 { ["is", "has", "its"] } else { ["are", "have", "their"] };
        let (place, formula) = if said.len() == 1 { ("place", "formula") } else { ("places", "formulas") };
        format!(
            "{} {are} 0 at every point and {have} no effect; check {their} {place} and the factors in {their} {formula}",
            few(&said, 4)
        )
    })
}
