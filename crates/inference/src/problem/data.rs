//! What was measured, and what is known of its noise.

use super::block_noise::BlockNoise;
use super::prior::Prior;
use super::scale;
use super::structured::Structured;
use crate::error::InferenceError;
use rijke_numerics::{C64, Cholesky, Matrix};
use serde::{Deserialize, Serialize};

/// All data of an inference: observations, each a block of real numbers with its covariance, and groups of
/// noise.
///
/// The covariance of a block is C = floor + sum over groups g of `sd_g`^2 `S_g`, where `S_g` is the structure
/// of group g in that block. Blocks are independent of each other.
#[derive(Clone, Debug, Default)]
pub struct Data {
    observations: Vec<Observation>,
    groups: Vec<NoiseGroup>,
    /// The noises of each block, in the order of [`Observation::noise`].
    noises: Vec<Vec<BlockNoise>>,
}

/// One block of data, say the growth rate, frequency and relative pressures of one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct Observation {
    /// Name of the operating point.
    pub label: String,
    /// The measured numbers.
    pub values: Vec<f64>,
    /// Measured covariance, full; the part of C that does not float.
    pub floor: Option<Matrix>,
    /// Group and structure matrix of each noise that acts on this block.
    pub noise: Vec<(usize, Matrix)>,
    /// In their place, for blocks of many data: a diagonal and columns.
    pub structured: Option<Structured>,
}

/// A noise of one standard deviation that acts on many data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseGroup {
    /// Name in tables, say "growth rate".
    pub name: String,
    /// Unit of the standard deviation.
    pub unit: String,
    /// Known, floated, or inferred.
    pub mode: NoiseMode,
}

/// What is known of a standard deviation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NoiseMode {
    /// Known; zero leaves the floor alone.
    Fixed {
        /// The standard deviation.
        sd: f64,
    },
    /// Maximised together with the parameters, as in section 5.1 of the paper; no prior, no Occam factor.
    Floated,
    /// A parameter ln sd with a Gaussian prior; carries its Occam factor.
    Inferred {
        /// Prior median of the standard deviation.
        median: f64,
        /// Prior standard deviation of its natural logarithm.
        ln_sd: f64,
    },
}

impl NoiseGroup {
    /// A known standard deviation.
    pub fn fixed(name: impl Into<String>, unit: impl Into<String>, sd: f64) -> Self {
        Self { name: name.into(), unit: unit.into(), mode: NoiseMode::Fixed { sd } }
    }

    /// A standard deviation that takes its most probable value.
    pub fn floated(name: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { name: name.into(), unit: unit.into(), mode: NoiseMode::Floated }
    }

    /// A standard deviation that is a parameter: ln sd is Gaussian about ln `median` with `ln_sd`.
    pub fn inferred(name: impl Into<String>, unit: impl Into<String>, median: f64, ln_sd: f64) -> Self {
        Self { name: name.into(), unit: unit.into(), mode: NoiseMode::Inferred { median, ln_sd } }
    }

    pub(crate) fn floats(&self) -> bool {
        !matches!(self.mode, NoiseMode::Fixed { .. })
    }
}

impl Observation {
    /// A block of numbers without noise so far.
    pub fn new(label: impl Into<String>, values: Vec<f64>) -> Self {
        Self { label: label.into(), values, floor: None, noise: Vec::new(), structured: None }
    }

    /// Adds a covariance that does not float: usually the measured one.
    #[must_use]
    pub fn with_floor(self, covariance: Matrix) -> Self {
        Self { floor: Some(covariance), ..self }
    }

    /// A block of many data, whose covariance is a diagonal and columns. It has no other floor and noise.
    #[must_use]
    pub fn with_structure(self, structured: Structured) -> Self {
        Self { structured: Some(structured), floor: None, noise: Vec::new(), ..self }
    }

    /// Adds `sd_g`^2 times `structure` to the covariance.
    #[must_use]
    pub fn with_noise(mut self, group: usize, structure: Matrix) -> Self {
        self.noise.push((group, structure));
        self
    }

    /// Adds `sd_g`^2 to the variance of each named element. [`Data::new`](super::Data::new) refuses elements
    /// that are not there.
    #[must_use]
    pub fn with_independent_noise(self, group: usize, elements: &[usize]) -> Self {
        // One too large for the values, which the check of sizes refuses, if an element is not there.
        let missing = elements.iter().any(|e| *e >= self.values.len());
        let mut ones = vec![0.0; self.values.len() + usize::from(missing)];
        for &e in elements {
            if let Some(one) = ones.get_mut(e) {
                *one = 1.0;
            }
        }
        self.with_noise(group, Matrix::diagonal(&ones))
    }

