//! What a model leaves of the data, once the head's errors are taken at their most probable values.

use super::head::Rest;
use super::measured::{Measured, sessions};
use super::stray::stray;
use rijke_numerics::C64;
use rijke_numerics::words::to_digits;
use rijke_study::plan::SdSpec;
use rijke_study::responses::ResponseStage;

/// A correlation of neighbouring residuals beyond this many standard deviations is none of noise.
pub(super) const NOT_NOISE: f64 = 4.0;

/// Residuals of such a share of the data are no small fault of the model.
pub(super) const POOR: f64 = 0.1;

/// Residuals of such a share of data that do not state errors as large are told, whether or not neighbouring
/// ones correlate.
const UNDESCRIBED: f64 = 0.3;

/// Residuals that are larger than expected by this factor are told, if it is no accident.
const LARGER: f64 = 1.2;

/// Residuals that are larger than what the data state by this factor are told where the noise covers them.
const BEYOND: f64 = 1.5;

/// What is left of a training. Every residual counts by the standard deviation that noise, misfit and what
/// was measured of it have together: one of loud numbers says nothing of quiet ones.
pub(super) struct Left {
    /// What the head makes of the model's answers, load after load.
    pub(super) heard: Vec<Vec<C64>>,
    /// Distance of every number from the model, over its standard deviation, load after load.
    pub(super) distances: Vec<Vec<f64>>,
    /// Root mean square of the residuals as they stand, both parts together.
    pub(super) size: f64,
    /// Root mean square of the residuals over that of the data, both in standard deviations.
    pub(super) share: f64,
    /// Correlation between neighbouring frequencies.
    pub(super) neighbours: f64,
    /// How far that correlation is above the one of noise and misfit, over the standard deviation of
    /// independent residuals.
    pub(super) neighbours_sds: f64,
    /// The size over that which noise, misfit and measured standard deviations have.
    pub(super) ratio: f64,
    /// Standard deviation of that ratio for independent residuals.
    pub(super) ratio_sd: f64,
    /// The size over that which the measured standard deviations have alone; none if some were not measured.
    pub(super) beyond_stated: Option<f64>,
    /// By which power of the modulus of the numbers the residuals grow, and its standard deviation; none
    /// where standard deviations were measured, rows are scaled, or the noise has a part in proportion to it.
    pub(super) growth: Option<[f64; 2]>,
}

/// Residuals that grow by a larger power than this, if it is no accident, are not of one noise.
const GROWS: f64 = 0.3;

/// By which power of the modulus of the numbers residuals grow, and its standard deviation: the slope of half
/// of ln |residual|^2, which scatters by pi/sqrt(24) for normal noise, over ln |number|.
fn growth(measured: &[Measured], distances: &[Vec<f64>]) -> Option<[f64; 2]> {
    if measured.iter().any(|m| !m.sd.is_empty() || !m.factor.is_empty() || m.sources > 0) {
        return None;
    }
    let numbers = measured.iter().flat_map(|m| m.values.iter().map(|z| z.norm()));
    let both = numbers.zip(distances.iter().flatten()).filter(|(z, d)| *z > 0.0 && **d > 0.0);
    let (x, y): (Vec<f64>, Vec<f64>) = both.map(|(z, d)| (z.ln(), d.ln())).unzip();
    let n = x.len() as f64;
    let [mean, level] = [&x, &y].map(|all| all.iter().sum::<f64>() / n);
    let spread: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
    let common: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean) * (y - level)).sum();
    (spread > 0.0).then(|| [common / spread, std::f64::consts::PI / (24.0 * spread).sqrt()])
}

