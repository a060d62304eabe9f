//! Flames that are spread along ducts.

use super::assembly::{Assembly, Flame, Listener};
use super::error::FileError;
use super::item::Item;
use super::problem::ElementProblem;
use super::schema::{self, Direction, Transfer};
use crate::flow_chain::ActionKind;
use crate::laws::{Law, SpreadPiece, spread_middle, spread_weights};
use rijke_numerics::C64;

/// Pieces of a spread flame whose file does not say a number.
const PIECES: usize = 40;

/// How much farther than the flame's beginning a velocity is sought that is taken just before it, over the
/// length: more than what [`crate::flow_chain`] takes for the same place.
const BEFORE: f64 = 4e-9;

/// Where the heat of a spread flame is released: in the middle of each of its pieces.
pub(super) struct Spread {
    /// m from the upstream end of the tube, parts of the heat, delays.
    pub(super) sources: Vec<[f64; 3]>,
    /// Where it ends, m.
    pub(super) end: f64,
}

impl Spread {
    /// Of a flame that begins at `x` of a tube of this length, in so many times more pieces than it has by
    /// its file; none if it is compact.
    pub(super) fn of(
        item: &Item,
        flame: &schema::Flame,
        x: f64,
        tube: f64,
        finer: usize,
    ) -> Result<Option<Self>, FileError> {
        let schema::Flame { length, pieces, density, delay, delay_end, .. } = flame;
        let Some(length) = *length else {
            let alone = [
                ("delay_end", delay_end.is_some()),
                ("pieces", pieces.is_some()),
                ("density", density.is_some()),
            ];
            return match alone.into_iter().find(|key| key.1) {
                Some((one, _)) => Err(item.fail(ElementProblem::Together { one, other: "length" })),
                None => Ok(None),
            };
        };
        let end = x + item.positive("length", length)?;
        if end > tube * (1.0 + 1e-9) {
            return Err(item.fail(ElementProblem::OutsideTube { at: end, length: tube }));
        }
        if flame.reference_side == Direction::Downstream {
            let message =
                "a flame with `length` answers to a velocity upstream: leave `reference_side` out".to_owned();
            return Err(item.fail(ElementProblem::Keys { message }));
        }
        let count = pieces.unwrap_or(PIECES);
        if !(1..=1000).contains(&count) {
            return Err(item.fail(ElementProblem::Range { key: "pieces", value: count, low: 1, high: 1000 }));
        }
        let count = finer * count;
        let delays = [*delay, item.not_negative("delay_end", delay_end.unwrap_or(*delay))?];
        let density = density.as_deref().unwrap_or(&[1.0]);
        for value in density {
            item.not_negative("density", *value)?;
        }
        let Some(weights) = spread_weights(density, count) else {
            return Err(item.fail(ElementProblem::NotPositive { key: "the sum of density", value: 0.0 }));
        };
        let source = |(k, weight): (usize, &f64)| {
            let middle = spread_middle(k, count);
            [x + length * middle, *weight, delays[0] + middle * (delays[1] - delays[0])]
        };
        Ok(Some(Self { sources: weights.iter().enumerate().map(source).collect(), end }))
    }
}

/// A spread flame in a chain: the places of its sources and of its end.
pub(super) struct Along {
    spread: Spread,
    pub(super) places: Vec<usize>,
    pub(super) end: usize,
}

impl Along {
    pub(super) fn of(spread: Spread, place_at: impl Fn(f64) -> usize) -> Self {
        let places = spread.sources.iter().map(|source| place_at(source[0])).collect();
        let end = place_at(spread.end);
        Self { spread, places, end }
    }
}

/// What [`Assembly::function`] made, so much later.
fn later(law: &Law, by: f64) -> Law {
    match law.clone() {
        Law::Transfer { gain, numerator, denominator, delay } => {
            Law::Transfer { gain, numerator, denominator, delay: delay + by }
        }
        Law::Table(table) => Law::Table(table.later(by)),
        Law::Scaled(law, factor) => Law::Scaled(Box::new(later(&law, by)), factor),
        other => other,
    }
}

impl Assembly<'_> {
    /// The laws of a flame spread behind `place`; `gain` is that of all its heat, which answers to the
    /// velocity so far upstream.
    pub(super) fn spread(
        &mut self,
        item: &Item,
        place: usize,
        shape: &Transfer,
        gain: f64,
        distance: f64,
        Along { spread, places, end }: &Along,
    ) -> Result<(), FileError> {
        let inside = |(j, other): &&(usize, String)| (place + 1..*end).contains(j) && *other != item.place;
        if let Some((_, other)) = self.devices.iter().find(inside) {
            let message =
                format!("{other} lies inside the flame, which ends at {} m: only ducts may", spread.end);
            return Err(item.fail(ElementProblem::Keys { message }));
        }
        // The delays are those of the sources.
        let transfer = self.function(item, &Transfer { delay: 0.0, ..shape.clone() }, gain)?;
        let start: f64 = self.segments[..place].iter().map(|s| s.length).sum();
        let mut pieces: Vec<SpreadPiece> = Vec::new();
        let mut last = None;
        for (&to, &[x, weight, delay]) in places.iter().zip(&spread.sources) {
            // One law for all pieces that are equally late.
            let law = last.filter(|(_, same)| *same == delay).map_or_else(
                || self.laws.push(format!("{}: flame", item.place), later(&transfer, delay)),
                |(law, _)| law,
            );
            last = Some((law, delay));
            pieces.push(SpreadPiece { place: to, law, weight });
            let reference = x - start + if distance == 0.0 { BEFORE * x } else { distance };
            // Volume flow over the area where it comes from.
            let share = weight * self.segments[place].area / self.segments[to].area;
            let law = Law::Scaled(Box::new(later(&transfer, delay)), C64::new(-share, 0.0));
            self.flames.push(Flame { place: to, law, effect: ActionKind::Eu, reference, downstream: false });
        }
        let law = pieces.first().map_or(0, |piece| piece.law);
        let spread = Some((*end, pieces));
        self.listeners.push(Listener { item: item.clone(), place, law, distance, downstream: false, spread });
        Ok(())
    }
}
