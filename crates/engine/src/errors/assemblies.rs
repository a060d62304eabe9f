//! What assemblies of the rig differ by, where more than one stage has points of one assembly: one cause,
//! whose posterior goes on.
//!
//! In the stage that meets an assembly first, its errors are noise that its points share. What that stage
//! tells of them is computed afterwards ([`Linearised::causes`]) and handed on with the posterior of the
//! parameters; in a later stage they are parameters beside the model's, in which the prediction is linear.

use super::Scatter;
use crate::gaussian::{NamedGaussian, Training};
use crate::noise::{BETWEEN, MEASURED, NONE, UNITS};
use crate::observed::{Observed, Used};
use rijke_inference::{Linearised, NoiseEstimate, Parameter, Prior};
use rijke_numerics::Matrix;

/// Between the words for an error and the name of its assembly.
pub(crate) const OF_INSTALLATION: &str = " of installation ";

/// The errors of the assemblies of a training.
#[derive(Default)]
pub(crate) struct Assemblies {
    /// Those of which an earlier stage tells.
    known: Vec<Effect>,
    /// Those of which later ones want to know.
    wanted: Vec<Effect>,
}

/// An error of one assembly.
struct Effect {
    /// As a parameter is called; no formula can have such a name.
    name: String,
    unit: String,
    /// The noise that it is where nothing is known of it.
    noise: String,
    /// Growth rate 0, frequency 1, then the parameters that vary.
    kind: usize,
    installation: String,
    /// The change of every number of the prediction, point after point.
    column: Vec<f64>,
}

impl Assemblies {
    /// Those of a training with errors of its base states.
    pub(crate) fn of(observed: &[Observed], used: &[Used], training: &Training, scatter: &[Scatter]) -> Self {
        let mut installations: Vec<&str> = Vec::new();
        for o in observed {
            let name = o.conditions.point.installation.as_str();
            if !installations.contains(&name) {
                installations.push(name);
            }
        }
        let shared = training.noise.of_an_installation;
        let measured = (0..2).filter(|k| shared[*k] != NONE && used.iter().any(|u| u.rows.contains(k)));
        let measured = measured.map(|k| (k, format!("{}{BETWEEN}", MEASURED[k]), UNITS[k].to_owned(), None));
        let varying = scatter.iter().enumerate();
        let varying = varying.map(|(k, s)| (2 + k, s.group.name.clone(), s.group.unit.clone(), Some(s)));
        let mut all = Self::default();
        for (kind, noise, unit, scatter) in measured.chain(varying) {
            for installation in &installations {
                let of = |(p, (o, u)): (usize, (&Observed, &Used))| -> Vec<f64> {
                    let own = o.conditions.point.installation == *installation;
                    match scatter {
                        _ if !own => vec![0.0; u.size()],
                        Some(scatter) => scatter.slopes[p].clone(),
                        None => (0..u.size()).map(|row| f64::from(u8::from(row == kind))).collect(),
                    }
                };
                let what = noise.strip_suffix(BETWEEN).unwrap_or(&noise);
                let name = format!("{what}{OF_INSTALLATION}{installation}");
                let known = training.known.iter().any(|k| k.names.contains(&name));
                let effect = Effect {
                    name,
                    unit: unit.clone(),
                    noise: noise.clone(),
                    kind,
                    installation: (*installation).to_owned(),
                    column: observed.iter().zip(used).enumerate().flat_map(of).collect(),
                };
                if known {
                    all.known.push(effect);
                } else if training.assemblies.iter().any(|a| a == installation) {
                    all.wanted.push(effect);
                }
            }
        }
        all
    }

    /// Whether an earlier stage tells of the error of this kind of the assembly of a point, so that it is no
    /// noise here.
    pub(crate) fn knows(&self, kind: usize, observed: &Observed) -> bool {
        let installation = &observed.conditions.point.installation;
        self.known.iter().any(|e| e.kind == kind && e.installation == *installation)
    }

    /// Those that are known, as parameters whose priors earlier stages tell.
    pub(crate) fn parameters(&self) -> Vec<Parameter> {
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        self.known.iter().map(|e| Parameter::new(e.name.clone(), "", e.unit.clone(), prior)).collect()
    }

