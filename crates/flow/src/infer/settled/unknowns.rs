//! What is unknown of settled states, with priors and their reasons.

use super::run::{SIX, SettledRun};
use crate::error::FlowError;
use crate::infer::scores::physical;
use crate::tube::closures::Closures;
use crate::tube::parameters::TubeParameters;
use crate::tube::pipe::Pipe;
use rijke_inference::{Parameter, Prior};

/// Number of unknowns that every run has; days and paths follow.
pub(crate) const FIXED: usize = 19;

/// The unknowns of `run`: the six parameters; power, place of the heater and orifice length; the closures
/// that the paper does not give; the thermometer's error of each day; the excess acoustic length of the path
/// to each microphone beyond the last; what only a ramp shows.
///
/// * The six parameters: uniform, as everywhere ([`crate::unknowns`]).
/// * Power meter 1 %, place of the heater 1 mm, orifice length 0.05 +- 0.015 m: ordinary calibration and
///   geometry.
/// * The delay behind the heater, L_or/(2c) in cold gas, changes as c to the power -gamma: 1 for an inertance
///   in uniform gas; but hot gas follows on cold, and the unsteady heat release and the band of the pulse
///   matter: 0.5 +- 0.5.
/// * Emissivity 0.30 (weathered steel 0.2 to 0.45, Incropera table A.11); share and decay length of the
///   wires' loss known to a third (fin estimate); entrance loss 0.6 +- 0.15 (sharp 1.0, rounded 0.05, thin
///   wall 0.6; Idelchik 3-1); Hagenbach's 1.25 +- 15 % (Shah & London give 1.20 to 1.33); jet reattachment at
///   10 to 15 step heights, +- 35 %.
/// * Velocity profile: anything from flat (1) to parabolic (4/3).
/// * Share of the power that the heater radiates to the wall: 40 cm^2 of ceramic at 400 to 700 K seen by a
///   wall at 330 K radiate 3 to 12 % of 180 W.
/// * Excess length: thermometers, insert and the like slow a pulse by some mm of path per interval; seen
///   without power, and scaled with the local speed of sound when hot.
/// * Of a run with ramps, last: lag of the heater (its ceramic's heat over a conductance that is known to 15
///   %), and heat capacity of the wall (c_p of AISI 304 rises from 477 to 515 J/(kg K) between 300 and 400 K,
///   Incropera table A.1; a wall thickness to 2 %).
#[must_use]
pub fn unknowns(run: &SettledRun, pipe: &Pipe) -> Vec<Parameter> {
    let c = &pipe.closures;
    let uniform = |name: &str, symbol: &str, unit: &str, low: f64, high: f64| {
        Parameter::new(name, symbol, unit, Prior::Uniform { low, high })
    };
    let normal = |name: &str, symbol: &str, unit: &str, mean: f64, sd: f64| {
        Parameter::new(name, symbol, unit, Prior::Normal { mean, sd })
    };
    let positive = |name: &str, symbol: &str, unit: &str, median: f64, ln_sd: f64| {
        Parameter::new(name, symbol, unit, Prior::LogNormal { median, ln_sd })
    };
    let mut list: Vec<Parameter> = crate::tube::parameters::unknowns().into_iter().take(SIX + 1).collect();
    list.extend([
        normal("heater_shift", "ΔX_h", "m", 0.0, 1e-3),
        normal("orifice_length", "L_or", "m", c.orifice_length, 0.015),
        normal("orifice_exponent", "γ_or", "1", 0.5, 0.5),
        positive("emissivity", "ε", "1", c.emissivity, 0.25),
        positive("wire_share", "f_w", "1", c.wire_share, 0.35),
        positive("wire_length", "l_w", "m", c.wire_length, 0.25),
        normal("entrance_loss", "K_e", "1", c.entrance_loss, 0.15),
        positive("development_loss", "K_H", "1", c.development_loss, 0.15),
        positive("jet_length", "l_j", "m", c.jet_length, 0.35),
        uniform("profile_factor", "β", "1", 1.0, 4.0 / 3.0),
        uniform("radiated_share", "f_r", "1", 0.0, 0.12),
        positive("radiated_length", "l_r", "m", c.radiated_length, 0.3),
    ]);
    for day in run.days() {
        let sd = run.states.iter().filter(|s| s.day == day).map(|s| s.ambient_sd).fold(0.0, f64::max);
        list.push(normal(&format!("ambient_offset {day}"), "ΔT_a", "K", 0.0, sd.max(1e-6)));
    }
    for k in 0..pipe.microphones.len() {
        list.push(normal(&format!("path_{}", k + 1), "l_p", "m", 0.0, PATH_SD));
    }
    if !run.ramps.is_empty() {
        list.push(positive("heater_lag", "τ_h", "s", c.heater_lag, 0.15));
        list.push(positive("wall_heat_capacity", "ρc_w", "J/(m^3 K)", c.wall_heat_capacity, 0.04));
    }
    list
}

