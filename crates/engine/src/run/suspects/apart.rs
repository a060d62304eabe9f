//! A day, or an installation, whose points lie to one side of a model that fits the others: a temperature
//! that was read or noted wrongly, a part at another place than stated, or something else that was other.
//! And days that scatter more than their points: an error that the points of a day share.

use crate::{Conditions, Observed};
use rijke_numerics::tails::{f_as_normal, student_of};
use std::collections::BTreeMap;

/// Difference from all others, over its standard error, that is said.
const APART: f64 = 6.0;

/// The same among groups that vary, as rare as a normal number beyond this.
const AMONG_FEW: f64 = 4.0;

/// The part of a frequency that it must be: 0.1 % is 0.6 K.
const LEAST: f64 = 1e-3;

/// Stated standard deviations of the ambient temperature that the frequency of a day must be, too.
const STATED: f64 = 4.0;

/// Measurements that the group, and all others together, must have.
const FEWEST: [usize; 2] = [2, 4];

/// What points have in common.
#[derive(Clone, Copy, PartialEq)]
pub(in crate::run) enum Common {
    Day,
    Installation,
}

/// A group of points that lies apart.
pub(in crate::run) struct Apart<'a> {
    common: Common,
    name: &'a str,
    points: Vec<&'a str>,
    /// Whether it lies apart in its frequencies, or else in its growth rates.
    frequencies: bool,
    /// By how much it lies higher than the others: a part of the frequency, or 1/s.
    higher: f64,
    /// The same, as a multiple of a standard error of which [`APART`] is said.
    distance: f64,
    /// Mean ambient temperature of its points, K.
    ambient: f64,
    /// Of a day, the one installation that all its points have.
    installation: Option<&'a str>,
}

/// An observation, what was measured and what the model says.
pub(in crate::run) type Held<'a> = (&'a Observed, f64, f64);

impl Common {
    fn name<'a>(self, t: &Held<'a>) -> &'a str {
        let point = &t.0.conditions.point;
        if self == Self::Day { &point.day } else { &point.installation }
    }

    /// The observations by what they have in common.
    fn groups<'a>(self, all: impl Iterator<Item = Held<'a>>) -> BTreeMap<&'a str, Vec<Held<'a>>> {
        let mut groups: BTreeMap<&str, Vec<Held<'a>>> = BTreeMap::new();
        all.for_each(|t| groups.entry(self.name(&t)).or_default().push(t));
        groups
    }

    /// What all observations have in common, if that has a name.
    fn one<'a>(self, all: &[Held<'a>]) -> Option<&'a str> {
        let name = self.name(all.first()?);
        (!name.is_empty() && all.iter().all(|t| self.name(t) == name)).then_some(name)
    }

    /// The day or installation that lies farthest apart, if any does, in its angular frequencies, or else its
    /// growth rates; `sd` is the standard deviation of what was measured. Where groups `vary` by a noise that
    /// the stage states, one is compared with the scatter of all others.
    pub(in crate::run) fn apart<'a>(
        self,
        there: &[Held<'a>],
        sd: f64,
        frequencies: bool,
        vary: bool,
    ) -> Option<Apart<'a>> {
        let mut names: Vec<&str> =
            there.iter().map(|t| self.name(t)).filter(|name| !name.is_empty()).collect();
        names.sort_unstable();
        names.dedup();
        // Frequencies are compared relative to those of the model.
        let unit = |t: &Held<'_>| if frequencies { t.2 } else { 1.0 };
        let size = there.iter().map(unit).sum::<f64>() / there.len().max(1) as f64;
        let of = |name: &&'a str| {
            let (here, others): (Vec<Held<'a>>, Vec<Held<'a>>) =
                there.iter().partition(|t| self.name(t) == *name);
            if here.len() < FEWEST[0] || others.len() < FEWEST[1] {
                return None;
            }
            let [own, all] =
                [&here, &others].map(|part| mean_and_squares(part.iter().map(|t| (t.1 - t.2) / unit(t))));
            let freedom = (there.len() - 2) as f64;
            let spread = ((own[1] + all[1]) / freedom).sqrt().max(sd / size);
            let error = spread * (1.0 / here.len() as f64 + 1.0 / others.len() as f64).sqrt();
            let mut limit = APART * error;
            if vary {
                let mean = |of: Vec<Held<'_>>| mean_and_squares(of.iter().map(|t| (t.1 - t.2) / unit(t)))[0];
                let means: Vec<f64> = self.groups(others.iter().copied()).into_values().map(mean).collect();
                if means.len() < FEWEST[1] {
                    return None;
                }
                let [_, squares] = mean_and_squares(means.iter().copied());
                // A further group about the mean of these, which tell their scatter with few degrees of
                // freedom.
                let (n, freedom) = (means.len() as f64, (means.len() - 1) as f64);
                let own = (squares / freedom * (1.0 + 1.0 / n)).sqrt();
                limit = limit.max(own * student_of(AMONG_FEW, freedom));
            }
            let mut points: Vec<&str> = here.iter().map(|t| t.0.conditions.id.as_str()).collect();
            points.dedup();
            let mean = |k: usize| here.iter().map(|t| ambient(t.0)[k]).sum::<f64>() / here.len() as f64;
            let (ambient, stated) = (mean(0), mean(1));
            let higher = own[0] - all[0];
            // An error of the temperature that is stated explains half of it in frequency.
            let least = if frequencies { LEAST.max(0.5 * STATED * stated / ambient) } else { 0.0 };
            let distance = APART * higher.abs() / limit;
            (distance > APART && higher.abs() > least).then_some(Apart {
                common: self,
                name,
                points,
                frequencies,
                higher,
                distance,
                ambient,
                installation: if self == Self::Day { Self::Installation.one(&here) } else { None },
            })
        };
        names.iter().filter_map(of).max_by(|a, b| a.distance.total_cmp(&b.distance))
    }
}

