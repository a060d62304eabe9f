//! No record makes the estimators panic, and what they accept is finite.

use proptest::prelude::*;
use rijke_numerics::Streams;
use rijke_signal::{
    BlowOptions, ClickOptions, Extent, Fault, PingOptions, Reflection, Trace, fit_blow, fit_click, fit_ping,
};

/// One channel of a kind: noise, nothing, extreme, steps, a tone, an impulse, not a number.
fn channel(kind: u8, length: usize, seed: u64) -> Vec<f64> {
    use rand::RngExt;
    let mut stream = Streams::new(seed).stream("any");
    let mut noise = || -> f64 { stream.random::<f64>() - 0.5 };
    (0..length)
        .map(|n| match kind {
            0 => noise(),
            1 => 0.0,
            2 => 1e300 * noise(),
            3 => 1e-300 * noise(),
            4 => (4.0 * noise()).round(),
            5 => 50.0 * (0.1 * n as f64).sin() * (-1e-3 * n as f64).exp() + noise(),
            6 => 100.0 * (-(n as f64 - 0.4 * length as f64).powi(2) / 20.0).exp() + noise(),
            7 if n == length / 2 => f64::NAN,
            _ => (0.1 * n as f64).cos(),
        })
        .collect()
}

#[test]
fn behaviour_wrong_rates_and_windows_are_faults() {
    let channels = vec![channel(5, 9600, 1), channel(6, 9600, 2)];
    for k in -30..=30 {
        let rate_hz = 10.0_f64.powi(10 * k);
        for rate_hz in [rate_hz, 3.0 * rate_hz, 8.0 * rate_hz, 25.0 * rate_hz] {
            let trace = Trace { channels: &channels, rate_hz, quiet: 1600, full_scale: f64::INFINITY };
            let scaled = PingOptions {
                band_hz: (0.01 * rate_hz, 0.04 * rate_hz),
                highest_hz: 0.16 * rate_hz,
                ..PingOptions::default()
            };
            let _ = (fit_ping(&trace, &PingOptions::default()).is_ok(), fit_ping(&trace, &scaled).is_ok());
            if !(1e2..1e8).contains(&rate_hz) {
                assert!(fit_click(&trace, &ClickOptions::default()).is_err(), "{rate_hz}");
            }
            let blow = BlowOptions { stretch_s: [0.01, 0.5], highest_hz: 600.0, near_hz: vec![170.0] };
            let _ = fit_blow(&channels, rate_hz, &blow).is_ok();
        }
    }
    for (rate_hz, stretch_s, highest_hz) in [
        (0.0, [0.01, 0.5], 600.0),
        (f64::NAN, [0.01, 0.5], 600.0),
        (8e3, [0.5, 0.01], 600.0),
        (8e3, [f64::NAN, 0.01], 600.0),
        (8e3, [0.01, 0.5], 0.0),
    ] {
        let blow = BlowOptions { stretch_s, highest_hz, near_hz: vec![170.0] };
        assert!(matches!(fit_blow(&channels, rate_hz, &blow), Err(Fault::Options(_))), "{blow:?}");
    }
    let trace = Trace { channels: &channels, rate_hz: 4e4, quiet: 1600, full_scale: f64::INFINITY };
    let refused = |options: ClickOptions| fit_click(&trace, &options).unwrap_err().to_string();
    let long = ClickOptions { window: (0.2, 0.1), ..ClickOptions::default() };
    assert!(refused(long).contains("longer than the record"));
    let reflection = Reflection {
        lags: vec![1e-3, -1e-3],
        strength: -1.0,
        smoothing: 7e-5,
        tolerance: 0.1,
        pace_sd: 0.0,
        dispersion: Vec::new(),
    };
    let early = ClickOptions { reflection: Some(reflection), ..ClickOptions::default() };
    assert!(refused(early).contains("no later than its impulse"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn oracle_any_record_gives_finite_numbers_or_a_fault(
        kinds in proptest::collection::vec(0_u8..9, 0..4),
        length in 0_usize..4000,
        quiet in 0_usize..4100,
        rate_hz in prop_oneof![Just(1e4), Just(62_500.0), 10.0..1e6],
        seed in any::<u64>(),
    ) {
        let channels: Vec<Vec<f64>> =
            kinds.iter().enumerate().map(|(m, &kind)| channel(kind, length, seed ^ m as u64)).collect();
        let trace = Trace { channels: &channels, rate_hz, quiet, full_scale: f64::INFINITY };
        if let Ok(fit) = fit_ping(&trace, &PingOptions::default()) {
            prop_assert!(fit.ping.vector().iter().all(|v| v.is_finite()));
        }
        let reflection = Reflection {
            lags: (0..channels.len()).map(|m| 1e-3 - 3e-4 * m as f64).collect(),
            strength: -1.0,
            smoothing: 7e-5,
            tolerance: 0.1,
            pace_sd: 0.2,
            dispersion: Vec::new(),
        };
        for reflection in [None, Some(reflection)] {
            if let Ok(extent) = Extent::of(&trace, &ClickOptions { reflection: reflection.clone(), ..ClickOptions::default() }) {
                prop_assert!(extent.before > 0.0 && extent.after.is_finite() && extent.band_hz.1 > 0.0);
            }
            if let Ok(fit) = fit_click(&trace, &ClickOptions { reflection, ..ClickOptions::default() }) {
                prop_assert!(fit.times.iter().chain(&fit.gains).all(|v| v.is_finite()));
            }
        }
    }
}
