//! Observed responses as the data of an inference: noise, a misfit along frequency, and the errors of the measuring head.

use crate::EngineError;
use rijke_inference::{Correlated, Data, NoiseGroup, NoiseMode, Observation, Structured, complex_columns};
use rijke_numerics::{C64, Matrix};
use rijke_study::ErrorTerm;
use rijke_study::plan::SdSpec;
use rijke_study::responses::MisfitSpec;

/// The numbers of one response that train.
#[derive(Clone, Debug)]
pub(super) struct Measured {
    /// What they are called.
    pub(super) label: String,
    /// Loads of one session share the errors of the head.
    pub(super) session: usize,
    pub(super) frequency_hz: Vec<f64>,
    pub(super) values: Vec<C64>,
    /// Empty if no standard deviations were measured.
    pub(super) sd: Vec<f64>,
}

/// Everything that the data of a training are made of. Loads of one session stand side by side.
pub(super) struct Blocks<'a> {
    pub(super) measured: &'a [Measured],
    /// Error terms of the head; none for a perfect one.
    pub(super) errors: &'a [ErrorTerm],
    pub(super) noise: &'a SdSpec,
    pub(super) misfit: Option<&'a MisfitSpec>,
}

impl Blocks<'_> {
    /// The data: one block for every session.
    ///
    /// # Errors
    /// [`EngineError::Inference`] for numbers that cannot be data.
    pub(super) fn data(&self) -> Result<Data, EngineError> {
        let mut groups = vec![group("noise", "1", self.noise)];
        let misfit = self.misfit.map(|m| {
            groups.push(group("misfit", "1", &m.size));
            groups.push(group("length of the misfit", "Hz", &m.length_hz));
            (m, groups.len() - 2)
        });
        let floated: Vec<Option<usize>> = self
            .errors
            .iter()
            .map(|term| match &term.sd {
                SdSpec::Fixed(_) => None,
                sd => {
                    groups.push(group(&format!("error b{} of the head", term.power), "1", sd));
                    Some(groups.len() - 1)
                }
            })
            .collect();
        let mut blocks = Vec::new();
        for loads in self.measured.chunk_by(|a, b| a.session == b.session) {
            let all = || loads.iter().flat_map(|m| m.values.iter());
            let values: Vec<f64> = all().flat_map(|z| [z.re, z.im]).collect();
            let variance = loads.iter().flat_map(|m| {
                let sd = |k: usize| m.sd.get(k).copied().unwrap_or(0.0);
                (0..2 * m.values.len()).map(move |i| sd(i / 2).powi(2))
            });
            let mut covariance = Structured::new(variance.collect()).with_noise(0, vec![1.0; values.len()]);
            for (columns, (term, group)) in self.columns(loads).iter().zip(self.errors.iter().zip(&floated)) {
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
                covariance = covariance.with_exact_misfit(&Correlated {
                    size,
                    length: size + 1,
                    kernel: misfit.kernel,
                    coordinate: &coordinate,
                    part: &part,
                    shortest: 0.0,
                })?;
            }
            let label = loads.iter().map(|m| m.label.as_str()).collect::<Vec<_>>().join(" ");
            blocks.push(Observation::new(label, values).with_structure(covariance));
        }
        Ok(Data::new(blocks, groups)?)
    }

    /// For every error term its columns, of unit root mean square over the band: b's polynomials times a power of what was measured,
    /// which differs from the true one by the noise alone, so that the error of this is of second order.
    pub(super) fn columns(&self, loads: &[Measured]) -> Vec<Matrix> {
        let frequencies = || loads.iter().flat_map(|m| m.frequency_hz.iter().copied());
        let low = frequencies().fold(f64::INFINITY, f64::min);
        let high = frequencies().fold(f64::NEG_INFINITY, f64::max);
        let column = |term: &ErrorTerm| {
            let mut columns = vec![Vec::new(); term.functions];
            for (m, k) in loads.iter().flat_map(|m| (0..m.values.len()).map(move |k| (m, k))) {
                let x = if high > low { 2.0 * (m.frequency_hz[k] - low) / (high - low) - 1.0 } else { 0.0 };
                let factor = m.values[k].powi(term.power);
                for (column, p) in columns.iter_mut().zip(legendre(x, term.functions)) {
                    column.push(factor * p);
                }
            }
            complex_columns(&columns)
        };
        self.errors.iter().map(column).collect()
    }
}

/// The first `count` Legendre polynomials at x, each of root mean square 1/sqrt(count) over -1 .. 1, so that their sum with coefficients
/// of unit variance has the mean square 1.
fn legendre(x: f64, count: usize) -> Vec<f64> {
    let (mut before, mut here) = (0.0, 1.0);
    (0..count)
        .map(|n| {
            let scaled = here * ((2 * n + 1) as f64 / count as f64).sqrt();
            let next = ((2 * n + 1) as f64 * x * here - n as f64 * before) / (n + 1) as f64;
            (before, here) = (here, next);
            scaled
        })
        .collect()
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

#[cfg(test)]
mod tests {
    use super::legendre;

    #[test]
    fn exact_polynomials_are_orthogonal_and_of_unit_mean_square_together() {
        let n = 4000;
        let at = |k: usize| -1.0 + (2 * k + 1) as f64 / n as f64;
        for (i, j) in [(0, 0), (3, 3), (7, 7), (2, 4), (0, 6)] {
            let mean = (0..n)
                .map(|k| {
                    let p = legendre(at(k), 8);
                    p[i] * p[j]
                })
                .sum::<f64>()
                / n as f64;
            let expected = if i == j { 0.125 } else { 0.0 };
            assert!((mean - expected).abs() < 1e-5, "{i} {j}: {mean}");
        }
    }
}
