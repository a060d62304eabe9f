//! Noise with a floor and a part in proportion to a modulus, and what residuals say of the two.

/// How the variance of a noise grows with the modulus m of what was measured: that of each part of a complex
/// number is sd^2 ((1 - w) + w (g(m)/level)^2). The floor is sd (1 - w)^1/2, the part that grows g(m)
/// sd w^1/2/level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoPart {
    share: f64,
    level: f64,
    grows: Grows,
}

/// How the part of a noise grows that does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grows {
    /// In proportion to the modulus, g = m: of an instrument, a gain or a source that is not steady.
    AsModulus,
    /// g = 1 + m^2: a quotient of two pressures p/q with the same noise n in both. To first order it is off
    /// by n (1 + m^2)^1/2 / |q|, and where |p|^2 + |q|^2 is the same at all frequencies 1/|q| is in
    /// proportion to (1 + m^2)^1/2.
    AsQuotient,
    /// g = 1/m: noise of one size of numbers that were divided by m.
    AsInverse,
}

impl Grows {
    fn at(self, modulus: f64) -> f64 {
        match self {
            Self::AsModulus => modulus,
            Self::AsQuotient => 1.0 + modulus * modulus,
            Self::AsInverse => modulus.recip(),
        }
    }
}

/// Largest ln of w/(1 - w) that is tried: a floor of a thousandth of the part in proportion, at the level, is
/// none, and numbers of which the model is zero must not count without limit.
const REACH: f64 = 14.0;
/// Steps of the scan between both ends.
const SCAN: usize = 56;
/// Steps of the golden section in the best place of the scan: to 1e-7 of ln of the ratio.
const SECTIONS: usize = 35;

impl TwoPart {
    /// Nats by which residuals must be more probable with a part in proportion before there is one: of white
    /// noise one set in fifty does so by chance, and its deviations stay honest.
    pub const ASKED: f64 = 2.0;
    /// Nats that another ratio of the parts may gain when the ratio has settled.
    pub const SETTLED: f64 = 0.02;

    /// A noise that does not grow.
    #[must_use]
    pub fn white() -> Self {
        Self { share: 0.0, level: 1.0, grows: Grows::AsModulus }
    }

    /// The one of [`TwoPart::of`] that is most probable among those that grow in these ways.
    #[must_use]
    pub fn among(ways: &[Grows], rows: &[[f64; 3]]) -> (Self, f64) {
        let all = ways.iter().map(|grows| Self::of(*grows, rows));
        all.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((Self::white(), 0.0))
    }

    /// The most probable one for residuals, and by how many nats these are more probable than with a noise
    /// that does not grow. Of every complex number `rows` has the modulus, the square of its residual's, and
    /// which share of its variance a fit has left to the residual, 1 without a fit; sd is most probable in
    /// both cases. White, and no gain, where moduli say nothing.
    #[must_use]
    pub fn of(grows: Grows, rows: &[[f64; 3]]) -> (Self, f64) {
        let level = (rows.iter().map(|[m, ..]| grows.at(*m).powi(2)).sum::<f64>() / rows.len() as f64).sqrt();
        let white = (Self::white(), 0.0);
        let squares: f64 = rows.iter().map(|[_, q, _]| q).sum();
        if !(level > 0.0 && level.is_finite() && squares > 0.0 && squares.is_finite()) {
            return white;
        }
        let at = |ln_ratio: f64| Self { share: 1.0 / (1.0 + (-ln_ratio).exp()), level, grows };
        let gain = |ln_ratio: f64| at(ln_ratio).gain(rows);
        let step = 2.0 * REACH / SCAN as f64;
        let scan = (0..=SCAN).map(|k| -REACH + step * k as f64);
        let Some(best) = scan.max_by(|a, b| gain(*a).total_cmp(&gain(*b))) else { return white };
        let (mut low, mut high) = ((best - step).max(-REACH), (best + step).min(REACH));
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        for _ in 0..SECTIONS {
            let (left, right) = (high - golden * (high - low), low + golden * (high - low));
            if gain(left) < gain(right) { low = left } else { high = right }
        }
        let found = at(0.5 * (low + high));
        let gain = found.gain(rows);
        if gain > 0.0 { (found, gain) } else { white }
    }

