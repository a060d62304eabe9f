//! The places between ducts: mean states on both sides, and the matrices with which disturbances (p, u, e)
//! pass them.

use super::ducts::{ActionKind, FlowDuct, FlowState};
use super::mean::{Mean, area_step, heat_step, state_of};
use super::number::Number;
use super::slots::Attached;
use crate::error::NetworkError;
use rijke_numerics::ComplexDual;

/// Everything of a chain that may depend on parameters, by duct.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Basis<T> {
    pub(super) length: Vec<T>,
    pub(super) area: Vec<T>,
    /// Factors on the wall losses, and on what acts at the upstream end.
    pub(super) wall: Vec<T>,
    pub(super) gain: Vec<T>,
    /// Logarithms of factors on the reflection coefficients.
    pub(super) ends: [T; 2],
    /// Temperature ratio at the upstream end.
    pub(super) ratios: Vec<T>,
    /// Ratio of specific heats.
    pub(super) gammas: Vec<f64>,
    pub(super) inlet: Mean<T>,
    /// What laws of the caller add: viscous and thermal loss per metre, reflection coefficients.
    pub(super) loss: Vec<Option<[T; 2]>>,
    pub(super) reflections: [Option<T>; 2],
    /// Mean state between the change of area and the heat before a duct, and in the duct.
    pub(super) between: Vec<Mean<T>>,
    pub(super) after: Vec<Mean<T>>,
    /// How disturbances pass the places before the ducts; the first is empty.
    pub(super) gates: Vec<Gate<T>>,
    /// Feedback beside the actions, by place: what it does, coefficient.
    pub(super) beside: Vec<Vec<(ActionKind, T)>>,
}

/// A place: matrices on (p, u, e) that need computing once.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Gate<T> {
    /// Nothing changes.
    Open,
    /// Steps and heat alone.
    Passive(Rows<T>),
    /// With actions: the step of area, fluxes before the heat, and from fluxes to the state behind it.
    Active { step: Option<Rows<T>>, before: Rows<T>, behind: Rows<T> },
}

impl<T> Gate<T> {
    fn map<U>(&self, f: impl Fn(&T) -> U + Copy) -> Gate<U> {
        let rows = |m: &Rows<T>| m.each_ref().map(|row| row.each_ref().map(f));
        match self {
            Self::Open => Gate::Open,
            Self::Passive(m) => Gate::Passive(rows(m)),
            Self::Active { step, before, behind } => {
                Gate::Active { step: step.as_ref().map(rows), before: rows(before), behind: rows(behind) }
            }
        }
    }
}

impl<T: Number> Basis<T> {
    /// The chain as it stands; `one` is the constant 1.
    pub(super) fn plain(one: &T, gamma: f64, inlet: FlowState, ducts: &[FlowDuct]) -> Self {
        let mut basis = Self::unsettled(one, gamma, inlet, ducts);
        basis.settle(ducts, &[]);
        basis
    }

    /// The same before [`Basis::settle`].
    pub(super) fn unsettled(one: &T, gamma: f64, inlet: FlowState, ducts: &[FlowDuct]) -> Self {
        let mut gammas: Vec<f64> = Vec::with_capacity(ducts.len());
        for duct in ducts {
            gammas.push(duct.gamma.unwrap_or_else(|| gammas.last().copied().unwrap_or(gamma)));
        }
        let all = |f: &dyn Fn(&FlowDuct) -> f64| ducts.iter().map(|d| one.real(f(d))).collect::<Vec<T>>();
        Self {
            length: all(&|d| d.length),
            area: all(&|d| d.area),
            wall: all(&|_| 1.0),
            gain: all(&|_| 1.0),
            ends: [one.real(0.0), one.real(0.0)],
            ratios: all(&|d| d.ratio),
            inlet: Mean {
                pressure: one.real(inlet.pressure),
                density: one.real(inlet.density),
                velocity: one.real(inlet.velocity),
                gamma: gammas.first().copied().unwrap_or(gamma),
            },
            gammas,
            loss: vec![None; ducts.len()],
            reflections: [None, None],
            between: Vec::new(),
            after: Vec::new(),
            gates: Vec::new(),
            beside: vec![Vec::new(); ducts.len()],
        }
    }

