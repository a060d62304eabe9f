//! What planned measurements would tell of the parameters of a model, before anything is measured.

use super::stages::Stage;
use rijke_inference::{InferenceError, Parameters, relative_noise};
use rijke_model::{Assembly, Conditions, ModelError, PointModel, Workspace, hears_near_field};
use rijke_numerics::{C64, Cholesky, Matrix, Order, symmetric_eigen};
use serde::Serialize;

/// Width of the posterior relative to the prior above which a direction counts as unidentified.
const UNIDENTIFIED: f64 = 0.9;
/// Components of a direction below this are left out of its name.
const MINOR: f64 = 0.2;

/// What measurements would leave of the prior of a model, to first order at the centre of the prior.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Identified {
    /// Each parameter with its standard deviation after the measurements, relative to that of the prior.
    pub(crate) widths: Vec<(String, f64)>,
    /// Combinations that keep more than 0.9 of the width of the prior: in words, and that share.
    pub(crate) unidentified: Vec<(String, f64)>,
    /// Number of combinations of the growth rates, and of the frequencies, of the stage's points that the model cannot reach within
    /// its priors and what the earlier stages teach. The noise, which floats, is learnt from these alone: where there are none, the
    /// model goes through every point, and the likelihood grows without bound as the noise goes to zero.
    pub(crate) left_to_noise: [usize; 2],
}

/// The posterior width of a Gaussian with the prior's scale S, the Jacobian J at the centre and the noise C is that of
/// (1 + S J' C^-1 J S)^-1, by whose eigenvectors the parameters are told apart.
///
/// J' C^-1 J is the sum over the points of the stage, by the model `assembly`, and over those of earlier stages, by what stands for them.
/// `sd`: noise of the growth rate (1/s), the angular frequency (rad/s), and each part of a relative pressure at each point.
pub(crate) fn identify(assembly: &Assembly, stage: &Stage, sd: [f64; 3]) -> Result<Identified, ModelError> {
    let list = assembly.parameters();
    let (standing, before) = &stage.earlier;
    let known = information(&jacobians(standing, before, sd)?, standing.parameters().len());
    let place = |i: usize| standing.parameters().iter().position(|p| p.name == list[i].name);
    let known = Matrix::from_fn(list.len(), list.len(), |i, j| match (place(i), place(j)) {
        (Some(i), Some(j)) => known[(i, j)],
        _ => 0.0,
    });
    let own = jacobians(assembly, &stage.points, sd)?;
    let total = known.plus(1.0, &information(&own, list.len()));
    let (values, vectors) = symmetric_eigen(&total).map_err(InferenceError::from)?;
    let left = |k: usize| 1.0 / (1.0 + values[k].max(0.0));
    let width = |i: usize| (0..list.len()).map(|k| vectors[(i, k)].powi(2) * left(k)).sum::<f64>().sqrt();
    let in_words = |k: usize| {
        let mut parts: Vec<(f64, &str)> =
            (0..list.len()).map(|i| (vectors[(i, k)], list[i].name.as_str())).collect();
        parts.retain(|(share, _)| share.abs() > MINOR);
        parts.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
        match &parts[..] {
            [(_, only)] => (*only).to_owned(),
            several => {
                let terms = several.iter().map(|(share, name)| format!("{share:+.2} {name}"));
                terms.collect::<Vec<_>>().join(" ")
            }
        }
    };
    Ok(Identified {
        widths: (0..list.len()).map(|i| (list[i].name.clone(), width(i))).collect(),
        unidentified: (0..list.len())
            .map(|k| (in_words(k), left(k).sqrt()))
            .filter(|(_, width)| *width > UNIDENTIFIED)
            .collect(),
        left_to_noise: [out_of_reach(&own, 0, &known)?, out_of_reach(&own, 1, &known)?],
    })
}

