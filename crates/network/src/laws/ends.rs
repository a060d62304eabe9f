//! Formulas of ends: open with a wall of finite thickness, flanged, choked.

use rijke_numerics::{C64, Jet, JetSpace};
use std::f64::consts::PI;

/// End correction of an unflanged end of finite wall thickness beyond that of a thin wall, over the radius:
/// Dalmont, Nederveen & Joly 2001, J. Sound Vib. 244, eq. (39), for outer radius b: delta = delta_inf
/// + (a/b)(delta_0 - delta_inf) + 0.057 (a/b)(1 - (a/b)^5), delta_0 = 0.6133, delta_inf = 0.8216 (about 0.5
///   %).
#[must_use]
pub fn thick_wall_correction(radius: f64, thickness: f64) -> f64 {
    let q = radius / (radius + thickness);
    0.8216 + q * (0.6133 - 0.8216) + 0.057 * q * (1.0 - q.powi(5)) - 0.6133
}

/// R of a compact choked nozzle behind a flow of Mach number M: (1 - (gamma-1)M/2)/(1 + (gamma-1)M/2)
/// (Marble & Candel 1977).
#[must_use]
pub fn choked_outlet(gamma: f64, mach: f64) -> f64 {
    let m = 0.5 * (gamma - 1.0) * mach;
    (1.0 - m) / (1.0 + m)
}

/// R of a compact choked inlet, which keeps mass flow and stagnation enthalpy, into a flow of Mach number M:
/// (1 - m)/(1 + m) with m = gamma M/(1 + (gamma-1) M^2) (Stow, Dowling & Hynes 2002).
#[must_use]
pub fn choked_inlet(gamma: f64, mach: f64) -> f64 {
    let m = gamma * mach / (1.0 + (gamma - 1.0) * mach * mach);
    (1.0 - m) / (1.0 + m)
}

/// Largest |ka| of [`piston`].
pub(super) const PISTON_UP_TO: f64 = 8.0;

/// Normalised radiation impedance of a piston in a baffle (Rayleigh, Theory of Sound, art. 302; Pierce 1981,
/// 5-4.4): 1 - J1(x)/(x/2) + i H1(x)/(x/2) with x = 2 ka, as power series. Good to 1e-12 for |ka| < 8.
pub(super) fn piston(ka: &Jet, space: JetSpace) -> Jet {
    let x = ka.scale(C64::new(2.0, 0.0));
    let square = &x * &x;
    // J1(x)/(x/2) = sum (-x^2/4)^m/(m! (m+1)!).
    let (mut term, mut resistance) = (space.real(1.0), space.real(0.0));
    for m in 1..40 {
        let k = f64::from(m);
        term = (&term * &square).scale(C64::new(-0.25 / (k * (k + 1.0)), 0.0));
        resistance = &resistance - &term;
    }
    // H1(x)/(x/2) = (4 x/(3 pi)) sum (-x^2)^m / (prod of (2j+1)(2j+3) over j = 1 .. m).
    let mut term = x.scale(C64::new(4.0 / (3.0 * PI), 0.0));
    let mut reactance = term.clone();
    for m in 1..40 {
        let k = f64::from(m);
        term = (&term * &square).scale(C64::new(-1.0 / ((2.0 * k + 1.0) * (2.0 * k + 3.0)), 0.0));
        reactance = &reactance + &term;
    }
    &resistance + &reactance.scale(C64::I)
}
