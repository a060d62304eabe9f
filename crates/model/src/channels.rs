//! Errors of the channels' calibration as parameters that all operating points share.

use crate::data::places;
use crate::{Knowledge, Observed, Training};
use rijke_inference::{Forward, ForwardError, InferenceError, Parameter, Parameters, Prediction, Prior};
use rijke_numerics::{C64, Matrix, Order};
use rijke_rig::Ping;

/// The delays and gains of the chosen microphones but the reference, which a training finds together with the model: a relative
/// pressure P is measured as P (1 + s d - g). Taken as noise of each point, their error would seem to vanish in the mean over
/// points; as parameters it stays.
pub(crate) struct Channels {
    /// First the delays d, then the gains g.
    pub(crate) parameters: Vec<Parameter>,
    /// For each of the microphones its place among all but the reference.
    places: Vec<usize>,
    covariance: Matrix,
}

impl Channels {
    /// None where nothing is known of the calibration, or one microphone alone is used.
    pub(crate) fn of(observed: &[Observed], training: &Training) -> Option<Self> {
        let errors = training.channels.as_ref()?;
        let ping = &observed.first()?.ping;
        let places = places(ping, &training.microphones);
        let (delays, gains) = (errors.delays.select(&places), errors.gains.select(&places));
        let n = places.len();
        let covariance = Matrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => delays[(i, j)],
            (false, false) => gains[(i - n, j - n)],
            _ => 0.0,
        });
        let parameter = |k: usize| {
            let place = places[k % n];
            let microphone = place + usize::from(place >= ping.reference);
            let (word, letter, unit) = if k < n { (DELAY, "d", "s") } else { (GAIN, "g", "1") };
            let prior = Prior::Normal { mean: 0.0, sd: covariance[(k, k)].sqrt() };
            Parameter::new(name(word, microphone), format!("{letter}_{}", microphone + 1), unit, prior)
        };
        let parameters: Vec<Parameter> = (0..2 * n).map(parameter).collect();
        (n > 0).then_some(Self { parameters, places, covariance })
    }

    /// The calibration as the prior, unless an earlier stage already knows better.
    pub(crate) fn prior(
        &self,
        parameters: Parameters,
        training: &Training,
    ) -> Result<Parameters, InferenceError> {
        let names: Vec<&str> = self.parameters.iter().map(|p| p.name.as_str()).collect();
        let known = |name: &str| training.known.iter().any(|k| k.names.iter().any(|n| n == name));
        if names.iter().any(|name| known(name)) {
            return Ok(parameters);
        }
        parameters.with_joint(&names, &vec![0.0; names.len()], &self.covariance)
    }

    /// The covariance of a ping without the share that these parameters stand for.
    pub(crate) fn apart_from(&self, ping: &Ping) -> Ping {
        let vector = ping.vector();
        let n = self.places.len();
        let mut slopes = Matrix::zeros(vector.len(), 2 * n);
        for (m, place) in self.places.iter().enumerate() {
            let row = 2 + 2 * place;
            let p = C64::new(vector[row], vector[row + 1]);
            for (column, z) in [(m, p * ping.s), (n + m, -p)] {
                (slopes[(row, column)], slopes[(row + 1, column)]) = (z.re, z.im);
            }
        }
        let shared = slopes.product(&self.covariance).product(&slopes.transpose());
        Ping { covariance: ping.covariance.plus(-1.0, &shared), ..ping.clone() }
    }
}

impl Knowledge {
    /// A ping with the delays and gains of channels undone that a training found; as it is where none were sought. Their uncertainty,
    /// which many points have made small against the misfit of any model, is left out.
    #[must_use]
    pub fn without_channels(&self, ping: &Ping) -> Ping {
        let found = |word: &str, m: usize| {
            let name = name(word, m);
            self.names.iter().position(|n| *n == name).map_or(0.0, |k| self.mean[k])
        };
        let clear = |(m, p): (usize, &C64)| p / (1.0 + ping.s * found(DELAY, m) - found(GAIN, m));
        Ping { pressures: ping.pressures.iter().enumerate().map(clear).collect(), ..ping.clone() }
    }
}

const DELAY: &str = "delay";
const GAIN: &str = "gain";

/// Microphones are counted from 1, as in the tables of observations.
fn name(word: &str, microphone: usize) -> String {
    format!("{word} of microphone {}", microphone + 1)
}

/// A model heard through channels whose delays and gains are parameters after its own.
pub(crate) struct Heard<'a> {
    pub(crate) inner: &'a dyn Forward,
    /// Number of its parameters.
    pub(crate) own: usize,
    /// s of every operating point, as measured.
    pub(crate) s: Vec<C64>,
    /// Number of microphones but the reference; zero where nothing is known of the channels.
    pub(crate) others: usize,
}

impl<'a> Heard<'a> {
    pub(crate) fn new(
        inner: &'a dyn Forward,
        own: usize,
        channels: Option<&Channels>,
        observed: &[Observed],
    ) -> Self {
        let others = channels.map_or(0, |c| c.places.len());
        Self { inner, own, s: observed.iter().map(|o| o.ping.s).collect(), others }
    }
}

