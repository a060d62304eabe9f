//! Viscous and thermal losses at walls: the boundary layers of a round tube and of rods inside it.
//!
//! A wall displaces flow (viscous) and compliance (thermal) by an area per length. For the inside of a tube
//! this is Zwikker & Kosten's solution (Sound Absorbing Materials, 1949, ch. II; Tijdeman, J. Sound Vib. 39,
//! 1975): the displaced fraction of the cross-section is 2 I1(z) / (z I0(z)), z = a sqrt(s/nu). For the
//! outside of a rod the same equations give 2 pi r delta K1(z)/K0(z), delta = sqrt(nu/s).

use complex_bessel::{Scaling, besseli_scaled, besselk_seq};
use rijke_numerics::C64;
use rijke_rig::GasState;
use std::f64::consts::PI;

/// The cross-section of the tube at some height.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Radius of the tube, m.
    pub radius: f64,
    /// Factor on the boundary layers of the tube's own wall: 1 for a smooth wall.
    pub roughness: f64,
    /// What stands in the tube.
    pub rods: Vec<Rods>,
}

/// Equal rods along the tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rods {
    /// How many.
    pub count: f64,
    /// Radius of one, m.
    pub radius: f64,
    /// Its boundary layers, relative to those of a smooth rod: threads and fabric have more surface.
    pub roughness: f64,
}

/// Impedance and admittance per length of the line dp/dx = -Z U, dU/dx = -Y p (U: volume velocity, m^3/s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Z, Pa s/m^4.
    pub impedance: C64,
    /// Y, m/(Pa s) per m.
    pub admittance: C64,
}

impl Section {
    /// The area that gas flows through, m^2.
    #[must_use]
    pub fn open_area(&self) -> f64 {
        let rods: f64 = self.rods.iter().map(|rod| rod.count * rod.radius.powi(2)).sum();
        PI * (self.radius.powi(2) - rods)
    }

    /// The line at complex frequency `s`.
    #[must_use]
    pub fn line(&self, gas: &GasState, s: C64) -> Line {
        let area = self.open_area();
        // sqrt(s/nu) and sqrt(s/alpha) differ by a real factor.
        let root = principal_root(s * (gas.density / gas.viscosity));
        let [viscous, thermal] = self.displaced_areas([root, root * gas.prandtl.sqrt()]).map(|a| a / area);
        let stiffness = gas.density * gas.sound_speed.powi(2);
        Line {
            impedance: s * gas.density / (area * (1.0 - viscous)),
            admittance: s * area / stiffness * (1.0 + (gas.gamma - 1.0) * thermal),
        }
    }

    /// Areas that the boundary layers of all walls displace, m^2; roots = sqrt(s/nu) and sqrt(s/alpha), 1/m.
    /// The layers of different walls are taken not to meet: they are 0.2 mm thick, the walls 5 mm apart.
    fn displaced_areas(&self, roots: [C64; 2]) -> [C64; 2] {
        let inverses = roots.map(|root| root.inv());
        let pair = |radius: f64| (roots.map(|root| radius * root), inverses.map(|inverse| inverse / radius));
        let (z, inverse) = pair(self.radius);
        let mut sums = inside(z, inverse).map(|ratio| self.roughness * 2.0 * PI * self.radius * ratio);
        for rod in &self.rods {
            let (z, inverse) = pair(rod.radius);
            let ratios = quotients(z, inverse);
            for (sum, ratio) in sums.iter_mut().zip(ratios) {
                *sum += rod.count * rod.roughness * 2.0 * PI * rod.radius * ratio;
            }
        }
        [sums[0] * inverses[0], sums[1] * inverses[1]]
    }
}

/// The square root in the right half plane, away from the negative real axis, without trigonometric
/// functions.
pub(crate) fn principal_root(q: C64) -> C64 {
    let re = (0.5 * (q.norm_sqr().sqrt() + q.re)).sqrt();
    C64::new(re, 0.5 * q.im / re)
}

/// I1(z)/I0(z), Re z > 0, of two numbers, given also 1/z.
fn inside(z: [C64; 2], inverse: [C64; 2]) -> [C64; 2] {
    if z.iter().all(|z| large(*z)) {
        return series(inverse);
    }
    z.map(|z| match (besseli_scaled(1.0, z), besseli_scaled(0.0, z)) {
        // The library fails only where it would overflow, far above the limit of the series.
        (Ok(one), Ok(zero)) if !large(z) => one / zero,
        _ => series([z.inv(); 2])[0],
    })
}

