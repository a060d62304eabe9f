//! States of operating points that were not measured, by an inference that has made those of others: which
//! points lack one, what they are in the words of the records, and whether what is inferred today is what the
//! folder has.

use crate::base::PointState;
use crate::cause::Cause;
use crate::plan::Base;
use crate::{Campaign, Point, Study};
use rijke_rig::{Day, Observations, PointObservations};
use std::collections::BTreeMap;

/// Standard deviations of the mass flow up to which two fits of the same flow are the same: each ends a
/// seventieth of one from the most probable flow at the latest.
const SAME: f64 = 0.05;
/// Kelvin and share of the mass flow that weigh alike where changes of states are compared.
const KELVIN: f64 = 300.0;
/// Share of all changes, root of the sum of squares, by which two lists of the same causes may differ.
const CAUSES: f64 = 0.05;

/// States by the names of their points.
pub type States = BTreeMap<String, PointState>;

/// Why a state cannot be foreseen.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unforeseen {
    /// A factor that the flow knows, and the campaign does not.
    #[error("{file} has no factor `{name}`; to predict the flow elsewhere, give the factor this name")]
    Factor {
        /// The file of the campaign.
        file: String,
        /// The factor.
        name: String,
    },
    /// No point with power was measured, or the campaign and the observations have other values of a factor.
    #[error(
        "no measured point has `{place}` and `{power}` as {file} says; to predict the flow elsewhere, correct one of the two"
    )]
    Unlike {
        /// The file of the campaign.
        file: String,
        /// The factor that is the place.
        place: String,
        /// The factor that is the power.
        power: String,
    },
    /// No measured point differs in place and power alone.
    #[error(
        "{point}: the flow is predicted at other {place} and {power}, but no measured point has this `{other}`"
    )]
    Like {
        /// The point.
        point: String,
        /// The factor that is the place.
        place: String,
        /// The factor that is the power.
        power: String,
        /// The factor that no measured point has so.
        other: String,
    },
}

impl Study {
    /// The points among `places` of the campaign whose state must be inferred and is not `known`.
    #[must_use]
    pub fn lacking(&self, places: &[usize], known: &States) -> Vec<&Point> {
        let Base::States(due) = &self.plan.base else { return Vec::new() };
        let all = places.iter().map(|k| &self.campaign.points[*k]);
        all.filter(|p| due.holds(&self.campaign, p) && !known.contains_key(&p.id)).collect()
    }

    /// Takes the states of `lacking` points from `found`, with the signs that errors have in the `known`
    /// ones; false if `found` is another inference than that of `known`.
    #[must_use]
    pub fn foresee(&mut self, lacking: &[String], known: &States, mut found: States) -> bool {
        let Some(signs) = signs(known, &found) else { return false };
        for id in lacking {
            if let Some(mut state) = found.remove(id) {
                let turned = state.errors.iter_mut().filter(|e| signs.get(&e.cause) == Some(&false));
                turned.for_each(|error| {
                    error.mass_flow = -error.mass_flow;
                    error.numbers.iter_mut().chain(&mut error.temperature).for_each(|v| *v = -*v);
                });
                self.foreseen.insert(id.clone(), state);
            }
        }
        true
    }
}

/// For every cause whether it has the same sign in both; none if the states or the causes are not the same.
fn signs(known: &States, found: &States) -> Option<BTreeMap<Cause, bool>> {
    // Of every cause the squares of both changes, and their product.
    let mut sums: BTreeMap<Cause, [f64; 3]> = BTreeMap::new();
    for (id, old) in known {
        let new = found.get(id)?;
        let sd = old.errors.iter().map(|e| e.mass_flow.powi(2)).sum::<f64>().sqrt();
        if old.places.len() != new.places.len() || (old.mass_flow - new.mass_flow).abs() > SAME * sd {
            return None;
        }
        for error in &old.errors {
            let same = new.errors.iter().find(|e| e.cause == error.cause)?;
            let sum = sums.entry(error.cause.clone()).or_default();
            let kelvins =
                error.temperature.iter().zip(&same.temperature).map(|(a, b)| [a / KELVIN, b / KELVIN]);
            let flow = [error.mass_flow / old.mass_flow, same.mass_flow / old.mass_flow];
            for [a, b] in kelvins.chain([flow]) {
                *sum = [sum[0] + a * a, sum[1] + b * b, sum[2] + a * b];
            }
        }
    }
    let all: f64 = sums.values().map(|s| s[0]).sum();
    let apart: f64 = sums.values().map(|s| s[0] + s[1] - 2.0 * s[2].abs()).sum();
    (apart <= CAUSES.powi(2) * all).then(|| sums.into_iter().map(|(cause, s)| (cause, s[2] > 0.0)).collect())
}

