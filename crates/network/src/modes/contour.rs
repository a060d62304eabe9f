//! Every mode in a rectangle of the s-plane, counted by the argument principle.
//!
//! The winding number of G(s) = F(s) prod (s - pole)^order round a cell is its number of zeros. Cells are
//! halved until each holds one zero or none; the first moment of G'/G gives the zero to some digits and
//! Newton the rest. Every edge is sampled once and shared by its neighbours. A winding number is accepted
//! from samples whose change of ln G agrees with the derivative at both ends and at the middle: strong
//! evidence, not a proof in interval arithmetic.

use crate::chain::checked::beyond_range;
use crate::chain::coefficients::{At, Coefficients, Pole};
use crate::chain::network::Network;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::plane::modes::Modes;
use crate::plane::poles::PolesByPlace;
use crate::plane::region::Region;
use crate::plane::zeros::zeros;
use rijke_numerics::C64;
use std::f64::consts::PI;

impl Network {
    /// All modes in `region`, or an error: never an incomplete list.
    ///
    /// Cost: about fifty sweeps per mode.
    ///
    /// # Errors
    /// [`NetworkError::Region`], [`NetworkError::NotAnalytic`], [`NetworkError::PoleInSegment`],
    /// [`NetworkError::Border`], [`NetworkError::NotFinite`], [`NetworkError::Uncertified`],
    /// [`NetworkError::Overflow`]; [`NetworkError::NoLaw`] and [`NetworkError::Property`] as
    /// [`Network::solve`].
    pub fn modes<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        region: &Region,
        work: &mut Workspace,
    ) -> Result<Modes, NetworkError> {
        region.check()?;
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        self.check(coefficients, C64::new(middle(region.sigma), middle(region.omega)), &mut work.laws)?;
        let step = 0.25 * PI / self.travel_time();
        // Poles far outside do not change the count and would only scale G.
        let wide = region.widened(4.0 * step);
        let mut poles = self.poles(coefficients, &wide)?;
        check_analytic(coefficients, region, &poles, work)?;
        let pole_count = poles.iter().filter(|p| region.contains(p.0)).map(|p| p.1).sum();
        poles.retain(|p| wide.contains(p.0));
        let f = |s: C64| {
            let f = self.characteristic(coefficients, s, &mut work.laws);
            [f.value, f.slope]
        };
        let sigma =
            if region.sigma[0].abs() > region.sigma[1].abs() { region.sigma[0] } else { region.sigma[1] };
        zeros(f, region, step, poles, pole_count)
            .map_err(|error| beyond_range(error, sigma, self.travel_time()))
    }

    /// Poles of F with their orders: those of every law that acts at a place or an end. All that lie in
    /// `region`; others may be among them.
    ///
    /// # Errors
    /// [`NetworkError::PoleInSegment`]; as [`Coefficients::poles_in`].
    pub fn poles<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        region: &Region,
    ) -> Result<Vec<(C64, usize)>, NetworkError> {
        let mut poles = PolesByPlace::default();
        for Pole { law, at, order } in coefficients.poles_in(region)? {
            for a in self.attachments.iter().filter(|a| a.law == law && a.weight != 0.0) {
                if a.key % 2 == 0 && a.key > 0 && a.key < 2 + 2 * self.segments.len() {
                    return Err(NetworkError::PoleInSegment { law: coefficients.name(law), at });
                }
                poles.add((at, order), law, |place| *place == a.key, a.key);
            }
        }
        Ok(poles.all())
    }
}

/// Slopes along sigma and omega that differ by more than this are those of no analytic function.
const SLOPES_DIFFER: f64 = 1e-4;

/// Compares the slopes of every law along sigma and along omega at nine points of the region that are not
/// beside one of its `poles`.
pub(crate) fn check_analytic<K: Coefficients + ?Sized>(
    coefficients: &K,
    region: &Region,
    poles: &[(C64, usize)],
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
    for k in 0..9 {
        let (a, b) = (0.17 + 0.33 * f64::from(k % 3), 0.17 + 0.33 * f64::from(k / 3));
        let s = C64::new(region.sigma[0] + a * width, region.omega[0] + b * height);
        let h = 1e-5 * s.norm().max(1e-3 * (width + height));
        if poles.iter().any(|p| (p.0 - s).norm() < 1e3 * h) {
            continue;
        }
        let along = |values: &mut dyn FnMut(C64) -> Vec<C64>, d: C64| -> Vec<C64> {
            let (up, down) = (values(s + d), values(s - d));
            up.iter().zip(down).map(|(u, v)| (u - v) / (2.0 * d)).collect()
        };
        let centre = values(s);
        // Rounding of a central difference is eps |law|/h; its truncation h^2 law''', which a long delay
        // makes large: the mismatch counts if a smaller step leaves it.
        let mut mismatches = |h: f64| -> Vec<f64> {
            let across = along(&mut values, C64::new(h, 0.0));
            let upward = along(&mut values, C64::new(0.0, h));
            let of = |law: usize| {
                let size = across[law].norm() + upward[law].norm() + centre[law].norm() / s.norm();
                (across[law] - upward[law]).norm() / size
            };
            (0..count).map(of).collect()
        };
        if mismatches(h).iter().all(|m| *m <= SLOPES_DIFFER) {
            continue;
        }
        let differs = |(_, mismatch): &(usize, f64)| *mismatch > SLOPES_DIFFER;
        if let Some((law, mismatch)) = mismatches(h / 64.0).into_iter().enumerate().find(differs) {
            return Err(NetworkError::NotAnalytic { law: coefficients.name(law), s, mismatch });
        }
    }
    Ok(())
}
