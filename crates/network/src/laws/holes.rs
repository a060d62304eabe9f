//! Holes: in a plate across the tube, and in its wall.

use super::wall::Wall;
use super::{Law, WallLaw};
use crate::chain::line::{curvature, line};
use rijke_numerics::{C64, Jet, JetSpace};

/// How much of the end correction of a hole is left in a tube `xi` = (radius of hole)/(radius of tube) as
/// wide: Fok's function, 1 - 1.4092 xi + 0.33818 xi^3 + 0.06793 xi^5 - 0.02287 xi^6 + 0.03015 xi^7 - 0.01641
/// xi^8 (Fok 1941, Doklady Akademii Nauk SSSR 31; as in Melling 1973, J. Sound Vib. 29, eq. (26)), and
/// 0.01222 xi^9. Fok's sum falls below 0 beyond 0.94 and ends at -0.01222 at xi = 1; with the last term it
/// is that of the field in the tube to 2e-4 for all xi, and 0 at 1.
#[must_use]
pub fn fok(xi: f64) -> f64 {
    const K: [f64; 10] = [1.0, -1.4092, 0.0, 0.33818, 0.0, 0.06793, -0.02287, 0.03015, -0.01641, 0.01222];
    K.iter().rev().fold(0.0, |sum, k| sum * xi + k)
}

/// Length of the air that a side hole moves on its inner side, over the radius of the hole, `delta` being
/// that over the radius of the tube: 0.82 - 0.193 delta - 1.09 delta^2 + 1.27 delta^3 - 0.71 delta^4
/// (Nederveen, Jansen & van Hassel 1998, Acta Acustica 84, eq. (40)).
#[must_use]
pub fn inner_correction(delta: f64) -> f64 {
    [0.82, -0.193, -1.09, 1.27, -0.71].iter().rev().fold(0.0, |sum, k| sum * delta + k)
}

/// Length by which an open side hole shortens the tube, over the radius of the hole (negative), with `height`
/// the length of the hole over its radius: -delta^2/(1.78 tanh(1.84 height) + 0.940 + 0.540 delta + 0.285
/// delta^2) (Dubos et al. 1999, Acta Acustica 85, eq. (73)).
#[must_use]
pub fn series_correction(delta: f64, height: f64) -> f64 {
    -delta * delta / (1.78 * (1.84 * height).tanh() + 0.940 + 0.540 * delta + 0.285 * delta * delta)
}

/// The length of a hole that the curved wall adds to it, over the radius of the hole: delta (1 + 0.207
/// delta^3)/8 (Nederveen, Jansen & van Hassel 1998, eq. (37)).
#[must_use]
pub fn matching_length(delta: f64) -> f64 {
    delta * (1.0 + 0.207 * delta.powi(3)) / 8.0
}

/// An open side hole: a line from the tube to the outside, with inertia at its inner end, and the series
/// inertia that it takes from the tube. Both together are a symmetric T: half the series inertia, the branch,
/// the other half.
#[derive(Clone, Debug, PartialEq)]
pub struct SideHole {
    /// Area of the hole over that of the duct.
    pub area_ratio: f64,
    /// Length of the line, m.
    pub length: f64,
    /// Length of the inner inertia, m.
    pub inner: f64,
    /// Length of the series inertia, m, negative.
    pub series: f64,
    /// Gas in the hole, and its diameter.
    pub gas: Wall,
    /// What its wall loses.
    pub wall: Option<WallLaw>,
    /// Reflection at the outer end.
    pub outlet: Law,
    /// Which of the four coefficients of the T.
    pub of: Leg,
}

/// A coefficient of feedback.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// k_mu = Z (1 + Y Z/4), Z the series impedance, Y the branch.
    Mu,
    /// k_mp = -Y Z/2.
    Mp,
    /// k_eu = -Y Z/2.
    Eu,
    /// k_ep = Y.
    Ep,
}