impl Forward for Heard<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        if self.others == 0 {
            return self.inner.predict(parameters, order);
        }
        let (own, errors) = parameters.split_at(self.own);
        let mut heard = self.inner.predict(own, order)?;
        let (n, p, size) = (self.others, parameters.len(), 2 + 2 * self.others);
        let (inner_triangle, triangle) = (self.own * (self.own + 1) / 2, p * (p + 1) / 2);
        let clear = std::mem::take(&mut heard.jacobian);
        let bent = std::mem::take(&mut heard.curvature);
        let rows = heard.values.len();
        if order >= Order::First {
            heard.jacobian = Matrix::zeros(rows, p);
        }
        if order == Order::Second && !bent.is_empty() {
            heard.curvature = vec![0.0; rows * triangle];
        }
        for row in (0..rows).step_by(2) {
            let (s, number) = (self.s[row / size], row % size);
            // s itself is heard as it is.
            let microphone = (number > 1).then(|| number / 2 - 1);
            let factor = microphone.map_or(C64::ONE, |m| 1.0 + s * errors[m] - errors[n + m]);
            // What a delay and a gain multiply.
            let by_error = microphone.into_iter().flat_map(|m| [(m, s), (n + m, -C64::ONE)]);
            let clear_value = C64::new(heard.values[row], heard.values[row + 1]);
            let value = clear_value * factor;
            (heard.values[row], heard.values[row + 1]) = (value.re, value.im);
            if order == Order::Value {
                continue;
            }
            let slope = |i: usize| C64::new(clear[(row, i)], clear[(row + 1, i)]);
            let mut set = |i: usize, z: C64| {
                (heard.jacobian[(row, i)], heard.jacobian[(row + 1, i)]) = (z.re, z.im);
            };
            (0..self.own).for_each(|i| set(i, slope(i) * factor));
            by_error.clone().for_each(|(k, z)| set(self.own + k, clear_value * z));
            if heard.curvature.is_empty() {
                continue;
            }
            let mut set = |place: usize, z: C64| {
                heard.curvature[row * triangle + place] = z.re;
                heard.curvature[(row + 1) * triangle + place] = z.im;
            };
            for place in 0..inner_triangle {
                let [re, im] = [row, row + 1].map(|r| bent[r * inner_triangle + place]);
                set(place, C64::new(re, im) * factor);
            }
            for (k, z) in by_error {
                let i = self.own + k;
                (0..self.own).for_each(|j| set(i * (i + 1) / 2 + j, slope(j) * z));
            }
        }
        Ok(heard)
    }

    fn highest_order(&self) -> Order {
        self.inner.highest_order()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::check::{slopes_from, slopes_near};

    /// Two points, a reference and one other microphone: s and P are (a + i b)^2 and (a - i b)^2 times the point's number.
    struct Squares;

    impl Forward for Squares {
        fn predict(&self, p: &[f64], _: Order) -> Result<Prediction, ForwardError> {
            let mut out = Prediction { jacobian: Matrix::zeros(8, 2), ..Prediction::default() };
            for k in 0..4 {
                let (unit, scale) = (if k % 2 == 0 { C64::I } else { -C64::I }, 1.0 + f64::from(k / 2));
                let z = p[0] + unit * p[1];
                let slopes = [2.0 * scale * z, 2.0 * scale * z * unit];
                let bends = [2.0 * scale * C64::ONE, 2.0 * scale * unit, 2.0 * scale * unit * unit];
                for part in [|z: C64| z.re, |z: C64| z.im] {
                    let row = out.values.len();
                    out.values.push(part(scale * z * z));
                    (0..2).for_each(|i| out.jacobian[(row, i)] = part(slopes[i]));
                    out.curvature.extend(bends.map(part));
                }
            }
            Ok(out)
        }
    }

    #[test]
    fn order_derivatives_through_channels_have_falling_taylor_remainders() {
        let s = vec![C64::new(-1.0, 2.0), C64::new(-2.0, 3.0)];
        let heard = Heard { inner: &Squares, own: 2, s, others: 1 };
        let (at, along) = ([0.7, 0.4, 0.02, -0.03], [0.3, -0.5, 0.2, 0.4]);
        let values = |h: f64| {
            let moved: Vec<f64> = at.iter().zip(along).map(|(a, d)| a + h * d).collect();
            heard.predict(&moved, Order::Second).unwrap()
        };
        let here = values(0.0);
        for row in 0..8 {
            let first: f64 = (0..4).map(|i| here.jacobian[(row, i)] * along[i]).sum();
            let bend = |i: usize, j: usize| {
                let (i, j) = (i.max(j), i.min(j));
                here.curvature[row * 10 + i * (i + 1) / 2 + j]
            };
            let second: f64 = (0..4)
                .flat_map(|i| (0..4).map(move |j| (i, j)))
                .map(|(i, j)| bend(i, j) * along[i] * along[j])
                .sum();
            let change = |h: f64| values(h).values[row] - here.values[row] - h * first;
            slopes_near(&slopes_from(0.2, |h| change(h).abs()), 2.0, 0.3);
            // s is a square, P a square times what the channel makes of it: of third order.
            let third = |h: f64| change(h) - 0.5 * h * h * second;
            if row % 4 < 2 {
                assert!(third(0.2).abs() < 1e-12);
            } else {
                slopes_near(&slopes_from(0.2, |h| third(h).abs()), 3.0, 0.05);
            }
        }
    }
}
