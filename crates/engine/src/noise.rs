//! What is assumed of the misfit of a model, and what a training found of it.

use crate::Observed;
use rijke_inference::{NoiseEstimate, NoiseMode, student};
use serde::{Deserialize, Serialize};

pub(crate) const NONE: NoiseMode = NoiseMode::Fixed { sd: 0.0 };

/// What is assumed of the difference between model and measurement: the plan's words with the numbers of
/// earlier stages in place.
#[derive(Clone, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviations of growth rate (1/s), angular frequency (rad/s) and each part of a relative
    /// pressure.
    pub of_a_point: [NoiseMode; 3],
    /// Standard deviations of what all points of one installation share, in the growth rate and the angular
    /// frequency. Where every point is an installation of its own, it cannot be told from the noise of the
    /// point.
    pub of_an_installation: [NoiseMode; 2],
    /// Whether the measured covariance is added to these.
    pub measured: bool,
    /// Parameters that come out a little different in every installation.
    pub varying: Vec<Varying>,
    /// An error of the laws of one role; a relative one enters with the errors of the base states only.
    pub law: Option<LawError>,
}

/// A parameter whose value scatters from installation to installation about the one that is inferred: the
/// ends, say, whose effective place moves with what stands near them.
///
/// Enters to first order, as noise along the slope of the prediction: it moves frequency and mode shape
/// together, so that what the microphones say of it in one installation is not taken for knowledge of its
/// mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Varying {
    /// Name of the parameter; one that a model does not have is ignored.
    pub parameter: String,
    /// Standard deviation between installations, in the parameter's unit.
    pub sd: NoiseMode,
}

/// A complex error of the laws of a role, the same at all points of one value of a factor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LawError {
    /// The role.
    pub role: String,
    /// Standard deviation of its real and of its imaginary part.
    pub sd: f64,
    /// Place of the factor among those of the campaign; none for an error that all points share.
    pub over: Option<usize>,
    /// The law to which it is added, in the unit of that law; none for a relative error of all laws of the
    /// role.
    #[serde(default)]
    pub added: Option<Added>,
}

/// A law, by what it acts on and where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Added {
    /// The coefficient, `eu`.
    pub coefficient: String,
    /// The place, as the file of its candidate has it.
    pub place: String,
    /// How far along frequency its error is about the same, Hz: the length of a squared exponential.
    pub length_hz: f64,
    /// Frequencies, Hz, and the standard deviation there over that of the error; the same everywhere if
    /// empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub along: Vec<[f64; 2]>,
}

/// Nodes of such an error in its length: the sum over them is the kernel to 1e-4 of it.
const NODES: f64 = 1.5;

impl Added {
    /// The standard deviation at `hertz` over that of the error: linear between the frequencies that are
    /// known, and beyond them that of the last one.
    pub(crate) fn size(&self, hertz: f64) -> f64 {
        let known = &self.along;
        let after = known.partition_point(|[f, _]| *f < hertz);
        match (after.checked_sub(1).and_then(|k| known.get(k)), known.get(after)) {
            (Some([f, a]), Some([g, b])) => a + (b - a) * (hertz - f) / (g - f),
            (Some([_, size]), None) | (None, Some([_, size])) => *size,
            (None, None) => 1.0,
        }
    }

    /// Nodes along frequency, each an error of unit variance of its own, and their weights in the error at
    /// `hertz`: sums over u of exp(-(f - u)^2/l^2) exp(-(g - u)^2/l^2) are in proportion to exp(-(f -
    /// g)^2/(2 l^2)).
    pub(crate) fn nodes(&self, hertz: f64) -> Vec<(i64, f64)> {
        let at = hertz / self.length_hz;
        let near = (at * NODES).round() as i64;
        let far = (3.0 * NODES) as i64 + 1;
        let weight = |k: i64| (k, (-(at - k as f64 / NODES).powi(2)).exp());
        let all: Vec<(i64, f64)> = (near - far..=near + far).map(weight).collect();
        let size = all.iter().map(|(_, w)| w * w).sum::<f64>().sqrt();
        all.into_iter().map(|(k, w)| (k, w / size)).collect()
    }
}

