//! The subproblem of a trust region: a quadratic model within a ball.

use crate::error::InferenceError;
use rijke_numerics::dot;
use rijke_numerics::{Matrix, symmetric_eigen};

/// The quadratic model g's + s'Hs/2 in scaled coordinates, on the eigenvectors of H.
pub(crate) struct Quadratic {
    values: Vec<f64>,
    vectors: Matrix,
    slope: Vec<f64>,
}

impl Quadratic {
    pub(crate) fn new(hessian: &Matrix, gradient: &[f64], stretch: &[f64]) -> Result<Self, InferenceError> {
        let n = gradient.len();
        let scaled = Matrix::from_fn(n, n, |i, j| hessian[(i, j)] / (stretch[i] * stretch[j]));
        let (values, vectors) = symmetric_eigen(&scaled)?;
        let mut model = Self { values, vectors, slope: Vec::new() };
        model.slope = model.project(gradient, stretch);
        Ok(model)
    }

    fn project(&self, gradient: &[f64], stretch: &[f64]) -> Vec<f64> {
        let scaled: Vec<f64> = gradient.iter().zip(stretch).map(|(g, d)| g / d).collect();
        (0..scaled.len()).map(|k| (0..scaled.len()).map(|i| self.vectors[(i, k)] * scaled[i]).sum()).collect()
    }

    /// Lowest eigenvalue over the highest; one for an empty matrix.
    pub(crate) fn ratio(&self) -> f64 {
        match (self.values.first(), self.values.last()) {
            (Some(low), Some(high)) => low / high.abs().max(f64::MIN_POSITIVE),
            _ => 1.0,
        }
    }

    fn positive(&self) -> bool {
        self.ratio() > 4.0 * f64::EPSILON
    }

    pub(crate) fn decrement(&self) -> f64 {
        if !self.positive() {
            return f64::INFINITY;
        }
        0.5 * self.slope.iter().zip(&self.values).map(|(g, l)| g * g / l).sum::<f64>()
    }

    pub(crate) fn decrement_of(&self, gradient: &[f64], stretch: &[f64]) -> f64 {
        let slope = self.project(gradient, stretch);
        0.5 * slope.iter().zip(&self.values).map(|(g, l)| g * g / l).sum::<f64>()
    }

    /// The minimiser of the model within `radius`, its length, and the drop that the model predicts.
    pub(crate) fn step(&self, radius: f64) -> (Vec<f64>, f64, f64) {
        let n = self.values.len();
        let at = |shift: f64| -> Vec<f64> {
            (0..n)
                .map(|k| if self.slope[k] == 0.0 { 0.0 } else { -self.slope[k] / (self.values[k] + shift) })
                .collect()
        };
        let mut along = at(0.0);
        if !self.positive() || norm(&along) > radius {
            let lowest = self.values.first().copied().unwrap_or(0.0);
            let mut low = (-lowest).max(0.0);
            let mut high = low + norm(&self.slope) / radius;
            // The length of s falls with the shift; its inverse is nearly straight in it, so Newton on that,
            // kept inside the bracket.
            let mut shift = high;
            for _ in 0..60 {
                along = at(shift);
                let length = norm(&along);
                if (length / radius - 1.0).abs() < 1e-3 || high - low <= 1e-14 * high {
                    break;
                }
                if length > radius {
                    low = shift;
                } else {
                    high = shift;
                }
                let slope: f64 = (0..n).map(|k| along[k] * along[k] / (self.values[k] + shift)).sum();
                let newton = shift + (length * length / slope) * (length / radius - 1.0);
                shift = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            }
            let length = norm(&along);
            if length < 0.9 * radius && lowest <= 0.0 {
                // The hard case: the gradient has no part along the lowest curvature; go along it to the
                // boundary.
                along[0] += (radius * radius - length * length).sqrt();
            }
        }
        let predicted =
            -(0..n).map(|k| along[k] * (self.slope[k] + 0.5 * self.values[k] * along[k])).sum::<f64>();
        let step = (0..n).map(|i| (0..n).map(|k| self.vectors[(i, k)] * along[k]).sum()).collect();
        (step, norm(&along), predicted)
    }
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(h: &Matrix, g: &[f64], s: &[f64]) -> f64 {
        dot(g, s) + 0.5 * h.quadratic(s)
    }

    #[test]
    fn oracle_step_is_the_lowest_point_of_the_ball() {
        // Positive definite, indefinite, and the hard case (no slope along the lowest curvature).
        let cases =
            [([3.0, 1.0, 2.0], [0.5, -0.3]), ([1.0, 1.0, -2.0], [0.5, -0.3]), ([2.0, 0.0, -1.0], [0.4, 0.0])];
        for ([a, b, c], g) in cases {
            let h = Matrix::from_fn(2, 2, |i, j| {
                if i != j {
                    b
                } else if i == 0 {
                    a
                } else {
                    c
                }
            });
            for radius in [0.05, 0.7, 100.0] {
                let model = Quadratic::new(&h, &g, &[1.0, 1.0]).unwrap();
                let (step, length, predicted) = model.step(radius);
                assert!(length <= radius * 1.002);
                assert!((predicted + value(&h, &g, &step)).abs() < 1e-9 * (1.0 + predicted.abs()));
                // No point of a fine polar grid is lower by more than the 0.2 % that the radius is allowed to
                // miss.
                let lowest = (0..=200)
                    .flat_map(|r| {
                        (0..720).map(move |t| (f64::from(r) / 200.0, f64::from(t).to_radians() / 2.0))
                    })
                    .map(|(r, t)| value(&h, &g, &[radius * r * t.cos(), radius * r * t.sin()]))
                    .fold(f64::INFINITY, f64::min);
                assert!(
                    -predicted <= lowest + 3e-3 * lowest.abs(),
                    "{a} {b} {c}, {radius}: {predicted} {lowest}"
                );
            }
        }
    }
}
