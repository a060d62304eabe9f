//! What response models predict, as a forward model of an inference.

use super::channels::ChannelsOfResponses;
use super::errors::Errors;
use super::head::HeardResponses;
use super::measured::{Measured, sessions};
use crate::shape::{FilledShape, LawOf, ShapeModel};
use crate::{Assembly, Conditions, EngineError};
use rayon::prelude::*;
use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_network::{Source, Workspace};
use rijke_numerics::{C64, InOrder, Jet, Matrix, Order};
use rijke_study::Place;
use rijke_study::responses::ResponseKind;
use std::f64::consts::PI;

/// One response: its model, what it is, and the frequencies (Hz) at which it is wanted.
#[derive(Clone, Debug)]
pub(super) struct Load<'a> {
    pub(super) point: String,
    pub(super) model: ShapeModel<'a>,
    pub(super) what: ResponseKind,
    pub(super) frequency_hz: Vec<f64>,
}

/// All responses of a training, in the order of its data: load after load, real and imaginary part in turn.
#[derive(Clone, Debug)]
pub(super) struct Responses<'a> {
    pub(super) loads: Vec<Load<'a>>,
    /// Parameters of the model; those of errors, then those of the channels come behind them.
    pub(super) own: usize,
    pub(super) errors: Errors,
    pub(super) channels: ChannelsOfResponses,
}

impl<'a> Load<'a> {
    /// A response under these conditions.
    ///
    /// # Errors
    /// Those of [`ShapeModel::new`], and propagation constants that other waves than those of sources have.
    pub(super) fn new(
        assembly: &'a Assembly,
        conditions: &Conditions,
        what: &ResponseKind,
        frequency_hz: &[f64],
    ) -> Result<Self, EngineError> {
        let sources = if let ResponseKind::Pressure { sources, .. } = what { sources.len() } else { 0 };
        assembly.waves_for(sources, &conditions.layout)?;
        Ok(Self {
            point: conditions.id.clone(),
            model: ShapeModel::new(assembly, conditions, &conditions.layout.microphones)?,
            what: what.clone(),
            frequency_hz: frequency_hz.to_vec(),
        })
    }

    /// The response at every frequency, with derivatives in the free parameters and s.
    pub(super) fn answer(&self, values: &[f64], order: Order) -> Result<Vec<Jet>, EngineError> {
        self.each(values, order, |filled, s, order, work| self.at(filled, s, order, work))
    }

    /// The pressures that waves of unit pressure from `sources` make, by frequency, source and place.
    fn made(
        &self,
        values: &[f64],
        sources: &[Place],
        order: Order,
    ) -> Result<Vec<Vec<Vec<Jet>>>, EngineError> {
        let carried = self.model.has_waves();
        self.each(values, order, |filled, s, order, work| {
            let one = |source: &Place| {
                if carried {
                    return Ok(filled.carried(s, source));
                }
                let entering = if *source == Place::Upstream { Source::Upstream } else { Source::Downstream };
                let forced = self.model.network.forced(filled, s, entering, order, work);
                let forced =
                    forced.map_err(|source| EngineError::Network { point: self.point.clone(), source })?;
                Ok(forced.before.into_iter().map(|[p, _]| p).collect())
            };
            sources.iter().map(one).collect()
        })
    }

