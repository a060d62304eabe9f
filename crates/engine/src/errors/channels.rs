//! Errors of the channels' calibration as parameters that all operating points share.

use crate::observed::{Observed, Used};
use crate::{NamedGaussian, Training};
use rijke_inference::{Forward, ForwardError, InferenceError, Parameter, Parameters, Prediction, Prior};
use rijke_numerics::{C64, Matrix, Order, packed};
use rijke_rig::{ChannelErrors, ModeRows};
use rijke_study::Rig;

/// The delays and gains of the chosen microphones but the reference, which a training finds together with the
/// model: a relative pressure P is measured as P (1 - s d + g). Taken as noise of each point, their error
/// would seem to vanish in the mean over points; as parameters it stays.
pub(crate) struct ChannelsOfModes {
    /// First the delays d, then the gains g.
    pub(crate) parameters: Vec<Parameter>,
    /// The microphones, but the reference.
    pub(crate) microphones: Vec<usize>,
    /// Of all of them, by what is stated.
    pub(crate) covariance: Matrix,
}

impl ChannelsOfModes {
    /// None where nothing is known of the calibration, or one microphone alone is used.
    pub(crate) fn of(rig: &Rig, errors: Option<&ChannelErrors>, chosen: &[usize]) -> Option<Self> {
        let errors = errors?;
        let (reference, count) = (rig.microphones.reference, rig.microphones.names.len());
        let others = (0..count).filter(|m| *m != reference);
        let microphones: Vec<usize> = others.filter(|m| chosen.contains(m)).collect();
        let places: Vec<usize> = microphones.iter().map(|m| m - usize::from(*m > reference)).collect();
        let (delays, gains) = (errors.delays.select(&places), errors.gains.select(&places));
        let n = places.len();
        let covariance = Matrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, true) => delays[(i, j)],
            (false, false) => gains[(i - n, j - n)],
            _ => 0.0,
        });
        let parameter = |k: usize| {
            let microphone = microphones[k % n];
            let (word, letter, unit) = if k < n { (DELAY, "d", "s") } else { (GAIN, "g", "1") };
            let prior = Prior::Normal { mean: 0.0, sd: covariance[(k, k)].sqrt() };
            let label = &rig.microphones.names[microphone];
            Parameter::new(name(word, label), format!("{letter}_{label}"), unit, prior)
        };
        let parameters: Vec<Parameter> = (0..2 * n).map(parameter).collect();
        (n > 0).then_some(Self { parameters, microphones, covariance })
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

    /// Takes from the covariance of an observation the share that these parameters stand for.
    pub(crate) fn take_from(&self, observed: &Observed, used: &mut Used) {
        let n = self.microphones.len();
        let mut slopes = Matrix::zeros(used.values.len(), 2 * n);
        for (k, (microphone, p)) in used.others.iter().zip(&used.pressures).enumerate() {
            let Some(m) = self.microphones.iter().position(|other| other == microphone) else { continue };
            let Some(row) = used.rows.iter().position(|row| *row == ModeRows::pressure(k)) else { continue };
            for (column, z) in [(m, -p * observed.near), (n + m, *p)] {
                (slopes[(row, column)], slopes[(row + 1, column)]) = (z.re, z.im);
            }
        }
        let shared = slopes.product(&self.covariance).product(&slopes.transpose());
        used.covariance = used.covariance.plus(-1.0, &shared);
    }
}

impl NamedGaussian {
    /// An observation with the delays and gains of channels undone that a training found; as it is where none
    /// were sought. Their uncertainty, which many points have made small against the misfit of any model, is
    /// left out.
    #[must_use]
    pub fn without_channels(&self, rig: &Rig, observed: &Observed) -> Observed {
        let found = |word: &str, m: usize| {
            let name = name(word, &rig.microphones.names[m]);
            self.names.iter().position(|n| *n == name).map_or(0.0, |k| self.mean[k])
        };
        let mut clear = observed.clone();
        for (m, p) in &mut clear.mode.pressures {
            *p /= 1.0 - observed.near * found(DELAY, *m) + found(GAIN, *m);
        }
        clear
    }
}