impl Campaign {
    /// Points at which nothing was measured, in the words of the records: like the nearest measured point
    /// that differs in the factors `place` and `power` of the heat alone.
    ///
    /// # Errors
    /// [`Unforeseen`].
    pub fn unmeasured(
        &self,
        points: &[&Point],
        observations: &Observations,
        place: &str,
        power: &str,
    ) -> Result<Vec<PointObservations>, Unforeseen> {
        let measured = Measured::of(self, observations, place, power)?;
        points.iter().map(|point| measured.planned(point)).collect()
    }
}

/// Measured points in the words of the study and of the records.
struct Measured<'a> {
    campaign: &'a Campaign,
    pairs: Vec<(&'a Point, &'a PointObservations)>,
    /// The factors that are the place of the heat and its power.
    place: usize,
    power: usize,
}

impl<'a> Measured<'a> {
    fn of(
        campaign: &'a Campaign,
        observations: &'a Observations,
        place: &str,
        power: &str,
    ) -> Result<Self, Unforeseen> {
        let file = || campaign.file.clone();
        let factor = |name: &str| {
            let lacking = || Unforeseen::Factor { file: file(), name: name.to_owned() };
            campaign.factor(name).ok_or_else(lacking)
        };
        let [at, heat] = [factor(place)?, factor(power)?];
        let hot = observations.points.iter().filter(|o| o.point.factor(power).is_some_and(|p| p > 0.0));
        let pairs: Vec<_> = hot.filter_map(|o| Some((campaign.point(&o.point.id)?.1, o))).collect();
        let same = |(p, o): &(&Point, &PointObservations)| {
            [(at, place), (heat, power)].iter().all(|(k, name)| {
                o.point.factor(name).is_some_and(|v| (p.factors[*k] - v).abs() <= 1e-9 * v.abs())
            })
        };
        if pairs.is_empty() || !pairs.iter().all(same) {
            return Err(Unforeseen::Unlike { file: file(), place: place.into(), power: power.into() });
        }
        Ok(Self { campaign, pairs, place: at, power: heat })
    }

