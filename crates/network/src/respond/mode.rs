//! The mode of an eigenvalue without derivatives.

use super::answer::{Places, Response};
use crate::chain::coefficients::Coefficients;
use crate::chain::network::Network;
use crate::chain::sweep::Step;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use rijke_numerics::{C64, Jet};

impl Network {
    /// Eigenvalue and relative pressures without derivatives: one plain sweep.
    pub(crate) fn mode_values<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        root: &Root,
        places: &Places,
        work: &mut Workspace,
    ) -> Result<Response, NetworkError> {
        let mut pressures = vec![C64::ZERO; places.at.len()];
        let mut reference = C64::ZERO;
        self.sweep(coefficients, root.s, &mut work.laws, |step| {
            if let Step::Joint { j, p, .. } = step {
                if j == places.reference {
                    reference = p.value;
                }
                for (to, _) in pressures.iter_mut().zip(&places.at).filter(|(_, place)| **place == j) {
                    *to = p.value;
                }
            }
        });
        self.check_properties(&work.laws)?;
        let loudest = pressures.iter().map(|p| p.norm()).fold(reference.norm(), f64::max);
        if !loudest.is_finite() {
            return Err(NetworkError::NotFinite { s: root.s });
        }
        if !places.at.is_empty() && reference.norm() <= 1e-12 * loudest {
            return Err(NetworkError::SilentReference { place: places.reference });
        }
        let plain = |value: C64| Jet::from_parts(value, Vec::new(), Vec::new());
        let pressures = pressures.into_iter().map(|p| plain(p / reference)).collect();
        Ok(Response { s: plain(root.s), pressures })
    }
}
