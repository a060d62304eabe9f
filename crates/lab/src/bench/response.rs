//! Heat sources: how much heat follows the velocity, and how it lags.

use super::value::Value;
use rijke_numerics::C64;
use rijke_rig::{Gas, GasState};
use serde::Deserialize;
use std::f64::consts::PI;

/// A source of heat over a short stretch of duct.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SourceTruth {
    /// Middle of the stretch, m from the upstream end.
    pub(crate) at: Value,
    /// Length of the stretch, m.
    pub(crate) thickness: f64,
    /// There where this factor is not 0.
    #[serde(default)]
    pub(crate) present: Option<String>,
    /// W.
    pub(crate) power: Value,
    /// Share of the power that reaches the gas.
    pub(crate) share: f64,
    /// Relative change of heat per relative change of velocity at low frequency; without it, that of a wire.
    #[serde(default)]
    pub(crate) sensitivity: Option<Value>,
    #[serde(default)]
    pub(crate) wire: Option<WireTruth>,
    /// What the times below are counted in.
    pub(crate) times: Times,
    /// Gamma-distributed delays, side by side; their weights add up to 1 for a sensitivity as stated.
    #[serde(default)]
    pub(crate) delay: Vec<DelayTruth>,
    /// Delay at low frequency of heat that is conducted through a film: z/sinh z, z^2 = 6 s times this (the
    /// heat equation across the film, flux at one face for temperature at the other).
    #[serde(default)]
    pub(crate) film: f64,
    /// Time constant of a capacity, 1/(1 + s times this).
    #[serde(default)]
    pub(crate) lag: f64,
    /// How far upstream of the stretch's beginning the velocity acts, m.
    #[serde(default)]
    pub(crate) reference: f64,
}

/// The wire that gives off the heat.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WireTruth {
    pub(crate) diameter: f64,
    pub(crate) length: f64,
    /// Velocity at the wire over velocity in the duct.
    pub(crate) speed_up: f64,
}

/// Units of the times of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Times {
    /// s.
    Seconds,
    /// 0.2 d/U of the wire, U the mean velocity in the duct (Lighthill, Proc. R. Soc. A 224, 1954, 1).
    Lighthill,
    /// m: lengths over the mean velocity at the reference.
    Lengths,
}

/// One of the delays.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DelayTruth {
    pub(crate) weight: f64,
    pub(crate) mean: f64,
    /// Shape of the gamma distribution: mean^2/variance; 0 for a delay without spread.
    #[serde(default)]
    pub(crate) shape: f64,
}

/// The lag of a source at one operating point, s.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Response {
    pub(crate) delays: Vec<[f64; 3]>,
    pub(crate) film: f64,
    pub(crate) lag: f64,
}

impl SourceTruth {
    /// The lag where the mean velocity at the reference is `velocity`, m/s.
    pub(crate) fn response(&self, velocity: f64) -> Response {
        let unit = match self.times {
            Times::Seconds => 1.0,
            Times::Lighthill => 0.2 * self.wire.map_or(0.0, |wire| wire.diameter) / velocity,
            Times::Lengths => 1.0 / velocity,
        };
        let delays = self.delay.iter().map(|d| [d.weight, d.mean * unit, d.shape]).collect();
        Response { delays, film: self.film * unit, lag: self.lag * unit }
    }
}

impl Response {
    /// The transfer function at complex frequency `s`, 1 at s = 0 if the weights add up to 1.
    pub(crate) fn at(&self, s: C64) -> C64 {
        let spread = |[weight, mean, shape]: &[f64; 3]| {
            let x = s * *mean;
            *weight * if *shape == 0.0 { (-x).exp() } else { (1.0 + x / *shape).powf(-*shape) }
        };
        let delayed: C64 =
            if self.delays.is_empty() { C64::ONE } else { self.delays.iter().map(spread).sum() };
        delayed * film(6.0 * s * self.film) / (1.0 + s * self.lag)
    }
}

/// z/sinh z of z^2.
fn film(square: C64) -> C64 {
    if square.norm() < 1e-3 {
        return 1.0 / (1.0 + square / 6.0 * (1.0 + square / 20.0 * (1.0 + square / 42.0)));
    }
    let z = square.sqrt();
    z / z.sinh()
}

