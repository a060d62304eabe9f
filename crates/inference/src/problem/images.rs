//! Where a model repeats itself: from one maximum, the places of others.

use super::alias::{Alias, Move};
use super::parameters::Parameters;
use crate::error::InferenceError;

/// Images further from the prior than this are left out: the drop in its ln density against that of the first
/// point, nats (8 sd).
const REACH: f64 = 32.0;
/// Most images of a point.
const MOST: usize = 64;
/// Images closer than this are one, in units of the prior's scale.
const SAME: f64 = 1e-6;

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

    /// The images of a point under all aliases and `more` of them, nearest first, as far as the prior
    /// reaches; without the point itself.
    pub(crate) fn images(&self, values: &[f64], more: impl Fn(&[f64]) -> Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        let density = |a: &[f64]| self.ln_density(&self.working(a)).ok().map(|d| d.value);
        let Some(first) = density(values) else { return Vec::new() };
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
        let mut found = vec![values.to_vec()];
        let mut next = 0;
        while next < found.len() && found.len() <= MOST {
            let at = found[next].clone();
            for image in self.neighbours(&at).into_iter().chain(more(&at)) {
                let within = image.len() == values.len()
                    && density(&image).is_some_and(|d| d.is_finite() && d > first - REACH);
                if within && !found.iter().any(|f| near(f, &image)) {
                    found.push(image);
                }
            }
            next += 1;
        }
        found.remove(0);
        found.truncate(MOST);
        found
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
            parameters.images(&[0.004, 0.5], |_| Vec::new()).iter().map(|a| a[0]).collect();
        taus.sort_by(f64::total_cmp);
        assert_eq!(taus.len(), 2);
        assert!((taus[0] - 0.010).abs() < 1e-12 && (taus[1] - 0.016).abs() < 1e-12, "{taus:?}");
    }

    #[test]
    fn exact_half_a_period_changes_the_sign_and_an_exchange_ends() {
        let half = Alias::period("tau", 0.003).and(Alias::mirror("gain", 0.0));
        let parameters = delay().with_alias(half).unwrap();
        let images = parameters.images(&[0.004, 0.5], |_| Vec::new());
        assert_eq!(images.len(), 6);
        for image in images {
            let halves = ((image[0] - 0.004) / 0.003).round();
            let sign = if halves.rem_euclid(2.0) == 0.0 { 1.0 } else { -1.0 };
            assert!((image[1] - 0.5 * sign).abs() < 1e-12, "{image:?}");
        }
        let two =
            (0..2).map(|i| Parameter::new(format!("a{i}"), "a", "1", Prior::Normal { mean: 0.0, sd: 1.0 }));
        let two = Parameters::new(two.collect()).unwrap().with_alias(Alias::exchange("a0", "a1")).unwrap();
        assert_eq!(two.images(&[0.3, -0.2], |_| Vec::new()), [[-0.2, 0.3]]);
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
