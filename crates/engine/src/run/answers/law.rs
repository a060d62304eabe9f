//! The law of a role over frequency: modulus and phase of what was inferred, the Bode plot of a flame, a
//! gauze or an end.

use super::super::course::{Chosen, Run};
use super::super::frame::{Frame, FrameColumn, FrameRow, finite};
use super::super::points::inputs::conditions;
use super::answer::{AnswerPanel, Found, Layer, LayerLook};
use super::axes::{axis_label, symbol};
use super::kinds::Ask;
use crate::{Conditions, EngineError, Observed, PointModel, Trained};
use rijke_formula::{Context, Formula, Kind};
use rijke_numerics::{C64, Matrix, range};
use rijke_study::names::S;
use rijke_study::plan::{Question, Selection};
use rijke_study::{Place, Study, StudyProblem, hertz};
use serde::Deserialize;
use std::f64::consts::{PI, TAU};

/// Asks for the law of a role over frequency.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Law {
    /// The role, of which the stage's model has a candidate.
    role: String,
    /// The points at which; those of the stage if absent.
    points: Option<Selection>,
    /// Frequencies from and to, Hz; about those that were measured if absent.
    frequency_hz: Option<[f64; 2]>,
    /// A formula of real names by which the law is divided.
    per: Option<String>,
    /// What it is called in the figure, as `F`.
    symbol: Option<String>,
}

/// Frequencies along a curve.
const STEPS: usize = 200;
/// Curves that a figure can show.
const CURVES: usize = 6;
/// Beyond the measured frequencies the axis reaches to these multiples of the lowest and the highest.
const MARGIN: [f64; 2] = [0.5, 1.2];

impl Ask for Law {
    const KIND: &'static str = "law";

    fn check(&self, study: &Study) -> Result<(), StudyProblem> {
        let missing = |key: &str, need| StudyProblem::Missing { key: key.to_owned(), need };
        if self.role.is_empty() {
            return Err(missing("role", "name the role whose law is shown"));
        }
        study.catalogue.known_role(&self.role)?;
        if let Some([from, to]) = self.frequency_hz
            && !(0.0 <= from && from < to && to.is_finite())
        {
            return Err(missing("frequency_hz", "give the lowest and a higher frequency, in Hz: [20, 400]"));
        }
        self.points.iter().try_for_each(|points| points.check(&study.campaign))?;
        self.per(study).map(|_| ())
    }

