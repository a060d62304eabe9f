//! Pings against the bound, against truth, and against records that must be refused.

use crate::ringing::Ringing;
use rijke_signal::{PingFit, PingOptions, Trace, fit_ping};

pub(crate) fn fit(ringing: &Ringing, channels: &[Vec<f64>]) -> Result<PingFit, rijke_signal::Fault> {
    let trace = Trace { channels, rate_hz: ringing.rate_hz, quiet: ringing.quiet, full_scale: f64::INFINITY };
    fit_ping(&trace, &PingOptions { reference: 5, ..PingOptions::default() })
}

#[test]
#[ignore = "long: a first look"]
fn look() {
    for (sigma, ratio, count) in [
        (-10.0, 30.0, 100),
        (-20.0, 10.0, 60),
        (-2.0, 10.0, 60),
        (-10.0, 1000.0, 60),
        (-20.0, 1000.0, 60),
        (-2.0, 1000.0, 60),
    ] {
        let ringing = Ringing::tube(sigma, ratio);
        let bound = ringing.bound(0);
        let mut z = vec![];
        let mut stated = vec![];
        let mut starts = vec![];
        let mut fails = 0;
        let clock = std::time::Instant::now();
        let mut white = 0.0;
        for seed in 0..count {
            let record = ringing.record(seed, "look");
            match fit(&ringing, &record) {
                Ok(f) => {
                    let d = f.ping.s - ringing.modes[0].0;
                    z.push((d.re / bound[(0, 0)].sqrt(), d.im / bound[(1, 1)].sqrt()));
                    stated.push((f.ping.covariance[(0, 0)] / bound[(0, 0)]).sqrt());
                    starts.push((f.window.0 - 0.4) * 1e3);
                    white += f.whiteness;
                    if seed < 2 {
                        println!(
                            "{:?} {:?} {:?} var {}",
                            f.modes, f.window, f.signal_to_noise, f.residual_variance
                        );
                    }
                }
                Err(e) => {
                    fails += 1;
                    if fails < 4 {
                        println!("{e}");
                    }
                }
            }
        }
        let n = z.len() as f64;
        let ms = |f: &dyn Fn(&(f64, f64)) -> f64| {
            let m = z.iter().map(f).sum::<f64>() / n;
            let v = z.iter().map(|x| f(x).powi(2)).sum::<f64>() / n;
            (m, v)
        };
        println!(
            "sigma {sigma} ratio {ratio}: mean,ms sigma {:?} omega {:?} stated sd/bound {:.3} start {:.2} ms (min {:.2} max {:.2}) fails {fails} white {:.2} time {:.2} ms incl. synthesis",
            ms(&|x| x.0),
            ms(&|x| x.1),
            stated.iter().sum::<f64>() / n,
            starts.iter().sum::<f64>() / n,
            starts.iter().fold(1e9f64, |a, &b| a.min(b)),
            starts.iter().fold(-1e9f64, |a, &b| a.max(b)),
            white / n,
            clock.elapsed().as_secs_f64() * 1e3 / f64::from(count as u32)
        );
    }
}

#[test]
fn exact_almost_noiseless_ping_returns_its_own_frequency_and_shape() {
    let ringing = Ringing::tube(-12.0, 1e6);
    let fit = fit(&ringing, &ringing.record(1, "noiseless")).unwrap();
    let (s, amplitudes) = &ringing.modes[0];
    assert!((fit.ping.s - s).norm() < 1e-4, "{}", fit.ping.s);
    for (p, a) in fit.ping.pressures.iter().zip(amplitudes) {
        assert!((p - a / amplitudes[5]).norm() < 1e-5);
    }
    assert!(fit.window.0 >= 0.4 && fit.window.0 < 0.4005, "start {}", fit.window.0);
}
