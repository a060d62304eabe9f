//! Decay rate, frequency and mode shape of one ring-down, with covariance and verdict.

use super::beating::last_beats;
use super::diagnosis;
use super::driven;
use super::found::PingFit;
use super::from_start::{Start, fit_whitened};
use super::heard::{Heard, beside_a_tone};
use super::learnt::{noise_heard, noise_without_silence};
use super::lost::lost;
use super::options::PingOptions;
use super::resolution;
use super::silence::{self, MIN_QUIET};
use super::whitened::{Noise, Whitened};
use crate::dsp::noise::Whitener;
use crate::{Fault, Mishap, Trace};

/// Fits one ring-down by maximum likelihood.
///
/// The record holds an optional quiet part (noise alone), optional steady forcing near the mode, and the free
/// decay; the end of forcing is found from the record. The mode is sought in [`PingOptions::band_hz`]; the
/// default, 80 to 300 Hz, is that of a metre of tube. Equal samples to the end of the record in all channels
/// are cut off, and a constant offset of a channel is taken away first.
/// All channels share every complex frequency; each channel has its own complex amplitudes. Noise is whitened
/// with its colour and correlation between channels as learnt from the quiet part (Gaussian, stationary: hum
/// is fitted apart). The covariance is the inverse Fisher information, scaled with the residual variance.
/// Cost: see `benches/records.rs`.
///
/// # Errors
/// A [`Fault`] that says why the record must not be used.
pub fn fit_ping(trace: &Trace<'_>, options: &PingOptions) -> Result<PingFit, Fault> {
    let cut: Option<Vec<Vec<f64>>> =
        trace.padded_from().map(|end| trace.channels.iter().map(|y| y[..end].to_vec()).collect());
    let trace = &Trace { channels: cut.as_deref().unwrap_or(trace.channels), ..*trace };
    trace.screen(512)?;
    options.check(trace)?;
    let steps = trace.coarse_steps();
    let levelled = trace.levelled(MIN_QUIET);
    let trace = &Trace { channels: levelled.as_deref().unwrap_or(trace.channels), ..*trace };
    let quiet = trace.quiet.min(trace.len());
    silence::check(trace, quiet)?;
    let deviations = if quiet >= MIN_QUIET { resolution::deviations(trace, &steps, quiet)? } else { None };
    let least = if deviations.is_some() { resolution::LEAST } else { 0.0 };
    let noise = if let Some(deviations) = deviations {
        Noise::of(Whitener::scaling(&deviations), Vec::new())
    } else if quiet >= MIN_QUIET {
        noise_heard(trace, options, Heard::of(trace, options, quiet))?
    } else {
        noise_without_silence(trace, options)?
    };
    let tones = noise.tones.clone();
    let fit = |noise: &Noise| judged_fit(trace, options, noise, least);
    let found = match fit(&noise) {
        // The pressure may wander slowly, by more than the quiet part shows.
        Err(fault) if diagnosis::is_doubtful(&fault) || matches!(fault, Fault::Weak(_)) => {
            let steady = |hz| noise.whitener.without_wander(hz, trace.rate_hz);
            let steady = diagnosis::loudest(trace, options).map(steady);
            steady.and_then(|whitener| fit(&Noise { whitener, ..noise }).ok()).ok_or(fault)
        }
        found => found,
    };
    found.map_err(|fault| {
        let (band, mains) = (options.band_hz, options.mains_hz);
        let doubtful = diagnosis::is_doubtful(&fault);
        let nothing = doubtful || matches!(fault, Fault::Weak(_));
        let fault = driven::outside(trace, band, mains, &fault)
            .or_else(|| doubtful.then(|| driven::elsewhere(trace, band, mains)).flatten())
            .or_else(|| nothing.then(|| driven::rings_above(trace, band, mains)).flatten())
            .unwrap_or_else(|| diagnosis::reason(trace, options, fault));
        let fault = driven::or_all_the_time(trace, fault);
        let silence_s = quiet as f64 / trace.rate_hz;
        beside_a_tone(fault, &tones, (diagnosis::loudest(trace, options), silence_s))
    })
}

/// The fit from the end of the plateau, or, if that is doubtful or fails, from the last decay.
fn judged_fit(trace: &Trace<'_>, options: &PingOptions, noise: &Noise, least: f64) -> Result<PingFit, Fault> {
    let record = Whitened::of(trace, options, noise)?;
    let fit = |start: Start<'_>| fit_whitened(trace, options, &record, least, start);
    let plateau = fit(Start::Plateau);
    let doubtful = plateau.as_ref().is_ok_and(|fit| fit.doubtful);
    let backwards = || fit(Start::Backwards)?.judged(options);
    let missing = || {
        let order = noise.whitener.order();
        let begin = (trace.quiet.min(trace.len()) + order) as f64 / trace.rate_hz;
        lost(&record.search(options), record.white(), &record.envelope, begin, order)
    };
    let beats = || {
        let (decay, hertz) = last_beats(&record.search(options), record.white(), &record.envelope)?;
        let fitted =
            decay.and_then(|decay| fit(Start::Found(&decay)).and_then(|fit| fit.judged(options)).ok());
        Some(fitted.ok_or(Mishap::Beat { hertz }.into()))
    };
    match plateau.and_then(|fit| fit.judged(options)) {
        // A later start is right if the forcing went on, and not if two modes decay all the while.
        Ok(found) if doubtful => match backwards() {
            Ok(later) if later.skipped_s == 0.0 => Ok(later),
            _ => Ok(found),
        },
        // Louder noise is louder wherever the decay begins.
        Err(fault) if diagnosis::is_doubtful(&fault) && !matches!(fault, Fault::Mishap(_)) => {
            if let Some(mishap) = missing() {
                return Err(mishap.into());
            }
            match backwards() {
                // A decay that was found, and in which the channels differ, says more.
                Err(apart @ (Fault::GainDrifts { .. } | Fault::GainsApart { .. })) => Err(apart),
                Ok(found) => Ok(found),
                Err(_) => beats().unwrap_or(Err(fault)),
            }
        }
        // What lost samples explain is no other jump.
        Err(fault @ Fault::Mishap(Mishap::Jumps { .. })) => Err(missing().map_or(fault, Into::into)),
        result => result,
    }
}
