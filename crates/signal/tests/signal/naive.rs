//! Where the usual shortcuts stand on the same records.

use crate::clicking::Clicking;
use crate::ringing::Ringing;
use rijke_numerics::C64;
use rijke_signal::{PingOptions, Trace, fit_ping};

fn root_mean_square(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

/// Growth rate from a straight line through the logarithm of the envelope of the strongest channel, as far as
/// the envelope is above three times the noise: demodulation at the known frequency and a mean over four
/// periods.
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
    slope(&points)
}

/// Of the straight line through points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let (mt, ma) = (points.iter().map(|p| p.0).sum::<f64>() / n, points.iter().map(|p| p.1).sum::<f64>() / n);
    let top: f64 = points.iter().map(|p| (p.0 - mt) * (p.1 - ma)).sum();
    top / points.iter().map(|p| (p.0 - mt).powi(2)).sum::<f64>()
}

/// Growth rate from a straight line through the logarithm of the Hilbert envelope of one channel, as far as
/// it is above three times the noise.
fn hilbert_decrement(y: &[f64], rate_hz: f64, noise: f64) -> f64 {
    let mut planner = rustfft::FftPlanner::new();
    let mut z: Vec<C64> = y.iter().map(|v| C64::from(*v)).collect();
    planner.plan_fft_forward(z.len()).process(&mut z);
    let half = z.len() / 2;
    z[1..half].iter_mut().for_each(|v| *v *= 2.0);
    z[half + 1..].fill(C64::ZERO);
    planner.plan_fft_inverse(z.len()).process(&mut z);
    let scale = 1.0 / z.len() as f64;
    let points: Vec<(f64, f64)> = z
        .iter()
        .enumerate()
        .map(|(n, v)| (n as f64 / rate_hz, v.norm() * scale))
        .take_while(|p| p.1 > 3.0 * noise)
        .map(|(t, a)| (t, a.ln()))
        .collect();
    slope(&points)
}

#[test]
fn oracle_growth_rate_beats_log_decrement_and_subspace() {
    let ringing = Ringing::tube(-10.0, 30.0);
    let bound = ringing.bound(0)[(0, 0)].sqrt();
    let mut errors = [const { Vec::new() }; 4];
    let end = ringing.quiet + ringing.forced;
    for seed in 0..80 {
        let record = ringing.record(seed, "naive");
        let trace = Trace { channels: &record, rate_hz: 1e4, quiet: 2000, full_scale: f64::INFINITY };
        let fit = fit_ping(&trace, &PingOptions { reference: 5, ..PingOptions::default() }).unwrap();
        errors[0].push(fit.ping.s.re + 10.0);
        errors[1].push(fit.subspace_guess.re + 10.0);
        errors[2].push(log_decrement(&record[3][end..], 1e4, 1090.0, 1.0) + 10.0);
        errors[3].push(hilbert_decrement(&record[3][end..], 1e4, 1.0) + 10.0);
    }
    println!("growth rate, rms error over the bound of {bound:.4} 1/s");
    let rms = errors.map(|e| root_mean_square(&e) / bound);
    println!(
        "maximum likelihood {:.2}, ESPRIT {:.2}, log decrement of the demodulated envelope {:.2}, of the Hilbert envelope {:.2}",
        rms[0], rms[1], rms[2], rms[3]
    );
    assert!(rms[0] < 1.25 && rms[1] > 1.3 * rms[0] && rms[2] > 1.5 * rms[0] && rms[3] > 1.5 * rms[0]);
}

/// Delay of `b` behind `a` at the largest sample of the raw cross-correlation, refined by a parabola.
fn raw_correlation(a: &[f64], b: &[f64], rate_hz: f64) -> f64 {
    let product = |lag: usize| a.iter().zip(&b[lag..]).map(|(x, y)| x * y).sum::<f64>();
    let values: Vec<f64> = (0..200).map(product).collect();
    let peak = (1..199).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap();
    let (l, m, r) = (values[peak - 1], values[peak], values[peak + 1]);
    (peak as f64 + 0.5 * (l - r) / (l - 2.0 * m + r)) / rate_hz
}

