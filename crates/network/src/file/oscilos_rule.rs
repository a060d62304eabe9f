//! Open ends by OSCILOS_lite's own rule, for comparison with its numbers.
//!
//! That program evaluates the polynomials of Norris and Sheng (1989, J. Sound Vib. 135, 85), fitted to
//! Levine and Schwinger's end and to the flanged one, at Im s alone. Its characteristic function is not
//! analytic then, so that modes cannot be counted; from a mode of the exact ends its own is a few steps
//! away.

use crate::chain::coefficients::Constant;
use crate::chain::workspace::Workspace;
use crate::chains::Chain;
use crate::error::NetworkError;
use crate::flow_chain::{FlowChain, FlowEnd};
use crate::laws::Law;
use crate::plane::newton::Newton;
use rijke_numerics::C64;

/// Steps after which the iteration is given up. Each takes what is left of the error times about the share
/// of the end in the phase, a few per cent.
const MOST: usize = 100;

/// The mode near `mode` if every open end (kinds 11 and 12) reflects by the rule of OSCILOS_lite; none if
/// the chain has no such end, or if the iteration does not end.
///
/// # Errors
/// As [`Chain::solve`].
pub fn by_the_rule_of_oscilos(chain: &FlowChain, mode: C64) -> Result<Option<C64>, NetworkError> {
    let ruled = |end: &FlowEnd, omega: f64| match end {
        FlowEnd::Reflection(Law::Unflanged { radius, sound_speed, .. }) => {
            Some(FlowEnd::Reflection(Law::Constant(unflanged(omega * radius / sound_speed))))
        }
        FlowEnd::Reflection(Law::Flanged { radius, sound_speed }) => {
            Some(FlowEnd::Reflection(Law::Constant(flanged(omega * radius / sound_speed))))
        }
        _ => None,
    };
    if chain.ends().iter().all(|end| ruled(end, mode.im).is_none()) {
        return Ok(None);
    }
    let (mut s, mut work) = (mode, Workspace::default());
    for _ in 0..MOST {
        let ends = chain.ends().clone().map(|end| ruled(&end, s.im).unwrap_or(end));
        let ruled = chain.clone().with_ends(ends);
        let next = ruled.solve(&Constant, s, &Newton::default(), &mut work)?.s;
        let step = (next - s).norm();
        s = next;
        if step <= 1e-10 * s.norm() {
            return Ok(Some(s));
        }
    }
    Ok(None)
}

/// R of an unflanged end at `ka`, with e^{st}.
fn unflanged(ka: f64) -> C64 {
    let square = ka * ka;
    let modulus = (1.0 + 0.2 * ka - 0.084 * square) / (1.0 + 0.2 * ka + 0.416 * square);
    C64::from_polar(-modulus, -2.0 * ka * (0.6133 + 0.027 * square) / (1.0 + 0.19 * square))
}

/// R of a flanged end at `ka`.
fn flanged(ka: f64) -> C64 {
    let square = ka * ka;
    let modulus = (1.0 + 0.323 * ka - 0.077 * square) / (1.0 + 0.323 * ka + 0.923 * square);
    C64::from_polar(-modulus, -2.0 * ka * (0.82159 - 0.49 * square) / (1.0 - 0.46 * square * ka))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fit of the unflanged end has its end correction to two per cent, 0.012 of the radius, and R to
    /// twice that times ka. The flanged one is fitted to a tube, of end correction 0.8216, where the law
    /// here is Rayleigh's piston, 0.8488.
    #[test]
    fn oracle_the_fits_are_those_of_the_exact_ends() {
        let (radius, sound_speed) = (0.05, 340.0);
        for ka in [0.05, 0.3, 0.7, 1.0] {
            let s = C64::new(0.0, ka * sound_speed / radius);
            let laws = [
                (Law::Unflanged { radius, sound_speed, correction: 0.0 }, unflanged(ka), 0.025),
                (Law::Flanged { radius, sound_speed }, flanged(ka), 0.055 * ka),
            ];
            for (law, fit, bound) in laws {
                let exact = law.analytic(s)[0];
                assert!((exact - fit).norm() < bound * exact.norm(), "{law:?} at {ka}: {exact} {fit}");
            }
        }
    }
    #[test]
    fn exact_long_waves_radiate_as_a_point_source() {
        // |R| = 1 - 2 (radiation resistance) = 1 - (ka)^2/2 in the open, twice that before a wall.
        for (end, part) in [(unflanged as fn(f64) -> C64, 0.5), (flanged, 1.0)] {
            let lost = (1.0 - end(1e-4).norm()) / 1e-8;
            assert!((lost / part - 1.0).abs() < 1e-3, "{lost} {part}");
        }
    }
}
