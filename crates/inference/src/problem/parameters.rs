//! The unknowns of one model and their joint prior.

use super::alias::Alias;
use super::parameter::{Coordinates, Parameter};
use super::prior::Prior;
use super::scale;
use crate::error::InferenceError;
use crate::numbers::normal_cdf;
use rijke_numerics::{Cholesky, Matrix};
use std::f64::consts::PI;

/// The parameters of a model in a fixed order, with their joint prior density in working coordinates.
///
/// Parameters are independent unless [`Parameters::with_joint`] ties some of them by a Gaussian: the way in
/// which the posterior of an earlier stage becomes the prior of the next.
#[derive(Clone, Debug)]
pub struct Parameters {
    list: Vec<Parameter>,
    joint: Vec<Joint>,
    /// True for parameters whose own prior is replaced by a joint one.
    tied: Vec<bool>,
    /// Where the model repeats itself if several values change at once.
    pub(super) aliases: Vec<Alias>,
}

#[derive(Clone, Debug)]
struct Joint {
    members: Vec<usize>,
    mean: Vec<f64>,
    covariance: Matrix,
    precision: Matrix,
    factor: Cholesky,
}

/// ln of a density with gradient and Hessian.
pub(crate) struct LnDensity {
    pub(crate) value: f64,
    pub(crate) gradient: Vec<f64>,
    pub(crate) hessian: Matrix,
}

impl Parameters {
    /// Independent parameters; the list may be empty, which is the model without freedom.
    ///
    /// # Errors
    /// [`InferenceError::BadPrior`] or, for a name given twice, [`InferenceError::BadName`].
    pub fn new(list: Vec<Parameter>) -> Result<Self, InferenceError> {
        for (i, parameter) in list.iter().enumerate() {
            parameter.validate()?;
            if list[..i].iter().any(|other| other.name == parameter.name) {
                return Err(name_error(&list, &parameter.name, "is given twice"));
            }
        }
        let tied = vec![false; list.len()];
        Ok(Self { list, joint: Vec::new(), tied, aliases: Vec::new() })
    }