/// What is left of `measured` by what the head hears; `rest` is the covariance of what is not the head's.
pub(super) fn left(measured: &[Measured], heard: Vec<Vec<C64>>, rest: Rest<'_>) -> Left {
    let turns = turns(measured, &heard);
    let (mut plain, mut square, mut data, mut pairs, mut shared) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let (mut stated, mut distances) = (0.0, Vec::with_capacity(measured.len()));
    for ((m, heard), turns) in measured.iter().zip(&heard).zip(&turns) {
        // Of a complex number: both parts have this variance.
        let sds: Vec<f64> = (0..m.values.len())
            .map(|i| (2.0 * rest.covariance_of(m, i, i)).max(f64::MIN_POSITIVE).sqrt())
            .collect();
        let residuals: Vec<C64> = m.values.iter().zip(heard).map(|(m, h)| m - h).collect();
        let standard: Vec<C64> = residuals.iter().zip(&sds).map(|(z, sd)| z / sd).collect();
        stated += residuals.iter().zip(&m.sd).map(|(z, sd)| 0.5 * (z / sd).norm_sqr()).sum::<f64>();
        plain += residuals.iter().map(|z| z.norm_sqr()).sum::<f64>();
        square += standard.iter().map(|z| z.norm_sqr()).sum::<f64>();
        data += m.values.iter().zip(&sds).map(|(z, sd)| (z / sd).norm_sqr()).sum::<f64>();
        pairs += standard.windows(2).zip(turns).map(|(w, turn)| (w[1] * w[0].conj() * turn).re).sum::<f64>();
        let common = |i: usize| 2.0 * rest.covariance_of(m, i - 1, i) / (sds[i - 1] * sds[i]);
        shared += (1..sds.len()).map(common).sum::<f64>();
        distances.push(standard.iter().map(|z| z.norm()).collect());
    }
    let count = measured.iter().map(|m| m.values.len()).sum::<usize>().max(1) as f64;
    // What the sources may be takes a direction each out of the residuals.
    let free = (count - sources(measured)).max(1.0);
    let neighbours = pairs / square.max(f64::MIN_POSITIVE);
    Left {
        heard,
        growth: growth(measured, &distances),
        distances,
        size: (plain / count).sqrt(),
        share: (square / data.max(f64::MIN_POSITIVE)).sqrt(),
        neighbours,
        neighbours_sds: (neighbours - shared / count) * (2.0 * free).sqrt(),
        ratio: (square / free).sqrt(),
        ratio_sd: 1.0 / (4.0 * free).sqrt(),
        beyond_stated: measured.iter().all(|m| m.sd.len() == m.values.len()).then(|| (stated / free).sqrt()),
    }
}

/// By which factor of modulus one a residual at each frequency but the first is referred to the phase of the
/// one before. Sources of unknown strength have a phase at every frequency that says nothing: there it is the
/// phase that brings what is heard at both frequencies nearest to each other. Elsewhere it is 1.
fn turns(measured: &[Measured], heard: &[Vec<C64>]) -> Vec<Vec<C64>> {
    let of_session = |loads: std::ops::Range<usize>| {
        let first = &measured[loads.start];
        let turn = |k: usize| {
            // Other loads of a session need not have one set of frequencies.
            if first.sources == 0 {
                return C64::ONE;
            }
            let along: C64 = loads.clone().map(|load| heard[load][k - 1] * heard[load][k].conj()).sum();
            if along.norm() > 0.0 { along / along.norm() } else { C64::ONE }
        };
        let own = |load: usize| (1..measured[load].values.len()).map(turn).collect::<Vec<_>>();
        loads.clone().map(own).collect::<Vec<_>>()
    };
    sessions(measured).into_iter().flat_map(of_session).collect()
}

/// Complex numbers that unknown sources take: one for each at every frequency of an excitation.
fn sources(measured: &[Measured]) -> f64 {
    let of_session = |loads: std::ops::Range<usize>| {
        let first = &measured[loads.start];
        first.sources * first.values.len()
    };
    sessions(measured).into_iter().map(of_session).sum::<usize>() as f64
}

impl Left {
    /// Whether standard deviations and leads are smaller than the residuals allow.
    pub(super) fn too_sure(&self) -> bool {
        self.is_larger(self.ratio, LARGER) || self.neighbours_sds > NOT_NOISE || self.grows().is_some()
    }

    /// The power by which residuals grow with the numbers, if they do.
    fn grows(&self) -> Option<f64> {
        let [power, sd] = self.growth?;
        let noise = self.neighbours_sds <= NOT_NOISE;
        (noise && power > GROWS && power > NOT_NOISE * sd).then_some(power)
    }

