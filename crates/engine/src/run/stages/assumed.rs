//! What a stage assumes of its misfit: the plan's words with the numbers of earlier stages.

use super::super::course::{Chosen, Run};
use crate::EngineError;
use crate::noise::{LawError, Noise, Varying};
use crate::rows::Choice;
use rijke_inference::NoiseMode;
use rijke_study::plan::{NoiseSpec, SdSpec, Stage};

impl Run {
    /// The plan's words, with what earlier stages found in the place of their names; without the error of a
    /// law, for which see [`Run::law_of`].
    pub(in crate::run) fn noise(&self, spec: &NoiseSpec) -> Result<Noise, EngineError> {
        let of =
            |stage: &str| self.chosen(stage).ok_or_else(|| EngineError::NoPoint { stage: stage.to_owned() });
        let mode = |sd: &SdSpec,
                    k: Option<usize>,
                    find: &dyn Fn(&Chosen) -> f64|
         -> Result<NoiseMode, EngineError> {
            Ok(match sd {
                SdSpec::Floated => NoiseMode::Floated,
                SdSpec::Fixed(sd) => NoiseMode::Fixed { sd: *sd },
                SdSpec::Inferred { median, ln_sd } => NoiseMode::Inferred { median: *median, ln_sd: *ln_sd },
                SdSpec::Like { stage, ln_sd, new_installation } => {
                    let like = of(stage)?;
                    let between = match k.filter(|k| *new_installation && *k < 2) {
                        Some(k) => self.between_installations(like)?[k],
                        None => 0.0,
                    };
                    let median = find(like).hypot(between);
                    if *ln_sd > 0.0 {
                        NoiseMode::Inferred { median, ln_sd: *ln_sd }
                    } else {
                        NoiseMode::Fixed { sd: median }
                    }
                }
            })
        };
        let number = |sd: &SdSpec, k: usize| mode(sd, Some(k), &|c| c.misfit[k]);
        let of_an_installation = match &spec.installation {
            Some([growth, frequency]) => [number(growth, 0)?, number(frequency, 1)?],
            None => [NoiseMode::Fixed { sd: 0.0 }; 2],
        };
        let varying = |v: &rijke_study::plan::PlannedVarying| -> Result<Varying, EngineError> {
            // The scatter that the earlier stage found of this parameter.
            let found = |c: &Chosen| {
                let of =
                    |n: &&rijke_inference::NoiseEstimate| n.name.starts_with(&format!("{},", v.parameter));
                c.trained.noise.iter().find(of).map_or(0.0, |n| n.sd)
            };
            Ok(Varying { parameter: v.parameter.clone(), sd: mode(&v.sd, None, &found)? })
        };
        Ok(Noise {
            of_a_point: [
                number(&spec.growth_rate, 0)?,
                number(&spec.angular_frequency, 1)?,
                number(&spec.pressure, 2)?,
            ],
            of_an_installation,
            measured: spec.measured,
            varying: spec.varying.iter().map(varying).collect::<Result<_, _>>()?,
            law: None,
        })
    }
}

impl Run {
    /// The error of a law that enters the model `choice` of a stage: what `spec` states, else the misfit of
    /// the law that a stage of responses measured on which the stage stands.
    ///
    /// # Errors
    /// [`EngineError::Refused`] where several laws have such a misfit.
    pub(in crate::run) fn law_of(
        &self,
        stage: &Stage,
        spec: &NoiseSpec,
        choice: &Choice,
    ) -> Result<Option<LawError>, EngineError> {
        if let Some(stated) = &spec.law {
            let law =
                |over| LawError { role: stated.role.clone(), sd: stated.sd, over: Some(over), added: None };
            return Ok(self.study.campaign.factor(&stated.over).map(law));
        }
        let mut all = Vec::new();
        for ground in self.study.plan.grounds(stage).into_iter().filter_map(|id| self.ground(id)) {
            let law = ground.with(choice, &stage.id)?.law.as_ref();
            all.extend(law.filter(|law| choice.contains_key(&law.role)).cloned());
        }
        if let [first, second, ..] = &all[..] {
            let problem = format!(
                "it stands on laws of two roles with a misfit, {} and {}, but only one can be included: state the larger of their effects as `law` \
                 of [stage.noise]",
                first.role, second.role
            );
            return Err(EngineError::Refused { stage: stage.id.clone(), problem });
        }
        Ok(all.pop())
    }

    /// How far growth rate (1/s) and angular frequency (rad/s) differ between installations by the parameters
    /// that vary, as a root mean square over the points that trained.
    fn between_installations(&self, like: &Chosen) -> Result<[f64; 2], EngineError> {
        let Chosen { trained, assembly, observed, .. } = like;
        let posterior = trained.posterior();
        let known = &posterior.gaussian;
        let varied = known.in_a_new_installation(&trained.noise);
        let microphones = self.reference();
        let mut sums = [0.0; 2];
        for o in observed.iter() {
            let of = |known| {
                let near = Some(o.near);
                posterior.predict_from(known, assembly, &o.conditions, microphones.as_slice(), near, None)
            };
            let (with, without) = (of(&varied)?.parameters, of(known)?.parameters);
            (0..2).for_each(|k| sums[k] += with[(k, k)] - without[(k, k)]);
        }
        Ok(sums.map(|sum| (sum / observed.len().max(1) as f64).max(0.0).sqrt()))
    }
}
