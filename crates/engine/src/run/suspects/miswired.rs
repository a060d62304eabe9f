//! Microphones that were exchanged, or have the other polarity, at all points, or at those of a day or of an
//! installation: by training again with the data put right.

use super::super::course::{Chosen, Run, microphones_of};
use super::written::{Form, Pressures, distance};
use crate::rows::Row;
use crate::{EngineError, Observed};
use rijke_numerics::{C64, Jet, Matrix};
use rijke_study::plan::Stage;
use std::collections::BTreeSet;
use std::fmt;

/// Mode shapes that lie nearer to the model than this, root mean square over the pressure of the reference,
/// ask for nothing: gains are known to some hundredths.
const FAR: f64 = 0.05;
/// Nats that data put right must gain to be told of.
pub(in crate::run) const LEADS: f64 = 10.0;
/// Data that are put right lie at most this part as far from the model that was fitted to the wrong ones.
pub(in crate::run) const NEARER: f64 = 0.5;
/// A fault of some points explains more than one of all points only if it leaves less than this part.
const SIMPLER: f64 = 0.9;

/// What may be wrong with microphones.
#[derive(Clone, Copy)]
pub(in crate::run) enum Wiring {
    Exchanged([usize; 2]),
    Reversed(usize),
}

impl Run {
    /// Why the mode shapes of a model may not fit, in a sentence: pressures that were written in another
    /// form, or the two microphones with which exchanged, or the one with which reversed, the model gains
    /// most. Nothing if they fit, or if the gain is small.
    ///
    /// # Errors
    /// [`EngineError::Stopped`].
    pub(in crate::run) fn miswired(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
    ) -> Result<Option<String>, EngineError> {
        let reference = self.rig.microphones.reference;
        // Without errors of gains.
        let microphones = microphones_of(&self.rig, stage);
        let of_model = |o: &Observed| {
            let used = o.used(&microphones, reference);
            if used.others.is_empty() {
                return Ok(Pressures::new());
            }
            let answer = found.solved(o, &used.microphones)?;
            Ok(used.microphones.iter().copied().zip(answer.pressures.iter().map(Jet::value)).collect())
        };
        let of_model = found.observed.iter().map(of_model).collect::<Result<Vec<_>, EngineError>>()?;
        let measured: Vec<&Pressures> = found.observed.iter().map(|o| &o.mode.pressures).collect();
        let as_they_are = distance(&of_model, &measured, |_, p| Some(p.clone()));
        if as_they_are <= FAR {
            return Ok(None);
        }
        let mut heard: Vec<usize> = of_model.iter().flatten().map(|(m, _)| *m).collect();
        heard.sort_unstable();
        heard.dedup();
        let reversed = heard.iter().map(|m| Wiring::Reversed(*m));
        let wirings: Vec<Wiring> = pairs(&heard).into_iter().map(Wiring::Exchanged).chain(reversed).collect();
        let mut best: Option<(f64, Wiring, Where)> = None;
        for at in Where::all(&found.observed) {
            let there: Vec<bool> = found.observed.iter().map(|o| at.holds(o)).collect();
            for wiring in &wirings {
                let right = |k: usize, p: &Pressures| match there[k] {
                    true => Some(wiring.put_right(p, reference)?.0),
                    false => None,
                };
                let far = distance(&of_model, &measured, right);
                // Of the same worth, what holds everywhere comes first.
                if best.as_ref().is_none_or(|(least, ..)| far < SIMPLER * least) {
                    best = Some((far, *wiring, at.clone()));
                }
            }
        }
        let wired = best.as_ref().map_or(as_they_are, |(far, ..)| *far);
        let form =
            Form::nearest(&of_model, &measured).filter(|(far, _)| *far < NEARER * as_they_are.min(wired));
        if let Some((_, form)) = form {
            return Ok(Some(form.words()));
        }
        let Some((_, wiring, at)) = best.filter(|(far, ..)| *far < NEARER * as_they_are) else {
            return Ok(None);
        };
        let put_right = |o: &mut Observed| {
            if at.holds(o) {
                wiring.change(o, reference)
            }
        };
        // Densities are of the numbers that were written: with another microphone as reference, n pressures
        // are those over one of them, z, with the Jacobian |z|^(-2 (n + 1)).
        let jacobian = |o: &Observed| {
            let (right, scale) = wiring.put_right(&o.mode.pressures, reference)?;
            Some(-2.0 * (right.len() + 1) as f64 * scale.norm().ln())
        };
        let changed = found.observed.iter().filter(|o| at.holds(o));
        let jacobian: f64 = changed.filter_map(jacobian).sum();
        let gain = self.gain(stage, row, found, &put_right)?.map(|gain| gain + jacobian);
        let name = |m: usize| &self.rig.microphones.names[m];
        Ok(gain.filter(|gain| *gain > LEADS).map(|gain| match wiring {
            Wiring::Exchanged([a, b]) => format!(
                "with microphones {} and {} exchanged at {at} this model gains {gain:.1} nats: check whether their channels, or their places in \
                 rig.toml, were exchanged",
                name(a),
                name(b)
            ),
            Wiring::Reversed(m) => format!(
                "with the sign of microphone {} turned at {at} this model gains {gain:.1} nats: check its polarity",
                name(m)
            ),
        }))
    }
}

