//! Where a model repeats itself: from one maximum, the places of others.

use super::alias::{Alias, Move};
use super::parameters::Parameters;
use crate::error::InferenceError;

/// Images further from the prior than this are left out: the drop in its ln density against that of the first
/// point, nats (8 sd).
const REACH: f64 = 32.0;
/// Most images of a point.
const MOST: usize = 256;
/// Images closer than this are one, in units of the prior's scale.
const SAME: f64 = 1e-6;

/// The places to which the aliases of a model lead from one point.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Images {
    /// Each with the ln density of the prior there less that at the point, nats; highest first.
    pub(crate) list: Vec<(Vec<f64>, f64)>,
    /// The same of the highest of those that were not formed because there are too many.
    pub(crate) rest: Option<f64>,
}

impl Parameters {
    /// Says where the model repeats itself, so that the other maxima are looked for.
    ///
    /// # Errors
    /// [`InferenceError::BadName`] for an unknown name, [`InferenceError::BadAlias`] for a step of zero or no
    /// number.
    pub fn with_alias(mut self, alias: Alias) -> Result<Self, InferenceError> {
        alias.validate(&self)?;
        self.aliases.push(alias);
        Ok(self)
    }

    /// The points that one alias leads to from physical `values`.
    fn neighbours(&self, values: &[f64]) -> Vec<Vec<f64>> {
        let both = self.aliases.iter().flat_map(|a| [1.0, -1.0].map(|sign| a.moved(self, values, sign)));
        both.flatten().collect()
    }

    /// The images of a point under all aliases and `more` of them, as far as the prior reaches; without the
    /// point itself. The one with the highest prior is always the next whose own images are formed, so that
    /// they grow outward from the centre of the prior wherever the point lies.
    pub(crate) fn images(&self, values: &[f64], more: impl Fn(&[f64]) -> Vec<Vec<f64>>) -> Images {
        let density = |a: &[f64]| self.ln_density(&self.working(a)).ok().map(|d| d.value);
        let Some(first) = density(values) else { return Images::default() };
        let scales = self.scales();
        let near = |a: &[f64], b: &[f64]| {
            let scaled = |(i, (a, b)): (usize, (&f64, &f64))| {
                let slope = self.list()[i].physical(self.list()[i].working(*b))[1].abs();
                let scale = scales[i] * slope;
                (a - b).abs()
                    <= SAME * if scale.is_finite() && scale > 0.0 { scale } else { b.abs().max(1.0) }
            };
            a.iter().zip(b).enumerate().all(scaled)
        };
        let (mut found, mut waiting) = (Vec::new(), vec![(values.to_vec(), 0.0)]);
        loop {
            let highest = (0..waiting.len()).reduce(|a, b| if waiting[b].1 > waiting[a].1 { b } else { a });
            let Some(highest) = highest.filter(|_| found.len() <= MOST) else { break };
            let next: (Vec<f64>, f64) = waiting.remove(highest);
            let around = self.neighbours(&next.0).into_iter().chain(more(&next.0));
            found.push(next);
            for image in around.filter(|image| image.len() == values.len()) {
                let above = density(&image).map_or(f64::NEG_INFINITY, |d| d - first);
                let known = |all: &[(Vec<f64>, f64)]| all.iter().any(|(a, _)| near(a, &image));
                if above.is_finite() && above > -REACH && !known(&found) && !known(&waiting) {
                    waiting.push((image, above));
                }
            }
        }
        // The point itself came first.
        found.remove(0);
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        Images { list: found, rest: waiting.iter().map(|(_, above)| *above).reduce(f64::max) }
    }
}

impl Alias {
    /// Fails for an unknown name, a step that is zero or not a number, a mirror that is not a number.
    fn validate(&self, parameters: &Parameters) -> Result<(), InferenceError> {
        for change in &self.moves {
            let (names, number, step) = match change {
                Move::Shift { parameter, by } => (vec![parameter], *by, true),
                Move::Mirror { parameter, about } => (vec![parameter], *about, false),
                Move::Exchange { parameter, with } => (vec![parameter, with], 1.0, false),
            };
            for name in names {
                parameters.place(name)?;
            }
            if !number.is_finite() || (step && number == 0.0) {
                let parameter = parameters.list()[parameters.place(name_of(change))?].name.clone();
                return Err(InferenceError::BadAlias { parameter, value: number });
            }
        }
        Ok(())
    }

