//! Chains with mean flow: two acoustic waves and an entropy wave in every duct, Mach numbers below 0.3.
//!
//! Between ducts the linearised balances of mass, momentum and energy hold. Closure: a sudden expansion keeps
//! p A_2 + rho u^2 A over the step (the pressure on the face is the upstream one: Borda and Carnot), a contraction keeps
//! entropy, a heat source keeps p + rho u^2. Entropy waves are carried without dispersion. The gas is perfect with
//! constant gamma; ducts lose nothing (wall losses: [`crate::Network`]).

use crate::contour::{Modes, Region};
use crate::error::NetworkError;
use crate::search::zeros;
use crate::sweep::Dual;
use rijke_numerics::{C64, Jet, JetSpace, Order};

/// The mean state of the gas in a duct, SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowState {
    /// Pressure, Pa.
    pub pressure: f64,
    /// Density, kg/m^3.
    pub density: f64,
    /// Velocity, m/s, positive.
    pub velocity: f64,
}

/// What separates a duct from the one before it, besides their areas.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// Nothing.
    None,
    /// Heat that raises the temperature by `ratio` and stays constant per mass of gas.
    Steady {
        /// Temperature after over before.
        ratio: f64,
    },
    /// The same mean heat; it fluctuates as Q'/Q = gain e^{-s delay} u'/u with the velocity before it.
    Flame {
        /// Temperature after over before.
        ratio: f64,
        /// Interaction index n.
        gain: f64,
        /// Delay, s.
        delay: f64,
    },
}

/// A duct of a flow chain.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowDuct {
    /// Length, m.
    pub length: f64,
    /// Cross-section, m^2.
    pub area: f64,
    /// What lies at its upstream end.
    pub source: Source,
}

/// A chain of ducts with mean flow.
///
/// ```
/// use rijke_network::flow_chain::{FlowChain, FlowDuct, FlowState, Source};
/// use rijke_network::{Region, laws::Law};
/// use rijke_numerics::C64;
/// let duct = FlowDuct { length: 1.0, area: 1.0, source: Source::None };
/// let inlet = FlowState { pressure: 101_325.0, density: 1.2041, velocity: 3.4 };
/// let end = Law::Constant(C64::new(-0.95, 0.0));
/// let chain = FlowChain::new(1.4, inlet, vec![duct], end.clone(), end).unwrap();
/// let modes = chain.modes(&Region { sigma: [-50.0, 10.0], omega: [100.0, 4000.0] }).unwrap();
/// assert_eq!(modes.modes.len(), 3);
/// ```
#[derive(Clone, Debug)]
pub struct FlowChain {
    gamma: f64,
    ducts: Vec<FlowDuct>,
    /// Mean state in each duct.
    states: Vec<FlowState>,
    /// Mean heat per mass added before each duct, J/kg.
    heat: Vec<f64>,
    ends: [crate::laws::Law; 2],
    entropy_waves: bool,
}

impl FlowState {
    fn sound_speed(&self, gamma: f64) -> f64 {
        (gamma * self.pressure / self.density).sqrt()
    }

    /// Mach number.
    #[must_use]
    pub fn mach(&self, gamma: f64) -> f64 {
        self.velocity / self.sound_speed(gamma)
    }
}