/// Weighting of the cross-spectrum.
#[derive(Clone, Copy, PartialEq)]
enum Weighting {
    /// None: Hannan & Thomson's of maximum likelihood where noise is white and the impulse is alone.
    Plain,
    /// The phase transform: every frequency alike. Without an average over records the smoothed coherence
    /// transform (SCOT) is the same.
    Phase,
}

/// Delay of `b` behind `a`, both windowed to 0.8 ms about `at` samples and limited to 0.3 to 4 kHz: the peak
/// of their weighted cross-correlation, interpolated 16 times and refined by a parabola.
fn weighted_correlation(a: &[f64], b: &[f64], at: [usize; 2], rate_hz: f64, weighting: Weighting) -> f64 {
    let (half, length, fine) = ((0.8e-3 * rate_hz) as usize, 512, 16);
    let mut planner = rustfft::FftPlanner::new();
    let forward = planner.plan_fft_forward(length);
    let spectrum = |y: &[f64], at: usize| {
        let mut z = vec![C64::ZERO; length];
        let mean = y[at - half..at + half].iter().sum::<f64>() / (2 * half) as f64;
        for (n, v) in y[at - half..at + half].iter().enumerate() {
            let hann = 1.0 - (std::f64::consts::TAU * (n as f64 + 0.5) / (2 * half) as f64).cos();
            z[n] = C64::from((v - mean) * hann);
        }
        forward.process(&mut z);
        z
    };
    let (first, second) = (spectrum(a, at[0]), spectrum(b, at[1]));
    let mut cross = vec![C64::ZERO; length * fine];
    for k in 1..length / 2 {
        let frequency = k as f64 * rate_hz / length as f64;
        if (300.0..4000.0).contains(&frequency) {
            let product = second[k] * first[k].conj();
            cross[k] = if weighting == Weighting::Phase { product / product.norm() } else { product };
        }
    }
    planner.plan_fft_inverse(length * fine).process(&mut cross);
    let size = cross.len() as i64;
    let value = |lag: i64| cross[lag.rem_euclid(size) as usize].re;
    let peak = (-400..400).max_by(|&i, &j| value(i).total_cmp(&value(j))).unwrap();
    let (l, m, r) = (value(peak - 1), value(peak), value(peak + 1));
    let lag = (peak as f64 + 0.5 * (l - r) / (l - 2.0 * m + r)) / fine as f64;
    (at[1] as f64 - at[0] as f64 + lag) / rate_hz
}

#[test]
fn oracle_arrival_time_beats_raw_and_weighted_correlations() {
    let clicking = Clicking { hum: 4.0, ..Clicking::tube(30.0) };
    let (truth, clean) = (clicking.arrivals(), clicking.clean());
    let mut errors = [const { Vec::new() }; 5];
    for seed in 0..60 {
        let record = clicking.noisy(&clean, seed, "naive");
        let fit = crate::click::fit(&clicking, &record).unwrap();
        let exact = truth[4] - truth[0];
        let sample =
            |m: usize| (clicking.quiet as f64 + (1e-3 + truth[m]) * clicking.rate_hz).round() as usize;
        let (a, b) = (&record[0], &record[4]);
        let weighted = |w| weighted_correlation(a, b, [sample(0), sample(4)], clicking.rate_hz, w);
        let plain = weighted(Weighting::Plain);
        errors[0].push(fit.times[4] - fit.times[0] - exact);
        errors[1].push(raw_correlation(a, b, clicking.rate_hz) - exact);
        errors[2].push((plain * clicking.rate_hz).round() / clicking.rate_hz - exact);
        errors[3].push(plain - exact);
        errors[4].push(weighted(Weighting::Phase) - exact);
    }
    let rms = errors.map(|e| 1e6 * root_mean_square(&e));
    let bound = 1e6 * clicking.bound(0)[(4, 4)].sqrt();
    println!("delay of 0.4 m, rms error in us; bound {bound:.2}: joint maximum likelihood {:.2}", rms[0]);
    println!("raw correlation of the record {:.2}; windowed, to the nearest sample {:.2}", rms[1], rms[2]);
    println!("windowed and interpolated {:.2}; with the phase transform {:.2}", rms[3], rms[4]);
    assert!(rms[0] < 1.3 * bound && rms[1] > 2.0 * rms[0] && rms[2] > 1.2 * rms[0]);
    assert!(rms[4] > 2.0 * rms[0]);
}
