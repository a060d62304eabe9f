//! Counting and finding the zeros of an analytic function in a rectangle: cells, edges and samples.

use super::modes::{Mode, Modes};
use super::region::Region;
use crate::error::NetworkError;
use rijke_numerics::C64;
use std::f64::consts::PI;

/// All zeros of an analytic function given with its derivative, or an error: the engine of
/// [`Network::modes`].
///
/// `poles` are poles of the function near the region, with orders; `step` is the longest interval between
/// samples, a quarter of the spacing of zeros or less.
pub(crate) fn zeros(
    f: impl FnMut(C64) -> [C64; 2],
    region: &Region,
    step: f64,
    poles: Vec<(C64, usize)>,
    pole_count: usize,
) -> Result<Modes, NetworkError> {
    /// A border of this many steps encloses some 1e4 modes.
    const LONGEST: f64 = 4e4;
    let Region { sigma: [left, right], omega: [low, high] } = *region;
    let border = ((right - left) + (high - low)) / step;
    if border.is_nan() || border > LONGEST {
        return Err(NetworkError::TooLarge {
            sigma: region.sigma,
            omega: region.omega,
            modes: 0.25 * border,
        });
    }
    let mut search = Search { f, poles, step, evaluations: 0 };
    let corners = [C64::new(left, low), C64::new(right, low), C64::new(right, high), C64::new(left, high)];
    let border = Cell {
        bottom: search.edge(corners[0], corners[1])?,
        right: search.edge(corners[1], corners[2])?,
        top: search.edge(corners[3], corners[2])?,
        left: search.edge(corners[0], corners[3])?,
    };
    let counted = border.winding();
    let mut modes: Vec<Mode> = Vec::new();
    search.resolve(border, 0, &mut modes)?;
    // A zero of G at a pole is a pole that does not act, not a mode.
    let before = modes.len();
    modes.retain(|m| !search.poles.iter().any(|p| (p.0 - m.s).norm() <= 1e-9 * m.s.norm()));
    let cancelled = (before - modes.len()) as i64;
    let found = modes.iter().map(|m| m.multiplicity as i64).sum::<i64>();
    if counted < 0 || found + cancelled != counted {
        return Err(NetworkError::Uncertified { counted, found });
    }
    modes.sort_by(|a, b| a.s.im.total_cmp(&b.s.im).then(a.s.re.total_cmp(&b.s.re)));
    Ok(Modes { modes, counted: found as usize, poles: pole_count, evaluations: search.evaluations })
}

/// All zeros of an analytic function in a region, with their orders: `f` gives it with its derivative, `step`
/// is the longest interval between samples, and `poles` are those of the function near the region.
///
/// # Errors
/// As [`crate::Network::modes`].
pub fn zeros_of(
    f: impl FnMut(C64) -> [C64; 2],
    region: &Region,
    step: f64,
    poles: Vec<(C64, usize)>,
) -> Result<Vec<(C64, usize)>, NetworkError> {
    let found = zeros(f, region, step, poles, 0)?;
    Ok(found.modes.iter().map(|m| (m.s, m.multiplicity)).collect())
}

/// G, and its logarithmic derivative, at one point.
#[derive(Clone, Copy, Debug)]
struct Sample {
    s: C64,
    g: C64,
    slope: C64,
}

/// Samples along a straight edge, close enough that ln G changes by less than 1.5 between neighbours.
type Edge = Vec<Sample>;

/// A rectangle: bottom and top run rightwards, left and right upwards.
struct Cell {
    bottom: Edge,
    right: Edge,
    top: Edge,
    left: Edge,
}

/// Change of ln G along an edge, and of its first moment about `centre`.
fn integrate(edge: &[Sample], centre: C64) -> (f64, C64) {
    let mut turn = 0.0;
    let mut moment = C64::ZERO;
    for w in edge.windows(2) {
        let change = (w[1].g / w[0].g).ln();
        turn += change.im;
        // By parts, with the cubic of Hermite for ln G: its slopes at both ends are known.
        let h = w[1].s - w[0].s;
        moment += (0.5 * (w[0].s + w[1].s) - centre) * change - h * h / 12.0 * (w[0].slope - w[1].slope);
    }
    (turn, moment)
}

impl Cell {
    fn sides(&self) -> [(&Edge, f64); 4] {
        [(&self.bottom, 1.0), (&self.right, 1.0), (&self.top, -1.0), (&self.left, -1.0)]
    }

