//! Checkers of derivatives, of convergence and of readers, for tests.

use crate::Stream;
use rand::RngExt;

/// Local slopes d ln(remainder) / d ln(h) of a Taylor remainder, for h = 1e-2, 5e-3, ... over six halvings.
///
/// `remainder(h)` is |f(x + h d) - Taylor polynomial|. A first-order polynomial gives slopes near 2, a
/// second-order one near 3. Remainders that reach rounding are left out, so the list may be shorter.
pub fn remainder_slopes(remainder: impl Fn(f64) -> f64) -> Vec<f64> {
    slopes_from(1e-2, remainder)
}

/// As [`remainder_slopes`], starting from the step `first`, for variables that are not of order one.
pub fn slopes_from(first: f64, remainder: impl Fn(f64) -> f64) -> Vec<f64> {
    let values: Vec<f64> = (0..7).map(|k| remainder(first / f64::from(1 << k))).collect();
    values.windows(2).filter(|w| w[1] > 0.0).map(|w| (w[0] / w[1]).log2()).collect()
}

/// What breaks programs that read numbers.
const HOSTILE: [&[u8]; 10] = [
    b"0",
    b"-1",
    b"1e308",
    b"1e-308",
    b"nan",
    b"inf",
    b"9223372036854775807",
    b"[]",
    b"'",
    b"\xff\xff\xff\xff",
];

/// A file with one to four damages drawn from `stream`: cut off, a bit turned, a stretch left out, copied to
/// another place or filled with one byte, a hostile number put in. For tests that no input makes a reader
/// panic.
pub fn damaged(whole: &[u8], stream: &mut Stream) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for _ in 0..stream.random_range(1..5) {
        let size = bytes.len();
        let (at, length) = (stream.random_range(0..=size), stream.random_range(0..64));
        let end = (at + length).min(size);
        match stream.random_range(0..8) {
            0 => bytes.truncate(at),
            1..=3 if at < size => bytes[at] ^= 1 << stream.random_range(0..8),
            4 => drop(bytes.drain(at..end)),
            5 => {
                let stretch = bytes[at..end].to_vec();
                let to = stream.random_range(0..=size);
                bytes.splice(to..to, stretch);
            }
            6 => bytes[at..end].fill([0, 0xff, 0x7f, b'9'][stream.random_range(0..4)]),
            _ => {
                let number = HOSTILE[stream.random_range(0..HOSTILE.len())];
                bytes.splice(at..end.min(at + number.len()), number.iter().copied());
            }
        }
    }
    bytes
}

/// Panics with the whole table unless the last three slopes lie within `tolerance` of `expected`.
///
/// # Panics
/// That is its purpose: call it from tests only.
#[track_caller]
#[allow(clippy::panic, reason = "an assertion for tests")]
pub fn slopes_near(slopes: &[f64], expected: f64, tolerance: f64) {
    let last = &slopes[slopes.len().saturating_sub(3)..];
    if last.len() < 3 || last.iter().any(|s| (s - expected).abs() > tolerance) {
        panic!("expected slopes {expected} +- {tolerance}, found {slopes:.4?}");
    }
}