/// How many combinations of number `row` of the points move by less than its noise over the prior that `known` leaves.
fn out_of_reach(own: &[Matrix], row: usize, known: &Matrix) -> Result<usize, ModelError> {
    let prior = Matrix::identity(known.rows()).plus(1.0, known);
    let factor = Cholesky::new(&prior).map_err(InferenceError::from)?;
    let moves: Vec<Vec<f64>> = own.iter().map(|j| factor.whiten(j.row(row))).collect();
    let product = |a: usize, b: usize| moves[a].iter().zip(&moves[b]).map(|(x, y)| x * y).sum();
    let covariance = Matrix::from_fn(own.len(), own.len(), product);
    let (variances, _) = symmetric_eigen(&covariance).map_err(InferenceError::from)?;
    Ok(variances.iter().filter(|v| **v < 1.0).count())
}

/// The sum of J'J.
fn information(jacobians: &[Matrix], parameters: usize) -> Matrix {
    jacobians
        .iter()
        .fold(Matrix::zeros(parameters, parameters), |sum, j| sum.plus(1.0, &j.transpose().product(j)))
}

/// C^{-1/2} J S of every point at the centre of the priors: growth rate, angular frequency, relative pressures. Microphones within
/// a radius of the heater are not used, as in the training.
fn jacobians(assembly: &Assembly, points: &[Conditions], sd: [f64; 3]) -> Result<Vec<Matrix>, ModelError> {
    let list = assembly.parameters();
    let parameters = Parameters::new(list.to_vec())?;
    let centre = parameters.centre();
    let values = parameters.physical(&centre);
    let slope = |k: usize| parameters.scales()[k] * list[k].physical(centre[k])[1];
    let scales: Vec<f64> = (0..list.len()).map(slope).collect();
    let work = &mut Workspace::default();
    let mut one = |conditions: &Conditions| {
        let microphones = far_from_heater(assembly, conditions);
        let model = PointModel::new(assembly, conditions, &microphones)?;
        let found = model.respond(&values, Order::First, work)?;
        let others: Vec<_> = model.numbers(&found).skip(1).collect();
        let pressures: Vec<C64> = others.iter().map(|p| p.value()).collect();
        let noise = relative_noise(&pressures);
        let factor = Cholesky::new(&noise).map_err(InferenceError::from)?;
        let column = |k: usize| {
            let s = found.s.gradient()[k];
            let parts: Vec<f64> = others.iter().map(|p| p.gradient()[k]).flat_map(|z| [z.re, z.im]).collect();
            let pressures = factor.whiten(&parts).into_iter().map(|p| p / sd[2]);
            let all = [s.re / sd[0], s.im / sd[1]].into_iter().chain(pressures);
            all.map(|z| z * scales[k]).collect::<Vec<f64>>()
        };
        let columns: Vec<Vec<f64>> = (0..list.len()).map(column).collect();
        Ok(Matrix::from_fn(2 + 2 * others.len(), list.len(), |row, k| columns[k][row]))
    };
    points.iter().map(&mut one).collect()
}

