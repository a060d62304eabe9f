//! Steps towards the maximum of the likelihood.

/// What the last step was.
struct Last {
    /// What Gauss and Newton proposed, and the square of its length in standard deviations.
    proposed: Vec<f64>,
    square: f64,
    /// What was done.
    taken: Vec<f64>,
}

/// Gauss-Newton steps, accelerated by what the last one has shown (Anderson 1965, of depth one). Where
/// channels do not show quite the same impulse, the curvature that Gauss and Newton neglect makes their steps
/// too long or too short in one direction, up to a factor of two: by themselves they then settle slowly, to
/// and fro.
#[derive(Default)]
pub(super) struct Steps(Option<Last>);

/// Length in standard deviations below which steps are accelerated: far away, the last step says nothing
/// about the next.
const NEAR: f64 = 3.0;
/// Bounds of the share of the last step that is taken back.
const SHARES: (f64, f64) = (-4.0, 0.9);

impl Steps {
    /// Forgets the last step: the function has changed.
    pub(super) fn restart(&mut self) {
        self.0 = None;
    }

    /// The step to take where Gauss and Newton propose `step` along the gradient `gradient`.
    pub(super) fn next(&mut self, step: Vec<f64>, gradient: &[f64]) -> Vec<f64> {
        // The normal matrix times the proposed step is the gradient: inner products in standard deviations.
        let inner = |other: &[f64]| -> f64 { gradient.iter().zip(other).map(|(g, s)| g * s).sum() };
        let square = inner(&step);
        let taken = match &self.0 {
            Some(last) if square < NEAR * NEAR && last.square < NEAR * NEAR => {
                let mixed = inner(&last.proposed);
                let change = square - 2.0 * mixed + last.square;
                let share = ((square - mixed) / change.max(f64::MIN_POSITIVE)).clamp(SHARES.0, SHARES.1);
                let pairs = step.iter().zip(&last.proposed).zip(&last.taken);
                pairs.map(|((now, before), taken)| now - share * (taken + now - before)).collect()
            }
            _ => step.clone(),
        };
        self.0 = Some(Last { proposed: step, square, taken: taken.clone() });
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps until a minimum is reached along whose axes Gauss and Newton believe `factors` times its true
    /// curvature.
    fn count(factors: [f64; 3], accelerated: bool) -> usize {
        let (mut place, mut steps) = ([2.0, -1.0, 0.5], Steps::default());
        for number in 0..200 {
            let gradient = place.map(|x: f64| -x);
            let proposed: Vec<f64> = gradient.iter().zip(factors).map(|(g, f)| g / f).collect();
            if proposed.iter().all(|s| s.abs() < 1e-6) {
                return number;
            }
            let taken = if accelerated { steps.next(proposed, &gradient) } else { proposed };
            place.iter_mut().zip(taken).for_each(|(x, s)| *x += s);
        }
        200
    }

    #[test]
    fn oracle_a_wrong_curvature_in_one_direction_costs_few_steps() {
        assert_eq!(count([1.0; 3], true), 1);
        for factors in [[0.52, 1.0, 1.0], [3.0, 1.0, 1.0], [1.0, 0.6, 1.05], [2.0, 1.1, 0.95]] {
            let (plain, fast) = (count(factors, false), count(factors, true));
            assert!(plain >= 15 && fast <= 8 && 2 * fast < plain, "{factors:?}: {fast} instead of {plain}");
        }
    }
}