    /// Mean states from the inlet state, the areas and the temperature ratios; `attached` laws act as
    /// feedback, too.
    pub(super) fn settle(&mut self, ducts: &[FlowDuct], attached: &[Attached]) {
        self.between = vec![self.inlet.clone()];
        self.after = vec![self.inlet.clone()];
        self.gates = vec![Gate::Open];
        for i in 1..self.area.len() {
            let areas = [&self.area[i - 1], &self.area[i]];
            let between = area_step(&self.after[i - 1], areas, ducts[i].smooth);
            self.after.push(heat_step(&between, &self.ratios[i], self.gammas[i]));
            self.between.push(between);
            let active = !ducts[i].actions.is_empty()
                || !self.beside[i].is_empty()
                || attached.iter().any(|a| a.acts_at(i));
            let gate = self.gate(i, !active, ducts[i].smooth);
            self.gates.push(gate);
        }
    }

    /// The same for a chain whose mean flow is that of `constant`.
    pub(super) fn settle_as(&mut self, constant: &Basis<ComplexDual>) {
        let one = self.inlet.velocity.clone();
        let like = |k: &ComplexDual| one.like(k.value);
        self.between = constant.between.iter().map(|m| m.map(like)).collect();
        self.after = constant.after.iter().map(|m| m.map(like)).collect();
        self.gates = constant.gates.iter().map(|g| g.map(like)).collect();
    }

    /// Something acts at the place before duct `i` from now on; mean states stay.
    pub(super) fn activate(&mut self, i: usize, smooth: bool) {
        if !matches!(self.gates[i], Gate::Active { .. }) {
            self.gates[i] = self.gate(i, false, smooth);
        }
    }

    fn gate(&self, i: usize, passive: bool, smooth: bool) -> Gate<T> {
        let (before, between, after) = (&self.after[i - 1], &self.between[i], &self.after[i]);
        let (a1, a2) = (&self.area[i - 1], &self.area[i]);
        let step = (a1 != a2).then(|| {
            let expands = !smooth && a2.value().re >= a1.value().re;
            let ratio = a1.over(a2);
            let [mass, force, energy] = fluxes(before, expands, before.gamma);
            let scale = |row: [T; 3]| row.map(|v| v * ratio.clone());
            let force = if expands {
                // p A_2 + rho u^2 A: the face carries the upstream pressure.
                let [p, u, e] = scale(force);
                [p + ratio.real(1.0) - ratio.clone(), u, e]
            } else {
                force
            };
            product(&inverse(&fluxes(between, expands, between.gamma)), &[scale(mass), force, scale(energy)])
        });
        if passive && between == after {
            return step.map_or(Gate::Open, Gate::Passive);
        }
        let before = fluxes(between, true, after.gamma);
        let behind = inverse(&fluxes(after, true, after.gamma));
        if passive {
            let heat = product(&behind, &before);
            Gate::Passive(step.map_or(heat.clone(), |step| product(&heat, &step)))
        } else {
            Gate::Active { step, before, behind }
        }
    }
}

impl Basis<ComplexDual> {
    /// Refuses a flow that is too fast, or chokes.
    pub(super) fn check(&self) -> Result<(), NetworkError> {
        for (index, mean) in self.after.iter().enumerate() {
            let mut mach = state_of(mean).mach(mean.gamma);
            if mach.is_nan() || mean.pressure.value.im != 0.0 {
                // The flow would choke. What it would be at constant density says how far it is from
                // possible.
                let [first, here] = [0, index].map(|i| self.area[i].value.re);
                mach = state_of(&self.inlet).mach(mean.gamma) * first / here
                    * self.ratios[index].value.re.max(1.0);
                mach = mach.max(1.0);
            }
            if !(0.0..0.3).contains(&mach) {
                return Err(NetworkError::TooFast { index, mach });
            }
        }
        Ok(())
    }

