//! Fig. 12: how many microphones are needed, and which?

use crate::empty_tube::{PRESSURE_MODEL_ERROR, Setting, case, names, predicted, setting};
use crate::{Case, Check, Microphones, StudyError};
use rayon::prelude::*;
use rijke_inference::NoiseMode;
use rijke_rig::Observations;

/// |R|, angle of R and eta of the empty tube from every set of microphones that holds the reference.
///
/// All sets assume the noise of relative pressures that all microphones together choose: a set of two measures no more
/// than it fits, and could not choose any.
///
/// # Errors
/// As [`crate::empty_tube()`].
pub fn microphones(observations: &Observations, truth: Option<[f64; 3]>) -> Result<Microphones, StudyError> {
    let Setting { assembly, empty, provenance } = setting(observations)?;
    let rig = &observations.rig;
    let (count, reference) = (rig.microphones.positions.len(), rig.microphones.reference);
    let (_, sd) = case(&assembly, &empty, (0..count).collect(), PRESSURE_MODEL_ERROR)?;
    let sets = subsets(count, reference)
        .into_par_iter()
        .map(|set| Ok(case(&assembly, &empty, set, NoiseMode::Fixed { sd })?.0))
        .collect::<Result<Vec<_>, StudyError>>()?;
    Ok(Microphones {
        provenance,
        point: empty.conditions.point.id.clone(),
        parameters: names(&assembly),
        positions_m: rig.microphones.positions.clone(),
        checks: checks(&sets),
        sets,
        pressure_noise_sd: sd,
        predicted: predicted(rig, &empty),
        truth: truth.map(|t| t.to_vec()),
    })
}

/// Every set of `count` microphones that holds `reference`, small sets first.
fn subsets(count: usize, reference: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = (0_u64..1 << count)
        .filter(|bits| bits >> reference & 1 == 1)
        .map(|bits| (0..count).filter(|m| bits >> m & 1 == 1).collect())
        .collect();
    all.sort_by_key(Vec::len);
    all
}

/// The statements of section 6.7.
fn checks(sets: &[Case]) -> Vec<Check> {
    let sd = |c: &Case, i: usize| c.covariance[i][i].sqrt();
    let all = sets.iter().max_by_key(|c| c.microphones.len());
    let (Some(one), Some(all)) = (sets.first(), all) else { return Vec::new() };
    // How much wider the posterior of a set is than that of all microphones, for its worst parameter.
    let width = |c: &Case| (0..3).map(|i| sd(c, i) / sd(all, i)).fold(0.0, f64::max);
    let pairs: Vec<f64> = sets.iter().filter(|c| c.microphones.len() == 2).map(width).collect();
    let best = pairs.iter().copied().fold(f64::INFINITY, f64::min);
    let worst = pairs.iter().copied().fold(0.0, f64::max);
    let spread = |size: usize| {
        let widths: Vec<f64> = sets.iter().filter(|c| c.microphones.len() == size).map(width).collect();
        widths.iter().copied().fold(0.0, f64::max)
    };
    let worsts: Vec<f64> = (2..=all.microphones.len()).map(spread).collect();
    vec![
        Check {
            statement: "With one microphone |R| and eta cannot be told apart.".into(),
            holds: one.correlation[0][2].abs() > 0.95,
            figure: format!("correlation {:.5}", one.correlation[0][2]),
            explanation: None,
        },
        Check {
            statement: "With two microphones the uncertainty depends strongly on which pair is used.".into(),
            holds: worst > 2.0 * best,
            figure: format!("{best:.2} to {worst:.2} times the standard deviations of all microphones"),
            explanation: None,
        },
        Check {
            statement: "The best pair is nearly as good as all microphones: within a factor of two in every parameter.".into(),
            holds: best < 2.0,
            figure: format!("{best:.2} times the standard deviation of all microphones for the worst parameter"),
            explanation: (best >= 2.0).then(|| {
                "Averaging alone makes seven further microphones 2.6 times better than one; a pair below that is as \
                 well placed as all of them."
                    .to_owned()
            }),
        },
        Check {
            statement: "The uncertainty of the worst set falls with every further microphone.".into(),
            holds: worsts.windows(2).all(|w| w[1] < w[0]),
            figure: worsts.iter().map(|w| format!("{w:.2}")).collect::<Vec<_>>().join(", "),
            explanation: None,
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paper_eight_microphones_have_the_sets_of_figure_12() {
        let all = subsets(8, 5);
        let counts: Vec<usize> = (1..=8).map(|k| all.iter().filter(|s| s.len() == k).count()).collect();
        assert_eq!(counts, [1, 7, 21, 35, 35, 21, 7, 1]);
        assert!(all.iter().all(|s| s.contains(&5)));
    }
}