/// K1(z)/K0(z), Re z > 0.
pub(crate) fn outside(z: C64) -> C64 {
    if large(z) {
        return series([-z.inv(); 2])[0];
    }
    // Both orders come out of one recurrence.
    match besselk_seq(0.0, z, 2, Scaling::Exponential).as_ref().map(|k| k.values.as_slice()) {
        Ok([zero, one]) => one / zero,
        _ => series([-z.inv(); 2])[0],
    }
}

/// The same of two numbers, given also 1/z.
fn quotients(z: [C64; 2], inverse: [C64; 2]) -> [C64; 2] {
    if z.iter().all(|z| large(*z)) { series(inverse.map(|x| -x)) } else { z.map(outside) }
}

/// Where the series below is exact to 1e-11 (its ninth term is -46 x^9).
fn large(z: C64) -> bool {
    z.norm_sqr() > 24.0 * 24.0
}

/// Hankel's expansion of I1/I0 in x = 1/z (Abramowitz & Stegun 9.7.1, quotient); with -x it is K1/K0. Two
/// numbers side by side: each sum waits for its last term.
fn series(x: [C64; 2]) -> [C64; 2] {
    const C: [f64; 9] = [
        1.0,
        -0.5,
        -0.125,
        -0.125,
        -25.0 / 128.0,
        -13.0 / 32.0,
        -1073.0 / 1024.0,
        -103.0 / 32.0,
        -375_733.0 / 32_768.0,
    ];
    C.iter().rev().fold([C64::ZERO; 2], |sum, c| [sum[0] * x[0] + c, sum[1] * x[1] + c])
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use complex_bessel::besselk_scaled;
    use rijke_rig::Gas;

    #[test]
    fn oracle_series_against_bessel_functions() {
        for z in [C64::new(24.5, 1.0), C64::new(18.0, 17.0), C64::new(100.0, 140.0), C64::new(300.0, 295.0)] {
            let i = besseli_scaled(1.0, z).unwrap() / besseli_scaled(0.0, z).unwrap();
            let k = besselk_scaled(1.0, z).unwrap() / besselk_scaled(0.0, z).unwrap();
            let found = inside([z; 2], [z.inv(); 2]);
            assert!(found.iter().all(|v| (v - i).norm() < 3e-11), "{z}: {}", found[0] - i);
            assert!((outside(z) - k).norm() < 3e-11, "{z}: {}", outside(z) - k);
        }
        for z in [C64::new(0.5, 0.4), C64::new(3.0, 2.9), C64::new(15.0, 14.0)] {
            let k = besselk_scaled(1.0, z).unwrap() / besselk_scaled(0.0, z).unwrap();
            assert!((outside(z) / k - 1.0).norm() < 1e-14, "{z}");
        }
    }

    #[test]
    fn exact_attenuation_of_kirchhoff() {
        // Kirchhoff 1868: alpha = sqrt(omega nu / 2)/(a c) (1 + (gamma-1)/sqrt(Pr)), to first order in
        // delta/a.
        let gas = Gas::air().at(293.15, 101_325.0);
        let tube = |radius| Section { radius, roughness: 1.0, rods: vec![] };
        let (omega, nu) = (1078.0, gas.viscosity / gas.density);
        let excess = |radius: f64| {
            let line = tube(radius).line(&gas, C64::new(0.0, omega));
            let gamma = line.impedance.sqrt() * line.admittance.sqrt();
            let kirchhoff = (omega * nu / 2.0).sqrt() / (radius * gas.sound_speed)
                * (1.0 + (gas.gamma - 1.0) / gas.prandtl.sqrt());
            gamma.re / kirchhoff - 1.0
        };
        // The rest is the second order of the expansion in delta/a: it falls in proportion to 1/a.
        assert_relative_eq!(excess(0.0237) / excess(0.237), 10.0, max_relative = 0.02);
        assert!(excess(0.237).abs() < 1e-3);
    }

    #[test]
    fn exact_a_rod_without_radius_changes_nothing_and_blockage_is_the_area() {
        let gas = Gas::air().at(293.15, 101_325.0);
        let s = C64::new(-10.0, 1078.0);
        let bare = Section { radius: 0.0237, roughness: 1.0, rods: vec![] };
        let thin = Section { rods: vec![Rods { count: 1.0, radius: 1e-9, roughness: 1.0 }], ..bare.clone() };
        assert_relative_eq!(
            bare.line(&gas, s).impedance.im,
            thin.line(&gas, s).impedance.im,
            max_relative = 1e-5
        );
        let prongs =
            Section { rods: vec![Rods { count: 2.0, radius: 0.002, roughness: 1.0 }], ..bare.clone() };
        assert_relative_eq!(bare.open_area() - prongs.open_area(), 2.0 * PI * 4e-6, max_relative = 1e-12);
    }
}
