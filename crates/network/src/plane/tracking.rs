//! Following one mode along a path of parameters.

use super::newton::Root;
use crate::error::NetworkError;
use rijke_numerics::C64;

/// Follows the mode `start` at t = 0 to t = 1. `solve(t, guess)` finds the eigenvalue of the network at t.
///
/// Steps are predicted along the secant and halved whenever `solve` fails or lands farther from the
/// prediction than a fiftieth of `spacing`, the distance of neighbouring modes (1/s), so that the mode does
/// not change its branch unnoticed at a near crossing. Returns every (t, s) visited.
///
/// # Errors
/// [`NetworkError::LostBranch`] when the step has shrunk below 2^-20; errors that are not recoverable at
/// once.
pub fn follow(
    start: C64,
    spacing: f64,
    mut solve: impl FnMut(f64, C64) -> Result<Root, NetworkError>,
) -> Result<Vec<(f64, C64)>, NetworkError> {
    const SMALLEST: f64 = 1.0 / 1_048_576.0;
    const FIRST: f64 = 1.0 / 16.0;
    /// A corrector step beyond this part of `spacing` halves the step.
    const TRUST: f64 = 0.02;
    let mut path = vec![(0.0, start)];
    let mut step = FIRST;
    while let Some(&(t, s)) = path.last()
        && t < 1.0
    {
        let next = (t + step).min(1.0);
        let slope = match path.as_slice() {
            [.., (t0, s0), _] => (s - s0) / (t - t0),
            _ => C64::ZERO,
        };
        let guess = s + slope * (next - t);
        match solve(next, guess) {
            Ok(root) if (root.s - guess).norm() <= TRUST * spacing => {
                path.push((next, root.s));
                step *= 1.5;
            }
            Err(error) if !error.is_recoverable() => return Err(error),
            outcome => {
                step *= 0.5;
                if step < SMALLEST {
                    let to = outcome.map_or(guess, |root| root.s);
                    return Err(NetworkError::LostBranch { from: s, to });
                }
            }
        }
    }
    Ok(path)
}
