//! Where a fit starts, and what the residuals of a fit say of floating noise.

use super::posterior::Posterior;
use crate::density::{Energy, Objective, TrustRegion, minimise};
use crate::error::InferenceError;
use crate::problem::{NoiseMode, Prediction};
use rijke_numerics::{Order, scatter_beyond};

/// How far, in ln sd, a noise may be from the root mean square of its residuals before all coordinates are
/// free.
const REACH: f64 = 1.5;

/// A floated noise that may be none: the measured covariance alone may explain the residuals.
pub(crate) struct Settled {
    pub(crate) coordinate: usize,
    /// ln of a standard deviation that adds nothing to the floor.
    pub(crate) ln_sd: f64,
}

/// A noise below this share of the measured variance counts as none.
const NEGLIGIBLE: f64 = 1e-3;
/// The share of it that adds nothing to rounding.
const NOTHING: f64 = 1e-16;

/// Residuals of data over the size of a noise in them.
struct Residuals {
    /// Square of each, and its measured variance.
    each: Vec<[f64; 2]>,
}

/// Squares of residuals over the measured variances that leave something for a noise.
const BEYOND: f64 = 1.5;

impl Residuals {
    fn squares(&self) -> f64 {
        self.each.iter().map(|[square, _]| square).sum()
    }

    /// The lowest measured variance; infinite without data.
    fn lowest(&self) -> f64 {
        self.each.iter().map(|[_, floor]| *floor).fold(f64::INFINITY, f64::min)
    }

    /// The mean of their squares over their measured variances.
    fn over(&self) -> f64 {
        let of = |[square, floor]: &[f64; 2]| if *square > 0.0 { square / floor } else { 0.0 };
        self.each.iter().map(of).sum::<f64>() / self.each.len().max(1) as f64
    }

    /// The variance of a noise that explains what they are beyond the measured ones, and no less than a
    /// hundredth of the mean of their squares.
    fn noise(&self) -> f64 {
        scatter_beyond(&self.each).max(0.01 * self.squares() / self.each.len().max(1) as f64)
    }
}

impl Settled {
    /// So far below the lowest variance of the floor that C is the floor to rounding, yet d/dt can still be
    /// formed.
    fn at(coordinate: usize, lowest: f64) -> Self {
        Self { coordinate, ln_sd: 0.5 * (NOTHING * lowest).ln() }
    }

    /// ln of the standard deviation whose variance is such a share of the lowest one of the floor.
    pub(crate) fn grown_to(&self, share: f64) -> f64 {
        self.ln_sd + 0.5 * (share / NOTHING).ln()
    }
}

