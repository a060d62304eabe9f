//! Whether the model describes the data, and whether its intervals are as wide as they must be.

use super::health::{ChiSquared, Health};
use crate::error::InferenceError;
use crate::evidence::Laplace;
use crate::fit::{Fit, Posterior};
use crate::linearised::Few;
use crate::numbers::chi_squared_sds;

/// Standard deviations beyond which chi-squared says that a model misses its data: those of a conflict with
/// the prior.
const MISSED: f64 = 4.0;
/// The factor on a standard deviation from which a warning says that it is too small.
const WIDER: f64 = 1.1;
/// More data than this are not few, and the matrices that say so are large.
const MOST: usize = 2000;

impl Posterior<'_> {
    /// Chi-squared of the residuals, with a warning if the model misses the data.
    pub(super) fn warn_of_misfit(&self, fit: &Fit, health: &mut Health) -> Result<(), InferenceError> {
        let all = self.chi_squared(fit)?;
        let (value, n) = (all.iter().sum::<f64>(), self.data().size());
        let told = if self.floating().is_empty() { self.told(fit).round() as usize } else { 0 };
        let freedom = n.saturating_sub(told);
        let found = ChiSquared { value, freedom, sds: chi_squared_sds(value, freedom) };
        health.chi_squared = Some(found);
        if found.sds <= MISSED {
            return Ok(());
        }
        let worst = (0..all.len()).reduce(|a, b| if all[b] > all[a] { b } else { a });
        let worst = worst.filter(|_| all.len() > 1).map_or(String::new(), |k| {
            let observation = &self.data().observations()[k];
            let (label, count) = (&observation.label, observation.values.len());
            format!(", {:.4e} of it in the {count} data of '{label}'", all[k])
        });
        health.warnings.push(format!(
            "the model misses the data: chi-squared is {value:.4e} with {freedom} degrees of freedom, {:.0} standard deviations{worst}. Look at the \
             residuals; correct the model, the data or the stated noise, or let the noise float",
            found.sds
        ));
        Ok(())
    }

    /// What few data leave unknown of noises that float, also as part of `fit`, with a warning where
    /// Laplace's standard deviations are too small. Nothing where it cannot be found.
    pub(super) fn few(&self, fit: &mut Fit, laplace: &Laplace, health: &mut Health) -> Option<Few> {
        if self.floating().is_empty() || self.data().size() > MOST {
            return None;
        }
        let few = self.linearised(fit, laplace).ok()?.few();
        few.noises.iter().for_each(|(group, few)| fit.noise[*group].few = Some(*few));
        let list = self.parameters().list();
        let narrow = |(factor, p): (&f64, &crate::Parameter)| {
            (*factor > WIDER).then(|| format!("that of {} by {factor:.2}", p.name))
        };
        let narrow: Vec<String> = few.parameters.iter().zip(list).filter_map(narrow).collect();
        if !narrow.is_empty() {
            let noises = fit.noise.iter().filter(|n| n.floats).map(|n| format!("'{}'", n.name));
            health.warnings.push(format!(
                "few data choose the noise {}, and Laplace's standard deviations, which take it for known, are too small: multiply {} (Assessment::sd \
                 has done so)",
                noises.collect::<Vec<_>>().join(" and "),
                narrow.join(", ")
            ));
        }
        Some(few)
    }
}
