//! A day whose frequencies lie to one side of a model that fits the other days: its temperature was read or
//! noted wrongly, or something else was other.

use crate::{Conditions, Observed};

/// Difference of a day from all others, over its standard error, that is said, and the part of the frequency
/// that it must be: 0.1 % is 0.6 K.
const APART: f64 = 6.0;
const LEAST: f64 = 1e-3;

/// Stated standard deviations of the ambient temperature that it must be, too.
const STATED: f64 = 4.0;

/// Measurements that a day, and all others together, must have.
const FEWEST: [usize; 2] = [2, 4];

/// A day that lies apart.
pub(super) struct Apart<'a> {
    day: &'a str,
    points: Vec<&'a str>,
    /// Part of the frequency by which it lies higher than the other days.
    higher: f64,
    /// The same over its standard error.
    distance: f64,
    /// Mean ambient temperature of its points, K.
    ambient: f64,
}

/// An observation, what was measured and what the model says.
pub(super) type Held<'a> = (&'a Observed, f64, f64);

/// The day that lies farthest apart, if any does, in its angular frequencies; `sd` is the standard deviation
/// of what was measured.
pub(super) fn day_apart<'a>(there: &[Held<'a>], sd: f64) -> Option<Apart<'a>> {
    let day = |t: &Held<'a>| t.0.conditions.point.day.as_str();
    let mut days: Vec<&str> = there.iter().map(day).filter(|day| !day.is_empty()).collect();
    days.sort_unstable();
    days.dedup();
    let size = there.iter().map(|t| t.2).sum::<f64>() / there.len().max(1) as f64;
    let of = |name: &&'a str| {
        let (here, others): (Vec<Held<'a>>, Vec<Held<'a>>) = there.iter().partition(|t| day(t) == *name);
        if here.len() < FEWEST[0] || others.len() < FEWEST[1] {
            return None;
        }
        let [own, all] = [&here, &others]
            .map(|part| mean_and_squares(part.iter().map(|(_, measured, model)| (measured - model) / model)));
        let freedom = (there.len() - 2) as f64;
        let spread = ((own[1] + all[1]) / freedom).sqrt().max(sd / size);
        let error = spread * (1.0 / here.len() as f64 + 1.0 / others.len() as f64).sqrt();
        let mut points: Vec<&str> = here.iter().map(|t| t.0.conditions.id.as_str()).collect();
        points.dedup();
        let mean = |k: usize| here.iter().map(|t| ambient(t.0)[k]).sum::<f64>() / here.len() as f64;
        let (ambient, stated) = (mean(0), mean(1));
        let higher = own[0] - all[0];
        // An error of the temperature that is stated explains half of it in frequency.
        let least = LEAST.max(0.5 * STATED * stated / ambient);
        let distance = higher.abs() / error;
        (distance > APART && higher.abs() > least).then_some(Apart {
            day: name,
            points,
            higher,
            distance,
            ambient,
        })
    };
    days.iter().filter_map(of).max_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Ambient temperature of a point and its standard deviation, K: where the campaign does not state it, that
/// of the gas at the first place.
fn ambient(o: &Observed) -> [f64; 2] {
    let Conditions { point, base, .. } = &*o.conditions;
    point.ambient.unwrap_or([base.temperature[0], 0.0])
}

/// Mean, and sum of the squares about it.
fn mean_and_squares(all: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let mean = all.clone().sum::<f64>() / all.clone().count().max(1) as f64;
    [mean, all.map(|v| (v - mean).powi(2)).sum()]
}

impl Apart<'_> {
    /// Whether a point is one of this day.
    pub(super) fn has(&self, id: &str) -> bool {
        self.points.contains(&id)
    }

    /// A sentence without its stop, with the change of temperature that would explain it.
    pub(super) fn said(&self) -> String {
        let Self { day, points, higher, ambient, .. } = self;
        // Frequencies grow as the square root of the temperature.
        let kelvin = (ambient * ((1.0 + higher).powi(2) - 1.0)).abs();
        let (above, warmer) = if *higher > 0.0 { ("above", "warmer") } else { ("below", "colder") };
        // In so few digits that all models say the same.
        let digits = usize::from(kelvin < 2.0);
        format!(
            "the frequencies of day {day} ({}) lie {:.1} % {above} the model on average, measured from those of the other days, far more than their scatter \
             explains: air {kelvin:.digits$} K {warmer} than stated would explain it; check T_amb of that day, and what else differed",
            if points.len() > 4 { format!("{}, {}, ...", points[0], points[1]) } else { points.join(", ") },
            100.0 * higher.abs(),
        )
    }
}