/// The microphones that a training would use: where the pressure is that of plane waves; the reference always.
fn far_from_heater(assembly: &Assembly, conditions: &Conditions) -> Vec<usize> {
    let rig = &assembly.rig;
    let near = |m: usize| hears_near_field(rig, &conditions.point, m);
    (0..rig.microphones.positions.len()).filter(|&m| m == rig.microphones.reference || !near(m)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::stages::stages;
    use super::*;
    use rijke_inference::{MapOptions, NoiseMode};
    use rijke_model::{Noise, Observed, Training, train};
    use rijke_rig::{Campaign, OperatingPoint, Ping, Rig};
    use std::path::Path;

    const SD: [f64; 3] = [0.1, 1.0, 5e-3];

    fn prong_points(positions: &str) -> Vec<(OperatingPoint, f64)> {
        let campaign = format!(
            "name = 'c'\n[[row]]\nid = 'C'\nheater = false\nthermocouples = false\npower_w = 0\nrepeats = 4\n\
             empty_tube = true\npositions_cm = [{positions}]\n"
        );
        let points = Campaign::parse(&campaign, Path::new("c")).unwrap().points;
        points.into_iter().map(|p| (p, 293.15)).collect()
    }

    /// What is foretold is what a training on data at the centre of the prior finds.
    #[test]
    fn oracle_widths_are_those_of_a_training() {
        let rig = Rig::juniper_yoko_2022();
        let (stages, _) = stages(&rig, &prong_points("10, 30, 55, 80"), &[]).unwrap();
        let all: Vec<usize> = (0..rig.microphones.positions.len()).collect();
        for id in ["prongs.6", "prongs.4"] {
            let (_, assembly) = stages[0].models.iter().find(|(name, _)| name == id).unwrap();
            let foretold = identify(assembly, &stages[0], SD).unwrap();
            let parameters = Parameters::new(assembly.parameters().to_vec()).unwrap();
            let centre = parameters.physical(&parameters.centre());
            let points = stages[0].earlier.1.iter().chain(&stages[0].points);
            let observed = points.map(|conditions| {
                let model = PointModel::new(assembly, conditions, &all).unwrap();
                let found = model.respond(&centre, Order::Value, &mut Workspace::default()).unwrap();
                let pressures = found.pressures.iter().map(|p| p.value()).collect();
                let (reference, covariance) =
                    (rig.microphones.reference, Matrix::identity(2 * rig.microphones.positions.len()));
                let ping = Ping { s: found.s.value(), pressures, reference, covariance };
                Observed { conditions: conditions.clone(), ping }
            });
            let fixed = SD.map(|sd| NoiseMode::Fixed { sd });
            let training = Training {
                microphones: all.clone(),
                noise: Noise {
                    growth_rate: fixed[0],
                    angular_frequency: fixed[1],
                    pressure: fixed[2],
                    ..Noise::FLOATED
                },
                known: Vec::new(),
                varying: Vec::new(),
                channels: None,
                search: MapOptions::default(),
                base_errors: false,
                checks: None,
            };
            let trained = train(assembly, &observed.collect::<Vec<_>>(), &training).unwrap();
            for (k, (name, width)) in foretold.widths.iter().enumerate() {
                let expected = trained.covariance[(k, k)].sqrt() / parameters.scales()[k];
                assert!((width / expected - 1.0).abs() < 1e-6, "{id} {name}: {width}, {expected}");
            }
        }
    }

    /// Two factors of which only the product acts: no measurement parts them, and the direction is named.
    #[test]
    fn exact_a_product_of_two_unknowns_is_not_identified() {
        let text = "[[candidate]]\nid = 'twice'\nrole = 'prongs'\nname = 'twice'\ncite = ['none']\n\
            parameters.a = { symbol = 'a', unit = '1', prior = { normal = { mean = 1.0, sd = 0.3 } } }\n\
            parameters.b = { symbol = 'b', unit = '1', prior = { normal = { mean = 1.0, sd = 0.3 } } }\n\
            [[candidate.effect]]\nacts_at = 'prong-end'\neu = 'a*b*A_p/A'\n";
        let own = rijke_candidates::Catalogue::from_toml(text, "own").unwrap();
        let rig = Rig::juniper_yoko_2022();
        let (stages, _) = stages(&rig, &prong_points("10, 30, 55, 80"), own.candidates()).unwrap();
        let (_, assembly) = stages[0].models.last().unwrap();
        let found = identify(assembly, &stages[0], SD.map(|sd| sd / 100.0)).unwrap();
        let [(words, width)] = &found.unidentified[..] else { panic!("{found:?}") };
        assert!((width - 1.0).abs() < 1e-9, "{width}");
        let opposite = ["-0.71 a +0.71 b", "+0.71 a -0.71 b", "+0.71 b -0.71 a", "-0.71 b +0.71 a"];
        assert!(opposite.contains(&words.as_str()), "{words}");
        // Each of them alone keeps half of its variance.
        let width = |name: &str| found.widths.iter().find(|(n, _)| n == name).unwrap().1;
        assert!((width("a") - 0.5_f64.sqrt()).abs() < 1e-3 && (width("a") - width("b")).abs() < 1e-9);
    }
}
