//! Analytic laws of s alone: what the elements of a network file, and users of the library, are made of.
//!
//! Knows nothing of how a chain with these laws is solved.

mod batch;
mod bias;
mod ends;
mod heard;
mod holes;
pub mod levine_schwinger;
mod remote;
mod remote_spread;
mod roots;
mod stretch;
pub mod wall;

pub use bias::{Behind, BiasHole, steady_share};
pub use ends::{choked_inlet, choked_outlet, thick_wall_correction};
pub use heard::{Heard, HeardLaws};
pub use holes::{Leg, SideHole, fok, inner_correction, matching_length, series_correction};
pub use remote::{NoReference, RemoteSource};
pub use remote_spread::{RemoteSpread, SpreadPiece, spread_middle, spread_weights};
pub use rijke_numerics::rational::{Likely, Table, TableError, TableRow, phase_slope};
pub use wall::{Wall, WallLaw};

use crate::chain::coefficients::{At, Coefficients, Laws, Pole};
use crate::error::NetworkError;
use crate::laws::batch::WallBatch;
use crate::laws::ends::{PISTON_UP_TO, piston};
use crate::laws::roots::polynomial_roots;
use crate::laws::wall::Loss;
use crate::plane::region::Region;
use crate::plane::zeros::zeros_of;
use rijke_numerics::{C64, Jet, JetSpace, Order};
use std::f64::consts::PI;