impl Noise {
    /// The measured covariance and nothing else: for a model that is exact.
    #[must_use]
    pub fn measured() -> Self {
        Self {
            of_a_point: [NONE; 3],
            of_an_installation: [NONE; 2],
            measured: true,
            varying: Vec::new(),
            law: None,
        }
    }

    /// The error of the law, as one of the noises that a training found.
    pub(crate) fn of_the_law(&self) -> Option<NoiseEstimate> {
        let law = self.law.as_ref()?;
        Some(NoiseEstimate {
            name: LAW.into(),
            unit: "1".into(),
            sd: law.sd,
            floats: false,
            few: Some(NoiseEstimate::KNOWN),
        })
    }
}

/// What a new measurement in a new installation differs by from a model whose parameters and base state are
/// known exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Misfit {
    /// Standard deviations of growth rate (1/s), angular frequency (rad/s) and each part of a relative
    /// pressure: noise of the point and of its installation together.
    pub measured: [f64; 3],
    /// Relative error of a law ([`Noise::law`]).
    pub law: f64,
}

impl Misfit {
    /// From the noise that a training found.
    #[must_use]
    pub fn of(noise: &[NoiseEstimate]) -> Self {
        let total = |wanted: &dyn Fn(&str) -> bool| {
            noise.iter().filter(|n| wanted(&n.name)).map(|n| n.sd * n.sd).sum::<f64>().sqrt()
        };
        Self {
            measured: MEASURED.map(|name| total(&|n| n.strip_suffix(BETWEEN).unwrap_or(n) == name)),
            law: total(&|n| n == LAW),
        }
    }
}

impl Misfit {
    /// The misfit of the growth rate that counts for stability, 1/s: what the noise that a training found, of
    /// the point and of its installation, says of the model's own error. What was measured of the noise of
    /// records is no part of it, unless the stage was told to leave that out (`measured = false`).
    #[must_use]
    pub fn of_growth(noise: &[NoiseEstimate]) -> f64 {
        let of = |n: &&NoiseEstimate| n.name.strip_suffix(BETWEEN).unwrap_or(&n.name) == MEASURED[0];
        noise.iter().filter(of).map(|n| n.sd * n.sd * n.unknown()[0]).sum::<f64>().sqrt()
    }

    /// What an interval of a new measurement must be wide by: with the root mean square of the measured
    /// standard deviations of `points`, where these are no part of the noise that was found, and what few
    /// data leave unknown of that noise (Satterthwaite 1946, as [`rijke_inference::Few`]).
    #[must_use]
    pub fn of_a_new_measurement(noise: &[NoiseEstimate], points: &[Observed], added: bool) -> Self {
        let sd = |k: usize| {
            let measured = if added { measured_sd(points, k) } else { 0.0 };
            let floor = if measured.is_finite() { measured * measured } else { 0.0 };
            let (mut variance, mut spread) = (floor, 0.0);
            for n in noise.iter().filter(|n| n.name.strip_suffix(BETWEEN).unwrap_or(&n.name) == MEASURED[k]) {
                let [factor, ln_variance] = n.unknown();
                let own = n.sd * n.sd * factor;
                variance += own;
                spread += own * own * ln_variance;
            }
            variance.sqrt() * if spread > 0.0 { student(2.0 * variance * variance / spread) } else { 1.0 }
        };
        Self { measured: [0, 1, 2].map(sd), ..Self::of(noise) }
    }
}

/// The noise of a point, and what its installation adds, of growth rate (1/s), angular frequency (rad/s) and
/// each part of a pressure.
pub(crate) fn of_point_and_installation(noise: &[NoiseEstimate]) -> [[f64; 2]; 3] {
    let sd = |name: &str| noise.iter().find(|n| n.name == name).map_or(0.0, |n| n.sd);
    MEASURED.map(|name| [sd(name), sd(&format!("{name}{BETWEEN}"))])
}