    /// A point as one of the records at which nothing was measured.
    fn planned(&self, point: &Point) -> Result<PointObservations, Unforeseen> {
        let differs = |p: &Point| {
            let of = |k: &usize| {
                let (a, b) = (p.factors[*k], point.factors[*k]);
                *k != self.place && *k != self.power && a != b && !(a.is_nan() && b.is_nan())
            };
            (0..self.campaign.factors.len()).find(of)
        };
        let near = |p: &Point| (p.factors[self.place] - point.factors[self.place]).abs();
        let like = self
            .pairs
            .iter()
            .filter(|(p, _)| differs(p).is_none())
            .min_by(|a, b| near(a.0).total_cmp(&near(b.0)));
        let Some((_, like)) = like else {
            let name = |k: usize| self.campaign.factors[k].name.clone();
            let other = self.pairs.first().and_then(|(p, _)| differs(p));
            return Err(Unforeseen::Like {
                point: point.id.clone(),
                place: name(self.place),
                power: name(self.power),
                other: other.map_or("a factor".to_owned(), name),
            });
        };
        let mut ambient = like.ambient.clone();
        if let Some([kelvin, sd]) = point.ambient
            && kelvin != ambient.ambient_temperature
        {
            ambient = Day { id: point.id.clone(), ambient_temperature: kelvin, ambient_temperature_sd: sd };
        }
        let mut planned = like.point.clone();
        planned.id.clone_from(&point.id);
        for k in [self.place, self.power] {
            if let Some(factor) = planned.factors.get_mut(&self.campaign.factors[k].name) {
                factor.value = point.factors[k];
            }
        }
        Ok(PointObservations::unmeasured(planned, ambient))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::BaseError;
    use crate::rig::GasModel;
    use crate::source::Source;

    fn state(mass_flow: f64, kelvin: f64) -> PointState {
        let error = |cause: &str, mass_flow: f64, kelvin: f64| BaseError {
            cause: Cause::Inferred(cause.into()),
            mass_flow,
            numbers: vec![mass_flow],
            temperature: vec![0.0, kelvin],
        };
        PointState {
            gas: GasModel::Perfect { gamma: 1.4, constant: 287.0, viscosity: [1.8e-5, 300.0], prandtl: 0.7 },
            other_gases: Vec::new(),
            pressure: 1e5,
            mass_flow,
            numbers: vec![(30, 0.5)],
            places: vec![0.0, 1.0],
            temperature: vec![300.0, 400.0],
            kinks: Vec::new(),
            errors: vec![error("a", 1e-5, kelvin), error("b", 2e-5, -1.0)],
            moved: Vec::new(),
        }
    }

    #[test]
    fn exact_causes_that_another_fit_turned_are_known_by_their_sign() {
        let known = States::from([("p".to_owned(), state(1e-3, 4.0))]);
        let mut turned = state(1e-3, 4.0);
        turned.errors[1].mass_flow *= -1.0;
        turned.errors[1].temperature[1] *= -1.0;
        let found = signs(&known, &States::from([("p".to_owned(), turned)])).unwrap();
        assert_eq!(found.values().copied().collect::<Vec<_>>(), [true, false]);
        let refused = |other: PointState| signs(&known, &States::from([("p".to_owned(), other)])).is_none();
        assert!(refused(state(1.01e-3, 4.0)), "another flow");
        assert!(refused(state(1e-3, 5.0)), "another error");
        assert!(refused(PointState { errors: Vec::new(), ..state(1e-3, 4.0) }), "another list of causes");
        assert!(signs(&known, &States::new()).is_none());
    }

    #[test]
    fn exact_a_planned_point_is_like_the_nearest_that_differs_in_place_and_power_alone() {
        let text = "point,x [mm],Q [W],load\na,200,60,1\nb,400,60,1\nc,250,90,1\nd,250,90,2\n";
        let source = |text: &str| Source { file: "campaign.csv".into(), text: text.to_owned() };
        let campaign = Campaign::parse(&source(text)).unwrap();
        let day = Day { id: "one".into(), ambient_temperature: 293.0, ambient_temperature_sd: 0.1 };
        let all = campaign.operating_points();
        let rig = include_str!("../../rig/data/rig.toml");
        let mut observations = Observations {
            rig: rijke_rig::Apparatus::parse(rig, std::path::Path::new("rig.toml")).unwrap(),
            kind: rijke_rig::DataKind::Measured,
            source: String::new(),
            points: all[..2].iter().map(|p| PointObservations::unmeasured(p.clone(), day.clone())).collect(),
            rejections: Vec::new(),
            channels: None,
        };
        let [c, d] = [&campaign.points[2], &campaign.points[3]];
        let asked = campaign.unmeasured(&[c], &observations, "x", "Q").unwrap();
        assert_eq!((asked.len(), &asked[0].point), (1, &all[2]));
        let said = |points: &[&Point], observations: &Observations, power: &str| {
            campaign.unmeasured(points, observations, "x", power).unwrap_err().to_string()
        };
        let like = said(&[d], &observations, "Q");
        assert!(
            like.starts_with("d: the flow is predicted at other x and Q") && like.contains("`load`"),
            "{like}"
        );
        let name = said(&[c], &observations, "Q_h");
        assert!(name.starts_with("campaign.csv has no factor `Q_h`"), "{name}");
        observations.points[0].point.factors.get_mut("Q").unwrap().value = 61.0;
        let other = said(&[c], &observations, "Q");
        assert!(other.contains("as campaign.csv says; to predict the flow elsewhere"), "{other}");
    }
}
