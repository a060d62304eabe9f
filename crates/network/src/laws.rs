//! Analytic laws of s alone: what the elements of a network file, and users of the library, are made of.

use crate::coefficients::{At, Coefficients, Laws, Pole};
use crate::levine_schwinger;
use crate::wall::Wall;
use rijke_numerics::{C64, Jet, JetSpace, Order, complex_eigenvalues};
use std::f64::consts::PI;

/// A coefficient as an analytic function of s.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// The same for every s.
    Constant(C64),
    /// constant + per_s s: drag and inertia of a compact obstacle, with per_s = rho l_eff A/A_d for an orifice.
    Linear {
        /// Value at s = 0.
        constant: C64,
        /// Slope.
        per_s: C64,
    },
    /// Viscous loss per metre at a wall.
    Viscous(WallLaw, Wall),
    /// Thermal loss per metre at a wall.
    Thermal(WallLaw, Wall),
    /// gain N(s)/D(s) e^{-s delay}, polynomials with ascending coefficients; the n-tau law has N = D = 1 and the
    /// filtered one D = 1 + s/omega_c.
    Transfer {
        /// Factor.
        gain: f64,
        /// N, coefficients of s^0, s^1, ...
        numerator: Vec<f64>,
        /// D.
        denominator: Vec<f64>,
        /// Delay, s.
        delay: f64,
    },
    /// Another law times cosh(s distance/c): what a velocity at `distance` upstream of a place is of the velocity there.
    VelocityUpstream(Box<Law>, f64, f64),
    /// Another law times sinh(s distance/c)/(rho c): what that velocity is of the pressure there. Fields: law, distance,
    /// c, rho.
    PressureUpstream(Box<Law>, f64, f64, f64),
    /// Admittance of a Helmholtz resonator over the duct's area: k_ep = s/(A (m s^2 + r s + k)).
    Helmholtz {
        /// Area of the duct, m^2.
        duct_area: f64,
        /// rho l_eff/A_neck, kg/m^4.
        inertance: f64,
        /// Resistance of the neck, Pa s/m^3.
        resistance: f64,
        /// rho c^2/V, Pa/m^3.
        stiffness: f64,
    },
    /// Admittance of a closed side branch: k_ep = ratio/(rho c) tanh(s length/c).
    QuarterWave {
        /// Area of the branch over that of the duct.
        area_ratio: f64,
        /// Length, m.
        length: f64,
        /// Speed of sound in it, m/s.
        sound_speed: f64,
        /// rho c in it, Pa s/m.
        impedance: f64,
    },
    /// R of an unflanged open end of radius a: Levine & Schwinger 1948, times e^{-2 i ka delta} for a wall of finite
    /// thickness, delta being the end correction beyond the thin-walled one over a (see [`thick_wall_correction`]).
    Unflanged {
        /// Radius, m.
        radius: f64,
        /// Speed of sound, m/s.
        sound_speed: f64,
        /// Additional end correction over the radius.
        correction: f64,
    },
    /// R of an end in an infinite baffle, by Rayleigh's piston: Z/(rho c) = 1 - J1(2ka)/ka + i H1(2ka)/ka.
    Flanged {
        /// Radius, m.
        radius: f64,
        /// Speed of sound, m/s.
        sound_speed: f64,
    },
    /// R = (z - 1)/(z + 1) of a normalised impedance z(s), another law without poles.
    Impedance(Box<Law>),
    /// Another law times a constant.
    Scaled(Box<Law>, C64),
}

/// Which law of wall losses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WallLaw {
    /// The paper's, section 6.1.
    Paper,
    /// Kirchhoff's.
    Kirchhoff,
    /// Zwikker and Kosten's.
    ZwikkerKosten,
}

/// End correction of an unflanged end of finite wall thickness beyond that of a thin wall, over the radius:
/// Dalmont, Nederveen & Joly 2001, J. Sound Vib. 244, eq. (39), for outer radius b: delta = delta_inf
/// + (a/b)(delta_0 - delta_inf) + 0.057 (a/b)(1 - (a/b)^5), delta_0 = 0.6133, delta_inf = 0.8216 (about 0.5 %).
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

