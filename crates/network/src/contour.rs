//! Every mode in a rectangle of the s-plane, counted by the argument principle.
//!
//! The winding number of G(s) = F(s) prod (s - pole)^order round a cell is its number of zeros. Cells are halved until
//! each holds one zero or none; the first moment of G'/G gives the zero to some digits and Newton the rest. Every edge
//! is sampled once and shared by its neighbours. A winding number is accepted from samples whose change of ln G agrees
//! with the derivative at both ends and at the middle: strong evidence, not a proof in interval arithmetic.

use crate::chain::Network;
use crate::coefficients::{At, Coefficients, Pole};
use crate::error::NetworkError;
use crate::newton::{Newton, Root, Workspace};
use crate::search::zeros;
use rijke_numerics::C64;
use std::f64::consts::PI;

/// A rectangle of the s-plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Limits of the growth rate, 1/s.
    pub sigma: [f64; 2],
    /// Limits of the angular frequency, rad/s. Laws with square roots of s or open ends need both above zero.
    pub omega: [f64; 2],
}

impl Region {
    /// Refuses limits that do not increase or are not finite.
    pub(crate) fn check(&self) -> Result<(), NetworkError> {
        let Self { sigma: [left, right], omega: [low, high] } = *self;
        if left < right && low < high && [left, right, low, high].iter().all(|v| v.is_finite()) {
            Ok(())
        } else {
            Err(NetworkError::Region { sigma: self.sigma, omega: self.omega })
        }
    }

    /// Whether `s` lies inside or on the border.
    #[must_use]
    pub fn contains(&self, s: C64) -> bool {
        (self.sigma[0]..=self.sigma[1]).contains(&s.re) && (self.omega[0]..=self.omega[1]).contains(&s.im)
    }

    /// The region with a margin on all sides, 1/s.
    #[must_use]
    pub fn widened(&self, margin: f64) -> Self {
        let wide = |[low, high]: [f64; 2]| [low - margin, high + margin];
        Self { sigma: wide(self.sigma), omega: wide(self.omega) }
    }
}

/// One mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// s = sigma + i omega.
    pub s: C64,
    /// |F/F'|/|s| at s: the relative error that Newton still sees.
    pub residual: f64,
    /// 1, or more for roots too close for rounding to tell apart; s is then their mean, to about the square root of
    /// rounding.
    pub multiplicity: usize,
}

impl Mode {
    /// The mode as what asks for its response, sensitivities and budget.
    #[must_use]
    pub fn root(&self) -> Root {
        Root { s: self.s, steps: 0, residual: self.residual }
    }
}

/// All modes of a region, with the count that certifies them: `found == counted` always, or there is an error.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// The modes in order of frequency.
    pub modes: Vec<Mode>,
    /// Modes by the winding number, with multiplicity.
    pub counted: usize,
    /// Declared poles of laws inside the region, with their orders; they are not modes.
    pub poles: usize,
    /// How often the chain was swept.
    pub evaluations: usize,
}