/// How much of the score of unknown `k` all places of the heater share. The power meter is one instrument;
/// the heater is set anew at each place. Of the parameters and closures a third (in sd) may differ from place
/// to place: correlations err by other amounts elsewhere along the tube, and the shared rest still says that
/// the rig is one.
pub(crate) fn shared_share(k: usize) -> f64 {
    const DIFFERENT: f64 = 1.0 / 3.0;
    match k {
        POWER => 1.0,
        HEATER => 0.0,
        _ => (1.0 - DIFFERENT * DIFFERENT).sqrt(),
    }
}

/// Whether unknown `k` moves the flow, and not just what is read of it: orifice and paths delay clicks.
pub(crate) fn moves_flow(k: usize, run: &SettledRun, pipe: &Pipe) -> bool {
    let paths = FIXED + run.days().len();
    !ORIFICE.contains(&k) && !(paths..paths + pipe.microphones.len()).contains(&k)
}

const POWER: usize = 6;
const HEATER: usize = 7;
/// Length and exponent.
const ORIFICE: [usize; 2] = [8, 9];

/// Sd of the excess acoustic length of one interval, m: a thermometer of 3 mm across the bore adds 0.4 mm of
/// inertance, the boundary layers of insert over 0.1 m about 0.1 mm, an unflanged probe less.
const PATH_SD: f64 = 1.5e-3;

/// The unknowns as the model takes them.
pub(crate) struct Filled {
    pub(crate) parameters: TubeParameters,
    pub(crate) closures: Closures,
    pub(crate) power_factor: f64,
    pub(crate) heater_shift: f64,
    pub(crate) orifice_length: f64,
    pub(crate) orifice_exponent: f64,
    /// One per day, one per path, and of a run with ramps lag and heat capacity.
    pub(crate) rest: Vec<f64>,
}

impl Filled {
    pub(crate) fn new(priors: &[Parameter], scores: &[f64], closures: &Closures) -> Result<Self, FlowError> {
        let v: Vec<f64> =
            priors.iter().zip(scores).map(|(p, &z)| physical(p, z)).collect::<Result<_, _>>()?;
        Ok(Self {
            parameters: TubeParameters {
                heater_drag: v[0],
                outer_nusselt: v[1],
                mount_resistance: v[2],
                wall_share: v[3],
                inner_nusselt: v[4],
                jet_enhancement: v[5],
            },
            power_factor: v[6],
            heater_shift: v[7],
            orifice_length: v[8],
            orifice_exponent: v[9],
            closures: Closures {
                emissivity: v[10],
                wire_share: v[11],
                wire_length: v[12],
                entrance_loss: v[13].max(0.0),
                development_loss: v[14],
                jet_length: v[15],
                profile_factor: v[16],
                radiated_share: v[17],
                radiated_length: v[18],
                ..closures.clone()
            },
            rest: v[FIXED..].to_vec(),
        })
    }
}
