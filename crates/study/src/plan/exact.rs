//! Factors whose readings a study takes as exact though its predictions follow from them.

use super::{Base, HeatedFlow, MeasuredGas, Plan};
use crate::law::Effect;
use crate::{Campaign, Catalogue, Rig};

impl Plan {
    /// The factors that stages of modes use, in a law or for the gas, that are read from an instrument, and
    /// of which no point states a standard deviation.
    pub(crate) fn exact_factors<'a>(
        &'a self,
        rig: &'a Rig,
        campaign: &'a Campaign,
        catalogue: &'a Catalogue,
    ) -> Vec<&'a str> {
        let of_the_gas: &[&str] = match &self.base {
            Base::HeatedFlow(HeatedFlow { power, flow, .. }) => &[power, flow],
            Base::Measured(MeasuredGas { flow: Some(flow), .. }) => &[flow],
            _ => &[],
        };
        let effects = self.stages.iter().flat_map(|stage| self.effects_of(stage, rig, catalogue));
        let effects: Vec<&Effect> = effects.collect();
        let in_a_law = |place: usize| effects.iter().any(|effect| effect.law.uses(place));
        // Whether a part is there, 0 or 1, is no reading.
        let is_flag = |k: usize| campaign.points.iter().all(|p| p.factors[k] == 0.0 || p.factors[k] == 1.0);
        let is_exact = |k: usize| {
            campaign.points.iter().all(|p| p.factor_sds[k] == 0.0)
                && campaign.points.iter().any(|p| p.factors[k].is_finite() && p.factors[k] != 0.0)
                && !is_flag(k)
        };
        let factors = campaign.factors.iter().enumerate();
        let exact = factors.filter(|(k, factor)| {
            is_exact(*k) && (of_the_gas.contains(&factor.name.as_str()) || in_a_law(rig.factors[*k]))
        });
        exact.map(|(_, factor)| factor.name.as_str()).collect()
    }
}
