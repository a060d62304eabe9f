//! What is assumed of the misfit of a model, as `study.toml` says it.

use serde::Deserialize;

/// A standard deviation: known, sought, or taken from an earlier stage.
#[derive(Clone, Debug, PartialEq)]
pub enum SdSpec {
    /// The most probable one, without an Occam factor, as in the paper.
    Floated,
    /// Known.
    Fixed(f64),
    /// A parameter with a log-normal prior.
    Inferred {
        /// Median.
        median: f64,
        /// Standard deviation of its logarithm.
        ln_sd: f64,
    },
    /// A parameter whose prior has the misfit that an earlier stage chose for its median.
    Like {
        /// The stage.
        stage: String,
        /// Standard deviation of its logarithm; 0 holds it there.
        ln_sd: f64,
        /// Whether what installations differ by is counted in.
        new_installation: bool,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    fixed: Option<f64>,
    median: Option<f64>,
    ln_sd: Option<f64>,
    like: Option<String>,
    new_installation: Option<bool>,
}

impl<'de> Deserialize<'de> for SdSpec {
    fn deserialize<D: serde::Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let need = "\"floated\", a number, { fixed = sd }, { median = sd, ln_sd = factor } or { like = \"stage\", ln_sd = factor, new_installation = true }";
        let value = toml::Value::deserialize(from)?;
        let positive = |v: f64| {
            if v >= 0.0 && v.is_finite() {
                Ok(v)
            } else {
                Err(Error::custom(format!("{v} is not a standard deviation; give {need}")))
            }
        };
        match &value {
            toml::Value::String(text) if text == "floated" => Ok(Self::Floated),
            toml::Value::Float(v) => positive(*v).map(Self::Fixed),
            toml::Value::Integer(v) => positive(*v as f64).map(Self::Fixed),
            toml::Value::Table(_) => {
                let table: Table =
                    Table::deserialize(value.clone()).map_err(|e| Error::custom(e.message()))?;
                match table {
                    Table {
                        fixed: Some(sd),
                        median: None,
                        ln_sd: None,
                        like: None,
                        new_installation: None,
                    } => positive(sd).map(Self::Fixed),
                    Table {
                        fixed: None,
                        median: Some(median),
                        ln_sd: Some(ln_sd),
                        like: None,
                        new_installation: None,
                    } if median > 0.0 && ln_sd > 0.0 => Ok(Self::Inferred { median, ln_sd }),
                    Table { fixed: None, median: None, ln_sd, like: Some(stage), new_installation } => {
                        let new_installation = new_installation.unwrap_or_default();
                        Ok(Self::Like { stage, ln_sd: positive(ln_sd.unwrap_or(0.0))?, new_installation })
                    }
                    _ => Err(Error::custom(format!("{value} is no standard deviation; give {need}"))),
                }
            }
            _ => Err(Error::custom(format!("{value} is no standard deviation; give {need}"))),
        }
    }
}

/// What is assumed of the difference between model and measurement.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NoiseSpec {
    /// Standard deviation of growth rates, 1/s.
    pub growth_rate: SdSpec,
    /// Standard deviation of angular frequencies, rad/s.
    pub angular_frequency: SdSpec,
    /// Standard deviation of each part of a relative pressure.
    pub pressure: SdSpec,
    /// What all points of one installation share: growth rate (1/s) and angular frequency (rad/s).
    pub installation: Option<[SdSpec; 2]>,
    /// Whether the measured covariance is added.
    pub measured: bool,
    /// Parameters that come out a little different in every installation.
    pub varying: Vec<PlannedVarying>,
    /// A relative error of the laws of a role.
    pub law: Option<PlannedLawError>,
}

impl Default for NoiseSpec {
    fn default() -> Self {
        Self {
            growth_rate: SdSpec::Floated,
            angular_frequency: SdSpec::Floated,
            pressure: SdSpec::Floated,
            installation: None,
            measured: true,
            varying: Vec::new(),
            law: None,
        }
    }
}

impl NoiseSpec {
    /// Every standard deviation that may be taken from an earlier stage.
    pub fn all(&self) -> impl Iterator<Item = &SdSpec> {
        [&self.growth_rate, &self.angular_frequency, &self.pressure]
            .into_iter()
            .chain(self.installation.iter().flatten())
            .chain(self.varying.iter().map(|v| &v.sd))
    }
}

/// A parameter that scatters between installations about the value that is inferred.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedVarying {
    /// Its name; one that a model does not have is passed over.
    pub parameter: String,
    /// Its standard deviation between installations.
    pub sd: SdSpec,
}

/// A complex relative error of the laws of a role, the same at all points of one value of a factor.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedLawError {
    /// The role.
    pub role: String,
    /// Standard deviation of its real and of its imaginary part.
    pub sd: f64,
    /// The factor over which it varies.
    pub over: String,
}