impl Law {
    /// The law at s, given as a jet.
    #[must_use]
    pub fn at(&self, s: &Jet, space: JetSpace) -> Jet {
        let real = |v: f64| C64::new(v, 0.0);
        let compose = |[v, d, dd]: [C64; 3]| s.compose(v, d, dd);
        match self {
            Self::Constant(value) => space.constant(*value),
            Self::Linear { constant, per_s } => s.scale(*per_s).shift(*constant),
            Self::Viscous(law, wall) => compose(law.loss(wall, s.value()).viscous),
            Self::Thermal(law, wall) => compose(law.loss(wall, s.value()).thermal),
            Self::Transfer { gain, numerator, denominator, delay } => {
                let polynomial =
                    |k: &[f64]| k.iter().rev().fold(space.real(0.0), |sum, &k| (&sum * s).shift(real(k)));
                let ratio = &polynomial(numerator) / &polynomial(denominator);
                (&ratio * &s.scale(real(-delay)).exp()).scale(real(*gain))
            }
            Self::VelocityUpstream(law, distance, c) => {
                let phase = s.scale(C64::new(0.0, -distance / c));
                &law.at(s, space) * &phase.cos()
            }
            Self::PressureUpstream(law, distance, c, rho) => {
                // sinh(x) = i sin(-i x).
                let phase = s.scale(C64::new(0.0, -distance / c));
                (&law.at(s, space) * &phase.sin()).scale(C64::new(0.0, 1.0 / (rho * c)))
            }
            Self::Helmholtz { duct_area, inertance, resistance, stiffness } => {
                let below = &(s * s).scale(real(*inertance)) + &s.scale(real(*resistance));
                (s / &below.shift(real(*stiffness))).scale(real(1.0 / duct_area))
            }
            Self::QuarterWave { area_ratio, length, sound_speed, impedance } => {
                s.scale(real(length / sound_speed)).tanh().scale(real(area_ratio / impedance))
            }
            Self::Unflanged { radius, sound_speed, correction } => {
                let ka = s.scale(C64::new(0.0, -radius / sound_speed));
                let [r, r1, r2] = levine_schwinger::reflection(ka.value());
                &ka.compose(r, r1, r2) * &ka.scale(C64::new(0.0, -2.0 * correction)).exp()
            }
            Self::Flanged { radius, sound_speed } => {
                let ka = s.scale(C64::new(0.0, -radius / sound_speed));
                let z = piston(&ka, space);
                &z.shift(-C64::ONE) / &z.shift(C64::ONE)
            }
            Self::Impedance(z) => {
                let z = z.at(s, space);
                &z.shift(-C64::ONE) / &z.shift(C64::ONE)
            }
            Self::Scaled(law, factor) => law.at(s, space).scale(*factor),
        }
    }