    fn corners(&self) -> [C64; 2] {
        [self.bottom[0].s, self.top[self.top.len() - 1].s]
    }

    fn winding(&self) -> i64 {
        let total: f64 = self.sides().iter().map(|(edge, sign)| sign * integrate(edge, C64::ZERO).0).sum();
        (total / (2.0 * PI)).round() as i64
    }

    /// Sum of the zeros minus the sum of the poles inside, relative to `centre`.
    fn moment(&self, centre: C64) -> C64 {
        let total: C64 = self.sides().iter().map(|(edge, sign)| *sign * integrate(edge, centre).1).sum();
        total / C64::new(0.0, 2.0 * PI)
    }
}

struct Search<F> {
    f: F,
    poles: Vec<(C64, usize)>,
    /// Longest interval between samples.
    step: f64,
    evaluations: usize,
}

impl<F: FnMut(C64) -> [C64; 2]> Search<F> {
    fn sample(&mut self, s: C64) -> Result<Sample, NetworkError> {
        self.evaluations += 1;
        let [f, d] = (self.f)(s);
        let (mut g, mut slope) = (f, d / f);
        for &(pole, order) in &self.poles {
            let d = s - pole;
            g *= (d / self.step).powi(order as i32);
            slope += order as f64 / d;
        }
        if g.is_finite() && slope.is_finite() {
            Ok(Sample { s, g, slope })
        } else {
            Err(NetworkError::NotFinite { s })
        }
    }

    fn edge(&mut self, from: C64, to: C64) -> Result<Edge, NetworkError> {
        let pieces = ((to - from).norm() / self.step).ceil().max(2.0) as usize;
        let mut edge = vec![self.sample(from)?];
        for k in 1..=pieces {
            let end = self.sample(from + (to - from) * (k as f64 / pieces as f64))?;
            let start = edge[edge.len() - 1];
            self.refine(start, end, 0, &mut edge)?;
        }
        Ok(edge)
    }

    /// Appends samples after `a` up to and including `b`.
    fn refine(&mut self, a: Sample, b: Sample, depth: usize, edge: &mut Edge) -> Result<(), NetworkError> {
        /// Halvings before a zero is taken to lie on the edge.
        const DEEPEST: usize = 40;
        if depth > DEEPEST {
            return Err(NetworkError::Border { s: a.s });
        }
        let middle = self.sample(0.5 * (a.s + b.s))?;
        if agrees(&a, &middle) && agrees(&middle, &b) {
            edge.push(middle);
            edge.push(b);
            return Ok(());
        }
        self.refine(a, middle, depth + 1, edge)?;
        self.refine(middle, b, depth + 1, edge)
    }

    /// Finds the zeros of a cell.
    fn resolve(&mut self, cell: Cell, depth: usize, modes: &mut Vec<Mode>) -> Result<(), NetworkError> {
        /// Cells of 2^-30 of the region's side hold one multiple root.
        const DEEPEST: usize = 60;
        /// Error of a moment, as a part of the diagonal of the cell.
        const BLUR: f64 = 0.02;
        let count = cell.winding();
        let [low, high] = cell.corners();
        let centre = 0.5 * (low + high);
        let diagonal = (high - low).norm();
        let moment = cell.moment(centre);
        // A zero and a pole that no law declared cancel in the count but not in the moment.
        if count < 0 || (count == 0 && moment.norm() > BLUR * diagonal) {
            return Err(NetworkError::UndeclaredPole { low, high });
        }
        if count == 0 {
            return Ok(());
        }
        let guess = centre + moment / count as f64;
        if count == 1 || depth >= DEEPEST {
            if let Some(mode) = self.polish(guess, low, high, count as usize) {
                if (mode.s - guess).norm() > BLUR * diagonal {
                    return Err(NetworkError::UndeclaredPole { low, high });
                }
                modes.push(mode);
                return Ok(());
            }
            if depth >= DEEPEST {
                return Ok(());
            }
        }
        let [one, two] = match self.halve(&cell) {
            Ok(halves) => halves,
            // Roots closer than rounding lets the edges between them be counted: one multiple root, at their
            // mean.
            Err(NetworkError::Border { .. }) if count > 1 && diagonal < 1e-2 * self.step => {
                let residual =
                    self.sample(guess).map_or(0.0, |g| (count as f64 / g.slope).norm() / guess.norm());
                modes.push(Mode { s: guess, residual, multiplicity: count as usize });
                return Ok(());
            }
            Err(error) => return Err(error),
        };
        self.resolve(one, depth + 1, modes)?;
        self.resolve(two, depth + 1, modes)
    }

