//! Values that the model needs and the data do not tell: each with its meaning, unit and source.

use serde::{Deserialize, Serialize};

/// Everything that is neither geometry nor one of the six parameters.
///
/// The paper does not give these. Each default says where it is from; `docs/theory/flow.md` says what each is
/// worth. The last three are switched off by default: the virtual laboratory uses them to be richer than the
/// model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Closures {
    /// Entrance loss on G^2 v/2 (thin-walled inlet; Idelchik, Handbook of Hydraulic Resistance, diagram 3-1).
    pub entrance_loss: f64,
    /// Excess loss of the developing laminar profile on G^2 v/2 (Hagenbach; Shah & London 1978).
    pub development_loss: f64,
    /// Share of the power that insert and leads give to the gas upstream of the heater (fin estimate from
    /// copper and steel cross-sections).
    pub wire_share: f64,
    /// Length over which that share decays upstream of the heater, m (fin length of a copper lead).
    pub wire_length: f64,
    /// First-order lag of the released power behind the supplied power, s (ceramic 21 J/K over 0.6 W/K).
    pub heater_lag: f64,
    /// Length over which the orifice jet's extra heat transfer decays, m (reattachment at 10 to 15 step
    /// heights).
    pub jet_length: f64,
    /// Extra acoustic length of the heater's two orifices, m: (L_h + 2 delta) A/A_d - L_h; delays a pulse by
    /// L/(2c).
    pub orifice_length: f64,
    /// Frequency at which the pulse of a click carries its energy, Hz: the wall's boundary layer slows a
    /// pulse by sqrt(nu/(2 omega))/a (1 + (gamma - 1)/sqrt(Pr)), about 0.2 % at 1 kHz; infinite for none.
    pub pulse_frequency: f64,
    /// Emissivity of the outer wall (weathered stainless steel).
    pub emissivity: f64,
    /// Centres of the two mounts, m.
    pub mounts: [f64; 2],
    /// Axial extent of a mount, m.
    pub mount_length: f64,
    /// Conductivity of the wall, W/(m K) (AISI 304; Incropera, table A.1).
    pub wall_conductivity: f64,
    /// Volumetric heat capacity of the wall, J/(m^3 K) (AISI 304, the same table).
    pub wall_heat_capacity: f64,
    /// Share of the power that the heater radiates to the wall; the model lumps it with the conducted share.
    pub radiated_share: f64,
    /// Length over which that share decays on both sides of the heater, m; about a diameter.
    pub radiated_length: f64,
    /// Momentum-flux factor of the velocity profile on the acceleration and exit terms: 1 for a flat, 4/3 for
    /// a parabolic profile.
    pub profile_factor: f64,
}

impl Default for Closures {
    fn default() -> Self {
        Self {
            entrance_loss: 0.6,
            development_loss: 1.25,
            wire_share: 0.04,
            wire_length: 0.09,
            heater_lag: 35.0,
            jet_length: 0.10,
            orifice_length: 0.05,
            pulse_frequency: 1000.0,
            emissivity: 0.30,
            mounts: [0.10, 0.90],
            mount_length: 0.02,
            wall_conductivity: 16.0,
            wall_heat_capacity: 7900.0 * 500.0,
            radiated_share: 0.0,
            radiated_length: 0.05,
            profile_factor: 1.0,
        }
    }
}
