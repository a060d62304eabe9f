//! Models that lose by a prior which the data contradict.

use super::super::parameter::TrainedParameter;
use super::super::record::StageRecord;

/// The models, by name, ln evidence and parameters, that a prior keeps from the first place, a sentence each:
/// the data contradict the prior of a parameter, and without its penalty, half the square of the distance,
/// the model would lead, even if the leader were freed of such penalties too.
pub(crate) fn behind_by_a_prior(models: &[(&str, Option<f64>, &[TrainedParameter])]) -> Vec<String> {
    let best = models.iter().filter_map(|m| m.1).fold(f64::NEG_INFINITY, f64::max);
    let paid = |parameters: &[TrainedParameter]| -> f64 {
        parameters.iter().filter_map(TrainedParameter::conflict).map(|z| 0.5 * z * z).sum()
    };
    let by_the_leader = models.iter().find(|m| m.1 == Some(best)).map_or(0.0, |m| paid(m.2));
    let one = |(id, evidence, parameters): &(&str, Option<f64>, &[TrainedParameter])| {
        let behind = best - (*evidence)?;
        let far: Vec<(&TrainedParameter, f64)> =
            parameters.iter().filter_map(|p| Some((p, p.conflict()?))).collect();
        let penalty = paid(parameters);
        let (p, z) = far.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let beside = match by_the_leader > 0.5 {
            true => format!(", and priors that the leader contradicts cost it {by_the_leader:.0} nats"),
            false => String::new(),
        };
        (behind > 0.0 && penalty - by_the_leader > behind).then(|| {
            format!(
                "{id} is {behind:.1} nats behind only because of a prior: the data move {} by {z:.1} sd of that prior, which lowers the evidence by \
                 about {penalty:.0} nats{beside}; check that prior",
                p.name
            )
        })
    };
    models.iter().filter_map(one).collect()
}

impl StageRecord {
    /// The models that a prior keeps from the first place, a sentence each.
    #[must_use]
    pub fn behind_by_a_prior(&self) -> Vec<String> {
        let all = self.models.iter().map(|m| (&*m.id, m.evidence.map(|e| e.ln_marginal), &*m.parameters));
        behind_by_a_prior(&all.collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::parameter::TrainedParameter;
    use super::behind_by_a_prior;
    use rijke_inference::{Parameter, Prior};

    /// A prior of 0.2 +- 0.02 where the data say 0.64 costs its model 242 nats, and the first place.
    #[test]
    fn behaviour_a_model_that_its_prior_keeps_behind_is_named() {
        let prior = Prior::Normal { mean: 0.2, sd: 0.02 };
        let of = |value| [TrainedParameter::of(&Parameter::new("a", "a", "1", prior), value, 0.003)];
        let (far, near) = (of(0.64), of(0.21));
        let said = behind_by_a_prior(&[("b", Some(10.0), &near), ("a", Some(-73.0), &far)]);
        assert!(
            said.len() == 1 && said[0].starts_with("a is 83.0 nats behind only because of a prior"),
            "{said:?}"
        );
        assert!(said[0].contains("move a by 22.0 sd of that prior"), "{said:?}");
        assert!(said[0].contains("by about 242 nats"), "{said:?}");
        // The first place is lost by less than 22^2/2 nats.
        let behind = |by: f64| behind_by_a_prior(&[("b", Some(0.0), &near), ("a", Some(-by), &far)]).len();
        assert_eq!([behind(241.0), behind(243.0)], [1, 0]);
        // Not where the leader contradicts the same prior as much.
        let leader = [TrainedParameter::of(&Parameter::new("a", "a", "1", prior), 0.65, 0.003)];
        assert!(behind_by_a_prior(&[("b", Some(10.0), &leader), ("a", Some(-9.0), &far)]).is_empty());
        // Not where it leads, where the data decide, or without evidence.
        assert!(behind_by_a_prior(&[("b", Some(10.0), &near), ("a", Some(20.0), &far)]).is_empty());
        assert!(
            behind_by_a_prior(&[("b", Some(10.0), &near), ("a", Some(-900.0), &far), ("c", None, &far)])
                .is_empty()
        );
    }
}