/// The points at which something is wrong.
#[derive(Clone, PartialEq)]
enum Where {
    Everywhere,
    Installation(String),
    Day(String),
}

impl Where {
    /// Those at which it may be: installations and days that hold several points but not all.
    fn all(observed: &[Observed]) -> Vec<Self> {
        let mut all = vec![Self::Everywhere];
        for o in observed {
            let point = &o.conditions.point;
            let own = [Self::Installation(point.installation.clone()), Self::Day(point.day.clone())];
            for at in own {
                let points: BTreeSet<&str> =
                    observed.iter().filter(|o| at.holds(o)).map(|o| o.conditions.id.as_str()).collect();
                let whole = observed.iter().all(|o| at.holds(o));
                if points.len() > 1 && !whole && !all.contains(&at) {
                    all.push(at);
                }
            }
        }
        all
    }

    fn holds(&self, o: &Observed) -> bool {
        match self {
            Self::Everywhere => true,
            Self::Installation(name) => o.conditions.point.installation == *name,
            Self::Day(name) => o.conditions.point.day == *name,
        }
    }
}

impl fmt::Display for Where {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Everywhere => write!(f, "all points"),
            Self::Installation(name) => write!(f, "all points of installation {name}"),
            Self::Day(name) => write!(f, "all points of day {name}"),
        }
    }
}

/// Two microphones each.
pub(in crate::run) fn pairs(all: &[usize]) -> Vec<[usize; 2]> {
    (0..all.len()).flat_map(|j| (0..j).map(move |i| [all[i], all[j]])).collect()
}

impl Wiring {
    /// The microphone whose place `m` has.
    fn other(self, m: usize) -> usize {
        match self {
            Self::Exchanged([a, b]) if m == a || m == b => a + b - m,
            _ => m,
        }
    }

    /// Pressures as they would be without this fault, and that of the reference, by which they are divided;
    /// none where a microphone in question was not heard.
    pub(in crate::run) fn put_right(
        self,
        measured: &[(usize, C64)],
        reference: usize,
    ) -> Option<(Pressures, C64)> {
        let scale = self.whole(reference, measured, reference)?;
        let right = |(m, _): &(usize, C64)| Some((*m, self.whole(*m, measured, reference)? / scale));
        Some((measured.iter().map(right).collect::<Option<_>>()?, scale))
    }

    /// The pressure of a microphone without this fault, over that of the reference as it was taken.
    fn whole(self, m: usize, measured: &[(usize, C64)], reference: usize) -> Option<C64> {
        let from = self.other(m);
        let found = match from == reference {
            true => C64::ONE,
            false => measured.iter().find(|(k, _)| *k == from)?.1,
        };
        Some(if self.turns(m) { -found } else { found })
    }

    fn turns(self, m: usize) -> bool {
        matches!(self, Self::Reversed(k) if k == m)
    }

