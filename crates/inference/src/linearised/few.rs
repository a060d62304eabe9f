//! What few data leave unknown of the noises that they choose, and how much wider that makes what is stated.
//!
//! A noise that floats is at its most probable value together with the parameters. From few data that is too
//! small on average, and whatever it is, the truth lies about it: intervals that take it for known are too
//! narrow. With t_g the variance of noise g and S_g its part of the covariance of the data, P as in
//! [`super`]:
//!
//! * The likelihood of the noise alone, the parameters integrated out (restricted likelihood: Patterson &
//!   Thompson, Biometrika 58 (1971) 545), is largest a step I^-1 g away in ln t, with g_g = tr(C^-1 F Sigma
//!   F' C^-1 S_g)/2 and the information I_gh = tr(P S_g P S_h)/2. For n data of one noise and q parameters
//!   that step, taken in t, is exact: t n/(n - q).
//! * A variance v, of which noise g brings v_g, is as certain as one from 2 v^2/(v' I^-1 v) degrees of
//!   freedom (Satterthwaite, Biometrics Bull. 2 (1946) 110; for mixed models Giesbrecht & Burns, Biometrics
//!   41 (1985) 477), with I after that step: beside a floor of variance f it grows as (t_g/(t_g + f))^2, so
//!   that what is unknown of t_g is in proportion to t_g + f. Of that interval of Student's t which holds the
//!   truth with the probability of two standard deviations, half of the half-width is stated: "two standard
//!   deviations" means what it says.

use super::{Floating, Linearised};
use rijke_numerics::tails::student_of;
use rijke_numerics::{Cholesky, Matrix, dot};

/// What few data leave unknown of the noises.
#[derive(Clone, Debug, PartialEq)]
pub struct Few {
    /// For each parameter, the factor on its standard deviation.
    pub parameters: Vec<f64>,
    /// For each noise that floats: its place among the groups, the factor on its variance, and the variance
    /// of the logarithm of its variance.
    pub noises: Vec<(usize, [f64; 2])>,
}

/// Half of what holds Student's t with the probability of two standard deviations, 1 % too wide at
/// 3 degrees of freedom, 4 % at 2 ([`student_of`]); fewer than one count as one.
#[must_use]
pub fn student(freedom: f64) -> f64 {
    0.5 * student_of(2.0, freedom.clamp(1.0, 1e9))
}

impl Linearised {
    /// What few data leave unknown of the noises. Noises without effect on the data are passed over.
    #[must_use]
    pub fn few(&self) -> Few {
        let p = self.learnt.columns();
        let known = || Few { parameters: vec![1.0; p], noises: Vec::new() };
        let noises: Vec<&Floating> = self.floating.iter().filter(|f| f.count > SEEN).collect();
        if noises.is_empty() {
            return known();
        }
        let learnt: Vec<Vec<f64>> =
            (0..p).map(|j| (0..self.learnt.rows()).map(|i| self.learnt[(i, j)]).collect()).collect();
        // S_g C^-1 F S, and its product with C^-1 F S from the left.
        let through: Vec<Vec<Vec<f64>>> =
            noises.iter().map(|f| learnt.iter().map(|l| self.through(f, l)).collect()).collect();
        let inner: Vec<Matrix> =
            through.iter().map(|t| Matrix::from_fn(p, p, |i, j| dot(&learnt[i], &t[j]))).collect();
        let turned: Vec<Vec<Option<Matrix>>> = noises.iter().map(|f| self.turned(f)).collect();
        let whole = |g: usize, h: usize| -> f64 {
            let both = turned[g].iter().zip(&turned[h]).filter_map(|(a, b)| a.as_ref().zip(b.as_ref()));
            both.map(|(a, b)| a.trace_of_product(b)).sum()
        };
        let information = Matrix::from_fn(noises.len(), noises.len(), |g, h| {
            let once: f64 = (0..p).map(|j| dot(&through[g][j], &self.weighed(&through[h][j]))).sum();
            let prior = if g == h { 0.25 * noises[g].precision } else { 0.0 };
            0.5 * (whole(g, h) - 2.0 * once + inner[g].trace_of_product(&inner[h])) + prior
        });
        let Ok(factor) = Cholesky::new(&information) else { return known() };
        let slope: Vec<f64> = inner.iter().map(|m| 0.5 * (0..p).map(|i| m[(i, i)]).sum::<f64>()).collect();
        // One datum at least tells of each noise.
        let step =
            factor.solve(&slope).into_iter().zip(&noises).map(|(s, f)| 1.0 + s.clamp(0.0, f.count.max(1.0)));
        let step: Vec<f64> = step.collect();
        // What is unknown of the variance of its data, and so of its own, grows as that variance does.
        let grown = |(g, step): (usize, &f64)| 1.0 + (step - 1.0) * whole(g, g) / noises[g].count;
        let grown: Vec<f64> = step.iter().enumerate().map(grown).collect();
        let parameter = |j: usize| {
            let s: Vec<f64> = (0..p).map(|i| self.root[(i, j)]).collect();
            let now: Vec<f64> = inner.iter().map(|m| m.quadratic(&s)).collect();
            let before = dot(&s, &s);
            let after = before + now.iter().zip(&step).map(|(v, step)| v * (step - 1.0)).sum::<f64>();
            let unknown: Vec<f64> = now.iter().zip(&grown).map(|(v, grown)| v * grown).collect();
            let spread = dot(&unknown, &factor.solve(&unknown));
            (after / before).sqrt() * student(2.0 * after * after / spread)
        };
        let inverse = factor.inverse();
        let noise = |g: usize| (noises[g].group, [step[g], inverse[(g, g)] * (grown[g] / step[g]).powi(2)]);
        Few { parameters: (0..p).map(parameter).collect(), noises: (0..noises.len()).map(noise).collect() }
    }

    /// C^-1 S, for each block.
    fn turned(&self, noise: &Floating) -> Vec<Option<Matrix>> {
        let mut all: Vec<Option<Matrix>> = vec![None; self.blocks.len()];
        for part in &noise.parts {
            let more = self.blocks[part.block].inverse.large_product(&part.covariance);
            all[part.block] = Some(match all[part.block].take() {
                Some(sum) => sum.plus(1.0, &more),
                None => more,
            });
        }
        all
    }
}

/// Noise that explains less of the data than this is taken for none.
const SEEN: f64 = 1e-6;