    /// The point after all moves, shifts made `sign` times.
    fn moved(&self, parameters: &Parameters, values: &[f64], sign: f64) -> Option<Vec<f64>> {
        let mut out = values.to_vec();
        for change in &self.moves {
            match change {
                Move::Shift { parameter, by } => out[parameters.index(parameter)?] += sign * by,
                Move::Mirror { parameter, about } => {
                    let i = parameters.index(parameter)?;
                    out[i] = 2.0 * about - out[i];
                }
                Move::Exchange { parameter, with } => {
                    out.swap(parameters.index(parameter)?, parameters.index(with)?);
                }
            }
        }
        Some(out)
    }
}

fn name_of(change: &Move) -> &str {
    match change {
        Move::Shift { parameter, .. } | Move::Mirror { parameter, .. } | Move::Exchange { parameter, .. } => {
            parameter
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Parameter, Prior};

    fn delay() -> Parameters {
        let tau = Parameter::new("tau", "tau", "s", Prior::Uniform { low: 0.0, high: 0.02 });
        let gain = Parameter::new("gain", "n", "1", Prior::Normal { mean: 0.0, sd: 1.0 });
        Parameters::new(vec![tau, gain]).unwrap()
    }

    #[test]
    fn exact_images_of_a_delay_fill_the_prior() {
        let parameters = delay().with_alias(Alias::period("tau", 0.006)).unwrap();
        let mut taus: Vec<f64> =
            parameters.images(&[0.004, 0.5], |_| Vec::new()).list.iter().map(|(a, _)| a[0]).collect();
        taus.sort_by(f64::total_cmp);
        assert_eq!(taus.len(), 2);
        assert!((taus[0] - 0.010).abs() < 1e-12 && (taus[1] - 0.016).abs() < 1e-12, "{taus:?}");
    }

    #[test]
    fn exact_half_a_period_changes_the_sign_and_an_exchange_ends() {
        let half = Alias::period("tau", 0.003).and(Alias::mirror("gain", 0.0));
        let parameters = delay().with_alias(half).unwrap();
        let images = parameters.images(&[0.004, 0.5], |_| Vec::new()).list;
        assert_eq!(images.len(), 6);
        for (image, _) in images {
            let halves = ((image[0] - 0.004) / 0.003).round();
            let sign = if halves.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
            assert!((image[1] - 0.5 * sign).abs() < 1e-12, "{image:?}");
        }
        let two =
            (0..2).map(|i| Parameter::new(format!("a{i}"), "a", "1", Prior::Normal { mean: 0.0, sd: 1.0 }));
        let two = Parameters::new(two.collect()).unwrap().with_alias(Alias::exchange("a0", "a1")).unwrap();
        assert_eq!(two.images(&[0.3, -0.2], |_| Vec::new()).list, [(vec![-0.2, 0.3], 0.0)]);
    }

    #[test]
    fn exact_images_grow_outward_from_the_centre_of_the_prior() {
        let tau = Parameter::new("tau", "tau", "s", Prior::Normal { mean: 0.0, sd: 1.0 });
        let parameters =
            |by| Parameters::new(vec![tau.clone()]).unwrap().with_alias(Alias::period("tau", by)).unwrap();
        // From a point 3.1 standard deviations away all within 3.1 on the other side come before those
        // beyond it.
        let images = parameters(0.02).images(&[3.1], |_| Vec::new());
        assert!(images.rest.is_some() && images.list.len() == MOST, "{}", images.list.len());
        let highest = images.list.iter().map(|(a, _)| a[0].abs()).fold(f64::INFINITY, f64::min);
        assert!(highest < 0.0101, "{highest}");
        assert!(images.list.iter().all(|(a, _)| a[0] < 3.1 && a[0] > -2.2), "{:?}", images.list.last());
        let few = parameters(1.0).images(&[0.25], |_| Vec::new());
        assert!(few.rest.is_none());
        for (a, above) in few.list {
            assert!((above + 0.5 * (a[0] * a[0] - 0.0625)).abs() < 1e-12, "{a:?} {above}");
        }
    }

    #[test]
    fn message_an_alias_without_a_step_names_its_parameter() {
        let error = delay().with_alias(Alias::period("tau", 0.0)).unwrap_err();
        assert!(
            matches!(&error, InferenceError::BadAlias { parameter, .. } if parameter == "tau"),
            "{error}"
        );
        assert!(
            delay()
                .with_alias(Alias::period("lag", 1.0))
                .unwrap_err()
                .to_string()
                .contains("known: tau, gain")
        );
    }
}