    /// Puts a mode right, with the covariance that its numbers have then to first order.
    fn change(self, o: &mut Observed, reference: usize) {
        let measured = &o.mode.pressures;
        let Some((right, scale)) = self.put_right(measured, reference) else { return };
        // Of the pressure w_m / w_r of microphone m, by that of microphone k as measured.
        let slope = |m: usize, ratio: C64, k: usize| {
            let whole = |of: usize| match self.other(of) == k {
                true => C64::ONE * if self.turns(of) { -1.0 } else { 1.0 },
                false => C64::ZERO,
            };
            (whole(m) - ratio * whole(reference)) / scale
        };
        let n = o.mode.covariance.rows();
        let first = n - 2 * right.len();
        let jacobian = Matrix::from_fn(n, n, |i, j| match (i.checked_sub(first), j.checked_sub(first)) {
            (Some(i), Some(j)) => {
                let (m, ratio) = right[i / 2];
                let z = slope(m, ratio, measured[j / 2].0);
                [[z.re, -z.im], [z.im, z.re]][i % 2][j % 2]
            }
            _ => f64::from(u8::from(i == j)),
        });
        o.mode.covariance = jacobian.product(&o.mode.covariance).product(&jacobian.transpose());
        o.mode.pressures = right;
    }
}

#[cfg(test)]
mod tests {
    use super::Wiring;
    use crate::run::suspects::doubts::tests::points;
    use rijke_numerics::{C64, Matrix};

    /// Against the same covariance under other names or signs, and, where the reference was one of the two,
    /// by differences.
    #[test]
    fn exact_the_covariance_of_pressures_goes_with_the_microphones() {
        let mut measured = points().swap_remove(0);
        let pressures = [C64::new(0.5, 0.1), C64::new(0.2, -0.3), C64::new(-0.6, 0.4)];
        measured.mode.pressures = (1..4).zip(pressures).collect();
        let of = |places: [usize; 3], signs: [f64; 3]| {
            Matrix::from_fn(8, 8, |i, j| {
                let pressure = |row: usize| row.checked_sub(2).map(|k| k / 2);
                let name = |row: usize| pressure(row).map_or(row, |k| 2 + 2 * places[k] + row % 2);
                let sign = |row: usize| pressure(row).map_or(1.0, |k| signs[k]);
                let (a, b) = (name(i), name(j));
                let own = if a == b { 20.0 } else { 0.0 };
                sign(i) * sign(j) * (own + (1 + a.min(b)) as f64 / (1 + a.max(b)) as f64)
            })
        };
        measured.mode.covariance = of([0, 1, 2], [1.0; 3]);
        let found = |wiring: Wiring| {
            let mut right = measured.clone();
            wiring.change(&mut right, 0);
            right.mode
        };
        let same = |found: &Matrix, expected: &Matrix, within: f64| {
            (0..8).all(|i| (0..8).all(|j| (found[(i, j)] - expected[(i, j)]).abs() < within))
        };
        for (reversed, signs) in [(2, [1.0, -1.0, 1.0]), (0, [-1.0; 3])] {
            let reversed = found(Wiring::Reversed(reversed)).covariance;
            assert!(same(&reversed, &of([0, 1, 2], signs), 1e-12));
        }
        let exchanged = found(Wiring::Exchanged([2, 3]));
        let expected = [(1, pressures[0]), (2, pressures[2]), (3, pressures[1])];
        assert_eq!(exchanged.pressures, expected);
        assert!(same(&exchanged.covariance, &of([0, 2, 1], [1.0; 3]), 1e-12));
        let reference = found(Wiring::Exchanged([0, 1]));
        let z = pressures[0];
        let ratios = |p: [C64; 3]| [1.0 / p[0], p[1] / p[0], p[2] / p[0]];
        let expected: Vec<(usize, C64)> = (1..4).zip(ratios(pressures)).collect();
        assert_eq!(reference.pressures, expected);
        // Central differences of all eight numbers.
        let numbers = |row: usize, by: f64| {
            let mut all = [0.0; 8];
            all[row] = by;
            let moved = [0, 1, 2].map(|k| pressures[k] + C64::new(all[2 + 2 * k], all[3 + 2 * k]));
            let ratios = ratios(moved);
            [
                all[0],
                all[1],
                ratios[0].re,
                ratios[0].im,
                ratios[1].re,
                ratios[1].im,
                ratios[2].re,
                ratios[2].im,
            ]
        };
        let step = 1e-5 * z.norm();
        let slopes =
            Matrix::from_fn(8, 8, |i, j| (numbers(j, step)[i] - numbers(j, -step)[i]) / (2.0 * step));
        let old = &measured.mode.covariance;
        let expected = Matrix::from_fn(8, 8, |i, j| {
            let sum = |a: usize| (0..8).map(|b| slopes[(i, a)] * old[(a, b)] * slopes[(j, b)]).sum::<f64>();
            (0..8).map(sum).sum()
        });
        assert!(same(&reference.covariance, &expected, 1e-5));
    }
}
