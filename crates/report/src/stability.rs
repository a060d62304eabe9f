//! Where a trained model says that the rig is stable: growth rate and probability of instability over two
//! factors.

use crate::draw::{Axis, COLUMN, Figure, Key, Mark, Panel, fixed, scale_stroke};
use rijke_rig::DataKind;
use std::collections::BTreeMap;

/// Numbers of the map, on a grid of two factors. Between the nodes the map is bilinear; where a node is
/// missing it is blank.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityMap {
    /// Which model, in one line.
    pub title: String,
    /// Whether the data that trained it were measured.
    pub data: DataKind,
    /// Labels of both axes.
    pub labels: [String; 2],
    /// Values of the horizontal factor, ascending.
    pub x: Vec<f64>,
    /// Values of the vertical factor, ascending.
    pub y: Vec<f64>,
    /// Growth rate, 1/s, of vertical value k at horizontal value j: `growth_rate[k][j]`; NaN where there is
    /// none.
    pub growth_rate: Vec<Vec<f64>>,
    /// Probability that the growth rate is positive, in the same order.
    pub probability: Vec<Vec<f64>>,
}

const SIZE: [f64; 2] = [COLUMN, 320.0];
/// Colour of operating points.
const NODE: &str = "#888";
/// Pieces into which a cell of the grid is cut: within each, a contour is straight.
const PIECES: usize = 8;
/// Contours of the growth rate, about.
const LEVELS: usize = 7;
const PROBABILITIES: [f64; 7] = [0.001, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999];

impl StabilityMap {
    /// The figure as the text of an SVG file.
    #[must_use]
    pub fn svg(&self) -> String {
        let finite = || self.growth_rate.iter().flatten().copied().filter(|v| v.is_finite());
        let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let growth = levels(low, high);
        let per_second = |v: f64| format!("{} s^{{-1}}", fixed(v, decimals(&growth)));
        let percent = |v: f64| format!("{} %", 100.0 * v);
        let (a, mut legend) = self.panel("(a) growth rate", &self.growth_rate, &growth, 0.0, per_second);
        let (b, more) =
            self.panel("(b) probability of instability", &self.probability, &PROBABILITIES, 0.5, percent);
        if more.is_empty() {
            let all = self.probability.iter().flatten().copied().filter(|v| v.is_finite());
            let side = if all.fold(0.0, f64::max) < 0.5 { "below 0.1 %" } else { "above 99.9 %" };
            legend.push(Key {
                mark: Mark::Dot(NODE),
                label: format!("probability of instability {side} everywhere"),
            });
        }
        legend.extend(more);
        let figure = Figure {
            title: self.title.clone(),
            caption: String::new(),
            columns: 2,
            panels: vec![a, b],
            legend,
            data: Some(self.data),
        };
        figure.svg()
    }

    /// Contours of one quantity, the level `bold` thick, with the entries of those that appear.
    fn panel(
        &self,
        tag: &str,
        values: &[Vec<f64>],
        levels: &[f64],
        bold: f64,
        words: impl Fn(f64) -> String,
    ) -> (Panel, Vec<Key>) {
        let ends = |list: &[f64]| [list.first(), list.last()].map(|v| v.copied().unwrap_or(0.0));
        let ([left, right], [bottom, top]) = (ends(&self.x), ends(&self.y));
        // Room for the operating points at the edges.
        let axis = |label: &str, low: f64, high: f64| Axis::covering(label, [low, high]);
        let (x, y) = (axis(&self.labels[0], left, right), axis(&self.labels[1], bottom, top));
        let mut panel = Panel::new(tag, SIZE, x, y);
        let mut legend = Vec::new();
        for (k, &level) in levels.iter().enumerate() {
            let lines = self.contour(values, level);
            if lines.is_empty() {
                continue;
            }
            let width = if level == bold { 3.0 } else { 1.4 };
            let stroke = scale_stroke(k, levels.len(), width);
            panel.curve(&lines, &stroke);
            legend.push(Key { mark: Mark::Line(stroke), label: words(level) });
        }
        for (k, &power) in self.y.iter().enumerate() {
            for (j, &x) in self.x.iter().enumerate().filter(|(j, _)| values[k][*j].is_finite()) {
                panel.dot([x, power], 1.8, NODE, &words(values[k][j]));
            }
        }
        (panel, legend)
    }

    /// The lines on which a quantity has a value, apart by points that are not finite.
    fn contour(&self, values: &[Vec<f64>], level: f64) -> Vec<[f64; 2]> {
        let mut pieces = Vec::new();
        for k in 1..self.y.len() {
            for j in 1..self.x.len() {
                let at = |u: f64, v: f64| {
                    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
                    let low = mix(values[k - 1][j - 1], values[k - 1][j], u);
                    let value = mix(low, mix(values[k][j - 1], values[k][j], u), v);
                    let x = mix(self.x[j - 1], self.x[j], u);
                    [x, mix(self.y[k - 1], self.y[k], v), value - level]
                };
                for (a, b) in (0..PIECES).flat_map(|a| (0..PIECES).map(move |b| (a, b))) {
                    let corner = |da: usize, db: usize| {
                        at((a + da) as f64 / PIECES as f64, (b + db) as f64 / PIECES as f64)
                    };
                    let [p, q, r, s] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    for triangle in [[p, q, r], [p, r, s]] {
                        pieces.extend(crossing(triangle));
                    }
                }
            }
        }
        self.joined(pieces)
    }

