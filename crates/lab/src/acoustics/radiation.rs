//! The open ends: radiation from an unflanged tube whose wall has a thickness.

use rijke_numerics::C64;
use rijke_rig::GasState;

/// An open end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEnd {
    /// Inner radius, m.
    pub inner_radius: f64,
    /// Outer radius, m.
    pub outer_radius: f64,
    /// Fraction of the reflected amplitude that is lost beyond radiation: edge vortices, the room, the stand.
    pub absorption: f64,
    /// Further end correction, in inner radii: what stands near the open end, or what a thermometer misses
    /// there.
    pub extension: f64,
}

impl OpenEnd {
    /// Reflection coefficient, reflected over incident pressure, at complex frequency `s`.
    ///
    /// Modulus and end correction: rational fits of Silva, Guillemain, Kergomard, Mallaroni & Norris, J.
    /// Sound Vib. 322 (2009) 255, unflanged, continued analytically from (ka)^2 to -(s a/c)^2. The wall's
    /// thickness lengthens the end correction as Dalmont, Nederveen & Joly, J. Sound Vib. 244 (2001) 505,
    /// give. Good to 0.3 % of the modulus and 1 % of the end correction up to ka = 1.5.
    #[must_use]
    pub fn reflection(&self, gas: &GasState, s: C64) -> C64 {
        let q = s * self.inner_radius / gas.sound_speed;
        let k2 = -q * q;
        let modulus = (1.0 + 0.800 * k2) / (1.0 + k2 * (1.300 + k2 * (0.266 + k2 * 0.0263)));
        let shape = (1.0 + 0.0599 * k2) / (1.0 + k2 * (0.238 + k2 * (-0.0153 + k2 * 0.001_50)));
        -(1.0 - self.absorption)
            * modulus
            * (-2.0 * q * (self.end_correction() * shape + self.extension)).exp()
    }

    /// End correction at low frequency, in inner radii: 0.6133 for a thin wall, 0.8216 for an infinite
    /// flange.
    #[must_use]
    pub fn end_correction(&self) -> f64 {
        let (thin, flanged, ratio) = (0.6133, 0.8216, self.inner_radius / self.outer_radius);
        flanged + ratio * (thin - flanged) + 0.057 * ratio * (1.0 - ratio.powi(5))
    }

    /// Impedance p/U at the open end, U out of the tube, when rods that reach out of it leave `open_area` of
    /// its cross-section. The reactance is that of a narrower open end; the resistance is that of a small
    /// source, which depends on the volume velocity alone. On the imaginary axis the parts of Z even and odd
    /// in s are these two.
    #[must_use]
    pub fn impedance(&self, gas: &GasState, open_area: f64, s: C64) -> C64 {
        let specific = |s: C64| {
            let r = self.reflection(gas, s);
            (1.0 + r) / (1.0 - r) * gas.density * gas.sound_speed
        };
        let (plus, minus) = (specific(s), specific(-s));
        let area = std::f64::consts::PI * self.inner_radius.powi(2);
        0.5 * (plus + minus) / area + 0.5 * (plus - minus) / open_area
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Gas;

    #[test]
    fn oracle_levine_schwinger_for_a_thin_wall() {
        let gas = Gas::air().at(293.15, 101_325.0);
        let end = OpenEnd { inner_radius: 0.02, outer_radius: 0.02, absorption: 0.0, extension: 0.0 };
        let table = include_str!("../../../../fixtures/reference/levine_schwinger.csv");
        let rows = table.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
        for row in rows {
            let value: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
            let (ka, modulus, length) = (value[0], value[1], value[2]);
            let r = end.reflection(&gas, C64::new(0.0, ka * gas.sound_speed / 0.02));
            let found = (-r).arg() / (-2.0 * ka);
            assert!((r.norm() - modulus).abs() < 0.0026, "ka {ka}: |R| {} against {modulus}", r.norm());
            assert!((found - length).abs() < 0.0065, "ka {ka}: l/a {found} against {length}");
        }
    }

    #[test]
    fn exact_limits_of_the_end_correction() {
        let end =
            |outer_radius| OpenEnd { inner_radius: 0.02, outer_radius, absorption: 0.0, extension: 0.0 };
        assert!((end(0.02).end_correction() - 0.6133).abs() < 1e-12);
        assert!((end(1e9).end_correction() - 0.8216).abs() < 1e-6);
    }

    #[test]
    fn exact_resistance_does_not_depend_on_blockage() {
        let gas = Gas::air().at(293.15, 101_325.0);
        let end = OpenEnd { inner_radius: 0.0237, outer_radius: 0.0254, absorption: 0.0, extension: 0.0 };
        let s = C64::new(0.0, 1078.0);
        let area = std::f64::consts::PI * 0.0237_f64.powi(2);
        let (free, blocked) = (end.impedance(&gas, area, s), end.impedance(&gas, 0.9 * area, s));
        assert!((free.re - blocked.re).abs() < 1e-12 * free.re);
        assert!((blocked.im / free.im - 1.0 / 0.9).abs() < 1e-12);
    }
}