    /// The same with laws that stay as they are when s moves; mean flow and lengths never move with s.
    pub(super) fn at_rest_in_s(&self) -> Self {
        let still = |k: &ComplexDual| ComplexDual::constant(k.value);
        let mut basis = self.clone();
        basis.length.iter_mut().for_each(|k| *k = still(k));
        basis.loss.iter_mut().flatten().flatten().for_each(|k| *k = still(k));
        basis.reflections.iter_mut().flatten().for_each(|k| *k = still(k));
        basis.beside.iter_mut().flatten().for_each(|k| k.1 = still(&k.1));
        basis
    }
}

pub(super) type Rows<T> = [[T; 3]; 3];

/// Mass, momentum (or p/rho^gamma, if `momentum` is not kept) and energy per area as rows on (p, u, e), for a
/// place behind which the gas has the ratio of specific heats `behind`.
pub(super) fn fluxes<T: Number>(mean: &Mean<T>, momentum: bool, behind: f64) -> Rows<T> {
    let Mean { pressure, density, velocity, gamma } = mean;
    let gamma = *gamma;
    let zero = pressure.real(0.0);
    let square = mean.speed_squared();
    let enthalpy = mean.enthalpy_as(behind);
    let inverse = square.recip();
    // Columns: what unit p, u and e are in p', u', rho'.
    let columns = [
        [pressure.real(1.0), zero.clone(), inverse],
        [zero.clone(), pressure.real(1.0), zero.clone()],
        [zero.clone(), zero, pressure.real(1.0)],
    ];
    let column = |[dp, du, drho]: &[T; 3]| -> [T; 3] {
        let mass = drho.clone() * velocity.clone() + density.clone() * du.clone();
        let second = if momentum {
            let carried = drho.clone() * velocity.clone() + (density.clone() * du.clone()).times(2.0);
            dp.clone() + carried * velocity.clone()
        } else {
            dp.over(pressure) - drho.over(density).times(gamma)
        };
        let thermal = dp.over(density) - pressure.over(density).over(density) * drho.clone();
        let stagnation = thermal.times(gamma / (gamma - 1.0)) + velocity.clone() * du.clone();
        let energy = mass.clone() * enthalpy.clone() + density.clone() * velocity.clone() * stagnation;
        [mass, second, energy]
    };
    let [a, b, c] = columns.map(|k| column(&k));
    let [a0, a1, a2] = a;
    let [b0, b1, b2] = b;
    let [c0, c1, c2] = c;
    [[a0, b0, c0], [a1, b1, c1], [a2, b2, c2]]
}

pub(super) fn apply<T: Number>(m: &Rows<T>, x: &[T; 3]) -> [T; 3] {
    let row =
        |r: &[T; 3]| r[0].clone() * x[0].clone() + r[1].clone() * x[1].clone() + r[2].clone() * x[2].clone();
    [row(&m[0]), row(&m[1]), row(&m[2])]
}

/// a b.
fn product<T: Number>(a: &Rows<T>, b: &Rows<T>) -> Rows<T> {
    let column = |k: usize| apply(a, &[b[0][k].clone(), b[1][k].clone(), b[2][k].clone()]);
    let [[a0, b0, c0], [a1, b1, c1], [a2, b2, c2]] = [column(0), column(1), column(2)];
    [[a0, a1, a2], [b0, b1, b2], [c0, c1, c2]]
}

/// The inverse by cofactors: the matrices are 3 x 3 and well scaled by rows.
pub(super) fn inverse<T: Number>(m: &Rows<T>) -> Rows<T> {
    let cofactor = |r: usize, k: usize| {
        let (i, j) = ((r + 1) % 3, (r + 2) % 3);
        let (v, w) = ((k + 1) % 3, (k + 2) % 3);
        m[i][v].clone() * m[j][w].clone() - m[i][w].clone() * m[j][v].clone()
    };
    let determinant = m[0][0].clone() * cofactor(0, 0)
        + m[0][1].clone() * cofactor(0, 1)
        + m[0][2].clone() * cofactor(0, 2);
    let over = determinant.recip();
    [0, 1, 2].map(|k| [0, 1, 2].map(|r| cofactor(r, k) * over.clone()))
}
