//! States of the gas tabulated over the factors: nodes on a grid, and the state between them.

use crate::{Conditions, EngineError, Observed};
use rijke_study::{Point, PointState, Rig};
use serde::Serialize;
use std::collections::BTreeSet;

/// Nodes of the temperature between two borders at most.
const NODES: usize = 21;

/// Most factors that vary independently of each other.
const AXES: usize = 3;

/// A factor that varies, and its values, ascending, SI.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SliderAxis {
    /// Its place among the factors of the campaign.
    pub factor: usize,
    /// Its values.
    pub levels: Vec<f64>,
}

/// The gas at one operating point, as the table has it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct State {
    /// Every factor, SI; none where it has none.
    factors: Vec<Option<f64>>,
    /// Temperature of the gas that enters, K.
    ambient: f64,
    /// kg/s.
    mass_flow: f64,
    /// What the base state brings besides.
    numbers: Vec<f64>,
    /// Where zones of the temperature meet, m.
    borders: Vec<f64>,
    /// Temperature at the shares of the zones, one zone after the other, K.
    temperature: Vec<f64>,
}

/// The states of the points of a grid, the last axis running fastest.
///
/// Between nodes everything is linear in every factor, places of borders and temperatures at the same shares
/// of their zones alike, so that the heated zone moves with what heats it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Table {
    pub(super) axes: Vec<SliderAxis>,
    /// Of every zone between borders, the shares of its length at which temperatures stand.
    shares: Vec<Vec<f64>>,
    /// Zones of fast change, as pairs of borders.
    kinks: Vec<[usize; 2]>,
    /// Places in the scope of the numbers that the states bring.
    brought: Vec<usize>,
    pub(super) states: Vec<State>,
}

impl Table {
    /// The table of the points, and for each node the place of its point; a sentence where there is none.
    pub(super) fn of(points: &[&Observed]) -> Result<(Self, Vec<usize>), String> {
        let (axes, order) = grid(points)?;
        let all: Vec<&Conditions> = order.iter().map(|&k| &*points[k].conditions).collect();
        let borders: Vec<Vec<f64>> = all.iter().map(|c| borders(&c.base)).collect();
        let Some((first, inner)) = all.first().zip(borders.first()) else {
            return Err("no operating point was measured".to_owned());
        };
        let brought: Vec<usize> = first.base.numbers.iter().map(|n| n.0).collect();
        let kinks = |(c, borders): (&&Conditions, &Vec<f64>)| -> Vec<[usize; 2]> {
            let place = |x: f64| borders.iter().position(|b| *b == x).unwrap_or(0);
            c.base.kinks.iter().map(|[from, to]| [place(*from), place(*to)]).collect()
        };
        let of_the_first = kinks((first, inner));
        let alike = all.iter().zip(&borders).all(|(c, b)| {
            b.len() == inner.len()
                && kinks((c, b)) == of_the_first
                && c.base.numbers.iter().map(|n| n.0).eq(brought.iter().copied())
        });
        if !alike {
            return Err("the states of the gas are not of one form at all points".to_owned());
        }
        let shares: Vec<Vec<f64>> = (0..=inner.len()).map(|z| shares(&all, &borders, z)).collect();
        let state = |(c, borders): (&&Conditions, &Vec<f64>)| State {
            factors: c.point.factors.iter().map(|v| Some(*v).filter(|v| v.is_finite())).collect(),
            ambient: c.layout.numbers[rijke_study::names::AMBIENT],
            mass_flow: c.base.mass_flow,
            numbers: c.base.numbers.iter().map(|n| n.1).collect(),
            borders: borders.clone(),
            temperature: (0..shares.len()).flat_map(|z| temperatures(c, borders, z, &shares[z])).collect(),
        };
        let states = all.iter().zip(&borders).map(state).collect();
        Ok((Self { axes, shares, kinks: of_the_first, brought, states }, order))
    }

    /// The values of the axes at a node.
    pub(super) fn setting(&self, node: usize) -> Vec<f64> {
        let value = |axis: &SliderAxis| self.states[node].factors[axis.factor].unwrap_or(f64::NAN);
        self.axes.iter().map(value).collect()
    }

    /// Nodes around a setting of the axes, and their weights.
    fn weights(&self, setting: &[f64]) -> Vec<(usize, f64)> {
        let mut all = vec![(0, 1.0)];
        for (axis, value) in self.axes.iter().zip(setting) {
            let levels = &axis.levels;
            let upper = levels.partition_point(|l| l <= value).clamp(1, levels.len() - 1);
            let share = (value - levels[upper - 1]) / (levels[upper] - levels[upper - 1]);
            let both = |(node, weight): (usize, f64)| {
                [(upper - 1, 1.0 - share), (upper, share)].map(|(k, w)| (node * levels.len() + k, weight * w))
            };
            all = all.into_iter().flat_map(both).collect();
        }
        all
    }