    /// Poles with |s| below 1e6, with their orders.
    #[must_use]
    pub fn poles(&self) -> Vec<(C64, usize)> {
        match self {
            Self::Transfer { denominator, .. } => polynomial_roots(denominator),
            Self::VelocityUpstream(law, ..) | Self::PressureUpstream(law, ..) | Self::Scaled(law, _) => {
                law.poles()
            }
            Self::Helmholtz { inertance, resistance, stiffness, .. } => {
                polynomial_roots(&[*stiffness, *resistance, *inertance])
            }
            Self::QuarterWave { length, sound_speed, .. } => {
                let first = 0.5 * PI * sound_speed / length;
                let count = (1e6 / first / 2.0) as usize;
                let pair = |k: usize| {
                    let omega = first * (2 * k + 1) as f64;
                    [(C64::new(0.0, omega), 1), (C64::new(0.0, -omega), 1)]
                };
                (0..=count.min(10_000)).flat_map(pair).collect()
            }
            // Poles of R are the zeros of z + 1.
            Self::Impedance(z) => match z.as_ref() {
                Self::Transfer { gain, numerator, denominator, delay } if *delay == 0.0 => {
                    let n = numerator.len().max(denominator.len());
                    let k = |p: &[f64], i: usize| p.get(i).copied().unwrap_or(0.0);
                    let sum: Vec<f64> = (0..n).map(|i| gain * k(numerator, i) + k(denominator, i)).collect();
                    polynomial_roots(&sum)
                }
                Self::Linear { constant, per_s } if *per_s != C64::ZERO => {
                    vec![(-(1.0 + constant) / per_s, 1)]
                }
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }
}

impl WallLaw {
    fn loss(self, wall: &Wall, s: C64) -> crate::wall::Loss {
        match self {
            Self::Paper => wall.paper(s),
            Self::Kirchhoff => wall.kirchhoff(s),
            Self::ZwikkerKosten => wall.zwikker_kosten(s),
        }
    }
}

/// Roots of a polynomial with ascending coefficients, by the eigenvalues of its companion matrix; equal roots are
/// joined if they agree to 1e-6. Leading zeros are dropped; none if the polynomial is constant.
fn polynomial_roots(coefficients: &[f64]) -> Vec<(C64, usize)> {
    let degree = coefficients.iter().rposition(|k| *k != 0.0).unwrap_or(0);
    if degree == 0 {
        return Vec::new();
    }
    // s = scale x balances the coefficients of a physical transfer function, whose s is large.
    let scale = (coefficients[0].abs() / coefficients[degree].abs()).powf(1.0 / degree as f64);
    let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
    let k = |i: usize| coefficients[i] * scale.powi(i as i32);
    let mut companion = vec![C64::ZERO; degree * degree];
    for i in 0..degree {
        companion[i * degree + degree - 1] = C64::new(-k(i) / k(degree), 0.0);
        if i > 0 {
            companion[i * degree + i - 1] = C64::ONE;
        }
    }
    let mut roots: Vec<(C64, usize)> = Vec::new();
    for x in complex_eigenvalues(&companion, degree).unwrap_or_default() {
        let s = x * scale;
        match roots.iter_mut().find(|r| (r.0 - s).norm() < 1e-6 * scale) {
            Some(root) => root.1 += 1,
            None => roots.push((s, 1)),
        }
    }
    roots
}

/// Normalised radiation impedance of a piston in a baffle (Rayleigh, Theory of Sound, art. 302; Pierce 1981, 5-4.4):
/// 1 - J1(x)/(x/2) + i H1(x)/(x/2) with x = 2 ka, as power series. Good to 1e-12 for |ka| < 8.
fn piston(ka: &Jet, space: JetSpace) -> Jet {
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

/// Named laws of s alone, as coefficients of a network without parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LawSet {
    /// Names for messages, and laws.
    pub laws: Vec<(String, Law)>,
}

impl LawSet {
    /// Adds a law and returns its number.
    pub fn push(&mut self, name: impl Into<String>, law: Law) -> usize {
        self.laws.push((name.into(), law));
        self.laws.len() - 1
    }
}

impl Coefficients for LawSet {
    fn parameters(&self) -> usize {
        0
    }
    fn laws(&self) -> usize {
        self.laws.len()
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        let order = at.order().max(Order::First);
        let space = JetSpace::new(1, order);
        let s = space.seed(0, at.s());
        for (k, (_, law)) in self.laws.iter().enumerate() {
            let jet = law.at(&s, space);
            laws.set_analytic(k, [jet.value(), jet.gradient()[0], jet.hessian(0, 0)]);
        }
    }
    fn name(&self, law: usize) -> String {
        self.laws.get(law).map_or_else(|| format!("law {law}"), |l| l.0.clone())
    }
    fn poles(&self) -> Vec<Pole> {
        let of = |(law, (_, l)): (usize, &(String, Law))| {
            l.poles().into_iter().map(move |(at, order)| Pole { law, at, order }).collect::<Vec<_>>()
        };
        self.laws.iter().enumerate().flat_map(of).collect()
    }
}
