//! What a training gives.

use crate::errors::{Common, Learned};
use crate::gaussian::NamedGaussian;
use rijke_inference::{Calls, Evidence, Linearised, NoiseEstimate, Parameter, Stop, Verdict};
use rijke_numerics::Matrix;
use std::sync::Arc;

/// A trained model.
#[derive(Clone, Debug)]
pub struct Trained {
    /// The free parameters: those of the model, then errors of the base states that all installations share
    /// and delays and gains of channels, if the training had any.
    pub parameters: Vec<Parameter>,
    /// How many of them are the model's.
    pub own: usize,
    /// What the errors of the base states among them are.
    pub(crate) common: Option<Common>,
    /// What was learnt of the errors of assemblies that later stages have points of.
    pub(crate) learned: Learned,
    /// Likewise of causes of error.
    pub(crate) causes: Learned,
    /// What the data tell of errors that several points share and that stayed a covariance.
    pub(crate) told: OfSeveral,
    /// Their most probable values.
    pub values: Vec<f64>,
    /// Their covariance, wider where few data chose the noise ([`rijke_inference::Few`]).
    pub covariance: Matrix,
    /// Standard deviations of the noise, chosen by the data where they float.
    pub noise: Vec<NoiseEstimate>,
    /// The evidence, in nats, in total.
    pub evidence: Evidence,
    /// How the search ended.
    pub stop: Stop,
    /// Calls of the model that the last search made.
    pub calls: Calls,
    /// Reasons not to trust the evidence; empty if it passed its checks or was not checked.
    pub warnings: Vec<String>,
    /// The model and its data to first order about these values, and the place of each datum in the
    /// prediction.
    pub(crate) linear: Arc<(Linearised, Vec<usize>)>,
    /// What a sampler said of the evidence, if one was asked.
    pub sampler: Option<Verdict>,
    /// Other maxima of the posterior that are not improbable: their odds against this one, and the values of
    /// the model's parameters there.
    pub elsewhere: Vec<(f64, Vec<f64>)>,
}

/// The fit without errors of the base states is searched again if the fit with them lies more standard
/// deviations from it than this: it may have missed a maximum.
const ELSEWHERE: f64 = 10.0;

impl Trained {
    /// The posterior of the parameters, the prior of the next stage.
    #[must_use]
    pub fn gaussian(&self) -> NamedGaussian {
        self.causes.beside(self.learned.beside(self.inferred()))
    }

    /// The posterior of the parameters and of the errors that several points share: what predictions have.
    pub(crate) fn of_predictions(&self) -> NamedGaussian {
        self.told.learned.beside(self.inferred())
    }

    fn inferred(&self) -> NamedGaussian {
        let names = self.parameters.iter().map(|p| p.name.clone()).collect();
        NamedGaussian { names, mean: self.values.clone(), covariance: self.covariance.clone() }
    }

    /// Whether the most probable values lie far from these of the model's parameters.
    pub(crate) fn lies_elsewhere(&self, at: &[f64]) -> bool {
        let far = |((value, at), sd): ((&f64, &f64), f64)| (value - at).abs() > ELSEWHERE * sd;
        self.values.iter().zip(at).zip(self.sd()).any(far)
    }

    /// By how much the value of parameter `j` changes with its working coordinate, where it is most probable.
    pub(crate) fn slope(&self, j: usize) -> f64 {
        let p = &self.parameters[j];
        p.physical(p.working(self.values[j]))[1]
    }

    /// Standard deviation of each parameter.
    #[must_use]
    pub fn sd(&self) -> Vec<f64> {
        let of = |(i, p): (usize, &Parameter)| p.sd_about(self.values[i], self.covariance[(i, i)].sqrt());
        self.parameters.iter().enumerate().map(of).collect()
    }
}

/// Errors that several points share and that stayed a covariance in a training.
#[derive(Clone, Debug, Default)]
pub(crate) struct OfSeveral {
    /// What the data tell of them: predictions have it. Where points are too many for one block, growth rates
    /// and frequencies alone: there the pressures of each point have errors of their own in the covariance.
    pub(crate) learned: Learned,
    /// The change of every such datum per standard deviation of each.
    pub(crate) columns: Vec<Vec<f64>>,
    /// The change of every datum of points that are too many for one block, pressures too.
    pub(crate) apart: Vec<Vec<f64>>,
}
