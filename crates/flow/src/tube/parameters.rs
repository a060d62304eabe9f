//! The six parameters of the paper's section 4.1, and the nuisances that a fit carries along.

use super::closures::Closures;
use crate::number::{Number, Single};
use rijke_inference::{Parameter, Prior};
use serde::{Deserialize, Serialize};

/// The six parameters by name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TubeParameters<N = f64> {
    /// C_d: inviscid drag of the heater, on G^2 v/2.
    pub heater_drag: N,
    /// theta_o: factor on the Nusselt number of the outer surface.
    pub outer_nusselt: N,
    /// R_m: thermal resistance of each mount, K/W.
    pub mount_resistance: N,
    /// phi: share of the power conducted into the tube wall.
    pub wall_share: N,
    /// n_1: factor on the Nusselt number of the inner surface.
    pub inner_nusselt: N,
    /// n_2: extra heat transfer just above the heater, decaying over the jet length.
    pub jet_enhancement: N,
}

/// All numbers that a fit may move: the six parameters and the nuisances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unknowns<N = f64> {
    /// The six.
    pub parameters: TubeParameters<N>,
    /// Supplied power over indicated power.
    pub power_factor: N,
    /// True ambient temperature minus indicated, K.
    pub ambient_offset: N,
    /// Lag of the heater, s.
    pub heater_lag: N,
    /// Extra acoustic length of the heater's orifices, m.
    pub orifice_length: N,
}

/// Number of entries of [`Unknowns`].
pub const UNKNOWNS: usize = 10;

impl Default for TubeParameters {
    /// The middle of what geometry and handbooks suggest; not a fit.
    fn default() -> Self {
        Self {
            heater_drag: 8.0,
            outer_nusselt: 1.0,
            mount_resistance: 5.0,
            wall_share: 0.12,
            inner_nusselt: 1.2,
            jet_enhancement: 1.0,
        }
    }
}

impl Unknowns {
    /// Without errors of meters: these parameters, and lag and orifices of the closures.
    #[must_use]
    pub fn known(parameters: &TubeParameters, closures: &Closures) -> Self {
        Self {
            parameters: *parameters,
            power_factor: 1.0,
            ambient_offset: 0.0,
            heater_lag: closures.heater_lag,
            orifice_length: closures.orifice_length,
        }
    }
}

impl<N: Number> Unknowns<N> {
    /// From a list in the order of [`unknowns`].
    #[must_use]
    pub fn from_array(a: [N; UNKNOWNS]) -> Self {
        Self {
            parameters: TubeParameters {
                heater_drag: a[0],
                outer_nusselt: a[1],
                mount_resistance: a[2],
                wall_share: a[3],
                inner_nusselt: a[4],
                jet_enhancement: a[5],
            },
            power_factor: a[6],
            ambient_offset: a[7],
            heater_lag: a[8],
            orifice_length: a[9],
        }
    }
}

impl<N: Single> Unknowns<N> {
    /// The values, in the order of [`unknowns`].
    #[must_use]
    pub fn values(&self) -> [f64; UNKNOWNS] {
        let p = &self.parameters;
        [
            p.heater_drag,
            p.outer_nusselt,
            p.mount_resistance,
            p.wall_share,
            p.inner_nusselt,
            p.jet_enhancement,
            self.power_factor,
            self.ambient_offset,
            self.heater_lag,
            self.orifice_length,
        ]
        .map(Single::value)
    }
}

impl<N: Copy> TubeParameters<N> {
    /// The same function of each.
    pub(crate) fn map<M>(&self, of: impl Fn(N) -> M) -> TubeParameters<M> {
        TubeParameters {
            heater_drag: of(self.heater_drag),
            outer_nusselt: of(self.outer_nusselt),
            mount_resistance: of(self.mount_resistance),
            wall_share: of(self.wall_share),
            inner_nusselt: of(self.inner_nusselt),
            jet_enhancement: of(self.jet_enhancement),
        }
    }
}

impl<N: Single> TubeParameters<N> {
    /// Without derivatives.
    #[must_use]
    pub fn plain(&self) -> TubeParameters {
        self.map(N::value)
    }
}

/// What is unknown, with priors: the six parameters uniform over what physics allows, the nuisances normal
/// with the sd of an ordinary calibration (power 1 %, thermometer 0.1 K, lag 5 s, orifice length 15 mm).
#[must_use]
pub fn unknowns() -> [Parameter; UNKNOWNS] {
    let uniform = |name: &str, symbol: &str, unit: &str, low, high| {
        Parameter::new(name, symbol, unit, Prior::Uniform { low, high })
    };
    let normal = |name: &str, symbol: &str, unit: &str, mean, sd| {
        Parameter::new(name, symbol, unit, Prior::Normal { mean, sd })
    };
    [
        uniform("heater_drag", "C_d", "1", 3.0, 20.0),
        uniform("outer_nusselt", "θ_o", "1", 0.6, 1.8),
        uniform("mount_resistance", "R_m", "K/W", 1.0, 20.0),
        uniform("wall_share", "φ", "1", 0.0, 0.30),
        uniform("inner_nusselt", "n_1", "1", 0.5, 2.5),
        uniform("jet_enhancement", "n_2", "1", 0.0, 3.0),
        normal("power_factor", "1+b", "1", 1.0, 0.01),
        normal("ambient_offset", "ΔT_a", "K", 0.0, 0.1),
        normal("heater_lag", "τ_h", "s", 35.0, 5.0),
        normal("orifice_length", "L_or", "m", 0.05, 0.015),
    ]
}