    fn answer(&self, run: &Run, question: &Question) -> Result<Found, EngineError> {
        let no_point = || EngineError::NothingToAnswer { question: question.id.clone() };
        let (_, stage) = run.study.plan.stage(&question.stage).ok_or_else(no_point)?;
        let chosen = run.chosen(&question.stage).ok_or_else(no_point)?;
        let candidates = chosen.assembly.candidates();
        let candidate = candidates.iter().position(|c| c.role == self.role).ok_or_else(no_point)?;
        let effects = &candidates[candidate].effects;
        let effect = effects.iter().position(|e| e.law.uses(S)).unwrap_or(0);
        let acts = effects.get(effect).ok_or_else(no_point)?;
        let per = self.per(&run.study).map_err(|why| EngineError::Study(question.fail(why)))?;
        let asked = Asked { chosen, law: [candidate, effect], place: &acts.place, per };

        let measured = || chosen.observed.iter().filter_map(|o| o.mode.angular_frequency).map(hertz);
        let band = match self.frequency_hz {
            Some(given) => given,
            None if measured().next().is_none() => return Err(no_point()),
            None => {
                let [low, high] = range(measured());
                [MARGIN[0] * low, MARGIN[1] * high]
            }
        };
        let points = self.points.as_ref().unwrap_or(&stage.points);
        let campaign = run.study.campaign.points.iter().enumerate();
        let known = campaign
            .filter(|(_, p)| points.holds(&run.study.campaign, p))
            .filter_map(|(k, p)| conditions(&run.study, p, run.states.get(&k), run.ambient[k]).ok());
        let mut curves: Vec<Curve> = Vec::new();
        for conditions in known {
            let Some(curve) = asked.curve(conditions, band)? else { continue };
            if !curves.iter().any(|other| other.is(&curve)) {
                curves.push(curve);
            }
        }
        if curves.is_empty() {
            return Err(no_point());
        }
        let different = curves.len();
        let shown: Vec<&Curve> = spread(different, CURVES).into_iter().map(|k| &curves[k]).collect();

        let law = format!("k_{{{}}}", acts.coefficient.name());
        let unit = if self.per.is_some() { "1" } else { acts.coefficient.unit(acts.place.is_along()) };
        let name = match (&self.symbol, &self.per) {
            (Some(name), _) => symbol(name),
            (None, Some(_)) => format!("{law}, divided"),
            (None, None) => law.clone(),
        };
        let columns = [
            ("frequency", "Frequency".to_owned(), "Hz"),
            ("modulus", format!("|{name}|"), unit),
            ("modulus_sd", format!("|{name}|, sd"), unit),
            ("phase", format!("Phase of {name}"), "rad"),
            ("phase_sd", format!("Phase of {name}, sd"), "rad"),
        ]
        .map(|(name, label, unit)| FrameColumn::new(name, &label, unit));
        let rows = shown.iter().flat_map(|curve| curve.rows()).collect();
        let mut dots = Vec::new();
        for curve in &shown {
            dots.extend(asked.measured(curve)?);
        }
        let panel = |y: usize| {
            let layer = |frame, look, sd| Layer { frame, look, x: 0, y, sd, mode: None };
            let layers = vec![layer(0, LayerLook::Band, Some(y + 1)), layer(1, LayerLook::Dots, None)];
            AnswerPanel { x: axis_label(&columns[0]), y: axis_label(&columns[y]), layers }
        };
        let panels = vec![panel(1), panel(3)];
        let divided = self.per.as_ref().map_or(String::new(), |per| format!(", divided by {per}"));
        let mut caption = format!(
            "{law} of {} at {}{divided}, at s = i omega, with two standard deviations (bands). Dots: what the model has at the frequencies of the modes \
             that were measured at these points; between and beyond them the curve follows from the form of the law.",
            candidates[candidate].id, acts.place_text
        );
        if different > shown.len() {
            caption += &format!(" {} of {different} different curves; `points` chooses others.", shown.len());
        }
        let frames = [rows, dots].map(|rows| Frame { columns: columns.to_vec(), rows });
        Ok((frames.to_vec(), panels, Vec::new(), caption))
    }
}

/// A law that is asked for.
struct Asked<'a> {
    chosen: &'a Chosen,
    /// Numbers of the candidate and of its effect.
    law: [usize; 2],
    place: &'a Place,
    per: Option<Formula>,
}

/// A law over frequency at a point.
struct Curve {
    conditions: Conditions,
    /// Frequencies, Hz.
    axis: Vec<f64>,
    values: Vec<LawValue>,
    /// Phases without jumps by turns; the first lies within half a turn of zero.
    phases: Vec<f64>,
}

impl Asked<'_> {
    fn model(&self, conditions: &Conditions) -> Result<(PointModel<'_>, f64), EngineError> {
        let x = conditions.layout.places(self.place).first().map_or(0.0, |(x, _)| *x);
        let per = self.per.as_ref().map_or(1.0, |per| per.real(&conditions.around(x)));
        Ok((PointModel::new(&self.chosen.assembly, conditions, &[])?, per))
    }

    /// The curve at a point; none where the law does not act.
    fn curve(&self, conditions: Conditions, [from, to]: [f64; 2]) -> Result<Option<Curve>, EngineError> {
        let (model, per) = self.model(&conditions)?;
        let axis: Vec<f64> = (0..=STEPS).map(|k| from + (to - from) * k as f64 / STEPS as f64).collect();
        let at = |f: &f64| LawValue::of(&model, self.law, along(*f), &self.chosen.trained);
        let Some(found) = axis.iter().map(at).collect::<Option<Vec<_>>>() else { return Ok(None) };
        drop(model);
        let values: Vec<LawValue> = found.into_iter().map(|v| v.over(per)).collect();
        let mut last = 0.0;
        let next = |v: &LawValue| {
            last += remainder(v.value.arg() - last);
            last
        };
        let phases = values.iter().map(next).collect();
        Ok(Some(Curve { conditions, axis, values, phases }))
    }

    /// The law at the frequencies of the modes that were measured at the point of a curve.
    fn measured(&self, curve: &Curve) -> Result<Vec<FrameRow>, EngineError> {
        let (model, per) = self.model(&curve.conditions)?;
        let id = &curve.conditions.id;
        let row = |o: &Observed| {
            let f = o.mode.angular_frequency.map(hertz)?;
            let beside = curve.axis.iter().position(|at| *at >= f)?.max(1) - 1;
            let v = LawValue::of(&model, self.law, along(f), &self.chosen.trained)?.over(per);
            let near = curve.phases[beside];
            Some(v.row(id, &o.mode.label, f, near + remainder(v.value.arg() - near)))
        };
        Ok(self.chosen.observed.iter().filter(|o| o.conditions.id == *id).filter_map(row).collect())
    }
}

