//! What is said and tabled of predictions.

use super::results::warn_of_ranking;
use crate::run::{AskedPoint, Averaged, Forecast, OpenModel, at_other_maxima, beyond};
use crate::{BeyondTable, SavedModel};
use rijke_numerics::words::{rounded, to_digits};
use rijke_numerics::{Failed, Tell};
use rijke_rig::files::csv_table;
use rijke_study::{Point, Study, hertz};
use std::collections::BTreeSet;

/// Predictions, and what made them.
pub struct Forecasts<'a> {
    /// The study with the points that were asked for.
    pub study: &'a Study,
    /// The model that went on from its stage.
    pub model: &'a SavedModel,
    /// The models that are open beside it.
    pub open: &'a [OpenModel],
    /// The predictions.
    pub found: &'a [Forecast],
}

impl Forecasts<'_> {
    /// Says what is doubtful. The points `held` are looked at for factors beyond what was measured, those
    /// among `axes` left out.
    pub fn tell_doubts(&self, held: &[usize], axes: &[usize], tell: &dyn Tell) {
        let Self { study, model, open, found } = *self;
        for assumed in &model.assumes {
            let search =
                if study.plan.responses.is_empty() { "; `rijke search` weighs all combinations" } else { "" };
            tell.note(format!("warning: this model depends on an undecided choice. {assumed}{search}"));
        }
        warn_of_ranking(&study.folder, &model.stage, tell);
        if model.trained_on.is_empty() {
            tell.note(
                "no mode was measured at the points of this stage. Its model is that of the earlier stages, and modes are numbered from the lowest frequency. \
                 Both standard deviations leave out the noise of a measurement, which is not known"
                    .to_owned(),
            );
        }
        if let Some([low, high]) = model.measured_hz {
            let far: Vec<&Forecast> =
                found.iter().filter(|f| !(low..=high).contains(&frequency(f))).collect();
            if let Some(first) = far.first() {
                tell.note(format!(
                    "warning: {} of {} modes lie beyond the frequencies at which a law of this model was measured, {low} to {high} Hz: it is extrapolated \
                     there; the first is at {}, {:.1} Hz",
                    far.len(),
                    found.len(),
                    first.point,
                    frequency(first)
                ));
            }
        }
        let [growth, hertz] = study.rig.search;
        let outside = |f: &&Forecast| {
            !(growth[0]..=growth[1]).contains(&f.growth_rate[0])
                || !(hertz[0]..=hertz[1]).contains(&frequency(f))
        };
        let outside: Vec<&Forecast> = found.iter().filter(outside).collect();
        if let Some(first) = outside.first() {
            tell.note(format!(
                "{} of {} modes lie outside the region that `rijke modes` searches, {} to {} 1/s and {} to {} Hz ([search] of rig.toml sets it); the \
                 first is at {}, {:.2} 1/s and {:.1} Hz",
                outside.len(),
                found.len(),
                growth[0],
                growth[1],
                hertz[0],
                hertz[1],
                first.point,
                first.growth_rate[0],
                frequency(first)
            ));
        }
        let asked: Vec<_> = found.iter().filter_map(|f| Some((f, f.beyond[0].as_ref()?))).collect();
        if let Some((first, table)) = asked.first() {
            tell.note(format!(
                "warning: {} of {} modes lie beyond a measured table, where its fit extrapolates. The first, at {}: {table}",
                asked.len(),
                found.len(),
                first.point
            ));
        }
        let lost: Vec<&Forecast> = found.iter().filter(|f| f.lost).collect();
        if let Some(first) = lost.first() {
            let mode =
                if first.mode.is_empty() { "the mode".to_owned() } else { format!("mode `{}`", first.mode) };
            tell.note(format!(
                "warning: at {} of {} points a mode could not be followed from a measured point; the row may be another mode. The first: {mode} at {}",
                how_many(lost.iter().map(|f| &f.point)),
                how_many(found.iter().map(|f| &f.point)),
                first.point
            ));
        }
        let far = beyond(study, &model.trained_on, held, axes);
        far.iter().for_each(|far| tell.note(format!("warning: {}", far.words())));
        if !open.is_empty() {
            tell.note(format!(
                "the columns averaged_... average, by probability, over this model and {} more that the evidence leaves open",
                open.len()
            ));
            if let Some(said) = at_other_maxima(model, open) {
                tell.note(format!("warning: {said}"));
            }
        }
        let growing: Vec<&Forecast> =
            found.iter().filter(|f| f.other.is_some_and(|[growth, _]| growth > 0.0)).collect();
        if let Some(first) = growing.first()
            && let Some([growth, hertz]) = first.other
        {
            let rests = |table: &BeyondTable| format!(" (by extrapolation: {table})");
            let rests = first.beyond[1].as_ref().map(rests).unwrap_or_default();
            tell.note(format!(
                "warning: at {} of {} points a mode that was not measured grows by this model: at {} one of {hertz:.1} Hz with {growth:+.2} 1/s{rests}; \
                 the column probability_of_instability does not include it",
                how_many(growing.iter().map(|f| &f.point)),
                how_many(found.iter().map(|f| &f.point)),
                first.point
            ));
        }
    }
}

