//! What response models predict, as a forward model of an inference.

use super::fill::Filled;
use super::model::{LawOf, ResponseModel};
use crate::EngineError;
use rayon::prelude::*;
use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_network::{Source, Workspace};
use rijke_numerics::{C64, Jet, Matrix, Order};
use rijke_study::responses::Quantity;
use std::f64::consts::PI;

/// One response: its model, what it is, and the frequencies (Hz) at which it is wanted.
#[derive(Clone, Debug)]
pub(super) struct Load<'a> {
    pub(super) point: String,
    pub(super) model: ResponseModel<'a>,
    pub(super) what: Quantity,
    pub(super) frequency_hz: Vec<f64>,
}

/// All responses of a training, in the order of its data: load after load, real and imaginary part in turn.
#[derive(Clone, Debug)]
pub(super) struct Responses<'a> {
    pub(super) loads: Vec<Load<'a>>,
    pub(super) parameters: usize,
}

impl Load<'_> {
    /// The response at every frequency, with derivatives in the free parameters and s.
    pub(super) fn answer(&self, values: &[f64], order: Order) -> Result<Vec<Jet>, EngineError> {
        let filled = Filled::new(&self.model, values, order);
        if !filled.is_possible() {
            let segments = self.model.network.segments().len();
            let source =
                rijke_network::NetworkError::Segment { index: segments, quantity: "length", value: f64::NAN };
            return Err(EngineError::Network { point: self.point.clone(), source });
        }
        let order = order.max(Order::First);
        self.frequency_hz
            .par_iter()
            .map_init(Workspace::default, |work, f| {
                self.at(&filled, C64::new(0.0, 2.0 * PI * f), order, work)
            })
            .collect()
    }

    fn at(
        &self,
        filled: &Filled<'_>,
        s: C64,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Jet, EngineError> {
        let network = &self.model.network;
        let fail = |source| EngineError::Network { point: self.point.clone(), source };
        match &self.what {
            Quantity::Reflection { reference_area, .. } => {
                let r = network.reflection_at(filled, s, 0, order, work).map_err(fail)?;
                let Some(reference) = reference_area else { return Ok(r) };
                // z = (1 + R)/(1 - R) times the ratio of areas.
                let ratio = filled.first_area().recip().scale(C64::new(*reference, 0.0));
                let up = &ratio * &r.shift(C64::ONE);
                let down = (-&r).shift(C64::ONE);
                Ok(&(&up - &down) / &(&up + &down))
            }
            Quantity::Transfer { to, from } => {
                let forced = network.forced(filled, s, Source::Upstream, order, work).map_err(fail)?;
                let [to, from] = [to, from].map(|m| &forced.before[self.model.microphones[*m]][0]);
                Ok(to / from)
            }
            Quantity::Law { at, coefficient, factor } => {
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
    /// All answers, load after load.
    pub(super) fn answers(&self, values: &[f64], order: Order) -> Result<Vec<Vec<Jet>>, EngineError> {
        self.loads.iter().map(|load| load.answer(values, order)).collect()
    }
}

/// The same without second derivatives, which cost several times the first and change the path of a search, not its end.
pub(super) struct Quick<'a, 'b>(pub(super) &'b Responses<'a>);

impl Forward for Quick<'_, '_> {
    fn predict(&self, values: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        self.0.predict(values, order.min(Order::First))
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}

impl Forward for Responses<'_> {
    fn predict(&self, values: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let answers = self.answers(values, order).map_err(|error| {
            let impossible = matches!(
                error,
                EngineError::Network { source: rijke_network::NetworkError::Segment { .. }, .. }
            );
            if impossible || error.is_recoverable() {
                ForwardError::recoverable(error)
            } else {
                ForwardError::fatal(error)
            }
        })?;
        let (p, n) = (self.parameters, 2 * answers.iter().map(Vec::len).sum::<usize>());
        let all = || answers.iter().flatten();
        let values: Vec<f64> = all().flat_map(|jet| [jet.value().re, jet.value().im]).collect();
        if order == Order::Value {
            return Ok(Prediction { values, ..Prediction::default() });
        }
        let mut jacobian = Matrix::zeros(n, p);
        for (k, jet) in all().enumerate() {
            for (i, slope) in jet.gradient().iter().take(p).enumerate() {
                (jacobian[(2 * k, i)], jacobian[(2 * k + 1, i)]) = (slope.re, slope.im);
            }
        }
        let mut curvature = Vec::new();
        if order == Order::Second {
            // s is the last seed, so that the triangle of the parameters comes first.
            let packed = p * (p + 1) / 2;
            curvature.reserve(n * packed);
            for jet in all() {
                let triangle = &jet.hessian_packed()[..packed];
                curvature.extend(triangle.iter().map(|z| z.re));
                curvature.extend(triangle.iter().map(|z| z.im));
            }
        }
        Ok(Prediction { values, jacobian, curvature })
    }
}