    /// Pieces end to end, so that dashes run through: first lines that begin somewhere, then closed ones.
    fn joined(&self, mut pieces: Vec<Piece>) -> Vec<[f64; 2]> {
        let least = |list: &[f64]| [list.first(), list.last()].map(|v| v.copied().unwrap_or(0.0));
        let frame = [least(&self.x), least(&self.y)];
        // The same point of two triangles differs by rounding.
        let place = |p: [f64; 2]| {
            [0, 1].map(|k| ((p[k] - frame[k][0]) / (frame[k][1] - frame[k][0]) * 1e7).round() as i64)
        };
        pieces.retain(|[a, b]| place(*a) != place(*b));
        let mut at: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        for (i, piece) in pieces.iter().enumerate() {
            piece.iter().for_each(|end| at.entry(place(*end)).or_default().push(i));
        }
        let (mut lines, mut drawn) = (Vec::new(), vec![false; pieces.len()]);
        let free = |end: [f64; 2]| at.get(&place(end)).is_some_and(|ends| ends.len() == 1);
        let begins = (0..pieces.len()).filter(|i| pieces[*i].iter().any(|end| free(*end)));
        for first in begins.chain(0..pieces.len()) {
            let [a, b] = pieces[first];
            let (mut next, mut end) = (Some(first), if free(b) { b } else { a });
            if !drawn[first] {
                lines.extend([[f64::NAN; 2], end]);
            }
            while let Some(i) = next.filter(|i| !drawn[*i]) {
                let [a, b] = pieces[i];
                (drawn[i], end) = (true, if place(a) == place(end) { b } else { a });
                lines.push(end);
                next = at.get(&place(end)).and_then(|all| all.iter().copied().find(|i| !drawn[*i]));
            }
        }
        lines
    }
}

/// Two ends.
type Piece = [[f64; 2]; 2];

/// Where the plane through three points is zero within their triangle.
fn crossing(triangle: [[f64; 3]; 3]) -> Option<Piece> {
    let side = |i: usize| {
        let ([x0, y0, a], [x1, y1, b]) = (triangle[i], triangle[(i + 1) % 3]);
        // Zero belongs to one side only, so that a line through a corner is found once.
        ((a < 0.0) != (b < 0.0)).then(|| [x0 + (x1 - x0) * a / (a - b), y0 + (y1 - y0) * a / (a - b)])
    };
    let ends: Vec<[f64; 2]> = (0..3).filter_map(side).collect();
    <Piece>::try_from(ends).ok()
}

/// Round levels between two values, zero among them if it is between.
fn levels(low: f64, high: f64) -> Vec<f64> {
    if high <= low {
        return Vec::new();
    }
    let rough = (high - low) / LEVELS as f64;
    let unit = 10f64.powf(rough.log10().floor());
    let step =
        [1.0, 2.0, 5.0, 10.0].map(|m| m * unit).into_iter().find(|s| *s >= rough).unwrap_or(10.0 * unit);
    let first = (low / step).ceil() as i64;
    (first..).map(|k| k as f64 * step).take_while(|v| *v <= high).collect()
}

fn decimals(levels: &[f64]) -> usize {
    let step = levels.windows(2).map(|w| w[1] - w[0]).fold(f64::INFINITY, f64::min);
    if step.is_finite() && step < 1.0 { (-step.log10()).ceil() as usize } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map() -> StabilityMap {
        let (x, y) = (vec![0.0, 0.5, 1.0], vec![0.0, 100.0]);
        // The plane 2 x - 0.01 y - 0.5.
        let value = |x: f64, y: f64| 2.0 * x - 0.01 * y - 0.5;
        let growth_rate: Vec<Vec<f64>> =
            y.iter().map(|y| x.iter().map(|x| value(*x, *y)).collect()).collect();
        let probability =
            growth_rate.iter().map(|row| row.iter().map(|v| f64::from(*v > 0.0)).collect()).collect();
        StabilityMap {
            title: "T".into(),
            data: DataKind::Virtual,
            labels: ["x / m", "y / W"].map(String::from),
            x,
            y,
            growth_rate,
            probability,
        }
    }

    #[test]
    fn exact_the_contour_of_a_plane_is_its_line() {
        let map = map();
        let lines = map.contour(&map.growth_rate, 0.25);
        let on: Vec<&[f64; 2]> = lines.iter().filter(|p| p[0].is_finite()).collect();
        assert!(on.len() > 5 && on.iter().all(|p| (2.0 * p[0] - 0.01 * p[1] - 0.75).abs() < 1e-12));
        let reach = |k: usize| on.iter().map(|p| p[k]).fold(0.0, f64::max);
        assert!((reach(0) - 0.875).abs() < 1e-12 && (reach(1) - 100.0).abs() < 1e-12);
        assert_eq!(lines.len(), on.len() + 1, "one line, through which its dashes run");
        assert!(map.contour(&map.growth_rate, 5.0).is_empty());
        assert_eq!(levels(-1.5, 1.5), [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5]);
    }

    #[test]
    fn exact_what_is_missing_is_blank() {
        let mut map = map();
        map.growth_rate[0][0] = f64::NAN;
        let svg = map.svg();
        assert!(!svg.contains("NaN") && svg.contains("probability of instability"));
        assert!(
            map.contour(&map.growth_rate, 0.25).iter().all(|p| p[0].is_nan() || p[0] >= 0.5),
            "the cell with the gap is left out"
        );
    }
}