/// Frequency of a predicted mode, Hz.
fn frequency(f: &Forecast) -> f64 {
    hertz(f.angular_frequency[0])
}

/// How many different points these are.
pub fn how_many<T: Ord>(points: impl Iterator<Item = T>) -> usize {
    points.collect::<BTreeSet<_>>().len()
}

/// A probability to three digits; below a billionth it is none that a model could know. Empty if it
/// is not known.
fn probability(p: f64) -> String {
    if p.is_finite() { rounded(if p < 1e-9 { 0.0 } else { p }) } else { String::new() }
}

/// Predictions as CSV, a row for each.
pub fn forecast_csv(study: &Study, found: &[Forecast]) -> Result<String, Failed> {
    let factors = study.campaign.factors.iter().map(|f| format!("{} [{}]", f.name, f.unit_in_print()));
    let numbers = "growth_rate [1/s],growth_rate_sd [1/s],growth_rate_model_sd [1/s],angular_frequency [rad/s],\
         angular_frequency_sd [rad/s],angular_frequency_model_sd [rad/s],probability_of_instability,\
         other_mode_growth_rate [1/s],other_mode_frequency [Hz]";
    let averaged = "averaged_growth_rate [1/s],averaged_growth_rate_sd [1/s],averaged_growth_rate_model_sd [1/s],\
         averaged_angular_frequency [rad/s],averaged_angular_frequency_sd [rad/s],\
         averaged_angular_frequency_model_sd [rad/s],averaged_probability_of_instability";
    let open = found.iter().any(|f| f.averaged.is_some());
    let averaged: Vec<&str> = averaged.split(',').filter(|_| open).collect();
    let several = found.iter().any(|f| !f.mode.is_empty());
    let mode = several.then(|| "mode".to_owned());
    let head = std::iter::once("point".to_owned())
        .chain(mode)
        .chain(factors)
        .chain(numbers.split(',').map(String::from))
        .chain(averaged.iter().map(|n| (*n).to_owned()));
    let row = |f: &Forecast| {
        let factors = f.factors.iter().map(|v| v.map_or(String::new(), |v| v.to_string()));
        let numbers = f.growth_rate.iter().chain(&f.angular_frequency).map(|v| format!("{v:.6}"));
        let mode = several.then(|| f.mode.clone());
        let row = std::iter::once(f.point.clone()).chain(mode).chain(factors).chain(numbers);
        let other = [0, 1].map(|k| f.other.map_or(String::new(), |o| format!("{:.6}", o[k])));
        let cell = |v: &f64| if v.is_finite() { format!("{v:.6}") } else { String::new() };
        let over = |a: &Averaged| {
            let numbers = a.growth_rate.iter().chain(&a.angular_frequency).map(cell);
            numbers.chain([probability(a.unstable)]).collect()
        };
        let averaged = f.averaged.as_ref().map_or_else(|| vec![String::new(); averaged.len()], over);
        row.chain([probability(f.unstable)]).chain(other).chain(averaged).collect()
    };
    csv_table(std::iter::once(head.collect()).chain(found.iter().map(row)))
}

/// Where the ambient temperature of a condition and its error come from, as far as its words do not say it;
/// `nearest` is the point of which it has all that it does not say.
pub fn surroundings(asked: &AskedPoint, point: &Point, nearest: &str) -> Option<String> {
    let [kelvin, sd] = point.ambient?;
    let given = |name: &str| asked.values.contains_key(name);
    let temperature = match (given("T_amb"), &asked.day) {
        (true, _) => None,
        (false, None) => Some(format!("as at {nearest}, the nearest point")),
        (false, Some(day)) => Some(format!("as at {nearest}, the nearest point of day {day}")),
    };
    let error = match (given("T_amb_sd"), &asked.day) {
        (true, _) => None,
        (false, None) => {
            Some("the campaign's standard deviation and an error independent of other points".to_owned())
        }
        (false, Some(day)) => Some(format!("the error of day {day}")),
    };
    let from: Vec<String> = [temperature, error].into_iter().flatten().collect();
    let missing: Vec<&str> = ["T_amb", "T_amb_sd"].into_iter().filter(|name| !given(name)).collect();
    (!from.is_empty()).then(|| {
        let (from, missing) = (from.join(", with "), missing.join(" and "));
        format!("T_amb = {} +- {sd} K: {from}; give {missing} in --at for another", to_digits(kelvin, 7))
    })
}
