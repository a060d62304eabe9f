//! Clicks on the scale of a common waveform.

use crate::Fault;
use crate::click::ClickFit;
use crate::dsp::scaled::inverse_scaled;
use rijke_numerics::{C64, Matrix};

/// Times and gains of one click on the scale of a template.
pub(super) struct Placed {
    pub(super) times: Vec<f64>,
    pub(super) gains: Vec<f64>,
    pub(super) covariance: Matrix,
}

/// Shift and scale that bring a waveform on the template, by weighted least squares; and the row that maps an
/// error of the waveform to one of the shift.
pub(super) fn place(fit: &ClickFit, template: &[C64]) -> Result<((f64, f64), Vec<f64>), Fault> {
    let (channels, bins) = (fit.times.len(), template.len());
    let rows: Vec<usize> = (channels..channels + 2 * bins).collect();
    let weight = inverse_scaled(&fit.joint.select(&rows))?;
    let (mut shift, mut scale) = coarse_shift(fit, template);
    let mut row = vec![0.0; 2 * bins];
    for _ in 0..8 {
        let mut design = Matrix::zeros(2 * bins, 2);
        let mut left = vec![0.0; 2 * bins];
        for k in 0..bins {
            let turned = template[k] * C64::from_polar(1.0, -fit.frequencies[k] * shift);
            let slope = C64::new(0.0, -fit.frequencies[k]) * turned * scale;
            let residual = fit.waveform[k] - turned * scale;
            for (part, (d, t, r)) in [(slope.re, turned.re, residual.re), (slope.im, turned.im, residual.im)]
                .into_iter()
                .enumerate()
            {
                design[(2 * k + part, 0)] = d;
                design[(2 * k + part, 1)] = t;
                left[2 * k + part] = r;
            }
        }
        let weighted = design.transpose().product(&weight);
        let gain = inverse_scaled(&weighted.product(&design))?.product(&weighted);
        let step = gain.times(&left);
        shift += step[0];
        scale += step[1];
        row = gain.row(0).to_vec();
        if step[0].abs() < 1e-12 {
            break;
        }
    }
    Ok(((shift, scale), row))
}

/// Shift at which the two waveforms correlate best, either sign, on a grid of a microsecond. A frequency
/// counts as it is known: the lowest may be hardly known beside the background.
fn coarse_shift(fit: &ClickFit, template: &[C64]) -> (f64, f64) {
    let known = |k: usize| {
        let row = fit.times.len() + 2 * k;
        (fit.joint[(row, row)] + fit.joint[(row + 1, row + 1)]).max(f64::MIN_POSITIVE).recip()
    };
    let weighed: Vec<C64> = template.iter().enumerate().map(|(k, t)| t.conj() * known(k)).collect();
    let power: f64 = weighed.iter().zip(template).map(|(w, t)| (w * t).re).sum();
    let product = |shift: f64| -> f64 {
        let terms = fit.waveform.iter().zip(&weighed).zip(&fit.frequencies);
        terms.map(|((w, t), f)| (w * t * C64::from_polar(1.0, f * shift)).re).sum::<f64>() / power
    };
    // Two lobes of an impulse of low frequency are farther apart.
    let highest = fit.frequencies.last().copied().unwrap_or(f64::INFINITY);
    let reach = ((1.2e6 * std::f64::consts::TAU / highest) as i32 - 60).clamp(300, 3000);
    let grid = (-reach..=reach).map(|k| f64::from(k) * 1e-6);
    let best = grid.max_by(|a, b| product(*a).abs().total_cmp(&product(*b).abs())).unwrap_or(0.0);
    (best, product(best))
}

/// Times and gains of a fit, counted from the template.
pub(super) fn absolute(fit: &ClickFit, template: &[C64]) -> Result<Placed, Fault> {
    let ((shift, scale), row) = place(fit, template)?;
    let channels = fit.times.len();
    let map = Matrix::from_fn(channels, fit.joint.rows(), |i, j| {
        if j < channels { f64::from(u8::from(i == j)) } else { row[j - channels] }
    });
    Ok(Placed {
        times: fit.times.iter().map(|t| t + shift).collect(),
        gains: fit.gains.iter().map(|g| g * scale).collect(),
        covariance: map.product(&fit.joint).product(&map.transpose()),
    })
}