/// A coefficient as an analytic function of s.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Law {
    /// The same for every s.
    Constant(C64),
    /// constant + per_s s: drag and inertia of a compact obstacle, with per_s = rho l_eff A/A_d for an
    /// orifice.
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
    /// gain N(s)/D(s) e^{-s delay}, polynomials with ascending coefficients; the n-tau law has N = D = 1 and
    /// the filtered one D = 1 + s/omega_c.
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
    /// A transfer function from a table.
    Table(Table),
    /// A hole with a bias flow.
    Bias(BiasHole),
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
    /// One of the four coefficients of an open side hole.
    SideHole(Box<SideHole>),
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
    /// R of an unflanged open end of radius a: Levine & Schwinger 1948, times e^{-2 i ka delta} for a wall of
    /// finite thickness, delta being the end correction beyond the thin-walled one over a (see
    /// [`thick_wall_correction`]).
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
    /// R = (z - 1)/(z + 1) of a normalised impedance z(s), another law.
    Impedance(Box<Law>),
    /// Another law times a constant.
    Scaled(Box<Law>, C64),
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
            Self::Table(table) => table.at(s, space),
            Self::Bias(hole) => hole.at(s),
            Self::Helmholtz { duct_area, inertance, resistance, stiffness } => {
                let below = &(s * s).scale(real(*inertance)) + &s.scale(real(*resistance));
                (s / &below.shift(real(*stiffness))).scale(real(1.0 / duct_area))
            }
            Self::QuarterWave { area_ratio, length, sound_speed, impedance } => {
                s.scale(real(length / sound_speed)).tanh().scale(real(area_ratio / impedance))
            }
            Self::SideHole(hole) => hole.at(s, space),
            Self::Unflanged { radius, sound_speed, correction } => {
                let ka = s.scale(C64::new(0.0, -radius / sound_speed));
                let [r, r1, r2] = levine_schwinger::reflection(ka.value());
                &ka.compose(r, r1, r2) * &ka.scale(C64::new(0.0, -2.0 * correction)).exp()
            }
            Self::Flanged { radius, sound_speed } => {
                let ka = s.scale(C64::new(0.0, -radius / sound_speed));
                if ka.value().norm() > PISTON_UP_TO {
                    return space.constant(C64::new(f64::NAN, f64::NAN));
                }
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

    /// Value, first and second derivative at s.
    #[must_use]
    pub fn analytic(&self, s: C64) -> [C64; 3] {
        let space = JetSpace::new(1, Order::Second);
        let jet = self.at(&space.seed(0, s), space);
        [jet.value(), jet.gradient()[0], jet.hessian(0, 0)]
    }

    /// All poles in `region`, with their orders; others may be among them. Poles without a formula are
    /// searched for and counted like modes.
    ///
    /// # Errors
    /// As [`crate::Network::modes`], if that search fails.
    pub fn poles_in(&self, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError> {
        Ok(match self {
            Self::Transfer { denominator, .. } => polynomial_roots(denominator),
            Self::Table(table) => table.terms.iter().map(|t| (t.0, 1)).collect(),
            Self::Scaled(law, _) => law.poles_in(region)?,
            Self::Bias(hole) => {
                // Above, only a resonance.
                let border = BiasHole::SHED_BELOW / hole.time;
                let mut all = Vec::new();
                for (low, high, time) in
                    [(LOWEST, border, 2.0 * hole.time), (border.max(LOWEST), f64::MAX, 0.0)]
                {
                    let omega = [region.omega[0].max(low), region.omega[1].min(high)];
                    if omega[0] < omega[1] {
                        let part = Region { omega, ..*region };
                        all.extend(roots_of(|s, _| hole.divisor(s), &part, time, &[])?);
                    }
                }
                all
            }
            Self::Helmholtz { inertance, resistance, stiffness, .. } => {
                polynomial_roots(&[*stiffness, *resistance, *inertance])
            }
            Self::QuarterWave { length, sound_speed, .. } => {
                let spacing = PI * sound_speed / length;
                let [low, high] = region.omega.map(|w| w / spacing - 0.5);
                if high - low > MOST_POLES {
                    return Err(NetworkError::TooLarge {
                        sigma: region.sigma,
                        omega: region.omega,
                        modes: high - low,
                    });
                }
                let all = low.floor() as i64..=high.ceil() as i64;
                all.map(|k| (C64::new(0.0, spacing * (k as f64 + 0.5)), 1)).collect()
            }
            // Poles of R are the zeros of z + 1, of which z itself has no poles.
            Self::Flanged { radius, sound_speed } => {
                let z = |s: &Jet, space| piston(&s.scale(C64::new(0.0, -radius / sound_speed)), space);
                roots_of(|s, space| z(s, space).shift(C64::ONE), region, 2.0 * radius / sound_speed, &[])?
            }
            // All four coefficients have the poles of the branch, of which the determinant of the T has none:
            // the network has them once, and k_ep declares them. Laws of open ends have a cut at omega = 0.
            Self::SideHole(hole) if hole.of == Leg::Ep && region.omega[1] > LOWEST => {
                let omega = [region.omega[0].max(LOWEST), region.omega[1]];
                let upper = Region { omega, ..*region };
                let poles = hole.outlet.poles_in(&upper.widened(1.0))?;
                roots_of(|s, space| hole.opening(s, space)[0].clone(), &upper, hole.travel_time(), &poles)?
            }
            // Poles of R are the zeros of z + 1.
            Self::Impedance(z) => match z.as_ref() {
                Self::Transfer { gain, numerator, denominator, delay } if *delay == 0.0 => {
                    let n = numerator.len().max(denominator.len());
                    let k = |p: &[f64], i: usize| p.get(i).copied().unwrap_or(0.0);
                    let sum: Vec<f64> = (0..n).map(|i| gain * k(numerator, i) + k(denominator, i)).collect();
                    polynomial_roots(&sum)
                }
                z => {
                    let poles = z.poles_in(&region.widened(1.0))?;
                    roots_of(|s, space| z.at(s, space).shift(C64::ONE), region, z.delay(), &poles)?
                }
            },
            _ => Vec::new(),
        })
    }

    /// The delay in it, s.
    fn delay(&self) -> f64 {
        match self {
            Self::Transfer { delay, .. } => *delay,
            Self::Table(table) => table.delay,
            Self::Scaled(law, _) => law.delay(),
            _ => 0.0,
        }
    }
}

/// Most resonances of a quarter-wave tube in a region: as many as the modes that a search takes on.
const MOST_POLES: f64 = 1e4;
/// Where the search for poles of open ends begins, rad/s.
const LOWEST: f64 = 1.0;

/// The zeros of an analytic function in `region`, or somewhat beyond if one lies on its border; `time` is the
/// longest delay in it, s.
fn roots_of(
    f: impl Fn(&Jet, JetSpace) -> Jet,
    region: &Region,
    time: f64,
    poles: &[(C64, usize)],
) -> Result<Vec<(C64, usize)>, NetworkError> {
    let space = JetSpace::new(1, Order::First);
    let at = |s: C64| {
        let jet = f(&space.seed(0, s), space);
        [jet.value(), jet.gradient()[0]]
    };
    zeros_near(at, region, (0.25 * PI / time).min(longest_step(region)), poles)
}

/// The longest interval between samples of a law along the border of a region.
fn longest_step(region: &Region) -> f64 {
    (region.sigma[1] - region.sigma[0]).hypot(region.omega[1] - region.omega[0]) / 16.0
}

/// The same of a function with its derivative, and with samples `step` apart.
fn zeros_near(
    f: impl Fn(C64) -> [C64; 2],
    region: &Region,
    step: f64,
    poles: &[(C64, usize)],
) -> Result<Vec<(C64, usize)>, NetworkError> {
    let mut outcome = Ok(Vec::new());
    for widening in [0.0, 0.37, 0.81, 1.29] {
        outcome = zeros_of(&f, &region.widened(widening * step), step, poles.to_vec());
        if !matches!(outcome, Err(NetworkError::Border { .. } | NetworkError::NotFinite { .. })) {
            break;
        }
    }
    outcome
}

/// Named laws of s alone, as coefficients of a network without parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LawSet {
    /// Names for messages, and laws.
    pub laws: Vec<(String, Law)>,
    /// Sources that answer to a velocity elsewhere by some of these laws. Their own laws follow `laws`.
    pub heard: Heard,
}