impl Curve {
    /// Whether another has the same values.
    fn is(&self, other: &Self) -> bool {
        let same = |(a, b): (&LawValue, &LawValue)| (a.value - b.value).norm() <= 1e-9 * a.value.norm();
        self.values.iter().zip(&other.values).all(same)
    }

    fn rows(&self) -> impl Iterator<Item = FrameRow> {
        let all = self.axis.iter().zip(&self.values).zip(&self.phases);
        all.map(|((f, value), phase)| value.row(&self.conditions.id, "", *f, *phase))
    }
}

impl Law {
    /// The formula by which the law is divided.
    fn per(&self, study: &Study) -> Result<Option<Formula>, StudyProblem> {
        let Some(text) = &self.per else { return Ok(None) };
        let scope = &study.rig.scope;
        let real = |name: usize| scope.names()[name].kind != Kind::Analytic;
        let context = Context { scope, here: &real, parameters: &[], definitions: &[] };
        let found = Formula::parse(text, &context);
        found.map(Some).map_err(|source| StudyProblem::Formula { key: "per".to_owned(), source })
    }
}

/// A law at one s, with standard deviations to first order.
#[derive(Clone, Copy)]
pub(super) struct LawValue {
    pub(super) value: C64,
    pub(super) modulus_sd: f64,
    pub(super) phase_sd: f64,
}

impl LawValue {
    /// Of an effect of a candidate at s, both by their numbers; none if nothing follows that law there.
    pub(super) fn of(model: &PointModel<'_>, effect: [usize; 2], s: C64, trained: &Trained) -> Option<Self> {
        let (value, gradient) = model.law_at(trained.best(), s, effect)?;
        let modulus = value.norm();
        // d|k| = Re(conj(k) dk)/|k|; d arg k = Im(conj(k) dk)/|k|^2.
        let sd = |part: fn(C64) -> f64, over: f64| {
            let slope: Vec<f64> = gradient.iter().map(|d| part(value.conj() * d) / over).collect();
            let own = Matrix::from_fn(slope.len(), slope.len(), |i, j| trained.covariance[(i, j)]);
            own.quadratic(&slope).max(0.0).sqrt()
        };
        Some(Self { value, modulus_sd: sd(|z| z.re, modulus), phase_sd: sd(|z| z.im, modulus * modulus) })
    }

    /// The same divided by a real number.
    pub(super) fn over(self, per: f64) -> Self {
        Self { value: self.value / per, modulus_sd: self.modulus_sd / per.abs(), ..self }
    }

    /// Real and imaginary part, modulus and its standard deviation, angle and its standard deviation.
    pub(super) fn numbers(&self) -> [f64; 6] {
        let Self { value, modulus_sd, phase_sd } = *self;
        [value.re, value.im, value.norm(), modulus_sd, value.arg().rem_euclid(TAU), phase_sd]
    }

    fn row(&self, point: &str, mode: &str, frequency: f64, phase: f64) -> FrameRow {
        FrameRow {
            label: point.to_owned(),
            series: point.to_owned(),
            mode: mode.to_owned(),
            values: [frequency, self.value.norm(), self.modulus_sd, phase, self.phase_sd]
                .map(finite)
                .to_vec(),
        }
    }
}

/// s on the axis of real frequencies, of one in Hz.
fn along(frequency: f64) -> C64 {
    C64::new(0.0, TAU * frequency)
}

/// An angle within half a turn of zero.
fn remainder(angle: f64) -> f64 {
    angle - TAU * ((angle + PI) / TAU).floor()
}

/// At most `most` of the numbers below `all`, the first and the last among them.
fn spread(all: usize, most: usize) -> Vec<usize> {
    if all <= most { (0..all).collect() } else { (0..most).map(|k| k * (all - 1) / (most - 1)).collect() }
}
