//! Pressures of sources of unknown strength: at every frequency of an excitation y = H a + noise, where the
//! columns of H are what the microphones hear of waves of unit pressure and a are unknown complex numbers,
//! integrated over.
//!
//! The field H a is normal about zero with the same standard deviation, [`FIELD`] times that of all
//! pressures, in every direction of the space that the columns of H span. So the volume that the sources
//! leave does not depend on H, and the likelihood is that of the residuals in the directions that no source
//! can reach, times a constant: the variable projection of Golub and Pereyra (SIAM J. Numer. Anal. 10 (1973)
//! 413).
//!
//! The space is taken at the columns H0 of the last fit, with the amplitudes a0 that fit best there:
//!
//! y = P (H - H0) a0 + Q b + noise, where Q spans the columns of H0 and P takes what lies in them away.
//!
//! It has the value and the slope of the likelihood where H = H0, and its curvature but for terms as small as
//! the residuals. The fit is repeated until H0 stays.

use super::measured::Measured;
use crate::EngineError;
use rijke_inference::{Observation, Structured, complex_columns};
use rijke_numerics::{C64, Jet};
use std::ops::Range;

/// Standard deviation of the field of the sources in each direction, over the root of the sum of squares of
/// the pressures, which is known.
const FIELD: f64 = 1.0;
/// Columns that are closer to each other than this part of their length are one.
const SAME: f64 = 1e-6;

/// What the microphones hear of the sources of one excitation at one frequency, about one answer of the rig.
#[derive(Clone, Debug)]
pub(super) struct Field {
    /// H0 by microphone and source.
    about: Vec<Vec<C64>>,
    /// Q by direction and microphone.
    basis: Vec<Vec<C64>>,
    /// a0.
    amplitudes: Vec<C64>,
}

/// The fields of the excitation whose microphones are `loads`, by frequency. `answers` hold at each frequency
/// what every source makes there.
pub(super) fn fields(
    measured: &[Measured],
    loads: Range<usize>,
    answers: &[Vec<C64>],
) -> Result<Vec<Field>, EngineError> {
    let frequencies = &measured[loads.start].frequency_hz;
    let at = |k: usize| {
        let count = answers[loads.start].len() / frequencies.len();
        let about: Vec<Vec<C64>> =
            loads.clone().map(|load| answers[load][k * count..(k + 1) * count].to_vec()).collect();
        let heard: Vec<C64> = loads.clone().map(|load| measured[load].values[k]).collect();
        Field::new(about, &heard).ok_or_else(|| EngineError::Unsettled {
            what: format!(
                "{} at {} Hz: the microphones cannot distinguish the sources; take the frequency out with `band_hz`, or state fewer `sources`",
                measured[loads.start].label, frequencies[k]
            ),
        })
    };
    (0..frequencies.len()).map(at).collect()
}

impl Field {
    /// About the columns `about`, by microphone and source, of what was `heard`; none if the columns are not
    /// independent.
    fn new(about: Vec<Vec<C64>>, heard: &[C64]) -> Option<Self> {
        let count = about.first().map_or(0, Vec::len);
        let mut basis: Vec<Vec<C64>> = Vec::with_capacity(count);
        let mut triangle = vec![vec![C64::ZERO; count]; count];
        for j in 0..count {
            let mut column: Vec<C64> = about.iter().map(|row| row[j]).collect();
            let whole = norm(&column);
            // Twice is enough: Parlett, The Symmetric Eigenvalue Problem, section 6.9.
            for _ in 0..2 {
                for (i, q) in basis.iter().enumerate() {
                    let share = dot(q, &column);
                    triangle[i][j] += share;
                    column.iter_mut().zip(q).for_each(|(z, q)| *z -= share * q);
                }
            }
            let rest = norm(&column);
            // NaN: no direction either.
            if !matches!(rest.partial_cmp(&(SAME * whole)), Some(std::cmp::Ordering::Greater)) {
                return None;
            }
            triangle[j][j] = C64::from(rest);
            basis.push(column.iter().map(|z| z / rest).collect());
        }
        let mut amplitudes = vec![C64::ZERO; count];
        for j in (0..count).rev() {
            let known: C64 = (j + 1..count).map(|i| triangle[j][i] * amplitudes[i]).sum();
            amplitudes[j] = (dot(&basis[j], heard) - known) / triangle[j][j];
        }
        Some(Self { about, basis, amplitudes })
    }

    /// What the microphones hear, up to what the sources can make: P (H - H0) a0. `answer` gives H by
    /// microphone and source.
    pub(super) fn told<'j>(&self, answer: &dyn Fn(usize, usize) -> &'j Jet) -> Vec<Jet> {
        let moved = |(m, row): (usize, &Vec<C64>)| {
            let mut sources = row.iter().zip(&self.amplitudes).enumerate();
            let (j, (h, a)) = sources.next()?;
            let mut sum = answer(m, j).shift(-h);
            sum *= *a;
            for (j, (h, a)) in sources {
                sum.add_scaled(answer(m, j), *a);
                sum += -h * a;
            }
            Some(sum)
        };
        let mut all: Vec<Jet> = self.about.iter().enumerate().filter_map(moved).collect();
        for q in &self.basis {
            let Some((first, others)) = all.split_first() else { break };
            let mut share = first.scale(q[0].conj());
            others.iter().zip(&q[1..]).for_each(|(z, q)| share.add_scaled(z, q.conj()));
            all.iter_mut().zip(q).for_each(|(z, q)| z.add_scaled(&share, -q));
        }
        all
    }

    /// The most probable pressures.
    pub(super) fn heard(&self) -> Vec<C64> {
        let one = |row: &Vec<C64>| row.iter().zip(&self.amplitudes).map(|(h, a)| h * a).sum();
        self.about.iter().map(one).collect()
    }

    /// The pressures as data, with the standard deviations that were measured, none or one for each, and the
    /// `factor` of the variance of the noise that floats. Where the deviations differ, a0 and the volume that
    /// the sources leave are off by terms as small as the residuals.
    pub(super) fn observation(&self, label: String, heard: &[C64], sds: &[f64], factor: f64) -> Observation {
        let values: Vec<f64> = heard.iter().flat_map(|z| [z.re, z.im]).collect();
        let columns = complex_columns(&self.basis);
        let variance = (0..values.len()).map(|i| sds.get(i / 2).map_or(0.0, |sd| sd * sd)).collect();
        let sds = vec![FIELD * norm(heard); columns.columns()];
        let covariance = Structured::new(variance)
            .with_noise(0, vec![factor; values.len()])
            .with_nuisances(&columns, &sds);
        Observation::new(label, values).with_structure(covariance)
    }
}

fn dot(a: &[C64], b: &[C64]) -> C64 {
    a.iter().zip(b).map(|(a, b)| a.conj() * b).sum()
}

fn norm(a: &[C64]) -> f64 {
    a.iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt()
}
