//! Newton's iteration on an analytic function, from a guess to the zero nearby.

use crate::error::NetworkError;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// How Newton's iteration is bounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Most steps taken; 30 unless set.
    pub max_steps: usize,
    /// The iteration ends when its estimate of the error, relative to |s|, is below this, at most 0.1; 1e-13
    /// unless set. Where rounding keeps it from that, 1e-8 after the last step is enough.
    pub tolerance: f64,
    /// No step is longer than this, 1/s. Half the spacing of modes, pi/(2 travel time), unless set.
    pub max_step: Option<f64>,
    /// A root farther than this from the guess is [`NetworkError::LostBranch`], 1/s. The spacing of modes
    /// unless set.
    pub radius: Option<f64>,
}

impl Default for Newton {
    fn default() -> Self {
        Self { max_steps: 30, tolerance: 1e-13, max_step: None, radius: None }
    }
}

/// An eigenvalue.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Root {
    /// s = sigma + i omega, 1/s and rad/s.
    pub s: C64,
    /// Newton steps taken.
    pub steps: usize,
    /// Estimate of the error of s relative to |s|, on the safe side.
    pub residual: f64,
}

/// The largest error, relative to |s|, at which a root may be called one.
const LOOSEST: f64 = 0.1;

/// An iteration that has used up its steps has converged if its least estimate of the error is below this.
const ROUNDED: f64 = 1e-8;

/// A Newton step shorter than this part of the last one is in the region of quadratic convergence.
const QUADRATIC: f64 = 0.1;

/// The step from `s1` to the zero of the inverse function's cubic through two points with slopes, and its
/// last term, which estimates the error (the true one is smaller by about the ratio of the step before to the
/// mode spacing).
///
/// With d = (s1 - s0)/(F1 - F0) and m = 1/F': s = s1 - m1 F1 + (m1 - d)/(F1 - F0) F1^2
/// - (m0 - 2d + m1)/(F1 - F0)^2 F1^2 F0. It saves the third sweep of Newton's iteration from a warm start.
fn inverse_cubic(s0: C64, f0: ComplexDual, s1: C64, f1: ComplexDual) -> (C64, f64) {
    let (m0, m1) = (f0.slope.inv(), f1.slope.inv());
    let h = (f1.value - f0.value).inv();
    let d = (s1 - s0) * h;
    let square = f1.value * f1.value * h;
    let cubic = (m0 - 2.0 * d + m1) * h * square * f0.value;
    (-m1 * f1.value + (m1 - d) * square - cubic, cubic.norm())
}

/// Newton's iteration on an analytic function whose zeros lie about `spacing` apart.
#[inline]
pub(crate) fn iterate(
    guess: C64,
    spacing: f64,
    settings: &Newton,
    mut f: impl FnMut(C64) -> ComplexDual,
) -> Result<Root, NetworkError> {
    if !(0.0..=LOOSEST).contains(&settings.tolerance) {
        return Err(NetworkError::Tolerance { tolerance: settings.tolerance });
    }
    let longest = settings.max_step.unwrap_or(0.5 * spacing);
    let mut s = guess;
    let mut last: Option<(C64, ComplexDual)> = None;
    let mut residual = f64::INFINITY;
    let mut least = (f64::INFINITY, guess);
    for steps in 1..=settings.max_steps {
        let at = f(s);
        let newton = -at.value / at.slope;
        if !newton.is_finite() {
            return Err(NetworkError::NotFinite { s });
        }
        let (step, error) = match last {
            Some((s0, f0)) if newton.norm() < QUADRATIC * (s - s0).norm() => inverse_cubic(s0, f0, s, at),
            _ => (newton, newton.norm()),
        };
        let length = step.norm();
        let limited = length > longest;
        last = (!limited).then_some((s, at));
        s += if limited { step * (longest / length) } else { step };
        residual = error / s.norm();
        if residual < least.0 {
            least = (residual, s);
        }
        if residual <= settings.tolerance {
            let radius = settings.radius.unwrap_or(spacing);
            return if (s - guess).norm() > radius {
                Err(NetworkError::LostBranch { from: guess, to: s })
            } else {
                Ok(Root { s, steps, residual })
            };
        }
    }
    // Rounding may keep it from the tolerance; the estimate then goes up and down.
    let radius = settings.radius.unwrap_or(spacing);
    if least.0 <= ROUNDED && (least.1 - guess).norm() <= radius {
        return Ok(Root { s: least.1, steps: settings.max_steps, residual: least.0 });
    }
    Err(NetworkError::NotConverged { steps: settings.max_steps, residual })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// F at a zero, where nothing is left but rounding: every step is as long as that.
    #[test]
    fn behaviour_rounding_above_the_tolerance_costs_no_root() {
        let zero = C64::new(-30.0, 700.0);
        let with_rounding = |rounding: f64| {
            let mut angle = 0.0;
            iterate(zero, 300.0, &Newton::default(), |_| {
                angle += 2.4;
                let value = C64::from_polar(1e-3 * rounding * zero.norm(), angle);
                ComplexDual { value, slope: C64::new(1e-3, 0.0) }
            })
        };
        let root = with_rounding(1e-10).unwrap();
        assert!((root.s - zero).norm() < 1e-6 && root.residual < 1e-8, "{root:?}");
        assert!(matches!(with_rounding(1e-5), Err(NetworkError::NotConverged { .. })));
    }
}
