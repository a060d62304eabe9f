//! The mode that lies nearest to where one was measured, beside poles of laws.
//!
//! Newton's method goes where the slope of the characteristic function points. Beside a pole, such as the
//! resonance of a branch, that is away from the pole and past the modes on both sides of it.

use super::PointModel;
use rijke_network::{Coefficients, Region, Workspace};
use rijke_numerics::C64;

/// A pole may have misled the search up to this many times the distance of the mode that was found.
const WIDER: f64 = 1.5;

impl PointModel<'_> {
    /// The mode nearest to `guess` of those that are less than `apart` from it, found by counting all of
    /// them; none where no law has a pole about that near, or where no mode lies so near.
    pub(super) fn behind_a_pole(
        &self,
        laws: &(dyn Coefficients + Sync),
        guess: C64,
        apart: f64,
    ) -> Option<C64> {
        let around = |distance: f64| Region {
            sigma: [guess.re - distance, guess.re + distance],
            omega: [(guess.im - distance).max(0.05 * guess.im), guess.im + distance],
        };
        let wide = around(WIDER * apart);
        let poles = self.chain().poles(laws, &wide).ok()?;
        if !poles.iter().any(|(pole, _)| wide.contains(*pole)) {
            return None;
        }
        // Modes in the corners of the square may lie farther away than the one that was found.
        let modes = self.chain().modes(laws, &around(apart), &mut Workspace::default()).ok()?;
        let distance = |s: &C64| (s - guess).norm();
        let all = modes.modes.iter().map(|m| m.s).filter(|s| distance(s) < apart);
        all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }
}