/// What a stage states that points may have in common.
#[derive(Clone, Copy)]
pub(in crate::run) struct Stated {
    /// A noise between installations.
    pub(in crate::run) installations: bool,
    /// Errors of the gas.
    pub(in crate::run) gas: bool,
}

/// Ambient temperature of a point and its standard deviation, K: where the campaign does not state it, that
/// of the gas at the first place.
fn ambient(o: &Observed) -> [f64; 2] {
    let Conditions { point, base, .. } = &*o.conditions;
    point.ambient.unwrap_or([base.temperature[0], 0.0])
}

/// By how much days scatter about the model where their points do not, in a sentence without its stop; `sd`
/// is the standard deviation of a measured frequency, rad/s. Single days of which that is said are `named`
/// and do not count.
///
/// An analysis of variance of the frequencies relative to those of the model: many days that are off hide
/// each other where each is compared with all others, and each counts as many points though it has one
/// error.
pub(in crate::run) fn scattered_days(
    there: &[Held<'_>],
    sd: f64,
    named: &[Apart<'_>],
    stated: Stated,
) -> Option<String> {
    let counts = |t: &Held<'_>| {
        !Common::Day.name(t).is_empty() && !named.iter().any(|group| group.has(&t.0.conditions.id))
    };
    let days = Common::Day.groups(there.iter().copied().filter(counts));
    let all: Vec<Held<'_>> = days.values().flatten().copied().collect();
    let (n, g) = (all.len() as f64, days.len() as f64);
    // Installations of one day each that are stated to vary make days differ.
    let installations = || days.values().all(|day| Common::Installation.one(day).is_some());
    if days.len() < 3 || n < 2.0 * g || (stated.installations && installations()) {
        return None;
    }
    let relative = |of: &[Held<'_>]| mean_and_squares(of.iter().map(|t| (t.1 - t.2) / t.2));
    let [_, total] = relative(&all);
    let within: f64 = days.values().map(|day| relative(day)[1]).sum();
    let size = all.iter().map(|t| t.2).sum::<f64>() / n;
    let noise = (within / (n - g)).max((sd / size).powi(2));
    let between = (total - within) / (g - 1.0);
    // What the days themselves scatter by: a mean over the points of a day has a share of their noise.
    let scatter = ((between - noise).max(0.0) * g / n).sqrt();
    // An error of T_amb that counts is inferred, and the frequencies are those of the gas that it makes.
    let [kelvin, known] = [0, 1].map(|k| all.iter().map(|t| ambient(t.0)[k]).sum::<f64>() / n);
    let of_ambient = 2.0 * kelvin * scatter;
    if stated.gas && of_ambient < known {
        return None;
    }
    (f_as_normal(between / noise, [g - 1.0, n - g]) > APART).then(|| {
        format!(
            "the frequencies of the {g} days scatter about the model by {:.2} % from day to day, far more than within a day. The points of a day \
             seem to share an error that is not stated, such as {:.1} K of T_amb; standard deviations of parameters count {n} independent errors \
             instead, and are too small. State T_amb_sd in campaign.csv, with base_errors = true",
            100.0 * scatter,
            of_ambient
        )
    })
}

/// Mean, and sum of the squares about it.
fn mean_and_squares(all: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    let mean = all.clone().sum::<f64>() / all.clone().count().max(1) as f64;
    [mean, all.map(|v| (v - mean).powi(2)).sum()]
}

impl Apart<'_> {
    /// Whether it is a day with the points of one installation only, which may be the cause as well.
    pub(in crate::run) fn is_one_installation(&self) -> bool {
        self.installation.is_some()
    }

    /// Whether a point is one of this group.
    pub(in crate::run) fn has(&self, id: &str) -> bool {
        self.points.contains(&id)
    }

    /// A sentence without its stop, about numbers called `what`, growth rates as `shown`; for a day with the
    /// change of temperature that would explain it.
    pub(in crate::run) fn said(&self, what: &str, shown: impl Fn(f64) -> String) -> String {
        let Self { common, name, points, frequencies, higher, ambient, installation, .. } = self;
        let group = if *common == Common::Day { "day" } else { "installation" };
        let by = if *frequencies { format!("{:.1} %", 100.0 * higher.abs()) } else { shown(higher.abs()) };
        let above = if *higher > 0.0 { "above" } else { "below" };
        let points = match &points[..] {
            [first, second, _, _, _, ..] => format!("{first}, {second}, ..."),
            few => few.join(", "),
        };
        let said = format!(
            "the {what} of {group} {name} ({points}) lie {by} {above} the model on average, measured from those of the other {group}s, far more than their scatter \
             explains: "
        );
        if *common == Common::Installation {
            return said + "check the places of the parts in that installation, and what else differed";
        }
        // Frequencies grow as the square root of the temperature.
        let kelvin = (ambient * ((1.0 + higher).powi(2) - 1.0)).abs();
        let warmer = if *higher > 0.0 { "warmer" } else { "colder" };
        // In so few digits that all models say the same.
        let digits = usize::from(kelvin < 2.0);
        let air = format!("air {kelvin:.digits$} K {warmer} than stated would explain it");
        said + &match installation {
            Some(own) => format!(
                "{air}, and so might parts at other places in {own}, the only installation of that day; check both"
            ),
            None => format!("{air}; check T_amb of that day, and what else differed"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Common, Held, student_of};
    use crate::Observed;
    use crate::run::suspects::doubts::tests::points;
    use std::sync::Arc;

    /// Student's t of two samples of one variance: three growth rates of one day against five of another.
    #[test]
    fn exact_a_day_lies_apart_by_the_t_of_two_samples() {
        let residuals = [0.3, -0.2, 0.5, -0.4, 0.1, 0.4, -0.3, 0.0];
        let points = points();
        let of_days = |(k, o): (usize, &Observed)| {
            let mut conditions = (*o.conditions).clone();
            conditions.point.day = if k < 3 { "2" } else { "1" }.to_owned();
            Observed { conditions: Arc::new(conditions), ..o.clone() }
        };
        let days: Vec<Observed> = points.iter().chain(&points).take(8).enumerate().map(of_days).collect();
        // Means 0.2 and -0.04, sums of squares about them 0.26 and 0.412.
        let error = ((0.26 + 0.412) / 6.0_f64).sqrt() * (1.0 / 3.0 + 1.0 / 5.0_f64).sqrt();
        let apart = |moved: f64, sd: f64| {
            let there: Vec<Held<'_>> =
                (0..8).map(|k| (&days[k], residuals[k] + if k < 3 { moved } else { 0.0 }, 0.0)).collect();
            Common::Day.apart(&there, sd, false, false).map(|found| (found.name.to_owned(), found.distance))
        };
        let moved = |t: f64| t * error - 0.24;
        assert_eq!(apart(moved(5.9), 0.0), None);
        let (day, distance) = apart(moved(6.1), 0.0).unwrap();
        assert!((distance - 6.1).abs() < 1e-9, "{day} {distance}");
        // By what was measured where that is more than the scatter.
        let error = 2.0 * (1.0 / 3.0 + 1.0 / 5.0_f64).sqrt();
        let distance = apart(7.0 * error - 0.24, 2.0).unwrap().1;
        assert!((distance - 7.0).abs() < 1e-9, "{distance}");
    }

    #[test]
    fn exact_installations_that_vary_are_compared_with_each_other() {
        let points = points();
        let of = |k: usize| {
            let mut conditions = (*points[0].conditions).clone();
            conditions.point.installation = (k / 2).to_string();
            Observed { conditions: Arc::new(conditions), ..points[0].clone() }
        };
        let all: Vec<Observed> = (0..10).map(of).collect();
        // Five installations of two points each, 0.1 apart; means of the others -1, 1, -1, 1 about zero.
        let distance = |first: f64, vary: bool| {
            let mean = |k: usize| [first, -1.0, 1.0, -1.0, 1.0][k / 2];
            let there: Vec<Held<'_>> =
                (0..10).map(|k| (&all[k], mean(k) + [0.05, -0.05][k % 2], 0.0)).collect();
            Common::Installation.apart(&there, 0.01, false, vary).map(|found| found.distance)
        };
        assert!(distance(4.0, false).is_none_or(|d| d < 8.0));
        // Their standard deviation is root 4/3, and a fifth one scatters about their mean by root 5/4 times
        // it.
        let limit = (5.0_f64 / 3.0).sqrt() * student_of(4.0, 3.0);
        assert_eq!(distance(0.99 * limit, true), None);
        assert!((distance(1.01 * limit, true).unwrap() - 6.06).abs() < 1e-9);
    }
}