impl SideHole {
    pub(super) fn at(&self, s: &Jet, space: JetSpace) -> Jet {
        let [pressure, velocity] = self.opening(s, space);
        let y = (&velocity / &pressure).scale(C64::new(self.area_ratio, 0.0));
        let z = s.scale(C64::new(self.gas.density * self.series, 0.0));
        let yz = &y * &z;
        let part = |factor: f64| yz.scale(C64::new(factor, 0.0));
        match self.of {
            Leg::Mu => &z * &part(0.25).shift(C64::ONE),
            Leg::Mp | Leg::Eu => part(-0.5),
            Leg::Ep => y,
        }
    }

    /// Pressure in the tube and velocity in the hole, of a wave 1 that reaches the outer end.
    pub(super) fn opening(&self, s: &Jet, space: JetSpace) -> [Jet; 2] {
        let Wall { density, sound_speed, .. } = self.gas;
        let real = |v: f64| C64::new(v, 0.0);
        let mut z = s.scale(real(density));
        let mut y = s.scale(real(1.0 / (density * sound_speed * sound_speed)));
        if let Some(law) = self.wall {
            z = &z + &Law::Viscous(law, self.gas).at(s, space);
            y = &y + &Law::Thermal(law, self.gas).at(s, space);
        }
        let (p, q) = (z.scale(real(self.length)), y.scale(real(self.length)));
        let square = &p * &q;
        let at = line(square.value());
        let c = square.compose(at.c, 0.5 * at.s, 0.5 * at.s1);
        let sh = square.compose(at.s, at.s1, curvature(square.value(), &at));
        let r = self.outlet.at(s, space);
        let outside = r.shift(C64::ONE);
        let leaving = (-&r).shift(C64::ONE).scale(real(1.0 / (density * sound_speed)));
        let pressure = &(&c * &outside) + &(&(&p * &sh) * &leaving);
        let velocity = &(&(&q * &sh) * &outside) + &(&c * &leaving);
        let inertia = &s.scale(real(density * self.inner)) * &velocity;
        [&pressure + &inertia, velocity]
    }

