//! What Gauss and Newton's method leaves out of the second derivatives of the cost: second derivatives of the
//! model times residuals.
//!
//! Along the floor of a narrow valley, where data say little, this part is as large as the rest. It is
//! learned from the slopes at both ends of each step, as a sum of u u'/d (Dennis, Gay & Welsch 1981, An
//! adaptive nonlinear least-squares algorithm, with the symmetric update of rank one in place of theirs).
//! Knows neither runs nor the model.

use super::joint::{Arrow, Scores};
use rijke_numerics::{Matrix, lu_solve, symmetric_eigen};

/// The terms u and d, oldest first.
#[derive(Default)]
pub(super) struct Bend(Vec<(Scores, f64)>);

impl Bend {
    /// Learns from a `step` along which this part of the gradient had this `change`.
    pub(super) fn learn(&mut self, step: &Scores, change: &Scores) {
        let u = self.0.iter().fold(change.clone(), |left, (u, d)| left.plus(-u.dot(step) / d, u));
        let d = u.dot(step);
        if d.abs() > DISTINCT * (u.dot(&u) * step.dot(step)).sqrt() {
            self.0.push((u, d));
        }
    }

    /// Newton's step down the slope `down`, where `arrow` has the inverse of the rest of the second
    /// derivatives. Oldest terms are forgotten until the sum is positive definite.
    pub(super) fn step(&mut self, arrow: &Arrow, down: &Scores) -> Scores {
        let plain = arrow.step(down);
        loop {
            let n = self.0.len();
            if n == 0 {
                return plain;
            }
            // Sherman, Morrison & Woodbury.
            let moved: Vec<Scores> = self.0.iter().map(|(u, _)| arrow.step(u)).collect();
            let inner = Matrix::from_fn(n, n, |i, j| {
                let (u, d) = &self.0[i];
                u.dot(&moved[j]) + if i == j { *d } else { 0.0 }
            });
            let right: Vec<f64> = self.0.iter().map(|(u, _)| u.dot(&plain)).collect();
            // By Sylvester's law, as many negative eigenvalues as negative terms, if the sum is positive.
            let negative = self.0.iter().filter(|term| term.1 < 0.0).count();
            let positive = symmetric_eigen(&inner)
                .is_ok_and(|(values, _)| values.iter().filter(|v| **v < 0.0).count() == negative);
            match lu_solve(&inner, &right) {
                Ok(shares) if positive => {
                    return moved.iter().zip(shares).fold(plain, |sum, (m, share)| sum.plus(-share, m));
                }
                _ => drop(self.0.remove(0)),
            }
        }
    }
}

/// Cosine between a step and what is new of its change, below which rounding decides.
const DISTINCT: f64 = 1e-8;

#[cfg(test)]
mod tests {
    use super::super::unknowns::FIXED;
    use super::*;

    /// With as many steps as unknowns, the second derivatives are known, whatever their sign.
    #[test]
    fn oracle_steps_are_those_of_the_dense_second_derivatives() {
        let centre = || Scores::centre([FIXED].into_iter());
        let scores = |v: [f64; 3]| {
            let mut all = vec![0.0; FIXED];
            all[..3].copy_from_slice(&v);
            centre().descent([all.as_slice()].into_iter())
        };
        let bend = Matrix::from_fn(3, 3, |i, j| if i == j { [0.7, -0.3, 0.2][i] } else { 0.1 });
        let arrow = Arrow::new([Matrix::zeros(FIXED, FIXED)].iter(), 0.0).unwrap();
        let act = |s: &Scores| {
            let image = bend.times(&s.of(0)[..3]);
            scores([image[0], image[1], image[2]])
        };
        let mut learned = Bend::default();
        for step in [[1.0, 0.2, 0.0], [0.1, 1.0, -0.4], [0.3, 0.2, 1.0]].map(scores) {
            learned.learn(&step, &act(&step));
        }
        let down = scores([0.4, -1.0, 0.5]);
        let found = learned.step(&arrow, &down);
        let left = found.plus(1.0, &act(&found)).plus(-1.0, &down);
        assert!(left.dot(&left) < 1e-20 * down.dot(&down), "{left:?}");
    }
}