    /// A number of the nodes at a setting.
    pub(super) fn between(&self, setting: &[f64], of: impl Fn(usize) -> f64) -> f64 {
        self.weights(setting).into_iter().map(|(node, weight)| weight * of(node)).sum()
    }

    /// The rig and its gas at a setting of the axes.
    pub(super) fn conditions(
        &self,
        rig: &Rig,
        like: &Conditions,
        setting: &[f64],
    ) -> Result<Conditions, EngineError> {
        let list = |of: &dyn Fn(&State) -> &[f64]| -> Vec<f64> {
            let count = self.states.first().map_or(0, |s| of(s).len());
            (0..count).map(|k| self.between(setting, |node| of(&self.states[node])[k])).collect()
        };
        let number = |of: &dyn Fn(&State) -> f64| self.between(setting, |node| of(&self.states[node]));
        let mut factors: Vec<f64> =
            (0..like.point.factors.len()).map(|k| number(&|s| s.factors[k].unwrap_or(f64::NAN))).collect();
        self.axes.iter().zip(setting).for_each(|(axis, value)| factors[axis.factor] = *value);
        let id = "a setting of the page".to_owned();
        let fail = |source| EngineError::Rig { point: id.clone(), source: Box::new(source) };
        let layout = rig.at_factors(&factors, number(&|s| s.ambient)).map_err(fail)?;
        let borders = list(&|s| &s.borders);
        let edges: Vec<f64> = [&[0.0], &borders[..], &[layout.length]].concat();
        let place = |(zone, share): (usize, &f64)| edges[zone] + share * (edges[zone + 1] - edges[zone]);
        let zones = self.shares.iter().enumerate();
        let base = PointState {
            mass_flow: number(&|s| s.mass_flow),
            numbers: self.brought.iter().copied().zip(list(&|s| &s.numbers)).collect(),
            places: zones.flat_map(|(z, shares)| shares.iter().map(move |s| place((z, s)))).collect(),
            temperature: list(&|s| &s.temperature),
            kinks: self.kinks.iter().map(|[from, to]| [borders[*from], borders[*to]]).collect(),
            errors: Vec::new(),
            ..like.base.clone()
        };
        let point = Point { id: id.clone(), factors, ..like.point.clone() };
        Ok(Conditions { id, point, layout, base, displaced: Vec::new() })
    }
}

