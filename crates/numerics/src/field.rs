//! A quantity over a grid of two others: where it is at least zero, and the lines on which it is zero.

use std::collections::{BTreeMap, BTreeSet};

/// Pieces into which a cell of the grid is cut along either side: within each triangle of such a piece the
/// quantity is taken as linear, within the cell as bilinear.
const PIECES: usize = 8;

/// The grid.
#[derive(Clone, Copy, Debug)]
pub struct GridField<'a> {
    /// Horizontal values, ascending, at least two.
    pub x: &'a [f64],
    /// Vertical values, ascending, at least two.
    pub y: &'a [f64],
}

/// Lines, closed or not, whose ends do not come again.
pub type Lines = Vec<Vec<[f64; 2]>>;

/// A corner of the fine grid, or where the quantity is zero between two of them.
type Spot = [usize; 2];

/// Where a quantity is at least zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Zero {
    /// The area where it is at least zero, as closed lines: those about the area run against the clock, those
    /// about its holes with the clock.
    pub area: Lines,
    /// The lines on which it is zero, the area on their left. A line that is closed ends where it begins.
    pub lines: Lines,
}

impl GridField<'_> {
    /// Of the largest of some quantities, each given at the nodes, `[vertical][horizontal]`. Cells of which a
    /// node is not finite are left out.
    #[must_use]
    pub fn zero(&self, quantities: &[Vec<Vec<f64>>]) -> Zero {
        let fine = Fine::of(self, quantities);
        let (mut edges, mut crossings) = (BTreeSet::new(), BTreeMap::new());
        for triangle in fine.triangles() {
            let corners = fine.inside(triangle);
            for (k, &a) in corners.iter().enumerate() {
                let b = corners[(k + 1) % corners.len()];
                // What two triangles share is no edge of the area.
                if a != b && !edges.remove(&[b, a]) {
                    edges.insert([a, b]);
                }
                if a != b && a[0] != a[1] && b[0] != b[1] {
                    crossings.insert(a, b);
                }
            }
        }
        let place = |line: Vec<Spot>| straight(line.into_iter().map(|s| fine.place(s)).collect());
        let area = loops(edges).into_iter().map(place).collect();
        Zero { area, lines: chains(crossings).into_iter().map(place).collect() }
    }
}

/// The grid cut into pieces, with the quantity at each corner.
struct Fine {
    x: Vec<f64>,
    y: Vec<f64>,
    values: Vec<f64>,
}

