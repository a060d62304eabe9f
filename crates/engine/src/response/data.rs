//! Observed responses as the data of an inference: noise, a misfit along frequency, and the errors of the
//! measuring head.

use super::head::{HeardResponses, columns, group_of};
use super::measured::{Measured, sessions};
use super::{LENGTH_OF_MISFIT, MISFIT, NOISE};
use crate::EngineError;
use rijke_inference::{Correlated, Data, NoiseGroup, NoiseMode, Observation, Structured};
use rijke_study::ErrorTerm;
use rijke_study::plan::SdSpec;
use rijke_study::responses::MisfitSpec;

/// Everything that the data of a training are made of. Loads of one session stand side by side.
pub(super) struct Blocks<'a> {
    pub(super) measured: &'a [Measured],
    /// Error terms of the head; none for a perfect one.
    pub(super) errors: &'a [ErrorTerm],
    /// Those errors, as far as they are known.
    pub(super) heard: &'a HeardResponses,
    pub(super) noise: &'a SdSpec,
    pub(super) misfit: Option<&'a MisfitSpec>,
}

impl Blocks<'_> {
    /// The data: one block for every session, and the tilt of [`HeardResponses`].
    ///
    /// # Errors
    /// [`EngineError::Inference`] for numbers that cannot be data.
    pub(super) fn data(&self) -> Result<Data, EngineError> {
        let mut groups = vec![group(NOISE, "1", self.noise)];
        let misfit = self.misfit.map(|m| {
            groups.push(group(MISFIT, "1", &m.size));
            groups.push(group(LENGTH_OF_MISFIT, "Hz", &m.length_hz));
            (m, groups.len() - 2)
        });
        let floated: Vec<Option<usize>> = self
            .errors
            .iter()
            .map(|term| match &term.sd {
                SdSpec::Fixed(_) => None,
                sd => {
                    groups.push(group(&group_of(term), "1", sd));
                    Some(groups.len() - 1)
                }
            })
            .collect();
        let mut blocks = Vec::new();
        for range in sessions(self.measured) {
            if self.measured[range.start].sources > 0 {
                blocks.extend(self.heard.pressures(self.measured, range));
                continue;
            }
            let (loads, about) = (&self.measured[range.clone()], &self.heard.about[range]);
            let all = || loads.iter().flat_map(|m| m.values.iter());
            let values: Vec<f64> = all().flat_map(|z| [z.re, z.im]).collect();
            let variance = loads.iter().flat_map(|m| {
                let sd = |k: usize| m.sd.get(k).copied().unwrap_or(0.0);
                (0..2 * m.values.len()).map(move |i| sd(i / 2).powi(2))
            });
            let factors = loads.iter().flat_map(|m| (0..2 * m.values.len()).map(|i| m.factor(i / 2)));
            let mut covariance = Structured::new(variance.collect()).with_noise(0, factors.collect());
            let columns = columns(loads, about, self.errors);
            for (columns, (term, group)) in columns.iter().zip(self.errors.iter().zip(&floated)) {
                covariance = match (group, &term.sd) {
                    (Some(group), _) => covariance.with_floated_nuisances(columns, *group),
                    (None, SdSpec::Fixed(sd)) => {
                        covariance.with_nuisances(columns, &vec![*sd; columns.columns()])
                    }
                    (None, _) => covariance,
                };
            }
            if let Some((misfit, size)) = misfit {
                let both = |f: &f64| [*f; 2];
                let coordinate: Vec<f64> =
                    loads.iter().flat_map(|m| m.frequency_hz.iter().flat_map(both)).collect();
                let part: Vec<usize> = (0..loads.len())
                    .flat_map(|load| (0..2 * loads[load].values.len()).map(move |i| 2 * load + i % 2))
                    .collect();
                covariance = covariance.with_misfit(&Correlated {
                    size,
                    length: size + 1,
                    kernel: misfit.kernel,
                    coordinate: &coordinate,
                    part: &part,
                })?;
            }
            let label = loads.iter().map(|m| m.label.as_str()).collect::<Vec<_>>().join(" ");
            blocks.push(Observation::new(label, values).with_structure(covariance));
        }
        blocks.extend(self.heard.tilt_datum());
        Ok(Data::new(blocks, groups)?)
    }
}

fn group(name: &str, unit: &str, sd: &SdSpec) -> NoiseGroup {
    let mode = match sd {
        SdSpec::Fixed(sd) => NoiseMode::Fixed { sd: *sd },
        SdSpec::Inferred { median, ln_sd } => NoiseMode::Inferred { median: *median, ln_sd: *ln_sd },
        // The misfit of another stage is no number of responses.
        SdSpec::Floated | SdSpec::Like { .. } => NoiseMode::Floated,
    };
    NoiseGroup { name: name.into(), unit: unit.into(), mode }
}