impl Network {
    /// All modes in `region`, or an error: never an incomplete list.
    ///
    /// Cost: about fifty sweeps per mode.
    ///
    /// # Errors
    /// [`NetworkError::Region`], [`NetworkError::NotAnalytic`], [`NetworkError::PoleInSegment`],
    /// [`NetworkError::Border`], [`NetworkError::NotFinite`], [`NetworkError::Uncertified`].
    pub fn modes<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        region: &Region,
        work: &mut Workspace,
    ) -> Result<Modes, NetworkError> {
        region.check()?;
        check_analytic(coefficients, region, work)?;
        let step = 0.25 * PI / self.travel_time();
        // Poles far outside do not change the count and would only scale G.
        let wide = region.widened(4.0 * step);
        let mut poles = self.poles(coefficients, &wide)?;
        let pole_count = poles.iter().filter(|p| region.contains(p.0)).map(|p| p.1).sum();
        poles.retain(|p| wide.contains(p.0));
        let f = |s: C64| {
            let f = self.characteristic(coefficients, s, &mut work.laws);
            [f.v, f.d]
        };
        zeros(f, region, step, poles, pole_count)
    }

    /// Newton from `guess`, and the modes that are nearer to the guess than the root found; normally none.
    ///
    /// # Errors
    /// As [`Network::solve`] and [`Network::modes`].
    pub fn solve_nearest<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        guess: C64,
        settings: &Newton,
        work: &mut Workspace,
    ) -> Result<(Root, Vec<Mode>), NetworkError> {
        let root = self.solve(coefficients, guess, settings, work)?;
        let radius = (root.s - guess).norm();
        if radius <= 1e-6 * root.s.norm() {
            return Ok((root, Vec::new()));
        }
        let region = Region {
            sigma: [guess.re - radius, guess.re + 0.999 * radius],
            omega: [guess.im - 0.998 * radius, guess.im + 0.997 * radius],
        };
        let mut nearer = self.modes(coefficients, &region, work)?.modes;
        nearer.retain(|m| (m.s - guess).norm() < radius * (1.0 - 1e-6));
        Ok((root, nearer))
    }

    /// Poles of F with their orders: those of every law that acts at a place or an end. All that lie in `region`; others may
    /// be among them.
    ///
    /// # Errors
    /// [`NetworkError::PoleInSegment`]; as [`Coefficients::poles_in`].
    pub fn poles<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        region: &Region,
    ) -> Result<Vec<(C64, usize)>, NetworkError> {
        let mut poles = Vec::new();
        for Pole { law, at, order } in coefficients.poles_in(region)? {
            let mut keys: Vec<usize> = Vec::new();
            for a in self.attachments.iter().filter(|a| a.law == law && a.weight != 0.0) {
                if a.key % 2 == 0 && a.key > 0 && a.key < 2 + 2 * self.segments.len() {
                    return Err(NetworkError::PoleInSegment { law: coefficients.name(law), at });
                }
                keys.push(a.key);
            }
            // Two coefficients of one place share a rank-one pole only if they act alike; count each.
            if !keys.is_empty() {
                poles.push((at, order * keys.len()));
            }
        }
        Ok(poles)
    }
}

/// Compares the slopes of every law along sigma and along omega at nine points of the region.
pub(crate) fn check_analytic<K: Coefficients + ?Sized>(
    coefficients: &K,
    region: &Region,
    work: &mut Workspace,
) -> Result<(), NetworkError> {
    let count = coefficients.laws();
    let [width, height] = [region.sigma[1] - region.sigma[0], region.omega[1] - region.omega[0]];
    let mut values = |s: C64| -> Vec<C64> {
        let at = At::search(s);
        work.laws.reset(count, &at);
        coefficients.fill(&at, &mut work.laws);
        (0..count).map(|k| work.laws.value(k)).collect()
    };
    let poles = coefficients.poles_in(region)?;
    for k in 0..9 {
        let (a, b) = (0.17 + 0.33 * f64::from(k % 3), 0.17 + 0.33 * f64::from(k / 3));
        let s = C64::new(region.sigma[0] + a * width, region.omega[0] + b * height);
        let h = 1e-5 * s.norm().max(1e-3 * (width + height));
        if poles.iter().any(|p| (p.at - s).norm() < 1e3 * h) {
            continue;
        }
        let along = |values: &mut dyn FnMut(C64) -> Vec<C64>, d: C64| -> Vec<C64> {
            let (up, down) = (values(s + d), values(s - d));
            up.iter().zip(down).map(|(u, v)| (u - v) / (2.0 * d)).collect()
        };
        let centre = values(s);
        let across = along(&mut values, C64::new(h, 0.0));
        let upward = along(&mut values, C64::new(0.0, h));
        for law in 0..count {
            // Rounding of a central difference is eps |law|/h; its truncation h^2 law'''.
            let size = across[law].norm() + upward[law].norm() + centre[law].norm() / s.norm();
            let mismatch = (across[law] - upward[law]).norm() / size;
            if mismatch > 1e-4 {
                return Err(NetworkError::NotAnalytic { law: coefficients.name(law), s, mismatch });
            }
        }
    }
    Ok(())
}