    /// The changes of all numbers by other errors, `slopes`, and by those that are known behind them.
    pub(crate) fn behind(&self, slopes: &Matrix) -> Matrix {
        let (rows, first) = (slopes.rows(), slopes.columns());
        Matrix::from_fn(rows, first + self.known.len(), |row, k| match k.checked_sub(first) {
            None => slopes[(row, k)],
            Some(k) => self.known[k].column[row],
        })
    }

    /// What a training tells of those that later stages want: of its noise, itself to first order with the
    /// place of each datum in the prediction, and its parameters with their values and covariance.
    pub(crate) fn learned(
        &self,
        (linear, order): &(Linearised, Vec<usize>),
        noise: &[NoiseEstimate],
        parameters: (&[Parameter], &[f64], &Matrix),
    ) -> Learned {
        let column = |e: &Effect| order.iter().map(|&place| e.column[place]).collect();
        let columns: Vec<Vec<f64>> = self.wanted.iter().map(column).collect();
        let sd = |e: &Effect| noise.iter().find(|n| n.name == e.noise).map_or(0.0, |n| n.sd);
        let sds: Vec<f64> = self.wanted.iter().map(sd).collect();
        // One that the data choose to be none, or to which they do not point, has nothing to hand on.
        let told = |k: &usize| sds[*k] > 0.0 && columns[*k].iter().any(|v| *v != 0.0);
        let kept: Vec<usize> = (0..columns.len()).filter(told).collect();
        let columns: Vec<Vec<f64>> = kept.iter().map(|&k| columns[k].clone()).collect();
        let sds: Vec<f64> = kept.iter().map(|&k| sds[k]).collect();
        let names = kept.iter().map(|&k| self.wanted[k].name.clone()).collect();
        Learned::of(linear, names, &columns, &sds, parameters)
    }
}

/// What a training found of errors of assemblies, or of causes, beside its parameters.
#[derive(Clone, Debug, Default)]
pub(crate) struct Learned {
    pub(crate) names: Vec<String>,
    pub(crate) mean: Vec<f64>,
    pub(crate) covariance: Matrix,
    /// With the parameters: a row for each error.
    pub(crate) with_parameters: Matrix,
}

impl Learned {
    /// The posterior of errors with these names and standard deviations, which are part of the noise of a
    /// training and move its data by their `columns`. The covariance of the errors is built on this one of
    /// the parameters: of two approximations, a joint matrix could have negative eigenvalues.
    pub(crate) fn of(
        linear: &Linearised,
        names: Vec<String>,
        columns: &[Vec<f64>],
        sds: &[f64],
        (parameters, values, covariance): (&[Parameter], &[f64], &Matrix),
    ) -> Self {
        let causes = linear.causes(columns, sds);
        let slope = |i: usize| parameters[i].physical(parameters[i].working(values[i]))[1];
        let along = Matrix::from_fn(names.len(), parameters.len(), |k, i| causes.along[(k, i)] / slope(i));
        let with_parameters = along.product(covariance);
        let covariance = causes.given.plus(1.0, &with_parameters.product(&along.transpose()));
        Self { names, mean: causes.mean, covariance, with_parameters }
    }

    /// `known` of the parameters, and this.
    pub(crate) fn beside(&self, known: NamedGaussian) -> NamedGaussian {
        let p = known.names.len();
        let covariance = Matrix::from_fn(p + self.names.len(), p + self.names.len(), |i, j| {
            match (i.checked_sub(p), j.checked_sub(p)) {
                (None, None) => known.covariance[(i, j)],
                (Some(k), None) => self.with_parameters[(k, j)],
                (None, Some(k)) => self.with_parameters[(k, i)],
                (Some(k), Some(l)) => self.covariance[(k, l)],
            }
        });
        NamedGaussian {
            names: known.names.into_iter().chain(self.names.iter().cloned()).collect(),
            mean: known.mean.into_iter().chain(self.mean.iter().copied()).collect(),
            covariance,
        }
    }
}