impl Fine {
    fn of(field: &GridField<'_>, quantities: &[Vec<Vec<f64>>]) -> Self {
        let count = |list: &[f64]| (list.len().max(1) - 1) * PIECES + 1;
        // The cell of a corner, and the share of the way through it.
        let cell = |i: usize, list: &[f64]| {
            let j = (i / PIECES).min(list.len().saturating_sub(2));
            (j, (i - j * PIECES) as f64 / PIECES as f64)
        };
        // A node of no weight need not be known.
        let mix = |a: f64, b: f64, t: f64| match t {
            0.0 => a,
            1.0 => b,
            t => a + (b - a) * t,
        };
        let axis = |list: &[f64]| -> Vec<f64> {
            let at = |i: usize| {
                let (j, t) = cell(i, list);
                mix(list[j], list[(j + 1).min(list.len() - 1)], t)
            };
            (0..count(list)).map(at).collect()
        };
        let (x, y) = (axis(field.x), axis(field.y));
        let at = |place: usize| {
            let (k, v) = cell(place / x.len(), field.y);
            let (j, u) = cell(place % x.len(), field.x);
            let of = |q: &Vec<Vec<f64>>| {
                let row = |k: usize| mix(q[k][j], q[k][(j + 1).min(q[k].len() - 1)], u);
                mix(row(k), row((k + 1).min(q.len() - 1)), v)
            };
            // What is not known of one may be the largest.
            let largest = |a: f64, b: f64| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) };
            quantities.iter().map(of).reduce(largest).unwrap_or(f64::NAN)
        };
        let values = (0..x.len() * y.len()).map(at).collect();
        Self { x, y, values }
    }

    /// Against the clock, where all corners are known.
    fn triangles(&self) -> impl Iterator<Item = [usize; 3]> {
        let wide = self.x.len();
        let pieces = (1..self.y.len()).flat_map(move |k| (1..wide).map(move |j| k * wide + j));
        let both = pieces.flat_map(move |s| {
            let [p, q, r] = [s - wide - 1, s - wide, s - 1];
            [[p, q, s], [p, s, r]]
        });
        both.filter(|t| t.iter().all(|&k| self.values[k].is_finite()))
    }

    /// The part of a triangle in which the quantity is at least zero.
    fn inside(&self, triangle: [usize; 3]) -> Vec<Spot> {
        let is_in = |k: usize| self.values[k] >= 0.0;
        let mut corners = Vec::new();
        for (a, b) in (0..3).map(|i| (triangle[i], triangle[(i + 1) % 3])) {
            if is_in(a) {
                corners.push([a, a]);
            }
            if is_in(a) != is_in(b) {
                corners.push([a.min(b), a.max(b)]);
            }
        }
        corners
    }

    fn place(&self, [a, b]: Spot) -> [f64; 2] {
        let at = |k: usize| [self.x[k % self.x.len()], self.y[k / self.x.len()]];
        let (p, q) = (at(a), at(b));
        if a == b {
            return p;
        }
        let t = self.values[a] / (self.values[a] - self.values[b]);
        [p[0] + (q[0] - p[0]) * t, p[1] + (q[1] - p[1]) * t]
    }
}

/// Edges end to end, each once, until they close.
fn loops(mut edges: BTreeSet<[Spot; 2]>) -> Vec<Vec<Spot>> {
    let mut all = Vec::new();
    while let Some([first, second]) = edges.pop_first() {
        let (mut line, mut end) = (vec![first], second);
        while end != first {
            line.push(end);
            let next = edges.range([end, [0, 0]]..).next().copied().filter(|e| e[0] == end);
            // As many edges begin at a corner as end there.
            let Some(next) = next else { break };
            edges.remove(&next);
            end = next[1];
        }
        all.push(line);
    }
    all
}

/// From each point to the next: first the lines that begin somewhere, then closed ones.
fn chains(mut next: BTreeMap<Spot, Spot>) -> Vec<Vec<Spot>> {
    let ends: BTreeSet<Spot> = next.values().copied().collect();
    let begins: Vec<Spot> = next.keys().copied().filter(|k| !ends.contains(k)).collect();
    let mut begins = begins.into_iter();
    let mut all = Vec::new();
    while let Some(first) = begins.next().or_else(|| next.keys().next().copied()) {
        let (mut line, mut end) = (vec![first], first);
        while let Some(to) = next.remove(&end) {
            line.push(to);
            end = to;
        }
        all.push(line);
    }
    all
}

