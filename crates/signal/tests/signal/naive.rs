//! Where the usual shortcuts stand on the same records.

use crate::clicking::Clicking;
use crate::ringing::Ringing;
use rijke_numerics::C64;
use rijke_signal::{PingOptions, Trace, fit_ping};

fn root_mean_square(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Growth rate from a straight line through the logarithm of the envelope of the strongest channel, as far as the
/// envelope is above three times the noise: demodulation at the known frequency and a mean over four periods.
fn log_decrement(y: &[f64], rate_hz: f64, omega: f64, noise: f64) -> f64 {
    let period = (std::f64::consts::TAU / omega * rate_hz * 4.0) as usize;
    let turned: Vec<C64> =
        y.iter().enumerate().map(|(n, v)| C64::from_polar(2.0 * v, -omega * n as f64 / rate_hz)).collect();
    let floor = 3.0 * noise * (4.0 / period as f64).sqrt();
    let points: Vec<(f64, f64)> = turned
        .chunks_exact(period)
        .enumerate()
        .map(|(k, c)| (k as f64 * period as f64 / rate_hz, (c.iter().sum::<C64>() / period as f64).norm()))
        .take_while(|p| p.1 > floor)
        .map(|(t, a)| (t, a.ln()))
        .collect();
    let n = points.len() as f64;
    let (mt, ma) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let top: f64 = points.iter().map(|p| (p.0 - mt) * (p.1 - ma)).sum();
    top / points.iter().map(|p| (p.0 - mt).powi(2)).sum::<f64>()
}

#[test]
fn oracle_growth_rate_beats_log_decrement_and_subspace() {
    let ringing = Ringing::tube(-10.0, 30.0);
    let bound = ringing.bound(0)[(0, 0)].sqrt();
    let mut errors = [Vec::new(), Vec::new(), Vec::new()];
    let end = ringing.quiet + ringing.forced;
    for seed in 0..80 {
        let record = ringing.record(seed, "naive");
        let trace = Trace { channels: &record, rate_hz: 1e4, quiet: 2000, full_scale: f64::INFINITY };
        let fit = fit_ping(&trace, &PingOptions { reference: 5, ..PingOptions::default() }).unwrap();
        errors[0].push(fit.ping.s.re + 10.0);
        errors[1].push(fit.subspace_guess.re + 10.0);
        errors[2].push(log_decrement(&record[3][end..], 1e4, 1090.0, 1.0) + 10.0);
    }
    println!("growth rate, rms error over the bound of {bound:.4} 1/s");
    let rms = errors.map(|e| root_mean_square(&e) / bound);
    println!("maximum likelihood {:.2}, ESPRIT {:.2}, log decrement {:.2}", rms[0], rms[1], rms[2]);
    assert!(rms[0] < 1.25 && rms[1] > 1.3 * rms[0] && rms[2] > 1.5 * rms[0]);
}

/// Delay of `b` behind `a` at the largest sample of the raw cross-correlation, refined by a parabola.
fn raw_correlation(a: &[f64], b: &[f64], rate_hz: f64) -> f64 {
    let product = |lag: usize| a.iter().zip(&b[lag..]).map(|(x, y)| x * y).sum::<f64>();
    let values: Vec<f64> = (0..200).map(product).collect();
    let peak = (1..199).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap();
    let (l, m, r) = (values[peak - 1], values[peak], values[peak + 1]);
    (peak as f64 + 0.5 * (l - r) / (l - 2.0 * m + r)) / rate_hz
}

#[test]
fn oracle_arrival_time_beats_raw_correlation() {
    let clicking = Clicking { hum: 5.0, ..Clicking::tube(30.0) };
    let truth = clicking.arrivals();
    let mut errors = [Vec::new(), Vec::new()];
    for seed in 0..30 {
        let record = clicking.record(seed, "naive");
        let fit = crate::click::fit(&clicking, &record).unwrap();
        let exact = truth[4] - truth[0];
        errors[0].push(fit.times[4] - fit.times[0] - exact);
        errors[1].push(raw_correlation(&record[0], &record[4], 62_500.0) - exact);
    }
    let rms = errors.map(|e| 1e6 * root_mean_square(&e));
    let bound = 1e6 * clicking.bound(0)[(4, 4)].sqrt();
    println!(
        "delay of 0.4 m, rms error in us: {:.2}, raw correlation {:.2}; bound {bound:.2}",
        rms[0], rms[1]
    );
    assert!(rms[0] < 1.4 * bound && rms[1] > 2.0 * rms[0]);
}
