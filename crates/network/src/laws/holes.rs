//! Holes: in a plate across the tube, and in its wall.

use super::wall::Wall;
use super::{Law, WallLaw};
use crate::chain::line::{curvature, line};
use rijke_numerics::{C64, Jet, JetSpace};

/// How much of the end correction of a hole is left in a tube `xi` = (radius of hole)/(radius of tube) as
/// wide: Fok's function, 1 - 1.4092 xi + 0.33818 xi^3 + 0.06793 xi^5 - 0.02287 xi^6 + 0.03015 xi^7 - 0.01641
/// xi^8 (Fok 1941, Doklady Akademii Nauk SSSR 31; as in Melling 1973, J. Sound Vib. 29, eq. (26)). 1 in the
/// open, 0 at xi = 1, where the fit ends at -0.012.
#[must_use]
pub fn fok(xi: f64) -> f64 {
    const K: [f64; 9] = [1.0, -1.4092, 0.0, 0.33818, 0.0, 0.06793, -0.02287, 0.03015, -0.01641];
    K.iter().rev().fold(0.0, |sum, k| sum * xi + k).max(0.0)
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
    use rijke_numerics::C64;
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
        // Inertia of a thin aperture in a tube from the evanescent modes of a velocity like that of a hole in
        // the open, (1 - (r/a)^2)^(-1/2)/2: xi sum of sinc^2(l xi)/(l J0^2(l)) over J1(l) = 0, over pi/4,
        // that of a hole in the open. By Kelvin's principle it is no less than the true one; it shares no
        // constant with the fit.
        const MODES: usize = 400;
        for xi in [0.05_f64, 0.1, 0.2, 0.3, 0.4, 0.5] {
            let mut sum = 0.0;
            let mut last = 0.0;
            for (l, j0) in zeros(MODES) {
                let sinc = (l * xi).sin() / (l * xi);
                sum += sinc * sinc / (l * j0 * j0);
                last = l;
            }
            // The rest, J0^2 = 2/(pi l) and sin^2 = 1/2: pi/(4 xi^2) sum of 1/l^2 over steps of pi.
            sum += 0.25 / (xi * xi * (last + 0.5 * PI));
            let exact = 4.0 * xi * sum / PI;
            let gap = exact - fok(xi);
            assert!((-1e-4..1e-3).contains(&gap), "at {xi}: {} against {exact}", fok(xi));
        }
        assert!(fok(1.0) == 0.0 && fok(0.0) == 1.0);
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
