//! A click that hum drowns.

use crate::dsp::kernels::{Powers, dot, peak};
use crate::{Fault, Trace};
use rijke_numerics::C64;

/// Refuses a click in which hum at the first two harmonics of the mains is as loud as a fifth of its impulse:
/// no impulse below the noise of the mains has that much there.
pub(super) fn loud_hum(trace: &Trace<'_>, mains_hz: f64) -> Result<(), Fault> {
    let (quiet, step) = (trace.quiet.min(trace.len()), 1.0 / trace.rate_hz);
    // Means over a fortieth of a period keep 99.6 % of the second harmonic.
    let block = ((trace.rate_hz / (40.0 * mains_hz)) as usize).max(1);
    let span = (trace.len() - quiet) / block;
    if ((span * block) as f64) * step * mains_hz < 3.0 {
        return Ok(());
    }
    let waves: Vec<Powers> = (1..=2)
        .map(|harmonic| {
            let turn = std::f64::consts::TAU * mains_hz * f64::from(harmonic) * step * block as f64;
            let mut wave = Powers::new(C64::from_polar(1.0, turn), span);
            let around = Powers::new(C64::from_polar(1.0, std::f64::consts::TAU / span as f64), span);
            for ((re, im), window) in wave.re.iter_mut().zip(&mut wave.im).zip(&around.re) {
                (*re, *im) = (*re * (1.0 - window), *im * (1.0 - window));
            }
            wave
        })
        .collect();
    for (channel, samples) in trace.channels.iter().enumerate() {
        let largest = peak(samples);
        let means: Vec<f64> =
            samples[quiet..].chunks_exact(block).map(|y| y.iter().sum::<f64>() / block as f64).collect();
        for (wave, harmonic) in waves.iter().zip([1.0, 2.0]) {
            let amplitude = 2.0 * dot(&means, &wave.re).hypot(dot(&means, &wave.im)) / span as f64;
            if amplitude > 0.2 * largest {
                let (frequency_hz, ratio) = (mains_hz * harmonic, amplitude / largest);
                return Err(Fault::LoudHum(channel.into(), frequency_hz, ratio));
            }
        }
    }
    Ok(())
}