    /// By how many nats it makes residuals more probable than a noise that does not grow, with the most
    /// probable sd of each. The density of a residual that has the share l of 2 v f is taken to the power l,
    /// so that the numbers that were fitted count for nothing: sd^2 is half the sum of q/f over that of l.
    #[must_use]
    pub fn gain(&self, rows: &[[f64; 3]]) -> f64 {
        let left: f64 = rows.iter().map(|[_, _, l]| l).sum();
        let plain: f64 = rows.iter().map(|[_, q, _]| q).sum();
        let scaled: f64 = rows.iter().map(|[m, q, _]| q / self.factor(*m)).sum();
        left * (plain / scaled).ln() - rows.iter().map(|[m, _, l]| l * self.factor(*m).ln()).sum::<f64>()
    }

    /// The variance at a modulus over sd^2.
    #[must_use]
    pub fn factor(&self, modulus: f64) -> f64 {
        1.0 - self.share + self.share * (self.grows.at(modulus) / self.level).powi(2)
    }

    /// How it grows.
    #[must_use]
    pub fn grows(&self) -> Grows {
        self.grows
    }

    /// The floor and the part that grows, over sd; of the latter what it has where g is 1.
    #[must_use]
    pub fn parts(&self) -> [f64; 2] {
        [(1.0 - self.share).sqrt(), self.share.sqrt() / self.level]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Streams;
    use rand::RngExt;
    use std::f64::consts::TAU;

    fn rows(seed: u64, [floor, share]: [f64; 2], grows: Grows) -> Vec<[f64; 3]> {
        let mut stream = Streams::new(seed).stream("two parts");
        // A quotient grows from one on.
        let most = if grows == Grows::AsQuotient { 4.0 } else { 1.0 };
        let mut row = |k: i32| {
            let (m, drawn): (f64, f64) = (most * 10_f64.powf(-2.0 * f64::from(k) / 79.0), stream.random());
            // Squares of both parts together: exponential, of mean 2.
            [m, -2.0 * (floor * floor + (share * grows.at(m)).powi(2)) * (1.0 - drawn).ln(), 1.0]
        };
        (0..80).map(&mut row).collect()
    }

    #[test]
    fn oracle_both_parts_are_where_the_likelihood_of_two_variances_is_largest() {
        use Grows::{AsModulus, AsQuotient};
        let truths =
            [(1, [1e-3, 0.03], AsModulus), (2, [5e-3, 0.03], AsModulus), (3, [1e-3, 0.05], AsModulus)];
        let quotients = [(4, [5e-3, 3e-3], AsQuotient), (5, [0.02, 0.01], AsQuotient)];
        for (seed, truth, grows) in truths.into_iter().chain(quotients) {
            let rows = rows(seed, truth, grows);
            let (found, gain) = TwoPart::of(grows, &rows);
            let n = rows.len() as f64;
            let sd = (rows.iter().map(|[m, q, _]| q / found.factor(*m)).sum::<f64>() / (2.0 * n)).sqrt();
            let parts = found.parts().map(|p| p * sd);
            let cost = |[a, b]: [f64; 2]| -> f64 {
                let of = |[m, q, _]: &[f64; 3]| {
                    let v = a * a + (b * grows.at(*m)).powi(2);
                    v.ln() + 0.5 * q / v
                };
                rows.iter().map(of).sum()
            };
            // Another route: both variances by themselves, by steps that halve.
            let (mut at, mut step) = (truth.map(f64::ln), 0.5);
            while step > 1e-7 {
                let value = |at: [f64; 2]| cost(at.map(f64::exp));
                let sides = [[step, 0.0], [-step, 0.0], [0.0, step], [0.0, -step]];
                let next = sides.map(|[a, b]| [at[0] + a, at[1] + b]);
                match next.into_iter().find(|next| value(*next) < value(at)) {
                    Some(next) => at = next,
                    None => step *= 0.5,
                }
            }
            for (found, alone) in parts.iter().zip(at.map(f64::exp)) {
                assert!((found / alone - 1.0).abs() < 1e-4, "{parts:?} {at:?}");
            }
            let white = (rows.iter().map(|[_, q, _]| q).sum::<f64>() / (2.0 * n)).sqrt();
            assert!((cost([white, 0.0]) - cost(parts) - gain).abs() < 1e-9 && gain > 5.0, "{gain}");
        }
    }

    #[test]
    fn coverage_white_residuals_seldom_ask_for_a_part_in_proportion() {
        // Twice the gain is chi squared of one number, or nothing where the part would be negative.
        use Grows::{AsModulus, AsQuotient};
        for (ways, most) in [(&[AsModulus][..], 11), (&[AsModulus, AsQuotient][..], 13)] {
            let white = |seed: u64| rows(seed, [0.01, 0.0], AsModulus);
            let asks = (0..200).filter(|seed| TwoPart::among(ways, &white(*seed)).1 > TwoPart::ASKED).count();
            assert!((1..=most).contains(&asks), "{asks}");
        }
        let (found, gain) = TwoPart::of(AsModulus, &[[0.0, 1.0, 1.0], [0.0, 2.0, 1.0]]);
        assert_eq!((found, gain), (TwoPart::white(), 0.0));
    }

    /// Two pressures of a standing wave, of which the sum of squares is the same everywhere, each with the
    /// same noise.
    #[test]
    fn oracle_the_noise_of_a_quotient_of_two_noisy_pressures() {
        let n = 2e-3;
        let rows: Vec<[f64; 3]> = (0..400)
            .map(|seed| {
                let mut stream = Streams::new(seed).stream("a quotient");
                let mut normal = || {
                    let [radius, turn]: [f64; 2] = [stream.random(), stream.random()];
                    crate::C64::from_polar((-2.0 * (1.0 - radius).ln()).sqrt(), TAU * turn)
                };
                let angle = 0.02 + 0.5 * (std::f64::consts::PI - 0.08) * seed as f64 / 399.0;
                let (p, q) = (angle.sin(), angle.cos());
                [p / q, ((p + n * normal()) / (q + n * normal()) - p / q).norm_sqr(), 1.0]
            })
            .collect();
        let (found, _) = TwoPart::among(&[Grows::AsModulus, Grows::AsQuotient], &rows);
        assert_eq!(found.grows(), Grows::AsQuotient);
        let sd = rows.iter().map(|[m, q, _]| q / found.factor(*m)).sum::<f64>() / (2.0 * rows.len() as f64);
        let share = sd.sqrt() * found.parts()[1];
        assert!((share / n - 1.0).abs() < 0.1, "{share}");
    }

    /// A line that is fitted to 12 numbers by least squares takes most of those at both ends: without the
    /// shares that it leaves, white noise of a modulus that is large in the middle would seem to grow.
    #[test]
    fn coverage_what_a_fit_takes_is_not_asked_for() {
        let n = 12;
        let x = |k: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
        let basis: Vec<Vec<f64>> = (0..n).map(|k| crate::special::legendre(x(k), 6)).collect();
        let asks = |shares: bool| -> usize {
            let one = |seed: u64| {
                let mut stream = Streams::new(seed).stream("a fit");
                let mut parts = [vec![0.0; n], vec![0.0; n]];
                for k in 0..n {
                    let [radius, turn]: [f64; 2] = [stream.random(), stream.random()];
                    let radius = (-2.0 * (1.0 - radius).ln()).sqrt();
                    (parts[0][k], parts[1][k]) = ((TAU * turn).cos() * radius, (TAU * turn).sin() * radius);
                }
                let columns = crate::Matrix::from_fn(n, 6, |i, j| basis[i][j]);
                let normal = columns.transpose().product(&columns);
                let inverse = crate::Cholesky::new(&normal).unwrap().inverse();
                let taken = |i: usize| inverse.quadratic(&basis[i]);
                let left = |part: &[f64]| -> Vec<f64> {
                    let along: Vec<f64> =
                        (0..6).map(|j| (0..n).map(|i| basis[i][j] * part[i]).sum()).collect();
                    let fitted = columns.times(&inverse.times(&along));
                    part.iter().zip(fitted).map(|(p, f)| p - f).collect()
                };
                let [re, im] = parts.each_ref().map(|p| left(p));
                let row = |i: usize| {
                    let share = if shares { 1.0 - taken(i) } else { 1.0 };
                    [1.05 - x(i).powi(2), re[i].powi(2) + im[i].powi(2), share]
                };
                TwoPart::of(Grows::AsModulus, &(0..n).map(row).collect::<Vec<_>>()).1 > 2.0
            };
            (0..200).filter(|seed| one(*seed)).count()
        };
        let [with, without] = [asks(true), asks(false)];
        assert!(with <= 14 && without > 50, "{with} {without}");
    }
}
