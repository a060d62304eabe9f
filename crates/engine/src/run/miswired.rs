//! Microphones that were exchanged, or have the other polarity, at all points: by training again with the
//! data put right.

use super::course::{Chosen, Run};
use crate::point::PointModel;
use crate::rows::Row;
use crate::{EngineError, Observed};
use rijke_network::Workspace;
use rijke_numerics::{C64, Matrix, Order};
use rijke_study::plan::Stage;

/// Mode shapes that lie nearer to the model than this, root mean square over the pressure of the reference,
/// ask for nothing: gains are known to some hundredths.
const FAR: f64 = 0.05;
/// Data that are put right lie at most this part as far from the model that was fitted to the wrong ones.
const NEARER: f64 = 0.5;

/// What may be wrong with microphones.
#[derive(Clone, Copy)]
enum Wiring {
    Exchanged([usize; 2]),
    Reversed(usize),
}

/// Pressures of one mode at microphones, over that of the reference.
type Shape = Vec<(usize, C64)>;

impl Run {
    /// The two microphones with which exchanged, or the one with which reversed, a model whose mode shapes do
    /// not fit gains most, in a sentence; nothing if the gain is small.
    ///
    /// # Errors
    /// [`EngineError::Stopped`].
    pub(super) fn miswired(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
    ) -> Result<Option<String>, EngineError> {
        let reference = self.rig.microphones.reference;
        let Some(shapes) = self.shapes(stage, found) else { return Ok(None) };
        let as_they_are = distance(&shapes, |shape| Some(shape.clone()));
        let mut heard: Vec<usize> = shapes.iter().flat_map(|(_, own)| own.iter().map(|h| h.0)).collect();
        heard.push(reference);
        heard.sort_unstable();
        heard.dedup();
        let pairs = heard.iter().flat_map(|a| heard.iter().filter(move |b| a < b).map(move |b| [*a, *b]));
        let all = pairs.map(Wiring::Exchanged).chain(heard.iter().map(|m| Wiring::Reversed(*m)));
        let with = |wiring: Wiring| (distance(&shapes, |s| wiring.put_right(s, reference)), wiring);
        let best = all.map(with).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, wiring)) = best.filter(|(far, _)| as_they_are > FAR && *far < NEARER * as_they_are)
        else {
            return Ok(None);
        };
        let gain = self.gain(stage, row, found, &|o| wiring.change(o, reference))?;
        let name = |m: usize| &self.rig.microphones.names[m];
        Ok(gain.map(|gain| match wiring {
            Wiring::Exchanged([a, b]) => format!(
                "with microphones {} and {} exchanged at all points this model gains {gain:.1} nats: check whether their channels, or their places in \
                 rig.toml, were exchanged",
                name(a),
                name(b)
            ),
            Wiring::Reversed(m) => format!(
                "with the sign of microphone {} turned at all points this model gains {gain:.1} nats: check its polarity",
                name(m)
            ),
        }))
    }

    /// The shapes of the model itself, without errors of gains, and those that were measured; none without
    /// microphones, or if a mode is not found.
    fn shapes(&self, stage: &Stage, found: &Chosen) -> Option<Vec<(Shape, Shape)>> {
        let (microphones, reference) = (self.microphones(stage), self.rig.microphones.reference);
        let own = &found.trained.values[..found.trained.own];
        let mut work = Workspace::default();
        let mut one = |o: &Observed| -> Option<Option<(Shape, Shape)>> {
            let used = o.used(&microphones, reference);
            if used.others.is_empty() {
                return Some(None);
            }
            let model = PointModel::new(&found.assembly, &o.conditions, &used.microphones).ok()?;
            let answer = model.starting_from(o.near).respond(own, Order::Value, &mut work).ok()?;
            let place = |m: &usize| used.microphones.iter().position(|k| k == m);
            let of_model = used.others.iter().map(|m| Some((*m, answer.pressures.get(place(m)?)?.value())));
            let measured = used.others.iter().copied().zip(used.pressures.iter().copied());
            Some(Some((of_model.collect::<Option<_>>()?, measured.collect())))
        };
        let all: Vec<Option<(Shape, Shape)>> = found.observed.iter().map(&mut one).collect::<Option<_>>()?;
        let all: Vec<(Shape, Shape)> = all.into_iter().flatten().collect();
        (!all.is_empty()).then_some(all)
    }
}

/// Root mean square of what measured shapes, put right, differ by from those of the model.
fn distance(shapes: &[(Shape, Shape)], put_right: impl Fn(&Shape) -> Option<Shape>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for (model, measured) in shapes {
        let right = put_right(measured).unwrap_or_else(|| measured.clone());
        for ((_, a), (_, b)) in model.iter().zip(&right) {
            sum += (a - b).norm_sqr();
            count += 1.0;
        }
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

impl Wiring {
    /// The shape as it would be without this fault; none where a microphone in question was not heard.
    fn put_right(self, shape: &Shape, reference: usize) -> Option<Shape> {
        let whole = |m: usize| match m == reference {
            true => Some(C64::ONE),
            false => shape.iter().find(|(k, _)| *k == m).map(|(_, p)| *p),
        };
        let right = |m: usize| match self {
            Self::Exchanged([a, b]) => whole(if m == a {
                b
            } else if m == b {
                a
            } else {
                m
            }),
            Self::Reversed(k) => whole(m).map(|p| if m == k { -p } else { p }),
        };
        let scale = right(reference)?;
        shape.iter().map(|(m, _)| Some((*m, right(*m)? / scale))).collect()
    }

    /// Puts a mode right. The covariance of a pressure goes with the microphone; where another reference
    /// divides them, all have its scale.
    fn change(self, o: &mut Observed, reference: usize) {
        let Some(right) = self.put_right(&o.mode.pressures, reference) else { return };
        let others = right.len();
        let first = o.mode.covariance.rows() - 2 * others;
        let place = |m: usize| right.iter().position(|(k, _)| *k == m);
        let from = |row: usize| match (self, row.checked_sub(first)) {
            (Self::Exchanged([a, b]), Some(k)) => {
                let m = right[k / 2].0;
                let other = if m == a {
                    b
                } else if m == b {
                    a
                } else {
                    m
                };
                place(other).map_or(row, |j| first + 2 * j + k % 2)
            }
            _ => row,
        };
        let scale = match self {
            Self::Exchanged(pair) if pair.contains(&reference) => {
                let other = if pair[0] == reference { pair[1] } else { pair[0] };
                o.mode.pressures.iter().find(|(k, _)| *k == other).map_or(1.0, |(_, p)| p.norm().recip())
            }
            _ => 1.0,
        };
        let size = |row: usize| if row < first { 1.0 } else { scale };
        let old = o.mode.covariance.clone();
        let n = old.rows();
        o.mode.covariance = Matrix::from_fn(n, n, |i, j| size(i) * size(j) * old[(from(i), from(j))]);
        o.mode.pressures = right;
    }
}