/// Where zones meet: borders of fast changes, and steps.
fn borders(base: &PointState) -> Vec<f64> {
    let steps = base.places.windows(2).filter(|w| w[0] == w[1]).map(|w| w[0]);
    let mut all: Vec<f64> = base.kinks.iter().flatten().copied().chain(steps).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Beginning and end of a zone.
fn zone(c: &Conditions, borders: &[f64], zone: usize) -> [f64; 2] {
    let from = if zone == 0 { 0.0 } else { borders[zone - 1] };
    [from, borders.get(zone).copied().unwrap_or(c.layout.length)]
}

/// Shares of a zone at which the state with the most nodes there has its own, or some of them.
fn shares(all: &[&Conditions], borders: &[Vec<f64>], z: usize) -> Vec<f64> {
    let inside = |(c, borders): (&&Conditions, &Vec<f64>)| -> Vec<f64> {
        let [from, to] = zone(c, borders, z);
        let inner = c.base.places.iter().filter(|x| **x > from && **x < to);
        inner.map(|x| (x - from) / (to - from)).collect()
    };
    let most = all.iter().zip(borders).map(inside).max_by_key(Vec::len).unwrap_or_default();
    let uniform = all.iter().all(|c| c.base.is_uniform());
    let own: Vec<f64> = if uniform { Vec::new() } else { most };
    let whole = [&[0.0], &own[..], &[1.0]].concat();
    let few = whole.len().min(NODES);
    (0..few).map(|k| whole[k * (whole.len() - 1) / (few - 1)]).collect()
}

/// Temperatures at the shares of a zone, on its own side of its borders; to 1 mK, as files carry them.
fn temperatures(c: &Conditions, borders: &[f64], z: usize, shares: &[f64]) -> Vec<f64> {
    let [from, to] = zone(c, borders, z);
    let at = |share: &f64| {
        let [before, after] = c.base.temperatures(from + share * (to - from));
        let found = if *share == 0.0 { after } else { before };
        (1e3 * found).round() / 1e3
    };
    shares.iter().map(at).collect()
}

/// The factors that vary independently of each other and span a grid of the points, and the points in its
/// order.
fn grid(points: &[&Observed]) -> Result<(Vec<SliderAxis>, Vec<usize>), String> {
    let values = |k: usize| -> BTreeSet<u64> { points.iter().map(|o| bits(o, k)).collect() };
    let count = points.first().map_or(0, |o| o.conditions.point.factors.len());
    let varying: Vec<usize> = (0..count).filter(|&k| values(k).len() > 1).collect();
    let tuple = |o: &Observed, chosen: &[usize]| chosen.iter().map(|&k| bits(o, k)).collect::<Vec<_>>();
    let distinct = |chosen: &[usize]| points.iter().map(|o| tuple(o, chosen)).collect::<BTreeSet<_>>().len();
    let different = distinct(&varying);
    let spans = |chosen: &Vec<usize>| {
        let cells: usize = chosen.iter().map(|&k| values(k).len()).product();
        cells == different && distinct(chosen) == different
    };
    let known = |chosen: &Vec<usize>| {
        points.iter().all(|o| chosen.iter().all(|&k| o.conditions.point.factors[k].is_finite()))
    };
    let all = subsets(&varying);
    let chosen = all.iter().filter(|s| !s.is_empty() && known(s)).find(|s| spans(s));
    let Some(chosen) = chosen else {
        return Err(if varying.is_empty() {
            "its operating points do not differ in their factors".to_owned()
        } else {
            "its operating points are no grid of their factors, between which the state of the gas could be interpolated"
                .to_owned()
        });
    };
    let level = |&factor: &usize| {
        let mut levels: Vec<f64> = points.iter().map(|o| o.conditions.point.factors[factor]).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup();
        SliderAxis { factor, levels }
    };
    let axes: Vec<SliderAxis> = chosen.iter().map(level).collect();
    let cells: usize = axes.iter().map(|a| a.levels.len()).product();
    let place = |o: &Observed| {
        axes.iter().fold(0, |sum, a| {
            let value = o.conditions.point.factors[a.factor];
            sum * a.levels.len() + a.levels.iter().position(|l| *l == value).unwrap_or(0)
        })
    };
    let first = |cell: usize| points.iter().position(|o| place(o) == cell);
    let order: Option<Vec<usize>> = (0..cells).map(first).collect();
    order.map(|order| (axes, order)).ok_or_else(|| "no point stands in a cell of the grid".to_owned())
}

fn bits(o: &Observed, factor: usize) -> u64 {
    let value = o.conditions.point.factors[factor];
    if value.is_nan() { u64::MAX } else { value.to_bits() }
}

/// Sets of at most [`AXES`] of these, the smaller first, in order.
fn subsets(of: &[usize]) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..AXES {
        let longer = |s: &Vec<usize>| {
            let rest = of.iter().filter(|k| s.last().is_none_or(|last| *k > last));
            rest.map(|k| [&s[..], &[*k]].concat()).collect::<Vec<_>>()
        };
        let size = all.last().map_or(0, Vec::len);
        let more: Vec<Vec<usize>> = all.iter().filter(|s| s.len() == size).flat_map(longer).collect();
        all.extend(more);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{SliderAxis, Table};

    /// What is linear in each of three factors is found exactly anywhere between nodes, the last axis running
    /// fastest.
    #[test]
    fn exact_numbers_between_nodes_are_linear_in_every_factor() {
        let levels = [vec![1.0, 2.0, 4.0], vec![-1.0, 3.0], vec![0.0, 0.5, 2.0, 3.0]];
        let axes = levels.iter().enumerate();
        let axes = axes.map(|(factor, levels)| SliderAxis { factor, levels: levels.clone() }).collect();
        let (shares, states) = (Vec::new(), Vec::new());
        let table = Table { axes, shares, kinks: Vec::new(), brought: Vec::new(), states };
        let of = |x: f64, y: f64, z: f64| (2.0 + x) * (5.0 - y) * (1.0 + 3.0 * z);
        let node = |k: usize| of(levels[0][k / 8], levels[1][k / 4 % 2], levels[2][k % 4]);
        for [x, y, z] in [[1.0, 3.0, 2.0], [3.5, 0.2, 2.7], [1.3, -1.0, 0.1], [4.0, 2.9, 3.0]] {
            let found = table.between(&[x, y, z], node);
            assert!((found - of(x, y, z)).abs() < 1e-12 * of(x, y, z), "{x} {y} {z}: {found}");
        }
    }
}
