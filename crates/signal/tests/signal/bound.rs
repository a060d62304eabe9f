//! The Cramer-Rao bound of a damped sinusoid: the Fisher matrix written out in [`crate::ringing`], against
//! reference values computed elsewhere, and against the closed form for long windows.

use crate::ringing::Ringing;
use rijke_numerics::C64;

fn single(alpha: f64, omega: f64, samples: usize, noise: f64) -> (f64, f64) {
    let amplitude = C64::from_polar(1.0, 0.3);
    let ringing = Ringing {
        decay: samples,
        noise,
        modes: vec![(C64::new(-alpha, omega), vec![amplitude])],
        ..Ringing::tube(-alpha, 1.0)
    };
    let bound = ringing.bound(0);
    (bound[(0, 0)].sqrt(), bound[(1, 1)].sqrt())
}

#[test]
fn oracle_reference_bounds_are_reproduced() {
    // fixtures/reference/signal.toml, crb_damped_sinusoid.
    let cases = [
        (12.0, 1090.0, 2000, 0.05, 9.312_241_93e-2, 9.263_182_39e-2),
        (12.0, 1090.0, 5000, 0.05, 8.333_856_53e-2, 8.293_248_08e-2),
        (30.0, 1100.0, 2000, 0.05, 3.303_104_11e-1, 3.267_464_16e-1),
        (5.0, 1080.0, 10_000, 0.02, 8.972_460_43e-3, 8.953_136_32e-3),
    ];
    for (alpha, omega, samples, noise, sigma, frequency) in cases {
        let (a, b) = single(alpha, omega, samples, noise);
        assert!((a / sigma - 1.0).abs() < 1e-8 && (b / frequency - 1.0).abs() < 1e-8, "{a} {b}");
    }
}

#[test]
fn exact_long_window_follows_the_closed_form() {
    // 4 (n / A) sqrt(alpha^3 dt); its error is of order alpha / omega and alpha dt.
    let (sigma, omega) = single(12.0, 3000.0, 12_000, 0.05);
    let closed = 4.0 * 0.05 * (12.0_f64.powi(3) * 1e-4).sqrt();
    assert!((sigma / closed - 1.0).abs() < 5e-3 && (omega / closed - 1.0).abs() < 5e-3);
}