impl Posterior<'_> {
    /// Starting point, the given or central parameters, and the prediction there. The floating noise is set
    /// to one, or to its median.
    pub(crate) fn start(&self, physical: Option<&[f64]>) -> Result<(Vec<f64>, Prediction), InferenceError> {
        let mut z = self.start_alone(physical)?;
        let values = self.parameters().physical(&z);
        // Before the model is called: a point beyond a bound must not reach it.
        let prediction =
            self.parameters().ln_density(&z).and_then(|_| self.predict(&values, Order::Value)).map_err(
                |source| InferenceError::NoStart {
                    at: self.parameters().in_words(&values),
                    source: Box::new(source),
                },
            )?;
        z.extend(self.floating().iter().map(|&g| match self.data().groups()[g].mode {
            NoiseMode::Inferred { median, .. } => median.ln(),
            _ => 0.0,
        }));
        self.guess_structured(&mut z, &prediction.values);
        Ok((z, prediction))
    }

    /// Sets what floats in structured blocks to a size that suits the residuals.
    fn guess_structured(&self, z: &mut [f64], predicted: &[f64]) {
        let (p, mut first) = (self.parameters().len(), 0);
        for observation in self.data().observations() {
            let n = observation.values.len();
            if let Some(structured) = &observation.structured {
                let residuals: Vec<f64> =
                    (0..n).map(|i| predicted[first + i] - observation.values[i]).collect();
                for (group, size) in structured.guesses(&residuals) {
                    let place = self.floating().iter().position(|g| *g == group);
                    if let Some(k) = place.filter(|_| self.data().groups()[group].mode == NoiseMode::Floated)
                    {
                        z[p + k] = size.ln();
                    }
                }
            }
            first += n;
        }
    }

    /// The working coordinates of the given or central parameters, without noise.
    pub(crate) fn start_alone(&self, physical: Option<&[f64]>) -> Result<Vec<f64>, InferenceError> {
        let p = self.parameters().len();
        match physical {
            Some(values) if values.len() != p => {
                Err(InferenceError::StartSize { found: values.len(), expected: p })
            }
            Some(values) => Ok(self.parameters().working(values)),
            None => Ok(self.parameters().centre()),
        }
    }

    /// Sets each floated (not inferred) noise to what its residuals have beyond the floor, and says which of
    /// them the floor explains. A noise without residuals is left alone.
    pub(crate) fn settle_noise(&self, z: &mut [f64], predicted: &[f64]) -> Vec<Settled> {
        let mut found = Vec::new();
        for (k, &g) in self.floating().iter().enumerate() {
            if let NoiseMode::Inferred { .. } = self.data().groups()[g].mode {
                continue;
            }
            let residuals = self.residuals_of(g, predicted);
            if residuals.squares() > 0.0 {
                z[self.parameters().len() + k] = 0.5 * residuals.noise().ln();
            }
            let lowest = residuals.lowest();
            if lowest > 0.0 && lowest.is_finite() && residuals.over() < 2.0 {
                found.push(Settled::at(self.parameters().len() + k, lowest));
            }
        }
        found
    }

    /// Whether the residuals of some noise that floats are, in the mean of their squares over the measured
    /// variances, larger than this.
    pub(super) fn leaves(&self, predicted: &[f64], limit: f64) -> bool {
        self.floating().iter().any(|&g| self.residuals_of(g, predicted).over() > limit)
    }

    /// Whether any noise is inferred, that is, has a prior.
    pub(crate) fn infers_noise(&self) -> bool {
        let inferred = |g: &usize| matches!(self.data().groups()[*g].mode, NoiseMode::Inferred { .. });
        self.floating().iter().any(inferred)
    }

    /// Raises inferred noises that lie far below what the residuals have beyond the floor; whether there are
    /// any. Below the floor J hardly depends on a noise but for its prior, at whose median a search then
    /// ends.
    pub(crate) fn raise_noise(&self, z: &mut [f64], predicted: &[f64]) -> bool {
        let (p, mut raised) = (self.parameters().len(), false);
        for (k, &g) in self.floating().iter().enumerate() {
            let residuals = self.residuals_of(g, predicted);
            let inferred = matches!(self.data().groups()[g].mode, NoiseMode::Inferred { .. });
            if !(inferred && residuals.over() > BEYOND) {
                continue;
            }
            let excess = 0.5 * residuals.noise().ln();
            if z[p + k] < excess - REACH {
                z[p + k] = excess;
                raised = true;
            }
        }
        raised
    }

    /// What a prediction leaves of the data that have a noise.
    fn residuals_of(&self, group: usize, predicted: &[f64]) -> Residuals {
        let mut each = Vec::new();
        let mut first = 0;
        for observation in self.data().observations() {
            for (_, s) in observation.noise.iter().filter(|(h, _)| *h == group) {
                for i in (0..observation.values.len()).filter(|&i| s[(i, i)] > 0.0) {
                    let r = predicted[first + i] - observation.values[i];
                    let known = observation.floor.as_ref().map_or(0.0, |f| f[(i, i)]) / s[(i, i)];
                    each.push([r * r / s[(i, i)], known]);
                }
            }
            first += observation.values.len();
        }
        Residuals { each }
    }

    /// The floated noises that have become negligible everywhere beside the floor and the other noises.
    pub(crate) fn vanished(&self, z: &[f64]) -> Vec<Settled> {
        let (p, sds) = (self.parameters().len(), self.noise_sd(z));
        let settled = |(k, g): (usize, usize)| {
            let floated = matches!(self.data().groups()[g].mode, NoiseMode::Floated);
            let lowest = self.data().observations().iter().flat_map(|o| {
                let own = o.noise.iter().filter(move |(h, _)| *h == g);
                let sds = &sds;
                own.flat_map(move |(_, s)| {
                    let others = o.noise.iter().filter(move |(h, _)| *h != g);
                    let known = move |i: usize| {
                        let beside = others.clone().map(|(h, s)| sds[*h].powi(2) * s[(i, i)]).sum::<f64>();
                        (o.floor.as_ref().map_or(0.0, |f| f[(i, i)]) + beside) / s[(i, i)]
                    };
                    (0..o.values.len()).filter(move |&i| s[(i, i)] > 0.0).map(known)
                })
            });
            let structured = self.data().observations().iter().filter_map(|o| o.structured.as_ref());
            let lowest = lowest.chain(structured.flat_map(|s| s.floors(g))).fold(f64::INFINITY, f64::min);
            // A noise that acts through columns alone has no floor to be negligible beside.
            let negligible = floated && lowest.is_finite() && (2.0 * z[p + k]).exp() < NEGLIGIBLE * lowest;
            negligible.then(|| Settled::at(p + k, lowest))
        };
        self.floating().iter().copied().enumerate().filter_map(settled).collect()
    }

    /// Brings the floating noise from the root mean square of the residuals to the maximum of the posterior
    /// with this prediction, which differs from it where data share noise, to within `tolerance` nats; calls
    /// no model. Begins at the noise `before` where that is more probable. A noise that has none (its
    /// residuals vanish, or its floor explains them) stays where it is.
    pub(crate) fn refine_noise(
        &self,
        z: &mut [f64],
        prediction: &Prediction,
        before: &[f64],
        tolerance: f64,
    ) -> Result<(), InferenceError> {
        let p = self.parameters().len();
        let noise = NoiseAlone { posterior: self, prediction, z: z.to_vec() };
        let cost = |noise_sd: &[f64]| {
            noise.evaluate(noise_sd, Order::Value).map_or(f64::INFINITY, |energy| energy.value)
        };
        let from = if cost(before) < cost(&z[p..]) { before } else { &z[p..] };
        let search = TrustRegion { tolerance, max_evaluations: 10, ..TrustRegion::default() };
        match minimise(&noise, from, &search) {
            Ok(minimum) if minimum.stop.converged() => {
                let near = minimum.z.iter().zip(&z[p..]).all(|(new, old)| (new - old).abs() < REACH);
                let there = [&z[..p], &minimum.z].concat();
                // Far below its residuals, most of which errors that data share explain, a noise may leave C
                // to the floor, which may be singular: the search over everything decides that, not this
                // one. A structured block has its variance on the diagonal.
                let structured = || self.data().observations().iter().all(|o| o.structured.is_some());
                if near || structured() || self.vanished(&there).is_empty() {
                    z.copy_from_slice(&there);
                }
            }
            Ok(_) => {}
            Err(error) if error.is_recoverable() || matches!(error, InferenceError::NoStart { .. }) => {}
            Err(error) => return Err(error),
        }
        Ok(())
    }
}

/// J as a function of the noise alone, for one prediction.
struct NoiseAlone<'a> {
    posterior: &'a Posterior<'a>,
    prediction: &'a Prediction,
    z: Vec<f64>,
}

impl Objective for NoiseAlone<'_> {
    fn size(&self) -> usize {
        self.posterior.floating().len()
    }

    fn evaluate(&self, noise: &[f64], order: Order) -> Result<Energy, InferenceError> {
        let mut z = self.z.clone();
        z[self.posterior.parameters().len()..].copy_from_slice(noise);
        self.posterior.noise_energy(&z, self.prediction, order)
    }
}
