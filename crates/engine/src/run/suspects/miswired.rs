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
        let right = |m: usize| {
            let from = self.other(m);
            let whole = match from == reference {
                true => C64::ONE,
                false => measured.iter().find(|(k, _)| *k == from)?.1,
            };
            Some(if matches!(self, Self::Reversed(k) if k == m) { -whole } else { whole })
        };
        let scale = right(reference)?;
        let all = measured.iter().map(|(m, _)| Some((*m, right(*m)? / scale)));
        Some((all.collect::<Option<_>>()?, scale))
    }

    /// Puts a mode right. The covariance of a pressure goes with the microphone, and has the scale of what
    /// divides it.
    fn change(self, o: &mut Observed, reference: usize) {
        let Some((right, scale)) = self.put_right(&o.mode.pressures, reference) else { return };
        let old = o.mode.covariance.clone();
        let n = old.rows();
        let first = n - 2 * right.len();
        let from = |row: usize| {
            let of_pressure = row.checked_sub(first);
            let place =
                of_pressure.and_then(|k| right.iter().position(|(m, _)| *m == self.other(right[k / 2].0)));
            place.map_or(row, |j| first + 2 * j + (row - first) % 2)
        };
        // What pressures have in common, such as an error of the gain, turns its sign with them.
        let turned = |row: usize| matches!(self, Self::Reversed(m) if m == right[(row - first) / 2].0);
        let size = |row: usize| match row < first {
            true => 1.0,
            false => scale.norm().recip() * if turned(row) { -1.0 } else { 1.0 },
        };
        o.mode.covariance = Matrix::from_fn(n, n, |i, j| size(i) * size(j) * old[(from(i), from(j))]);
        o.mode.pressures = right;
    }
}

#[cfg(test)]
mod tests {
    use super::Wiring;
    use crate::run::suspects::doubts::tests::points;
    use rijke_numerics::{C64, Matrix};

    /// Against the same covariance under the names that are right, or, if the reference was one of the two,
    /// with standard deviations over the pressure of what takes its place.
    #[test]
    fn exact_the_covariance_of_a_pressure_goes_with_its_microphone() {
        let mut measured = points().swap_remove(0);
        let pressures = [C64::new(0.5, 0.1), C64::new(0.2, -0.3), C64::new(-0.6, 0.4)];
        measured.mode.pressures = (1..4).zip(pressures).collect();
        let of = |places: [usize; 3], scale: f64| {
            Matrix::from_fn(8, 8, |i, j| {
                let name = |row: usize| row.checked_sub(2).map_or(row, |k| 2 + 2 * places[k / 2] + k % 2);
                let size = |row: usize| if row < 2 { 1.0 } else { scale };
                let (a, b) = (name(i), name(j));
                let own = if a == b { 20.0 } else { 0.0 };
                size(i) * size(j) * (own + (1 + a.min(b)) as f64 / (1 + a.max(b)) as f64)
            })
        };
        measured.mode.covariance = of([0, 1, 2], 1.0);
        let found = |wiring: Wiring| {
            let mut right = measured.clone();
            wiring.change(&mut right, 0);
            right.mode
        };
        let same = |found: &Matrix, expected: &Matrix| {
            (0..8).all(|i| (0..8).all(|j| (found[(i, j)] - expected[(i, j)]).abs() < 1e-12))
        };
        let reversed = found(Wiring::Reversed(2)).covariance;
        let sign = |row: usize| if (4..6).contains(&row) { -1.0 } else { 1.0 };
        let old = &measured.mode.covariance;
        assert!(same(&reversed, &Matrix::from_fn(8, 8, |i, j| sign(i) * sign(j) * old[(i, j)])));
        let exchanged = found(Wiring::Exchanged([2, 3]));
        let expected = [(1, pressures[0]), (2, pressures[2]), (3, pressures[1])];
        assert_eq!(exchanged.pressures, expected);
        assert!(same(&exchanged.covariance, &of([0, 2, 1], 1.0)));
        let reference = found(Wiring::Exchanged([0, 1]));
        let z = pressures[0];
        assert_eq!(reference.pressures, [(1, 1.0 / z), (2, pressures[1] / z), (3, pressures[2] / z)]);
        let expected = of([0, 1, 2], z.norm().recip());
        let found = &reference.covariance;
        assert!((4..8).all(|i| (4..8).all(|j| (found[(i, j)] - expected[(i, j)]).abs() < 1e-12)));
    }
}