    /// Whether a ratio of residuals to what is expected is above `limit`, and by no accident.
    fn is_larger(&self, ratio: f64, limit: f64) -> bool {
        ratio > limit && ratio > 1.0 + NOT_NOISE * self.ratio_sd
    }

    /// The share of the data that the model leaves, if it does not describe them.
    pub(super) fn undescribed(&self, stage: &ResponseStage) -> Option<f64> {
        let poor = self.neighbours_sds > NOT_NOISE && self.share > POOR;
        (poor || self.is_covered(stage)).then_some(self.share)
    }

    /// Whether the inferred noise covers residuals that are a large part of data which do not state errors as
    /// large.
    fn is_covered(&self, stage: &ResponseStage) -> bool {
        let floats = !matches!(stage.noise, SdSpec::Fixed(_));
        let stated = self.beyond_stated.is_some_and(|b| b < BEYOND);
        floats && self.share > UNDESCRIBED && self.neighbours_sds <= NOT_NOISE && !stated
    }

    /// The share of the data that the residuals are, where they are small but no noise.
    pub(super) fn nearly_right(&self) -> Option<f64> {
        (self.share <= POOR && self.neighbours_sds > NOT_NOISE).then_some(self.share)
    }

    /// What the residuals say of the model, a sentence each; `mistaken` says what the data may be instead,
    /// and is asked where the model is far from them.
    pub(super) fn remarks(
        &self,
        stage: &ResponseStage,
        measured: &[Measured],
        mistaken: &dyn Fn() -> Option<String>,
    ) -> Vec<String> {
        let mut remarks = Vec::new();
        if self.is_larger(self.ratio, LARGER) {
            remarks.push(too_large(stage, self));
        }
        let floats = !matches!(stage.noise, SdSpec::Fixed(_));
        if let Some(beyond) = self.beyond_stated.filter(|b| floats && self.is_larger(*b, BEYOND)) {
            remarks.push(format!(
                "the residuals are {beyond:.1} times the standard deviations that the data state, and the inferred noise covers the rest: the data \
                 are worse than stated, or the model misses an effect, which may have moved its parameters by more than their deviations"
            ));
        }
        let stated = self.beyond_stated.or((!floats).then_some(self.ratio));
        if let Some(part) =
            stated.filter(|part| *part < 1.0 / BEYOND && *part < 1.0 - NOT_NOISE * self.ratio_sd)
        {
            remarks.push(format!(
                "the stated noise is about {} times too large for these residuals: the standard deviations of parameters are then too large, and leads \
                 too small; check what is stated (`noise` of the stage, or the column of `sd`)",
                to_digits(1.0 / part, 2)
            ));
        }
        if let Some(power) = self.grows() {
            remarks.push(format!(
                "the residuals grow with the modulus of the data, to the power {power:.1}, but one noise is taken for all: standard deviations are too small, by a \
                 factor of two over a decade of moduli; give every row its standard deviation (a column `sd`), such as 3 % of the modulus, or let the noise \
                 float alone (noise = \"floated\", without misfit), with a part in proportion to the modulus"
            ));
        } else {
            remarks.extend(stray(measured, &self.distances));
        }
        if self.share > POOR {
            remarks.extend(mistaken());
        }
        if self.is_covered(stage) {
            remarks.push(format!(
                "the residuals of this model are {:.0} % of the data, and the inferred noise covers them: unless the data are as noisy as that, \
                 the model is wrong",
                100.0 * self.share
            ));
        }
        if self.neighbours_sds > NOT_NOISE {
            remarks.push(not_noise(stage, measured, self));
        }
        remarks
    }
}

/// What is said of residuals that are larger than expected.
fn too_large(stage: &ResponseStage, left: &Left) -> String {
    let (what, remedy) = if matches!(stage.noise, SdSpec::Fixed(_)) {
        (
            "the stated noise lets",
            "state a larger noise, let it be inferred, or look for what the model lacks",
        )
    } else {
        (
            "the inferred noise lets",
            "its prior holds the noise down: look for what the model lacks, or widen that prior",
        )
    };
    format!(
        "the residuals are {:.1} times as large as {what} expect (rms {:.2e}): standard deviations are too small by this factor, and leads \
         too large; {remedy}",
        left.ratio, left.size
    )
}