    /// Time that sound needs to the outside and back, s.
    pub(super) fn travel_time(&self) -> f64 {
        2.0 * (self.length + self.inner) / self.gas.sound_speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::{C64, Matrix, lu_solve};
    use std::f64::consts::PI;

    /// Zeros of J1 beyond 0, by Newton from McMahon's first term.
    fn zeros(count: usize) -> impl Iterator<Item = (f64, f64)> {
        let bessel = |order: f64, x: f64| complex_bessel::besselj(order, C64::new(x, 0.0)).unwrap().re;
        (1..=count).map(move |n| {
            let mut x = PI * (n as f64 + 0.25);
            for _ in 0..6 {
                let (j1, j0) = (bessel(1.0, x), bessel(0.0, x));
                x -= j1 / (j0 - j1 / x);
            }
            (x, bessel(0.0, x))
        })
    }

    #[test]
    fn oracle_fok_against_the_field_of_an_aperture_in_a_tube() {
        // Inertia of a thin aperture in a tube from the evanescent modes of a velocity sum of c_j (1 -
        // (r/a)^2)^(j - 1/2), over pi/4, that of a hole in the open. By Kelvin's principle the least over c
        // is no less than the true one; it shares no constant with the fit.
        const MODES: usize = 2000;
        const SHAPES: usize = 4;
        let gamma_half = |j: usize| (0..j).fold(PI.sqrt(), |g, k| g * (k as f64 + 0.5));
        let spherical = |j: usize, x: f64| {
            // J_(j - 1/2)(x) sqrt(pi x/2), upward from cos and sin; by its series where that loses digits.
            if x < 2.0 {
                let (mut term, mut sum) = (1.0, 0.0);
                for m in 0..30 {
                    sum += term;
                    term *= -0.25 * x * x / ((m + 1) as f64 * (m as f64 + j as f64 + 0.5));
                }
                return sum * (0.5 * x).powf(j as f64 - 0.5) / gamma_half(j) * (0.5 * PI * x).sqrt();
            }
            let (mut last, mut now) = (x.cos(), x.sin());
            for k in 1..j {
                (last, now) = (now, (2 * k - 1) as f64 / x * now - last);
            }
            if j == 0 { last } else { now }
        };
        for xi in [0.1_f64, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99] {
            let mut a = Matrix::zeros(SHAPES, SHAPES);
            for (l, j0) in zeros(MODES) {
                let x = l * xi;
                let of = |j: usize| {
                    // Hankel's transform of shape j over its flux 1/(2 j + 1).
                    let half = j as f64 + 0.5;
                    let bessel = spherical(j + 1, x) / (0.5 * PI * x).sqrt();
                    2.0_f64.powf(half - 1.0) * gamma_half(j) * bessel / x.powf(half) * (2.0 * half)
                };
                let shapes: [f64; SHAPES] = std::array::from_fn(of);
                for i in 0..SHAPES {
                    for k in 0..SHAPES {
                        a[(i, k)] += shapes[i] * shapes[k] / (l * j0 * j0);
                    }
                }
            }
            // Of the first shape the rest decays as 1/l^2 only: pi/(4 xi^2) sum of 1/l^2 over steps of pi.
            a[(0, 0)] += 0.25 / (xi * xi * (PI * (MODES as f64 + 0.75)));
            let solved = lu_solve(&a, &[1.0; SHAPES]).unwrap();
            let exact = 4.0 * xi / PI / solved.iter().sum::<f64>();
            let gap = exact - fok(xi);
            assert!(gap.abs() < 2e-4, "at {xi}: {} against {exact}", fok(xi));
        }
        assert!(fok(1.0).abs() < 1e-12 && fok(0.0) == 1.0);
    }

    #[test]
    fn oracle_corrections_of_side_holes_against_other_fits() {
        for k in 1..=7 {
            let d = 0.1 * f64::from(k);
            // Lefebvre & Scavone 2012, J. Acoust. Soc. Am. 131, finite elements.
            let inner = [0.822, -0.095, -1.566, 2.138, -1.640, 0.502];
            let inner = inner.iter().rev().fold(0.0, |sum, k| sum * d + k);
            assert!((inner_correction(d) - inner).abs() < 0.01, "{d}");
            // Nederveen, Jansen & van Hassel 1998, a long hole.
            let series = (-0.37 + 0.087 * d) * d * d;
            assert!((series_correction(d, 10.0) / series - 1.0).abs() < 0.03, "{d}");
            // The volume between a hole's plane face and the curved wall of the tube, by quadrature over the
            // hole.
            let (mut volume, n) = (0.0, 400);
            for i in 0..n {
                let r = (f64::from(i) + 0.5) / f64::from(n);
                for j in 0..n {
                    let x = r * (PI * (f64::from(j) + 0.5) / f64::from(n)).sin() * d;
                    volume += r * (1.0 - (1.0 - x * x).sqrt()) / d;
                }
            }
            let mean = volume * 2.0 / f64::from(n * n);
            assert!((matching_length(d) / mean - 1.0).abs() < 0.01, "{d}: {} {mean}", matching_length(d));
        }
    }
    #[test]
    fn oracle_series_corrections_fall_as_the_first_mode_across_a_hole() {
        // Across the hole flow decays with its depth as e^(-k z) with J1'(k) = 0: 1/correction goes from that
        // of no depth to that of any as tanh(k height).
        let bessel = |order: f64, x: f64| complex_bessel::besselj(order, C64::new(x, 0.0)).unwrap().re;
        let slope = |x: f64| bessel(0.0, x) - bessel(1.0, x) / x;
        let (mut low, mut high) = (1.0, 3.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if slope(middle) > 0.0 { low = middle } else { high = middle }
        }
        for delta in [0.2, 0.7] {
            let inverse = |height: f64| -series_correction(delta, height).recip();
            let risen = (inverse(0.5) - inverse(0.0)) / (inverse(1e3) - inverse(0.0));
            assert!((risen.atanh() / 0.5 - low).abs() < 2e-3, "{delta}: {} {low}", risen.atanh() / 0.5);
        }
    }
}
