//! The grid of a map of stability, back from its table.

use super::super::frame::{Frame, FrameRow};
use super::answer::Layer;
use rijke_numerics::{GridField, range};
use std::collections::BTreeMap;

/// The nodes of a map of stability: growth rates and their deviations, a grid for each mode.
#[derive(Clone, Debug, PartialEq)]
pub struct MapNodes {
    /// Horizontal values, ascending.
    pub x: Vec<f64>,
    /// Vertical values, ascending.
    pub y: Vec<f64>,
    /// By mode, vertical and horizontal value: growth rate and its standard deviation, NaN where there is
    /// none.
    pub modes: Vec<Vec<Vec<[f64; 2]>>>,
}

impl MapNodes {
    /// Of the table that a layer of [`LayerLook::GrowthMap`](super::LayerLook::GrowthMap) draws.
    #[must_use]
    pub fn of(frame: &Frame, layer: &Layer) -> Self {
        let number = |row: &FrameRow, k: usize| row.number(k).unwrap_or(f64::NAN);
        let axis = |k: usize| {
            let mut all: Vec<f64> =
                frame.rows.iter().map(|r| number(r, k)).filter(|v| v.is_finite()).collect();
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let (x, y) = (axis(layer.x), axis(layer.y));
        let nowhere = vec![vec![[f64::NAN; 2]; x.len()]; y.len()];
        let mut modes: BTreeMap<&str, Vec<Vec<[f64; 2]>>> = BTreeMap::new();
        for row in &frame.rows {
            let place = |all: &[f64], k: usize| all.iter().position(|v| *v == number(row, k));
            let (Some(j), Some(k), Some(sd)) = (place(&x, layer.x), place(&y, layer.y), layer.sd) else {
                continue;
            };
            modes.entry(&row.mode).or_insert_with(|| nowhere.clone())[k][j] =
                [number(row, sd - 1), number(row, sd)];
        }
        Self { x, y, modes: modes.into_values().collect() }
    }

    /// The grid.
    #[must_use]
    pub fn field(&self) -> GridField<'_> {
        GridField { x: &self.x, y: &self.y }
    }

    /// A number of each node, mode by mode.
    #[must_use]
    pub fn each(&self, of: impl Fn([f64; 2]) -> f64) -> Vec<Vec<Vec<f64>>> {
        let row = |row: &Vec<[f64; 2]>| row.iter().map(|v| of(*v)).collect();
        self.modes.iter().map(|grid| grid.iter().map(row).collect()).collect()
    }

    /// The least and the largest growth rate of the mode that grows fastest.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        let largest = |k: usize, j: usize| {
            let all = self.modes.iter().map(|grid| grid[k][j][0]);
            all.reduce(|a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) }).unwrap_or(f64::NAN)
        };
        let all = (0..self.y.len()).flat_map(|k| (0..self.x.len()).map(move |j| largest(k, j)));
        range(all.filter(|v| v.is_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::LayerLook;
    use super::*;

    #[test]
    fn exact_rows_in_any_order_are_a_grid_and_the_fastest_mode_counts() {
        let row = |mode: &str, x: f64, y: f64, growth: Option<f64>| FrameRow {
            mode: mode.into(),
            values: vec![Some(x), Some(y), growth, Some(0.5)],
            ..FrameRow::default()
        };
        let rows = vec![
            row("1", 1.0, 20.0, Some(3.0)),
            row("1", 0.0, 20.0, Some(-2.0)),
            row("1", 0.0, 10.0, Some(1.0)),
            row("1", 1.0, 10.0, None),
            row("2", 0.0, 20.0, Some(-1.0)),
            row("2", 1.0, 20.0, Some(-4.0)),
            row("2", 0.0, 10.0, Some(-4.0)),
            row("2", 1.0, 10.0, Some(9.0)),
        ];
        let layer = Layer { frame: 0, look: LayerLook::GrowthMap, x: 0, y: 1, sd: Some(3), mode: None };
        let nodes = MapNodes::of(&Frame { columns: Vec::new(), rows }, &layer);
        assert_eq!((&nodes.x[..], &nodes.y[..]), (&[0.0, 1.0][..], &[10.0, 20.0][..]));
        assert_eq!(nodes.modes[0][1], [[-2.0, 0.5], [3.0, 0.5]]);
        // At (1, 10) one of the modes is not known.
        assert_eq!(nodes.range(), [-1.0, 3.0]);
        assert_eq!(nodes.each(|[mean, sd]| mean + 2.0 * sd)[1][0][0], -3.0);
    }
}