/// What is said of residuals that correlate along frequency.
fn not_noise(stage: &ResponseStage, measured: &[Measured], left: &Left) -> String {
    let remedy = match &stage.misfit {
        _ if left.share > POOR => "this model does not describe these data",
        // Pressures of unknown sources are trained without a misfit.
        None if measured.iter().any(|m| m.sources > 0) => {
            "the model of the rig or of the instrument misses an effect, such as an error of a temperature (T_amb_sd), a length or a \
             place that counts as exact. More frequencies make the result more certain, but not more right: state these errors, or give the \
             microphones larger ones ([microphones] of rig.toml). Fewer frequencies (`step_hz`) hide the effect and leave its bias in the \
             parameters"
        }
        None => {
            "the model of the rig or of the instrument misses an effect, such as an error of a temperature (T_amb_sd), a length or a \
             place that counts as exact. More frequencies make the result more certain, but not more right: state these errors, or let the \
             misfit correlate ([responses.misfit]). Fewer frequencies (`step_hz`) hide the effect and leave its bias in the parameters"
        }
        Some(_) => "the model of the rig or of the instrument misses an effect",
    };
    format!(
        "the residuals are not noise: rms {}, {} % of the data if each counts by its standard deviation; neighbours correlate \
         by {:.2}, {:.0} standard deviations above what noise and misfit give; {remedy}",
        to_digits(left.size, 3),
        to_digits(100.0 * left.share, 2),
        left.neighbours,
        left.neighbours_sds
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::Streams;
    use std::f64::consts::FRAC_1_SQRT_2;

    fn load(values: Vec<C64>, sd: Vec<f64>) -> Measured {
        let frequency_hz = (0..values.len()).map(|k| k as f64).collect();
        let (factor, level) = (Vec::new(), Vec::new());
        Measured { label: String::new(), session: 0, sources: 0, frequency_hz, values, sd, level, factor }
    }

    /// Two hundred numbers of which the second half was measured a hundred times as badly; beside the noise
    /// the first half is off by `own` and the second by `other` of its standard deviations.
    fn left_of(own: f64, other: f64) -> Left {
        let mut stream = Streams::new(3).stream("residuals");
        let mut normal = || {
            let drawn: f64 = StandardNormal.sample(&mut stream);
            FRAC_1_SQRT_2 * drawn
        };
        let sd: Vec<f64> = (0..200).map(|k| if k < 100 { 1e-3 } else { 0.1 }).collect();
        let off = |k: usize| if k < 100 { own } else { other };
        let value = |(k, sd): (usize, &f64)| {
            C64::new(1.0, 0.0) + C64::new(normal() + off(k), normal()) * sd * std::f64::consts::SQRT_2
        };
        let values = sd.iter().enumerate().map(value).collect();
        let measured = load(values, sd);
        let rest = Rest { noise: &[], kernel: None };
        left(&[measured], vec![vec![C64::new(1.0, 0.0); 200]], rest)
    }

    #[test]
    fn behaviour_each_residual_counts_by_its_own_standard_deviation() {
        let noise = left_of(0.0, 0.0);
        assert!((noise.ratio - 1.0).abs() < 4.0 * noise.ratio_sd, "{}", noise.ratio);
        assert!(noise.neighbours_sds.abs() < 4.0, "{}", noise.neighbours_sds);
        // A fault of the well measured half, which the noise of the other half is far above.
        let fault = left_of(2.0, 0.0);
        assert!(fault.ratio > 1.5 && fault.neighbours_sds > 8.0, "{} {}", fault.ratio, fault.neighbours_sds);
        // Of what was measured the standard deviations are the whole expectation here.
        assert!((fault.beyond_stated.unwrap() / fault.ratio - 1.0).abs() < 1e-12);
        // In numbers as they stand the poorly measured half is nearly all of it.
        assert!((fault.size / noise.size - 1.0).abs() < 1e-2 && noise.size > 0.08);
        assert!(noise.share < 0.02, "{}", noise.share);
    }

    #[test]
    fn behaviour_residuals_in_proportion_to_the_numbers_are_told_from_those_of_one_noise() {
        let mut stream = Streams::new(5).stream("in proportion");
        let mut normal = || {
            let drawn: f64 = StandardNormal.sample(&mut stream);
            drawn
        };
        let mut power = |size: &dyn Fn(f64) -> f64| {
            let model: Vec<C64> =
                (0..60).map(|k| C64::new(0.1 * 10_f64.powf(f64::from(k) / 59.0), 0.0)).collect();
            let values = model.iter().map(|z| z + size(z.norm()) * C64::new(normal(), normal())).collect();
            let measured = load(values, Vec::new());
            left(&[measured], vec![model], Rest { noise: &[], kernel: None }).grows()
        };
        let proportional = power(&|z| 0.03 * z).unwrap();
        assert!((proportional - 1.0).abs() < 0.5, "{proportional}");
        assert_eq!(power(&|_| 0.01), None);
    }

    /// Two microphones hear a source whose field one of them has 2 % off, with noise of 0.5 %; the model has
    /// the field as it is. Whether the source has the phase 0 or one that jumps from frequency to frequency
    /// says nothing of the model.
    #[test]
    fn behaviour_the_phase_of_an_unknown_source_hides_no_fault() {
        let mut stream = Streams::new(11).stream("phases of sources");
        let mut drawn = || -> f64 { StandardNormal.sample(&mut stream) };
        let noise: Vec<[C64; 2]> =
            (0..60).map(|_| [0, 1].map(|_| 5e-3 * C64::new(drawn(), drawn()))).collect();
        let jumps: Vec<f64> = (0..60).map(|_| 3.0 * drawn()).collect();
        let of = |phase: &dyn Fn(usize) -> f64, fault: f64| {
            let source = |k: usize| C64::from_polar(1.0, phase(k));
            let field = |k: usize, m: usize| C64::new(1.0 + 0.5 * m as f64, 0.01 * k as f64);
            let heard = |m: usize| (0..60).map(|k| field(k, m) * source(k)).collect::<Vec<_>>();
            let values = |m: usize| {
                let off = |k: usize| source(k) * fault * (1.0 - 2.0 * m as f64) + noise[k][m];
                heard(m).into_iter().enumerate().map(|(k, z)| z + off(k)).collect::<Vec<_>>()
            };
            let all = [0, 1].map(|m| Measured { sources: 1, ..load(values(m), vec![5e-3; 60]) });
            left(&all, vec![heard(0), heard(1)], Rest { noise: &[], kernel: None })
        };
        let (still, jumping) = (of(&|_| 0.0, 0.02), of(&|k| jumps[k], 0.02));
        assert!(still.neighbours_sds > 2.0 * NOT_NOISE, "{}", still.neighbours_sds);
        assert!((jumping.neighbours / still.neighbours - 1.0).abs() < 0.1, "{}", jumping.neighbours);
        // Noise alone does not correlate, whatever the phases are.
        for left in [of(&|_| 0.0, 0.0), of(&|k| jumps[k], 0.0)] {
            assert!(left.neighbours_sds.abs() < NOT_NOISE, "{}", left.neighbours_sds);
        }
    }

    /// Noise in proportion to the modulus is taken for what it is where every number has its share of it.
    #[test]
    fn behaviour_no_growth_is_told_where_the_noise_has_a_part_in_proportion() {
        let model: Vec<C64> = (1..=30).map(|k| C64::from(0.1 * f64::from(k))).collect();
        let values: Vec<C64> =
            model.iter().enumerate().map(|(k, z)| z * (1.0 + 0.2 * (k as f64).sin())).collect();
        let factor = model.iter().map(|z| z.norm_sqr()).collect();
        let all = [Measured { factor, ..load(values.clone(), Vec::new()) }];
        let noise = [rijke_inference::NoiseEstimate {
            name: super::super::NOISE.into(),
            unit: "1".into(),
            sd: 0.1,
            floats: true,
            few: None,
        }];
        let rest = Rest { noise: &noise, kernel: None };
        assert_eq!(left(&all, vec![model.clone()], rest).growth, None);
        assert!(left(&[load(values, Vec::new())], vec![model], rest).growth.is_some());
    }
}
