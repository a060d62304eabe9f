//! What a term may be in proportion to.

use crate::Observed;
use crate::point::Probed;
use rijke_numerics::words::to_digits;
use rijke_study::names::DENSITY;
use rijke_study::{Campaign, hertz, unit_behind};

/// Factors that vary by less than this share of the largest are no factors of terms, nor are factors whose
/// courses are as parallel.
const VARIES: f64 = 0.02;

/// One, the factors of the campaign that vary, the velocity and the frequency, each in the largest of their
/// values.
pub(super) fn factors(
    campaign: &Campaign,
    observed: &[Observed],
    probed: &[Probed],
) -> Vec<(String, Vec<f64>)> {
    let mut all = vec![(String::new(), vec![1.0; observed.len()])];
    let velocity = |o: &Observed| {
        let around = o.conditions.around(0.0);
        o.conditions.base.mass_flow / (around[DENSITY] * o.conditions.layout.areas(0.0)[1])
    };
    let of_campaign = campaign.factors.iter().enumerate().map(|(k, f)| {
        let values = observed.iter().map(|o| o.conditions.point.factors[k]);
        (f.name.clone(), f.unit_in_print(), values.map(|v| if v.is_finite() { v } else { 0.0 }).collect())
    });
    let named: Vec<(String, String, Vec<f64>)> = of_campaign
        .chain([
            ("velocity".into(), "m/s".into(), observed.iter().map(velocity).collect()),
            ("frequency".into(), "Hz".into(), probed.iter().map(|p| hertz(p.s.im)).collect()),
        ])
        .collect();
    for (name, unit, values) in named {
        let largest = values.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
        let scaled: Vec<f64> = values.iter().map(|v| v / largest).collect();
        let parallel = |other: &[f64]| {
            // Whatever is left of it after a multiple of the other.
            let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let by = square(&scaled, other) / square(other, other);
            let left: f64 = scaled.iter().zip(other).map(|(a, b)| (a - by * b).powi(2)).sum();
            left < VARIES * VARIES * square(&scaled, &scaled)
        };
        if largest > 0.0 && largest.is_finite() && !all.iter().any(|(_, other)| parallel(other)) {
            let unit = unit_behind(&unit);
            all.push((format!("{name}/({}{unit})", to_digits(largest, 4)), scaled));
        }
    }
    all
}
