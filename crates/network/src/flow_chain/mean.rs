//! Mean states behind changes of area and behind heat.

use super::ducts::FlowState;
use super::number::Number;
use rijke_numerics::ComplexDual;

/// Mean pressure, density and velocity, and the gas that has them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mean<T> {
    pub(super) pressure: T,
    pub(super) density: T,
    pub(super) velocity: T,
    /// Ratio of specific heats.
    pub(super) gamma: f64,
}

impl<T> Mean<T> {
    pub(super) fn map<U>(&self, f: impl Fn(&T) -> U) -> Mean<U> {
        let [pressure, density, velocity] = [&self.pressure, &self.density, &self.velocity].map(f);
        Mean { pressure, density, velocity, gamma: self.gamma }
    }
}

impl<T: Number> Mean<T> {
    /// c^2.
    pub(super) fn speed_squared(&self) -> T {
        self.pressure.over(&self.density).times(self.gamma)
    }

    /// Stagnation enthalpy, J/kg.
    pub(super) fn enthalpy(&self) -> T {
        self.enthalpy_as(self.gamma)
    }

    /// The same in front of a place behind which the gas has another `gamma`. Only differences across a place
    /// count, and a gas that becomes another one at constant pressure and density takes no heat.
    pub(super) fn enthalpy_as(&self, gamma: f64) -> T {
        self.pressure.over(&self.density).times(gamma / (gamma - 1.0))
            + (self.velocity.clone() * self.velocity.clone()).times(0.5)
    }

    /// p + rho u^2.
    fn thrust(&self) -> T {
        self.pressure.clone() + self.density.clone() * self.velocity.clone() * self.velocity.clone()
    }
}

/// The state behind a step from area `a1` to `a2`: mass and stagnation enthalpy are kept; an expansion keeps
/// p A_2 + rho u^2 A, a contraction or a step of a smooth wall p/rho^gamma. By Newton in the density; two
/// more steps than the value needs carry first and second derivatives over.
pub(super) fn area_step<T: Number>(before: &Mean<T>, [a1, a2]: [&T; 2], smooth: bool) -> Mean<T> {
    if a1 == a2 {
        return before.clone();
    }
    let gamma = before.gamma;
    let (ratio, stagnation) = (a1.over(a2), before.enthalpy());
    let flux = before.density.clone() * before.velocity.clone() * ratio.clone();
    let k = gamma / (gamma - 1.0);
    let state = |density: &T| {
        let velocity = flux.over(density);
        let kinetic = (velocity.clone() * velocity.clone()).times(0.5);
        let pressure = (stagnation.clone() - kinetic) * density.times(1.0 / k);
        Mean { pressure, density: density.clone(), velocity, gamma }
    };
    let expands = !smooth && a2.value().re >= a1.value().re;
    let defect = |density: &T| {
        let s = state(density);
        if expands {
            let kept = before.pressure.clone()
                + before.density.clone() * before.velocity.clone() * before.velocity.clone() * ratio.clone();
            s.thrust() - kept
        } else {
            s.pressure.over(&before.pressure).ln() - s.density.over(&before.density).ln().times(gamma)
        }
    };
    // At fixed flux and enthalpy H: dp/drho = (gamma-1)/gamma (H + u^2/2), d(rho u^2)/drho = -u^2.
    let slope = |density: &T| {
        let s = state(density);
        let square = s.velocity.clone() * s.velocity.clone();
        let pressure = (stagnation.clone() + square.times(0.5)).times(1.0 / k);
        if expands { pressure - square } else { pressure.over(&s.pressure) - density.recip().times(gamma) }
    };
    let mut density = before.density.clone();
    // Two steps after convergence; a flow that the contraction would choke has no state, and the steps never
    // settle.
    let mut extra = 0;
    for _ in 0..50 {
        let step = defect(&density).over(&slope(&density));
        let small = step.value().norm() < 1e-14 * density.value().norm();
        density = density - step;
        if small {
            extra += 1;
            if extra == 3 {
                return state(&density);
            }
        }
    }
    state(&density.real(f64::NAN))
}

/// The state behind heat that raises p/rho by `ratio`, of gas with this `gamma`: mass and p + rho u^2 are
/// kept. Complex if the heat would choke the flow.
pub(super) fn heat_step<T: Number>(before: &Mean<T>, ratio: &T, gamma: f64) -> Mean<T> {
    if *ratio == ratio.real(1.0) {
        return Mean { gamma, ..before.clone() };
    }
    // With m = rho u: x + m^2 (R T2)/x = p + m u for the pressure x, R T2 = ratio p/rho.
    let flux = before.density.clone() * before.velocity.clone();
    let total = before.thrust();
    let hot = ratio.clone() * before.pressure.over(&before.density);
    let product = flux.clone() * flux.clone() * hot.clone();
    let root = (total.clone() * total.clone() - product.times(4.0)).sqrt();
    let pressure = (total + root).times(0.5);
    let density = pressure.over(&hot);
    Mean { velocity: flux.over(&density), pressure, density, gamma }
}

/// The mean state without its slopes.
pub(super) fn state_of(mean: &Mean<ComplexDual>) -> FlowState {
    FlowState {
        pressure: mean.pressure.value.re,
        density: mean.density.value.re,
        velocity: mean.velocity.value.re,
    }
}