    /// What `one` says at every frequency.
    fn each<T: Send>(
        &self,
        values: &[f64],
        order: Order,
        one: impl Fn(&FilledShape<'_>, C64, Order, &mut Workspace) -> Result<T, EngineError> + Sync,
    ) -> Result<Vec<T>, EngineError> {
        let order = order.max(Order::First);
        let filled = FilledShape::new(&self.model, values, self.model.space(order), &self.point)?;
        self.frequency_hz
            .par_iter()
            .map_init(Workspace::default, |work, f| one(&filled, C64::new(0.0, 2.0 * PI * f), order, work))
            .in_order()
    }

    fn at(
        &self,
        filled: &FilledShape<'_>,
        s: C64,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Jet, EngineError> {
        let network = &self.model.network;
        let fail = |source| EngineError::Network { point: self.point.clone(), source };
        match &self.what {
            ResponseKind::Reflection { reference_area, .. } => {
                let r = network.reflection_at(filled, s, 0, order, work).map_err(fail)?;
                let Some(reference) = reference_area else { return Ok(r) };
                // z = (1 + R)/(1 - R) times the ratio of areas.
                let ratio = filled.first_area().recip().scale(C64::new(*reference, 0.0));
                let up = &ratio * &r.shift(C64::ONE);
                let down = (-&r).shift(C64::ONE);
                Ok(&(&up - &down) / &(&up + &down))
            }
            ResponseKind::Transfer { to, from } => {
                let forced = network.forced(filled, s, Source::Upstream, order, work).map_err(fail)?;
                let [to, from] = [to, from].map(|m| &forced.before[self.model.microphones[*m]][0]);
                Ok(to / from)
            }
            ResponseKind::Pressure { .. } => Err(EngineError::Unsettled {
                what: "a pressure of an unknown source is no number of the rig".to_owned(),
            }),
            ResponseKind::Law { at, coefficient, factor } => {
                let space = self.model.space(order);
                let s = space.seed(space.seeds() - 1, s);
                let walls = filled.walls(&s);
                let mut sum = space.real(0.0);
                for law in &self.model.laws {
                    let LawOf::Effect { candidate, effect, around } = *law else { continue };
                    let own = self.model.effect(candidate, effect);
                    if own.coefficient == *coefficient && own.place == *at {
                        sum = &sum + &filled.effect([candidate, effect, around], &s, &walls);
                    }
                }
                Ok(sum.scale(C64::new(factor.real(&self.model.numbers), 0.0)))
            }
        }
    }
}

impl Responses<'_> {
    /// All parameters, those of errors and of the channels among them.
    pub(super) fn parameters(&self) -> usize {
        self.own + self.errors.causes.len() + self.channels.parameters.len()
    }

    /// All answers with the errors, as the channels give them, load after load. With unknown sources: at each
    /// frequency what every one of them makes.
    pub(super) fn answers(&self, values: &[f64], order: Order) -> Result<Vec<Vec<Jet>>, EngineError> {
        let (own, rest) = values.split_at(self.own);
        let (errors, channels) = rest.split_at(self.errors.causes.len());
        let mut answers = clear(&self.loads, own, order)?;
        if !errors.is_empty() {
            for (load, answers) in answers.iter_mut().enumerate() {
                *answers = self.errors.with(load, answers, own, errors);
            }
        }
        if channels.is_empty() {
            return Ok(answers);
        }
        let before = own.len() + errors.len();
        let of_load = |(load, answers): (usize, &Vec<Jet>)| {
            let frequencies = &self.loads[load].frequency_hz;
            let sources = answers.len() / frequencies.len().max(1);
            let at = |(k, answer): (usize, &Jet)| {
                self.channels.heard(load, frequencies[k / sources.max(1)], answer, before, channels)
            };
            answers.iter().enumerate().map(at).collect()
        };
        Ok(answers.iter().enumerate().map(of_load).collect())
    }
}

/// The answers of loads without errors, load after load; with unknown sources at each frequency what every
/// one of them makes.
pub(super) fn clear(loads: &[Load<'_>], values: &[f64], order: Order) -> Result<Vec<Vec<Jet>>, EngineError> {
    // What one source makes at all microphones is one answer of the rig, whatever the excitation.
    let mut known: Vec<(&Load<'_>, Vec<Vec<Vec<Jet>>>)> = Vec::new();
    let mut all = Vec::with_capacity(loads.len());
    for load in loads {
        let ResponseKind::Pressure { microphone, sources, .. } = &load.what else {
            all.push(load.answer(values, order)?);
            continue;
        };
        let of = |(other, _): &&(&Load<'_>, _)| {
            let same =
                matches!(&other.what, ResponseKind::Pressure { sources: known, .. } if known == sources);
            same && other.point == load.point && other.frequency_hz == load.frequency_hz
        };
        let found = match known.iter().position(|k| of(&k)) {
            Some(found) => found,
            None => {
                known.push((load, load.made(values, sources, order)?));
                known.len() - 1
            }
        };
        let place = load.model.microphones[*microphone];
        let at = |made: &Vec<Vec<Jet>>| {
            made.iter().map(move |by_place| by_place[place].clone()).collect::<Vec<_>>()
        };
        all.push(known[found].1.iter().flat_map(at).collect());
    }
    Ok(all)
}

/// What the head tells of all responses, as far as its errors are known: the forward model of a training.
pub(super) struct Told<'a, 'b> {
    pub(super) responses: &'b Responses<'a>,
    pub(super) measured: &'b [Measured],
    pub(super) heard: &'b HeardResponses,
    /// Second derivatives cost several times the first and change the path of a search, not its end.
    pub(super) highest: Order,
}

impl Forward for Told<'_, '_> {
    fn highest_order(&self) -> Order {
        self.highest
    }

    fn predict(&self, values: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let order = order.min(self.highest);
        let answers = self.responses.answers(values, order)?;
        let tilt = self.heard.tilted(&answers);
        let told = |range| self.heard.told(self.measured, range, &answers);
        let all: Vec<Jet> = sessions(self.measured).into_iter().flat_map(told).collect();
        let (p, n) = (self.responses.parameters(), 2 * all.len());
        let mut values: Vec<f64> = all.iter().flat_map(|jet| [jet.value().re, jet.value().im]).collect();
        values.extend(tilt.iter().map(|jet| jet.value().re));
        if order == Order::Value {
            return Ok(Prediction { values, ..Prediction::default() });
        }
        let mut jacobian = Matrix::zeros(values.len(), p);
        for (k, jet) in all.iter().enumerate() {
            for (i, slope) in jet.gradient().iter().take(p).enumerate() {
                (jacobian[(2 * k, i)], jacobian[(2 * k + 1, i)]) = (slope.re, slope.im);
            }
        }
        for (i, slope) in tilt.iter().flat_map(|jet| jet.gradient().iter().take(p).enumerate()) {
            jacobian[(n, i)] = slope.re;
        }
        let mut curvature = Vec::new();
        if order == Order::Second {
            // s is the last seed, so that the triangle of the parameters comes first.
            let packed = p * (p + 1) / 2;
            curvature.reserve(values.len() * packed);
            for jet in &all {
                let triangle = &jet.hessian_packed()[..packed];
                curvature.extend(triangle.iter().map(|z| z.re));
                curvature.extend(triangle.iter().map(|z| z.im));
            }
            curvature.extend(tilt.iter().flat_map(|jet| jet.hessian_packed()[..packed].iter().map(|z| z.re)));
        }
        Ok(Prediction { values, jacobian, curvature })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Assembly, run::conditions_at};
    use rijke_numerics::check::{slopes_from, slopes_near};
    use rijke_study::Study;
    use std::path::Path;
    use std::sync::Arc;

    #[test]
    fn order_responses_have_their_derivatives_in_lengths_and_radii() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/side-hole-tube");
        let study = Study::open(&folder).unwrap();
        let candidates =
            ["wall.bessel", "mouth.unflanged"].map(|id| study.catalogue.get(id).unwrap().clone()).to_vec();
        let assembly = Assembly::new(Arc::new(study.rig.clone()), candidates, &Default::default()).unwrap();
        let names: Vec<&str> = assembly.parameters().iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["bore", "b1", "b2", "b3", "b4", "extra"]);
        let conditions = conditions_at(&study, 1).unwrap();
        let load = Load {
            point: "s1-xxxo".into(),
            model: ShapeModel::new(&assembly, &conditions, &conditions.layout.microphones).unwrap(),
            what: ResponseKind::Reflection { at: Place::Upstream, reference_area: Some(1.2e-5) },
            frequency_hz: vec![333.0, 1490.0, 3800.0],
        };
        let at = [1.97e-3, 1.5e-3, 1.7e-3, 1.75e-3, 1.3e-3, 2e-4];
        let found = load.answer(&at, Order::Second).unwrap();
        for direction in [
            [1e-4, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1e-4, -1e-4, 0.0],
            [5e-5, 1e-4, 0.0, 0.0, 5e-5, 2e-4],
        ] {
            for (k, jet) in found.iter().enumerate() {
                let slope: C64 = (0..6).map(|i| jet.gradient()[i] * direction[i]).sum();
                let bend: C64 = (0..6)
                    .flat_map(|i| (0..6).map(move |j| (i, j)))
                    .map(|(i, j)| 0.5 * jet.hessian(i, j) * direction[i] * direction[j])
                    .sum();
                let moved = |h: f64| {
                    let values: Vec<f64> = at.iter().zip(&direction).map(|(a, d)| a + h * d).collect();
                    load.answer(&values, Order::Value).unwrap()[k].value() - jet.value()
                };
                slopes_near(&slopes_from(0.3, |h| (moved(h) - slope * h).norm()), 2.0, 0.15);
                slopes_near(&slopes_from(0.3, |h| (moved(h) - slope * h - bend * h * h).norm()), 3.0, 0.4);
            }
        }
    }
}