const DELAY: &str = "delay";
const GAIN: &str = "gain";

fn name(word: &str, microphone: &str) -> String {
    format!("{word} of {microphone}")
}

/// A model heard through channels whose delays and gains are parameters after its own.
pub(crate) struct ThroughChannels<'a> {
    pub(crate) inner: &'a dyn Forward,
    /// Number of its parameters.
    pub(crate) own: usize,
    /// s of every observation, as measured, and for each of its pressures the place of the microphone among
    /// the parameters.
    pub(crate) heard: Vec<(C64, Vec<usize>)>,
    /// Number of microphones but the reference; zero where nothing is known of the channels.
    pub(crate) others: usize,
}

impl<'a> ThroughChannels<'a> {
    pub(crate) fn new(
        inner: &'a dyn Forward,
        own: usize,
        channels: Option<&ChannelsOfModes>,
        observed: &[Observed],
        used: &[Used],
    ) -> Self {
        let others = channels.map_or(0, |c| c.microphones.len());
        let place = |m: &usize| channels.and_then(|c| c.microphones.iter().position(|other| other == m));
        let of = |(o, u): (&Observed, &Used)| (o.near, u.others.iter().filter_map(place).collect());
        Self { inner, own, heard: observed.iter().zip(used).map(of).collect(), others }
    }
}

impl Forward for ThroughChannels<'_> {
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        if self.others == 0 {
            return self.inner.predict(parameters, order);
        }
        let (own, errors) = parameters.split_at(self.own);
        let mut heard = self.inner.predict(own, order)?;
        let (n, p) = (self.others, parameters.len());
        let (inner_triangle, triangle) = (self.own * (self.own + 1) / 2, p * (p + 1) / 2);
        let clear = std::mem::take(&mut heard.jacobian);
        let bent = std::mem::take(&mut heard.curvature);
        let rows = heard.values.len();
        if order >= Order::First {
            heard.jacobian = Matrix::zeros(rows, p);
        }
        // A model without parameters of its own has no second derivatives to give.
        if order == Order::Second && (self.own == 0 || !bent.is_empty()) {
            heard.curvature = vec![0.0; rows * triangle];
        }
        // s itself is heard as it is.
        let complex = self.heard.iter().flat_map(|(s, microphones)| {
            std::iter::once((*s, None)).chain(microphones.iter().map(move |m| (*s, Some(*m))))
        });
        for (row, (s, microphone)) in (0..rows).step_by(2).zip(complex) {
            let factor = microphone.map_or(C64::ONE, |m| 1.0 - s * errors[m] + errors[n + m]);
            // What a delay and a gain multiply.
            let by_error = microphone.into_iter().flat_map(|m| [(m, -s), (n + m, C64::ONE)]);
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
                (0..self.own).for_each(|j| set(packed(i, j), slope(j) * z));
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

    /// Two points, a reference and one other microphone: s and P are (a + i b)^2 and (a - i b)^2 times the
    /// point's number.
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
        let heard = [C64::new(-1.0, 2.0), C64::new(-2.0, 3.0)].map(|s| (s, vec![0])).to_vec();
        let heard = ThroughChannels { inner: &Squares, own: 2, heard, others: 1 };
        let (at, along) = ([0.7, 0.4, 0.02, -0.03], [0.3, -0.5, 0.2, 0.4]);
        let values = |h: f64| {
            let moved: Vec<f64> = at.iter().zip(along).map(|(a, d)| a + h * d).collect();
            heard.predict(&moved, Order::Second).unwrap()
        };
        let here = values(0.0);
        for row in 0..8 {
            let first: f64 = (0..4).map(|i| here.jacobian[(row, i)] * along[i]).sum();
            let bend = |i: usize, j: usize| here.curvature[row * 10 + packed(i, j)];
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