impl FlowChain {
    /// The chain behind an inlet state; the mean states of the other ducts follow from the balances.
    ///
    /// # Errors
    /// [`NetworkError::Empty`]; [`NetworkError::Segment`] for a length, area, inlet quantity or Mach number (M < 0.3)
    /// that is not allowed; the quantity is named.
    pub fn new(
        gamma: f64,
        inlet: FlowState,
        ducts: Vec<FlowDuct>,
        upstream: crate::laws::Law,
        downstream: crate::laws::Law,
    ) -> Result<Self, NetworkError> {
        if ducts.is_empty() {
            return Err(NetworkError::Empty);
        }
        let (mut states, mut heat) = (vec![inlet], vec![0.0]);
        for (index, duct) in ducts.iter().enumerate() {
            let ratio = match duct.source {
                Source::None => 1.0,
                Source::Steady { ratio } | Source::Flame { ratio, .. } => ratio,
            };
            let named = [
                ("length", duct.length),
                ("area", duct.area),
                ("temperature ratio", ratio),
                ("inlet pressure", inlet.pressure),
                ("inlet density", inlet.density),
                ("inlet velocity", inlet.velocity),
            ];
            if let Some(&(quantity, value)) = named.iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
                return Err(NetworkError::Segment { index, quantity, value });
            }
            if index > 0 {
                let before = states[index - 1];
                let stepped = area_step(gamma, before, ducts[index - 1].area, duct.area);
                let heated = heat_step(stepped, ratio);
                let enthalpy = |s: FlowState| {
                    gamma / (gamma - 1.0) * s.pressure / s.density + 0.5 * s.velocity * s.velocity
                };
                heat.push(enthalpy(heated) - enthalpy(stepped));
                states.push(heated);
            }
            let mach = states[index].mach(gamma);
            if mach.is_nan() || mach >= 0.3 {
                return Err(NetworkError::TooFast { index, mach });
            }
        }
        Ok(Self { gamma, ducts, states, heat, ends: [upstream, downstream], entropy_waves: true })
    }

    /// The same chain with entropy waves that are lost in every duct, as shear and turbulence do to them in slow flows.
    /// Carried without loss they grow like e^{-sigma l/u} backwards in time, which for decaying modes in slow flows
    /// drowns the acoustics in rounding.
    #[must_use]
    pub fn without_entropy_waves(mut self) -> Self {
        self.entropy_waves = false;
        self
    }

    /// Mean states of the ducts.
    #[must_use]
    pub fn states(&self) -> &[FlowState] {
        &self.states
    }

    /// Every mode in `region`, counted as by [`crate::Network::modes`]. Laws of the ends must be analytic and free of poles
    /// there.
    ///
    /// # Errors
    /// As [`crate::Network::modes`].
    pub fn modes(&self, region: &Region) -> Result<Modes, NetworkError> {
        let Region { sigma, omega } = *region;
        if !(sigma[0] < sigma[1] && omega[0] < omega[1]) {
            return Err(NetworkError::Region { sigma, omega });
        }
        let times = self.ducts.iter().zip(&self.states).map(|(d, s)| d.length / s.sound_speed(self.gamma));
        let step = 0.25 * std::f64::consts::PI / times.sum::<f64>();
        zeros(|s| self.characteristic(s), region, step, Vec::new(), 0)
    }

    /// F(s) = g - R_d f at the outlet for g = 1 and no entropy wave at the inlet, and dF/ds.
    #[must_use]
    pub fn characteristic(&self, s: C64) -> [C64; 2] {
        let space = JetSpace::new(1, Order::First);
        let at = space.seed(0, s);
        let dual = |jet: &Jet| Dual { v: jet.value(), d: jet.gradient()[0] };
        let [up, down] = [0, 1].map(|k| dual(&self.ends[k].at(&at, space)));
        let constant = |v: f64| Dual::constant(C64::new(v, 0.0));
        let delayed = |w: Dual, time: f64| {
            let e = (-s * time).exp();
            w * Dual { v: e, d: -time * e }
        };
        let mut waves = [up, constant(1.0), constant(0.0)];
        for (i, duct) in self.ducts.iter().enumerate() {
            let state = self.states[i];
            let c = state.sound_speed(self.gamma);
            if i > 0 {
                let flame = match duct.source {
                    Source::Flame { gain, delay, .. } => {
                        let e = gain * (-s * delay).exp();
                        Dual { v: e, d: -delay * e }
                    }
                    _ => constant(0.0),
                };
                waves = self.cross(i, waves, flame);
            }
            let [f, g, entropy] = waves;
            let u = state.velocity;
            // An entropy wave that has nothing to meet need not be followed through the last duct.
            let met = self.entropy_waves && i + 1 < self.ducts.len();
            let carried = if met { delayed(entropy, duct.length / u) } else { constant(0.0) };
            waves = [delayed(f, duct.length / (c + u)), delayed(g, -duct.length / (c - u)), carried];
        }
        let f = waves[1] - down * waves[0];
        [f.v, f.d]
    }

    /// Waves after the step and source before duct `i`, from the waves before it.
    fn cross(&self, i: usize, waves: [Dual; 3], flame: Dual) -> [Dual; 3] {
        let gamma = self.gamma;
        let (a1, a2) = (self.ducts[i - 1].area, self.ducts[i].area);
        let before = self.states[i - 1];
        let between = area_step(gamma, before, a1, a2);
        let after = self.states[i];
        let multiply = |m: &[[f64; 3]; 3], w: [Dual; 3]| -> [Dual; 3] {
            std::array::from_fn(|r| {
                let term = |k: usize| Dual { v: w[k].v * m[r][k], d: w[k].d * m[r][k] };
                term(0) + term(1) + term(2)
            })
        };
        // Balances as rows acting on (f, g, entropy).
        let fluxes = |state: FlowState, area: f64, face: f64, expands: bool| -> [[f64; 3]; 3] {
            let (p, rho, u) = (state.pressure, state.density, state.velocity);
            let c = state.sound_speed(gamma);
            let enthalpy = gamma / (gamma - 1.0) * p / rho + 0.5 * u * u;
            // Columns: p', u', rho' of unit f, g, entropy.
            let shape = [
                [1.0, 1.0 / (rho * c), 1.0 / (c * c)],
                [1.0, -1.0 / (rho * c), 1.0 / (c * c)],
                [0.0, 0.0, -1.0 / (c * c)],
            ];
            let mut rows = [[0.0; 3]; 3];
            for (column, [dp, du, drho]) in shape.into_iter().enumerate() {
                let mass = area * (drho * u + rho * du);
                rows[0][column] = mass;
                rows[1][column] = if expands {
                    face * dp + area * (drho * u * u + 2.0 * rho * u * du)
                } else {
                    dp / p - gamma * drho / rho
                };
                let stagnation = gamma / (gamma - 1.0) * (dp / rho - p * drho / (rho * rho)) + u * du;
                rows[2][column] = mass * enthalpy + area * rho * u * stagnation;
            }
            rows
        };
        let expands = a2 >= a1;
        let balance = multiply(&fluxes(before, a1, a2, expands), waves);
        let stepped = solve(&fluxes(between, a2, a2, expands), balance);
        if matches!(self.ducts[i].source, Source::None) {
            return stepped;
        }
        let mut balance = multiply(&fluxes(between, a2, a2, true), stepped);
        let c = between.sound_speed(gamma);
        let velocity = stepped[0] - stepped[1];
        let scale = 1.0 / (between.density * c);
        let mean = self.heat[i] * a2 * between.density * between.velocity;
        let heat = if matches!(self.ducts[i].source, Source::Steady { .. }) {
            // Constant per mass: Q' follows the mass flow.
            Dual { v: balance[0].v * self.heat[i], d: balance[0].d * self.heat[i] }
        } else {
            let relative = mean * scale / between.velocity;
            let h = flame * velocity;
            Dual { v: h.v * relative, d: h.d * relative }
        };
        balance[2] = balance[2] + heat;
        solve(&fluxes(after, a2, a2, true), balance)
    }
}