/// Without points that lie on the way from the one before to the one after.
fn straight(line: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::with_capacity(line.len());
    for at in line {
        while let [.., a, b] = kept[..] {
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [at[0] - b[0], at[1] - b[1]]);
            // Along one axis alone, as edges of the grid run.
            let along = |k: usize| u[k] == 0.0 && v[k] == 0.0;
            if !(along(0) || along(1)) {
                break;
            }
            kept.pop();
        }
        kept.push(at);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 3] = [0.0, 0.5, 1.0];
    const Y: [f64; 2] = [0.0, 100.0];

    fn nodes(value: impl Fn(f64, f64) -> f64) -> Vec<Vec<f64>> {
        Y.iter().map(|y| X.iter().map(|x| value(*x, *y)).collect()).collect()
    }

    /// Positive where it runs against the clock.
    fn size(loops: &Lines) -> f64 {
        let of = |l: &Vec<[f64; 2]>| {
            let ends = |k: usize| (l[k], l[(k + 1) % l.len()]);
            (0..l.len()).map(ends).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum::<f64>()
        };
        loops.iter().map(of).sum()
    }

    #[test]
    fn exact_a_plane_is_zero_on_one_line_and_positive_on_one_side() {
        let field = GridField { x: &X, y: &Y };
        let plane = |x: f64, y: f64| 2.0 * x - 0.01 * y - 0.75;
        let zero = field.zero(&[nodes(plane)]);
        assert_eq!((zero.area.len(), zero.lines.len()), (1, 1));
        assert!(zero.lines[0].iter().all(|p| plane(p[0], p[1]).abs() < 1e-12));
        let ends = [zero.lines[0].first().unwrap(), zero.lines[0].last().unwrap()];
        assert!(ends.iter().any(|p| (p[0] - 0.375).abs() < 1e-12 && p[1] == 0.0), "{ends:?}");
        assert!(ends.iter().any(|p| (p[0] - 0.875).abs() < 1e-12 && p[1] == 100.0), "{ends:?}");
        // Right of the line from 0.375 to 0.875.
        assert!((size(&zero.area) - 37.5).abs() < 1e-9, "{}", size(&zero.area));
        let above = field.zero(&[nodes(|_, _| -1.0)]);
        assert!(above.area.is_empty() && above.lines.is_empty());
        let all = field.zero(&[nodes(|_, _| 0.0)]);
        assert!(size(&all.area) == 100.0 && all.lines.is_empty() && all.area[0].len() <= 5);
    }

    #[test]
    fn exact_a_corner_that_is_zero_is_no_area() {
        let field = GridField { x: &X, y: &Y };
        let zero = field.zero(&[nodes(|x, y| x + 0.01 * y - 2.0)]);
        assert!(
            size(&zero.area).abs() < 1e-12 && zero.lines.iter().all(|l| l.len() <= 3),
            "{:?}",
            zero.lines
        );
        let rest = field.zero(&[nodes(|x, y| 2.0 - x - 0.01 * y)]);
        assert!((size(&rest.area) - 100.0).abs() < 1e-12);
    }

    #[test]
    fn exact_a_hole_turns_with_the_clock_and_a_gap_is_left_out() {
        let x = [0.0, 1.0, 2.0, 3.0];
        let field = GridField { x: &x, y: &x };
        let mut hill = vec![vec![1.0; 4]; 4];
        for k in [1, 2] {
            (1..3).for_each(|j| hill[k][j] = -1.0);
        }
        let zero = field.zero(std::slice::from_ref(&hill));
        assert_eq!((zero.area.len(), zero.lines.len()), (2, 1));
        assert_eq!(zero.lines[0].first(), zero.lines[0].last(), "a closed line");
        // The square in the middle, four halves beside it, and four corners 1 - 2 x y < 0.
        let hole = 3.0 + 2.0 * (1.0 - std::f64::consts::LN_2);
        assert!((9.0 - size(&zero.area) - hole).abs() < 1e-3, "{}", size(&zero.area));
        hill[0][0] = f64::NAN;
        let gap = field.zero(&[hill]);
        assert!((size(&zero.area) - size(&gap.area) - 1.0).abs() < 0.3, "the cell with the gap is left out");
        assert!(gap.area.iter().flatten().all(|p| p[0] >= 1.0 || p[1] >= 1.0));
    }

    #[test]
    fn exact_the_largest_of_two_counts_where_both_are_known() {
        let field = GridField { x: &X, y: &Y };
        let (left, right) = (nodes(|x, _| 0.25 - x), nodes(|x, _| x - 0.75));
        let both = field.zero(&[left.clone(), right.clone()]);
        assert!((size(&both.area) - 50.0).abs() < 1e-9 && both.lines.len() == 2);
        let mut unknown = right;
        unknown[0][0] = f64::NAN;
        let part = field.zero(&[left, unknown]);
        assert!((size(&part.area) - 25.0).abs() < 1e-9);
    }
}
