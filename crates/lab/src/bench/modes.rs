//! All modes of a chain in a region of the s-plane.

use super::error::BenchError;
use super::truth::Search;
use rijke_numerics::C64;
use std::f64::consts::{PI, TAU};

/// Every zero of `drive` in the region, lowest frequency first: the winding number says how many there are,
/// the secant method from finer and finer grids finds them.
pub(crate) fn modes(point: &str, drive: impl Fn(C64) -> C64, region: Search) -> Result<Vec<C64>, BenchError> {
    let ([low, high], [from, to]) = (region.growth_rate, region.frequency_hz.map(|f| TAU * f));
    let corners = [C64::new(low, from), C64::new(high, from), C64::new(high, to), C64::new(low, to)];
    let turns: f64 = (0..4).map(|k| side(&drive, corners[k], corners[(k + 1) % 4])).sum();
    let counted = (turns / TAU).round() as i64;
    let inside = |s: C64| s.re > low && s.re < high && s.im > from && s.im < to;
    let mut found: Vec<C64> = Vec::new();
    for grid in [6, 12, 24, 48] {
        if found.len() as i64 >= counted {
            break;
        }
        for across in 0..3 {
            for along in 0..grid {
                let start = C64::new(
                    low + (high - low) * (f64::from(across) + 0.5) / 3.0,
                    from + (to - from) * (f64::from(along) + 0.5) / f64::from(grid),
                );
                let root = root(&drive, start).filter(|s| inside(*s));
                found.extend(root.filter(|s| found.iter().all(|known| (known - s).norm() > 1e-3)));
            }
        }
    }
    found.sort_by(|a, b| a.im.total_cmp(&b.im));
    if found.len() as i64 == counted {
        return Ok(found);
    }
    Err(BenchError::Modes { point: point.to_owned(), counted, found: found.len() })
}

/// Change of the argument along a side, rad.
fn side(drive: &impl Fn(C64) -> C64, a: C64, b: C64) -> f64 {
    const PARTS: usize = 48;
    let at = |k: usize| a + (b - a) * (k as f64 / PARTS as f64);
    let values: Vec<C64> = (0..=PARTS).map(|k| drive(at(k))).collect();
    (0..PARTS).map(|k| turn(drive, [at(k), at(k + 1)], [values[k], values[k + 1]], 12)).sum()
}

/// The same between two places, halved until it turns by less than a third of a right angle.
fn turn(drive: &impl Fn(C64) -> C64, [a, b]: [C64; 2], [fa, fb]: [C64; 2], depth: usize) -> f64 {
    let angle = (fb / fa).arg();
    if angle.abs() < PI / 6.0 || depth == 0 {
        return angle;
    }
    let (middle, f) = (0.5 * (a + b), drive(0.5 * (a + b)));
    turn(drive, [a, middle], [fa, f], depth - 1) + turn(drive, [middle, b], [f, fb], depth - 1)
}

/// The zero that the secant method finds from `guess`; none if it does not converge in 40 steps.
fn root(drive: &impl Fn(C64) -> C64, guess: C64) -> Option<C64> {
    let (mut s, mut before) = (guess, guess * (1.0 + 1e-5));
    let mut last = drive(before);
    for _ in 0..40 {
        let here = drive(s);
        let step = here * (s - before) / (here - last);
        if !step.is_finite() {
            return None;
        }
        (before, last) = (s, here);
        s -= step;
        if step.norm() < 1e-12 * s.norm() {
            // After a wild jump the secant is so steep that its step is small anywhere: the slope here
            // decides.
            let near = s * 1e-6;
            let newton = drive(s) * near / (drive(s + near) - drive(s));
            return (newton.norm() < 1e-9 * s.norm()).then_some(s);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_all_zeros_of_a_product_are_found() {
        let zeros = [C64::new(-3.0, 500.0), C64::new(-40.0, 520.0), C64::new(10.0, 1900.0)];
        let drive = |s: C64| zeros.iter().map(|z| s - z).product::<C64>() * (s * 1e-3).exp();
        let region = Search { growth_rate: [-100.0, 50.0], frequency_hz: [20.0, 400.0], observed: None };
        let found = modes("p", drive, region).unwrap();
        assert_eq!(found.len(), 3);
        assert!(zeros.iter().zip(&found).all(|(z, s)| (z - s).norm() < 1e-8), "{found:?}");
    }
}