/// x from M x = b, by Cramer's rule: the matrices are 3 x 3 and well scaled by rows.
fn solve(m: &[[f64; 3]; 3], b: [Dual; 3]) -> [Dual; 3] {
    let cofactor = |r: usize, k: usize| {
        let (r1, r2, k1, k2) = ((r + 1) % 3, (r + 2) % 3, (k + 1) % 3, (k + 2) % 3);
        m[r1][k1] * m[r2][k2] - m[r1][k2] * m[r2][k1]
    };
    let determinant: f64 = (0..3).map(|k| m[0][k] * cofactor(0, k)).sum();
    std::array::from_fn(|k| {
        let mut sum = Dual::constant(C64::ZERO);
        for (r, b) in b.iter().enumerate() {
            let w = cofactor(r, k) / determinant;
            sum = sum + Dual { v: b.v * w, d: b.d * w };
        }
        sum
    })
}

/// Mean state behind a change of area, by Newton in the density ratio from the state before it.
fn area_step(gamma: f64, before: FlowState, a1: f64, a2: f64) -> FlowState {
    if a1 == a2 {
        return before;
    }
    let FlowState { pressure: p1, density: rho1, velocity: u1 } = before;
    let k = gamma / (gamma - 1.0);
    let stagnation = k * p1 / rho1 + 0.5 * u1 * u1;
    let state = |rho2: f64| {
        let u2 = rho1 * u1 * a1 / (rho2 * a2);
        let p2 = (stagnation - 0.5 * u2 * u2) * rho2 / k;
        FlowState { pressure: p2, density: rho2, velocity: u2 }
    };
    let defect = |rho2: f64| {
        let s = state(rho2);
        if a2 > a1 {
            (s.pressure + s.density * s.velocity * s.velocity - p1 - rho1 * u1 * u1 * a1 / a2) / p1
        } else {
            (s.pressure / p1).ln() - gamma * (rho2 / rho1).ln()
        }
    };
    let mut rho2 = rho1;
    for _ in 0..50 {
        let h = 1e-6 * rho2;
        let slope = (defect(rho2 + h) - defect(rho2 - h)) / (2.0 * h);
        let step = defect(rho2) / slope;
        rho2 -= step;
        if step.abs() < 1e-15 * rho2 {
            break;
        }
    }
    state(rho2)
}

/// Mean state behind heat that raises the temperature by `ratio`: mass and p + rho u^2 are kept, p = rho R T.
fn heat_step(before: FlowState, ratio: f64) -> FlowState {
    let FlowState { pressure: p, density: rho, velocity: u } = before;
    // With m = rho u and x = p2: x + m^2 R T2/x = p + m u, R T2 = ratio p/rho.
    let total = p + rho * u * u;
    let product = (rho * u).powi(2) * ratio * p / rho;
    let pressure = 0.5 * (total + (total * total - 4.0 * product).sqrt());
    let density = pressure * rho / (ratio * p);
    FlowState { pressure, density, velocity: rho * u / density }
}