    /// Replaces the priors of the named parameters by one Gaussian in their working coordinates.
    ///
    /// # Errors
    /// [`InferenceError::BadName`] for an unknown name or one already tied, [`InferenceError::BadJoint`] for
    /// a covariance that is not positive definite or not of the right size.
    pub fn with_joint(
        mut self,
        names: &[&str],
        mean: &[f64],
        covariance: &Matrix,
    ) -> Result<Self, InferenceError> {
        let bad = |problem: String| InferenceError::BadJoint { names: names.join(", "), problem };
        let mut members = Vec::new();
        for &name in names {
            let index = self.place(name)?;
            if self.tied[index] || members.contains(&index) {
                return Err(name_error(&self.list, name, "is given twice"));
            }
            members.push(index);
        }
        let n = members.len();
        if mean.len() != n || covariance.rows() != n || covariance.columns() != n {
            return Err(bad(format!(
                "{n} names, {} means and a {} x {} covariance",
                mean.len(),
                covariance.rows(),
                covariance.columns()
            )));
        }
        if mean.iter().any(|v| !v.is_finite()) {
            return Err(bad(format!("the mean {mean:?} is not finite")));
        }
        for (k, name) in names.iter().enumerate() {
            scale::check(name, "sd", covariance[(k, k)].sqrt(), Some(mean[k]))?;
        }
        let asymmetry = (0..n)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| {
                (covariance[(i, j)] - covariance[(j, i)]).abs()
                    / (covariance[(i, i)] * covariance[(j, j)]).sqrt()
            })
            .fold(0.0, f64::max);
        if asymmetry > 1e-9 {
            return Err(bad(format!(
                "the covariance is not symmetric (correlations differ by {asymmetry:.1e})"
            )));
        }
        let factor = Cholesky::new(covariance).map_err(|e| bad(e.to_string()))?;
        for &i in &members {
            self.tied[i] = true;
        }
        self.joint.push(Joint {
            members,
            mean: mean.to_vec(),
            covariance: covariance.clone(),
            precision: factor.inverse(),
            factor,
        });
        Ok(self)
    }

    /// As [`Parameters::with_joint`], of a Gaussian in physical values as [`crate::Laplace::parameters`] and
    /// [`crate::Laplace::physical_covariance`] state it: the inverse of their step from working coordinates,
    /// so that nothing is lost.
    ///
    /// # Errors
    /// As [`Parameters::with_joint`]; a mean at which a transform has no slope.
    pub fn with_physical_joint(
        self,
        names: &[&str],
        mean: &[f64],
        covariance: &Matrix,
    ) -> Result<Self, InferenceError> {
        let sizes = [names.len(), mean.len(), covariance.rows(), covariance.columns()];
        if sizes.iter().any(|size| *size != names.len()) {
            // Which says what does not fit.
            return self.with_joint(names, mean, covariance);
        }
        let mut working = Vec::with_capacity(mean.len());
        let mut slopes = Vec::with_capacity(mean.len());
        for (name, value) in names.iter().zip(mean) {
            let parameter = &self.list[self.place(name)?];
            working.push(parameter.working(*value));
            slopes.push(parameter.physical(parameter.working(*value))[1]);
        }
        let n = covariance.rows().min(slopes.len());
        let moved = Matrix::from_fn(n, n, |i, j| covariance[(i, j)] / (slopes[i] * slopes[j]));
        self.with_joint(names, &working, &moved)
    }

    /// The parameters, in order.
    #[must_use]
    pub fn list(&self) -> &[Parameter] {
        &self.list
    }

    /// Number of parameters.
    #[must_use]
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// True if the model has no freedom.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Place of the parameter called `name`.
    #[must_use]
    pub fn index(&self, name: &str) -> Option<usize> {
        self.list.iter().position(|p| p.name == name)
    }

    /// As [`Parameters::index`], with an error that lists the known names.
    pub(crate) fn place(&self, name: &str) -> Result<usize, InferenceError> {
        self.index(name).ok_or_else(|| name_error(&self.list, name, "is unknown"))
    }

    /// Physical values at the working coordinates `z`.
    #[must_use]
    pub fn physical(&self, z: &[f64]) -> Vec<f64> {
        self.list.iter().zip(z).map(|(p, &z)| p.physical(z)[0]).collect()
    }

    /// Physical values with the names of their parameters, for people.
    pub(crate) fn in_words(&self, values: &[f64]) -> String {
        let one = |(p, v): (&Parameter, &f64)| {
            let short = format!("{v:.4e}").parse::<f64>().unwrap_or(*v);
            format!("{} = {short}", p.name)
        };
        self.list.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
    }

    /// Working coordinates of physical values.
    #[must_use]
    pub fn working(&self, values: &[f64]) -> Vec<f64> {
        self.list.iter().zip(values).map(|(p, &a)| p.working(a)).collect()
    }

    /// The centre of the prior in working coordinates, where a fit starts: the median of each parameter.
    #[must_use]
    pub fn centre(&self) -> Vec<f64> {
        let mut z: Vec<f64> = self.list.iter().map(|p| p.start().0).collect();
        for joint in &self.joint {
            for (&i, &m) in joint.members.iter().zip(&joint.mean) {
                z[i] = m;
            }
        }
        z
    }

    /// The standard deviation of the prior in each working coordinate, or its like for a prior that is not
    /// Gaussian.
    #[must_use]
    pub fn scales(&self) -> Vec<f64> {
        let mut scales: Vec<f64> = self.list.iter().map(|p| p.start().1).collect();
        for joint in &self.joint {
            for (k, &i) in joint.members.iter().enumerate() {
                scales[i] = joint.covariance[(k, k)].sqrt();
            }
        }
        scales
    }

    /// A point of the prior in working coordinates from as many independent standard normal numbers.
    /// A [`Prior::Flat`] parameter cannot be drawn and gives NaN.
    #[must_use]
    pub fn from_standard_normal(&self, xi: &[f64]) -> Vec<f64> {
        let mut z: Vec<f64> = self
            .list
            .iter()
            .zip(xi)
            .map(|(p, &x)| match (p.prior, p.coordinates) {
                (Prior::Normal { mean, sd }, Coordinates::Natural) => mean + sd * x,
                (Prior::LogNormal { median, ln_sd }, Coordinates::Log) => median.ln() + ln_sd * x,
                (_, Coordinates::Score) => x,
                (prior, _) => p.working(prior.quantile(normal_cdf(x))),
            })
            .collect();
        for joint in &self.joint {
            let own: Vec<f64> = joint.members.iter().map(|&i| xi[i]).collect();
            for (k, &i) in joint.members.iter().enumerate() {
                let row = joint.factor.lower().row(k);
                z[i] = joint.mean[k] + row.iter().zip(&own).map(|(l, x)| l * x).sum::<f64>();
            }
        }
        z
    }

    /// True if a joint prior stands in the place of the declared one of parameter `i`.
    pub(crate) fn is_tied(&self, i: usize) -> bool {
        self.tied[i]
    }

    /// Each joint prior: its members, how far `z` is from its mean, and the factor of its covariance.
    pub(crate) fn joints(&self, z: &[f64]) -> impl Iterator<Item = (&[usize], Vec<f64>, &Cholesky)> {
        self.joint.iter().map(move |joint| {
            let offset = joint.members.iter().zip(&joint.mean).map(|(&i, m)| z[i] - m).collect();
            (joint.members.as_slice(), offset, &joint.factor)
        })
    }

    /// Slopes with respect to the standard normal numbers `xi`, from slopes with respect to the working
    /// coordinates `z` that belong to them.
    ///
    /// Both densities are one: dz/dxi = phi(xi)/p(z) for a parameter with a prior of its own.
    pub(crate) fn along_standard_normal(
        &self,
        xi: &[f64],
        z: &[f64],
        slopes: &[f64],
    ) -> Result<Vec<f64>, InferenceError> {
        let mut out = vec![0.0; self.len()];
        for i in (0..self.len()).filter(|&i| !self.tied[i]) {
            let ln_phi = -0.5 * (xi[i] * xi[i] + (2.0 * PI).ln());
            out[i] = slopes[i] * (ln_phi - self.list[i].ln_density(z[i])?[0]).exp();
        }
        for joint in &self.joint {
            for (l, &j) in joint.members.iter().enumerate() {
                let lower = joint.factor.lower();
                out[j] = joint.members.iter().enumerate().map(|(k, &i)| slopes[i] * lower[(k, l)]).sum();
            }
        }
        Ok(out)
    }

    /// The first parameter whose prior is improper.
    #[must_use]
    pub fn improper(&self) -> Option<&Parameter> {
        self.list.iter().zip(&self.tied).find(|(p, tied)| p.prior == Prior::Flat && !**tied).map(|(p, _)| p)
    }

    /// The same parameters with the prior standard deviation (or width) of parameter `i` multiplied by
    /// `factor`; in a joint prior its correlations stay.
    ///
    /// # Panics
    /// If there is no parameter `i`.
    #[must_use]
    pub fn widened(&self, i: usize, factor: f64) -> Self {
        let mut wide = self.clone();
        wide.list[i].prior = wide.list[i].prior.widened(factor);
        for joint in &mut wide.joint {
            let Some(place) = joint.members.iter().position(|&m| m == i) else { continue };
            let scale = |k: usize| if k == place { factor } else { 1.0 };
            let (n, c) = (joint.members.len(), joint.covariance.clone());
            joint.covariance = Matrix::from_fn(n, n, |k, l| scale(k) * c[(k, l)] * scale(l));
            if let Ok(factor) = Cholesky::new(&joint.covariance) {
                joint.precision = factor.inverse();
                joint.factor = factor;
            }
        }
        wide
    }

    /// ln of the prior density in working coordinates.
    pub(crate) fn ln_density(&self, z: &[f64]) -> Result<LnDensity, InferenceError> {
        let n = self.len();
        let mut out = LnDensity { value: 0.0, gradient: vec![0.0; n], hessian: Matrix::zeros(n, n) };
        for i in 0..n {
            if !self.tied[i] {
                let [value, slope, curvature] = self.list[i].ln_density(z[i])?;
                out.value += value;
                out.gradient[i] = slope;
                out.hessian[(i, i)] = curvature;
            }
        }
        for joint in &self.joint {
            let offset: Vec<f64> = joint.members.iter().zip(&joint.mean).map(|(&i, m)| z[i] - m).collect();
            let pull = joint.precision.times(&offset);
            let white = joint.factor.whiten(&offset);
            let size = offset.len() as f64;
            out.value -= 0.5
                * (white.iter().map(|w| w * w).sum::<f64>() + joint.factor.ln_det() + size * (2.0 * PI).ln());
            for (k, &i) in joint.members.iter().enumerate() {
                out.gradient[i] -= pull[k];
                for (l, &j) in joint.members.iter().enumerate() {
                    out.hessian[(i, j)] -= joint.precision[(k, l)];
                }
            }
        }
        Ok(out)
    }
}

fn name_error(list: &[Parameter], name: &str, problem: &'static str) -> InferenceError {
    let known = list.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(", ");
    InferenceError::BadName { parameter: name.to_owned(), problem, known }
}
