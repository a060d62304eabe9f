//! Clicks against the bound and against truth.

use crate::clicking::Clicking;
use rijke_signal::{ClickFit, ClickOptions, Fault, Trace, fit_click};

pub(crate) fn fit(clicking: &Clicking, channels: &[Vec<f64>]) -> Result<ClickFit, Fault> {
    let trace =
        Trace { channels, rate_hz: clicking.rate_hz, quiet: clicking.quiet, full_scale: f64::INFINITY };
    let options = ClickOptions { reflection: clicking.gaps(), ..ClickOptions::default() };
    fit_click(&trace, &options)
}

#[test]
#[ignore = "long: a first look"]
fn look() {
    for (ratio, reflection, hum) in [
        (30.0, 0.0, 0.0),
        (300.0, 0.0, 0.0),
        (300.0, 0.8, 0.0),
        (30.0, 0.8, 0.0),
        (300.0, 0.8, 30.0),
        (3000.0, 0.8, 0.0),
    ] {
        let clicking = Clicking { reflection, hum, ..Clicking::tube(ratio) };
        let mut sums = [(0.0, 0.0, 0.0); 8];
        let mut fails = 0;
        let mut chi = 0.0;
        let n = 600;
        let clock = std::time::Instant::now();
        let mut fitting = 0.0;
        for seed in 0..n {
            let record = clicking.record(seed, "look");
            let c0 = clock.elapsed().as_secs_f64();
            let fitted = fit(&clicking, &record);
            fitting += clock.elapsed().as_secs_f64() - c0;
            match fitted {
                Ok(f) => {
                    let bound = clicking.bound(f.pivot);
                    let truth = clicking.arrivals();
                    chi += f.chi_squared;
                    for m in 0..8 {
                        if m == f.pivot {
                            continue;
                        }
                        let d = f.times[m] - f.times[f.pivot] - truth[m] + truth[f.pivot];
                        sums[m].0 += d / bound[(m, m)].sqrt();
                        sums[m].1 += d * d / bound[(m, m)];
                        sums[m].2 += f.covariance[(m, m)] / bound[(m, m)];
                    }
                    if seed == 0 {
                        println!(
                            "{:?} pivot {} taps {:?} snr {:?} sd bound {} us",
                            f.times,
                            f.pivot,
                            f.reflection,
                            f.signal_to_noise,
                            bound[((f.pivot + 1) % 8, (f.pivot + 1) % 8)].sqrt() * 1e6
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
        println!(
            "ratio {ratio} refl {reflection} hum {hum} fails {fails} chi2 {:.2} fit {:.3} ms",
            chi / n as f64,
            fitting * 1e3 / n as f64
        );
        for (m, s) in sums.iter().enumerate() {
            println!(
                "  {m}: mean {:.2} ms {:.3} stated {:.3}",
                s.0 / n as f64,
                s.1 / n as f64,
                s.2 / n as f64
            );
        }
    }
}