/// Whether the noise of growth rates and that of frequencies was found, of the point or of its installation.
pub(crate) fn floats(noise: &[NoiseEstimate]) -> [bool; 2] {
    let found = |name: &str| {
        noise.iter().any(|n| n.floats && n.name.strip_suffix(BETWEEN).unwrap_or(&n.name) == name)
    };
    [found(MEASURED[0]), found(MEASURED[1])]
}

/// The parameters that vary between installations, by name, with their standard deviations.
pub(crate) fn varying(noise: &[NoiseEstimate]) -> impl Iterator<Item = (&str, f64)> {
    let named = noise.iter().filter(|n| !MEASURED.iter().any(|m| n.name.strip_suffix(BETWEEN) == Some(m)));
    named.filter_map(|n| n.name.strip_suffix(BETWEEN).map(|name| (name, n.sd)))
}

/// Root mean square of the measured standard deviations of growth rate (0), angular frequency (1) or relative
/// pressures (2): of these over real and imaginary parts of all microphones but the reference.
pub(crate) fn measured_sd(points: &[Observed], k: usize) -> f64 {
    let variance = |o: &Observed| {
        let rows = o.used(&[], usize::MAX).rows;
        rows.iter().position(|row| *row == k).map(|i| o.mode.covariance[(i, i)])
    };
    // That of the reference is zero, and is no measurement.
    let pressures = |o: &Observed| {
        let n = o.mode.covariance.rows();
        let of = (n - 2 * o.mode.pressures.len()..n).map(|i| o.mode.covariance[(i, i)]);
        of.filter(|v| *v > 0.0).collect::<Vec<_>>()
    };
    let all: Vec<f64> = match k {
        0 | 1 => points.iter().filter_map(variance).collect(),
        _ => points.iter().flat_map(pressures).collect(),
    };
    (all.iter().sum::<f64>() / all.len().max(1) as f64).sqrt()
}

pub(crate) const MEASURED: [&str; 3] = ["growth rate", "angular frequency", "relative pressure"];

pub(crate) const UNITS: [&str; 3] = ["1/s", "rad/s", "1"];

pub(crate) const BETWEEN: &str = ", between installations";

const LAW: &str = "error of the law";

#[cfg(test)]
mod tests {
    use super::Added;

    fn added(along: Vec<[f64; 2]>) -> Added {
        Added { coefficient: "eu".into(), place: "flame".into(), length_hz: 40.0, along }
    }

    #[test]
    fn exact_the_size_of_an_error_is_linear_between_frequencies() {
        let some = added(vec![[100.0, 1.0], [200.0, 3.0], [250.0, 2.0]]);
        for (hertz, size) in
            [(50.0, 1.0), (100.0, 1.0), (125.0, 1.5), (200.0, 3.0), (240.0, 2.2), (300.0, 2.0)]
        {
            assert!((some.size(hertz) - size).abs() < 1e-12, "{hertz}: {}", some.size(hertz));
        }
        assert!((added(Vec::new()).size(70.0) - 1.0).abs() < 1e-12);
    }

    /// Errors of unit variance at the nodes correlate as a squared exponential of the length.
    #[test]
    fn exact_nodes_of_an_error_have_its_correlation() {
        let error = added(Vec::new());
        for (f, g) in [(300.0, 300.0), (300.0, 317.0), (281.0, 333.0), (300.0, 400.0), (90.0, 310.0)] {
            let there = error.nodes(g);
            let of = |node: i64| there.iter().find(|(k, _)| *k == node).map_or(0.0, |(_, w)| *w);
            let sum: f64 = error.nodes(f).iter().map(|(k, w)| w * of(*k)).sum();
            let distance: f64 = (f - g) / 40.0;
            let exact = (-0.5 * distance * distance).exp();
            assert!((sum - exact).abs() < 2e-4, "{f} {g}: {sum} {exact}");
        }
    }
}