    /// Newton on G from `guess`; the root, if it lies in the cell.
    fn polish(&mut self, guess: C64, low: C64, high: C64, multiplicity: usize) -> Option<Mode> {
        let mut s = guess;
        let m = multiplicity as f64;
        for _ in 0..25 {
            let sample = match self.sample(s) {
                Ok(sample) => sample,
                // F vanishes exactly: the slope of ln G is infinite there.
                Err(_) => return inside(s, low, high).then_some(Mode { s, residual: 0.0, multiplicity }),
            };
            let step = -m / sample.slope;
            s += step;
            if step.norm() <= 1e-13 * s.norm() {
                let residual = step.norm() / s.norm();
                return inside(s, low, high).then_some(Mode { s, residual, multiplicity });
            }
            if !inside(s, low - (high - low), high + (high - low)) {
                return None;
            }
        }
        let residual = self.sample(s).map_or(0.0, |sample| (m / sample.slope).norm() / s.norm());
        (residual < 1e-9 && inside(s, low, high)).then_some(Mode { s, residual, multiplicity })
    }

    /// Halves a cell across its longer side, moving the cut if a zero lies on it.
    fn halve(&mut self, cell: &Cell) -> Result<[Cell; 2], NetworkError> {
        let [low, high] = cell.corners();
        let size = high - low;
        let mut failure = NetworkError::Border { s: 0.5 * (low + high) };
        // Odd fractions, so that the cut of one half does not continue that of another.
        for fraction in [0.503, 0.441, 0.561, 0.383, 0.622] {
            let outcome = if size.im > size.re {
                let cut = low.im + fraction * size.im;
                self.edge(C64::new(low.re, cut), C64::new(high.re, cut)).and_then(|middle| {
                    let (left_low, left_high) = self.split(&cell.left, middle[0])?;
                    let (right_low, right_high) = self.split(&cell.right, middle[middle.len() - 1])?;
                    Ok([
                        Cell {
                            bottom: cell.bottom.clone(),
                            right: right_low,
                            top: middle.clone(),
                            left: left_low,
                        },
                        Cell { bottom: middle, right: right_high, top: cell.top.clone(), left: left_high },
                    ])
                })
            } else {
                let cut = low.re + fraction * size.re;
                self.edge(C64::new(cut, low.im), C64::new(cut, high.im)).and_then(|middle| {
                    let (bottom_left, bottom_right) = self.split(&cell.bottom, middle[0])?;
                    let (top_left, top_right) = self.split(&cell.top, middle[middle.len() - 1])?;
                    Ok([
                        Cell {
                            bottom: bottom_left,
                            right: middle.clone(),
                            top: top_left,
                            left: cell.left.clone(),
                        },
                        Cell {
                            bottom: bottom_right,
                            right: cell.right.clone(),
                            top: top_right,
                            left: middle,
                        },
                    ])
                })
            };
            match outcome {
                Ok(cells) => return Ok(cells),
                Err(error) => failure = error,
            }
        }
        Err(failure)
    }

    /// Splits an edge at a new sample that lies on it.
    fn split(&mut self, edge: &Edge, at: Sample) -> Result<(Edge, Edge), NetworkError> {
        let start = edge[0].s;
        let distance = (at.s - start).norm();
        let k = edge.partition_point(|sample| (sample.s - start).norm() <= distance).clamp(1, edge.len() - 1);
        let mut first = edge[..k].to_vec();
        self.refine(edge[k - 1], at, 0, &mut first)?;
        let mut second = vec![at];
        self.refine(at, edge[k], 0, &mut second)?;
        second.extend_from_slice(&edge[k + 1..]);
        Ok((first, second))
    }
}

/// Whether the change of ln G between two samples is small and is what their slopes say.
fn agrees(a: &Sample, b: &Sample) -> bool {
    let change = (b.g / a.g).ln();
    let predicted = 0.5 * (b.s - a.s) * (a.slope + b.slope);
    change.is_finite() && (change - predicted).norm() < 0.25 && predicted.norm() < 1.5
}

fn inside(s: C64, low: C64, high: C64) -> bool {
    (low.re..=high.re).contains(&s.re) && (low.im..=high.im).contains(&s.im)
}