/// d ln Q/d ln U of a wire that gives off `heat`, W, to a stream of `velocity`, m/s: Nu = 0.24 + 0.56 Re^0.45
/// with properties at film temperature (Collis & Williams, J. Fluid Mech. 6, 1959, 357; Re < 44). Ten passes
/// settle the film.
pub(crate) fn wire_sensitivity(wire: WireTruth, gas: &Gas, cold: &GasState, velocity: f64, heat: f64) -> f64 {
    let (mut film, mut slope) = (*cold, 0.0);
    for _ in 0..10 {
        let reynolds = wire.speed_up * velocity * wire.diameter * film.density / film.viscosity;
        let power_law = 0.56 * reynolds.powf(0.45);
        slope = 0.45 * power_law / (0.24 + power_law);
        let conductance = (0.24 + power_law) * film.conductivity * PI * wire.length;
        film = gas.at(cold.temperature + 0.5 * heat / conductance, cold.pressure);
    }
    slope
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const S: C64 = C64::new(-20.0, 1500.0);

    #[test]
    fn exact_all_lags_have_their_delay_at_low_frequency() {
        let cases = [
            Response { delays: vec![[1.0, 1e-3, 0.0]], ..Default::default() },
            Response { delays: vec![[1.0, 1e-3, 3.0]], ..Default::default() },
            Response { film: 1e-3, ..Default::default() },
            Response { lag: 1e-3, ..Default::default() },
            Response { delays: vec![[1.5, 1.2e-3, 4.0], [-0.5, 1.6e-3, 0.0]], ..Default::default() },
        ];
        for response in cases {
            let h = C64::new(0.0, 1e-2);
            assert_relative_eq!(response.at(C64::ZERO).re, 1.0, max_relative = 1e-12);
            let slope = (response.at(h) - response.at(-h)) / (2.0 * h);
            assert_relative_eq!(slope.re, -1e-3, max_relative = 1e-8);
        }
    }

    #[test]
    fn oracle_gamma_distributed_delays_against_quadrature() {
        // Shape 3: density n^3 t^2 e^{-n t/tau}/(2 tau^3) with n = 3, by the midpoint rule.
        let (tau, n, cells) = (1e-3, 3.0, 200_000);
        let h = 20.0 * tau / f64::from(cells);
        let sum: C64 = (0..cells)
            .map(|k| {
                let t = (f64::from(k) + 0.5) * h;
                (n / tau).powi(3) * t * t / 2.0 * (-n * t / tau).exp() * h * (-S * t).exp()
            })
            .sum();
        let closed = Response { delays: vec![[1.0, tau, n]], ..Default::default() }.at(S);
        assert!((sum - closed).norm() < 1e-8, "{sum} against {closed}");
    }

    #[test]
    fn oracle_film_against_finite_differences_of_the_heat_equation() {
        // T'' = z^2 T on (0, 1), T(0) = 0, T(1) = 1: flux T'(0) = z/sinh z. Second-order differences, by
        // elimination.
        let square = 6.0 * S * 1e-3;
        let flux = |n: usize| {
            let h = 1.0 / n as f64;
            let (mut before, mut here) = (C64::ZERO, C64::ONE);
            for _ in 1..n {
                (before, here) = (here, here * (2.0 + square * h * h) - before);
            }
            // T(h)/h is T'(0) + h^2/6 T'''(0), and T''' = z^2 T'.
            (1.0 / (here * h)) / (1.0 + square * h * h / 6.0)
        };
        let exact = film(square);
        assert!((flux(400) - exact).norm() < 1e-5 * exact.norm(), "{} against {exact}", flux(400));
    }

    #[test]
    fn lab_a_wire_follows_velocity_by_a_little_less_than_half() {
        let gas = Gas::air();
        let cold = gas.at(293.15, 101_325.0);
        let wire = WireTruth { diameter: 3e-4, length: 3.0, speed_up: 1.6 };
        let [slow, fast] = [0.3, 0.6].map(|u| wire_sensitivity(wire, &gas, &cold, u, 50.0));
        assert!(0.3 < slow && slow < fast && fast < 0.45, "{slow} {fast}");
    }
}