impl LawSet {
    /// Adds a law and returns its number. To be done before anything is `heard`.
    pub fn push(&mut self, name: impl Into<String>, law: Law) -> usize {
        self.laws.push((name.into(), law));
        self.laws.len() - 1
    }

    /// All but those of sources that answer to a velocity elsewhere.
    fn fill_laws(&self, at: &At, laws: &mut Laws) {
        let space = JetSpace::new(1, at.order().max(Order::First));
        let s = space.seed(0, at.s());
        let alone = at.order() == Order::Value;
        let mut batch = WallBatch::new(at.s());
        // The two laws of one wall follow each other, and are known together.
        let mut wall_before: Option<(WallLaw, Wall, Loss)> = None;
        for (k, (_, law)) in self.laws.iter().enumerate() {
            let (Law::Viscous(kind, wall) | Law::Thermal(kind, wall)) = law else {
                let jet = law.at(&s, space);
                laws.set_analytic(k, [jet.value(), jet.gradient()[0], jet.hessian(0, 0)]);
                continue;
            };
            let viscous = matches!(law, Law::Viscous(..));
            if alone {
                batch.push(k, *kind, viscous, wall, laws);
                continue;
            }
            let loss = match wall_before {
                Some((other, same, loss)) if other == *kind && same == *wall => loss,
                _ => kind.loss(wall, at.s()),
            };
            wall_before = Some((*kind, *wall, loss));
            laws.set_analytic(k, if viscous { loss.viscous } else { loss.thermal });
        }
        batch.write(laws);
    }
}

impl Coefficients for LawSet {
    fn parameters(&self) -> usize {
        0
    }
    fn laws(&self) -> usize {
        self.laws.len() + self.heard.laws()
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        self.fill_laws(at, laws);
        self.heard.fill(self.laws.len(), at, laws);
    }
    fn name(&self, law: usize) -> String {
        let heard = law.checked_sub(self.laws.len()).and_then(|beyond| self.heard.source_of(beyond));
        let law = heard.map_or(law, |source| source.law);
        self.laws.get(law).map_or_else(|| format!("law {law}"), |l| l.0.clone())
    }
    fn reference_at(&self, law: usize) -> Option<f64> {
        self.heard.reference_at(law.checked_sub(self.laws.len())?)
    }
    fn poles_in(&self, region: &Region) -> Result<Vec<Pole>, NetworkError> {
        let mut poles = Vec::new();
        for (law, (_, l)) in self.laws.iter().enumerate().filter(|(law, _)| !self.heard.repeats(*law)) {
            // Those of T on the border of the region are poles near it of a loop.
            let margin = if self.heard.is_in_a_loop(law) { 1.0 } else { 0.0 };
            let found = l.poles_in(&region.widened(margin))?;
            poles.extend(found.into_iter().map(|(at, order)| Pole { law, at, order }));
        }
        let by = (longest_step(region), |law: usize| self.laws[law].1.delay());
        let fill = |at: &At, laws: &mut Laws| self.fill_laws(at, laws);
        self.heard.poles(self.laws.len(), &mut poles, region, fill, by)?;
        Ok(poles)
    }
}