    fn validate(&self, groups: usize) -> Result<(), InferenceError> {
        let bad = |problem: String| {
            Err(InferenceError::BadObservation { observation: self.label.clone(), problem })
        };
        if let Some((i, v)) = self.values.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            return bad(format!("value {i} is {v}"));
        }
        let n = self.values.len();
        if let Some(structured) = &self.structured {
            if self.floor.is_some() || !self.noise.is_empty() {
                return bad("a structured covariance cannot have a floor or noise beside it".to_owned());
            }
            return structured.problem(n, groups).map_or(Ok(()), bad);
        }
        for (name, m) in
            self.floor.iter().map(|m| ("floor", m)).chain(self.noise.iter().map(|(_, m)| ("structure", m)))
        {
            if (m.rows(), m.columns()) != (n, n) {
                return bad(format!("its {name} is {} x {}, but it has {n} values", m.rows(), m.columns()));
            }
            if let Some(v) = m.as_slice().iter().find(|v| !v.is_finite()) {
                return bad(format!("its {name} holds {v}"));
            }
            if (0..n).any(|i| m[(i, i)] < 0.0) {
                return bad(format!("its {name} has a negative variance"));
            }
            let size = |i: usize, j: usize| (m[(i, i)] * m[(j, j)]).sqrt();
            let skew = |&(i, j): &(usize, usize)| {
                (m[(i, j)] - m[(j, i)]).abs()
                    > SYMMETRIC * size(i, j).max(m[(i, j)].abs()).max(m[(j, i)].abs())
            };
            if let Some((i, j)) = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).find(skew) {
                let (a, b) = (m[(i, j)], m[(j, i)]);
                return bad(format!("its {name} is not symmetric: {a} at ({i}, {j}), {b} at ({j}, {i})"));
            }
        }
        if let Some((group, _)) = self.noise.iter().find(|(g, _)| *g >= groups) {
            return bad(format!("it names noise group {group}, but there are {groups}"));
        }
        // With all standard deviations one, C must be a covariance: otherwise some datum has no noise at all.
        let zero = self.floor.clone().unwrap_or_else(|| Matrix::zeros(n, n));
        let all = self.noise.iter().fold(zero, |sum, (_, s)| sum.plus(1.0, s));
        match Cholesky::new(&all) {
            Ok(_) => Ok(()),
            Err(source) => bad(format!(
                "its covariance is not positive definite even with every noise at one ({source}); is a variance zero?"
            )),
        }
    }
}

/// Largest difference of the two halves of a covariance, as a correlation.
const SYMMETRIC: f64 = 1e-6;

impl Data {
    /// Checks and keeps observations and groups of noise.
    ///
    /// # Errors
    /// [`InferenceError::BadObservation`] for numbers that are not finite, matrices of the wrong size, a
    /// block whose covariance cannot be positive definite; [`InferenceError::BadNoise`] for an impossible
    /// standard deviation.
    pub fn new(observations: Vec<Observation>, groups: Vec<NoiseGroup>) -> Result<Self, InferenceError> {
        for group in &groups {
            let problem = match group.mode {
                NoiseMode::Fixed { sd } if !(sd >= 0.0 && sd.is_finite()) => Some(format!("sd = {sd}")),
                NoiseMode::Inferred { median, ln_sd }
                    if !(median > 0.0 && median.is_finite() && ln_sd > 0.0 && ln_sd.is_finite()) =>
                {
                    Some(format!("median = {median}, ln_sd = {ln_sd}; both must be positive and finite"))
                }
                NoiseMode::Inferred { median, ln_sd } => {
                    Prior::LogNormal { median, ln_sd }.in_range(&group.name).err().map(|e| e.to_string())
                }
                NoiseMode::Fixed { sd } if sd > 0.0 => {
                    scale::check(&group.name, "sd", sd, None).err().map(|e| e.to_string())
                }
                _ => None,
            };
            if let Some(problem) = problem {
                return Err(InferenceError::BadNoise { group: group.name.clone(), problem });
            }
        }
        for observation in &observations {
            observation.validate(groups.len())?;
        }
        let of = |o: &Observation| o.noise.iter().map(|(g, s)| BlockNoise::new(*g, s)).collect();
        let noises = observations.iter().map(of).collect();
        Ok(Self { observations, groups, noises })
    }

    /// The noises of block `k`.
    pub(crate) fn noises(&self, k: usize) -> &[BlockNoise] {
        &self.noises[k]
    }

    /// The covariance of block `k` with the standard deviations `sds` of the groups, as a dense matrix.
    pub(crate) fn covariance(&self, k: usize, sds: &[f64]) -> Matrix {
        let observation = &self.observations[k];
        if let Some(structured) = &observation.structured {
            return structured.dense(sds);
        }
        let n = observation.values.len();
        let mut sum = observation.floor.clone().unwrap_or_else(|| Matrix::zeros(n, n));
        for noise in &self.noises[k] {
            noise.add_to(&mut sum, sds[noise.group].powi(2));
        }
        sum
    }

    /// The blocks.
    #[must_use]
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// The groups of noise.
    #[must_use]
    pub fn groups(&self) -> &[NoiseGroup] {
        &self.groups
    }

    /// Number of real data over all blocks.
    #[must_use]
    pub fn size(&self) -> usize {
        self.observations.iter().map(|o| o.values.len()).sum()
    }
}

/// Structure of the noise of relative pressures P = p / `p_ref`, as real and imaginary part in turn.
///
/// Every microphone has circular noise of one standard deviation relative to the reference pressure, so the
/// relative pressures have the complex covariance I + P P^H: they share the noise of the reference. `others`
/// are the relative pressures without the reference's own 1. Each of the real and imaginary parts of the raw
/// pressures then has the standard deviation that the group carries, in units of |`p_ref`|.
#[must_use]
pub fn relative_noise(others: &[C64]) -> Matrix {
    let n = others.len();
    Matrix::from_fn(2 * n, 2 * n, |row, column| {
        let (i, j) = (row / 2, column / 2);
        let k = others[i] * others[j].conj() + if i == j { C64::ONE } else { C64::ZERO };
        // A circular complex covariance K is [[Re K, -Im K], [Im K, Re K]] in real and imaginary parts.
        match (row % 2, column % 2) {
            (0, 0) | (1, 1) => k.re,
            (0, _) => -k.im,
            _ => k.im,
        }
    })
}
