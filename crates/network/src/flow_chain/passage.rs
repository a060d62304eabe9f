//! How a disturbance (p, u, e) with e = rho' - p/c^2 passes ducts and the places between them.

use super::mean::{Mean, area_step, heat_step};
use super::number::Number;
use super::{Effect, FlowChain, FlowDuct, FlowEnd, FlowState};
use crate::transfer::{curvature, line};

/// Everything of a chain that may depend on parameters, by duct.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Basis<T> {
    pub(super) length: Vec<T>,
    pub(super) area: Vec<T>,
    /// Factors on the wall losses, and on what acts at the upstream end.
    pub(super) wall: Vec<T>,
    pub(super) gain: Vec<T>,
    /// Delays added to what acts at the upstream end, s.
    pub(super) delay: Vec<T>,
    /// Logarithms of factors on the reflection coefficients.
    pub(super) ends: [T; 2],
    /// Mean state between the change of area and the heat before a duct, and in the duct.
    pub(super) between: Vec<Mean<T>>,
    pub(super) after: Vec<Mean<T>>,
    /// How disturbances pass the places before the ducts; the first is empty.
    gates: Vec<Gate<T>>,
}

/// A place: matrices on (p, u, e) that need computing once.
#[derive(Clone, Debug, PartialEq)]
enum Gate<T> {
    /// Nothing changes.
    Open,
    /// Steps and heat alone.
    Passive(Rows<T>),
    /// With actions: the step of area, fluxes before the heat, and from fluxes to the state behind it.
    Active { step: Option<Rows<T>>, before: Rows<T>, behind: Rows<T> },
}

impl<T: Number> Basis<T> {
    /// The chain as it stands; `one` is the constant 1.
    pub(super) fn plain(one: &T, gamma: f64, inlet: FlowState, ducts: &[FlowDuct]) -> Self {
        let ratios: Vec<T> = ducts.iter().map(|d| one.real(d.ratio)).collect();
        let mut basis = Self {
            length: ducts.iter().map(|d| one.real(d.length)).collect(),
            area: ducts.iter().map(|d| one.real(d.area)).collect(),
            wall: vec![one.real(1.0); ducts.len()],
            gain: vec![one.real(1.0); ducts.len()],
            delay: vec![one.real(0.0); ducts.len()],
            ends: [one.real(0.0), one.real(0.0)],
            between: Vec::new(),
            after: Vec::new(),
            gates: Vec::new(),
        };
        let inlet = Mean {
            pressure: one.real(inlet.pressure),
            density: one.real(inlet.density),
            velocity: one.real(inlet.velocity),
        };
        basis.settle(gamma, inlet, &ratios, ducts);
        basis
    }

    /// Mean states from the inlet state, the areas and the temperature ratios.
    pub(super) fn settle(&mut self, gamma: f64, inlet: Mean<T>, ratios: &[T], ducts: &[FlowDuct]) {
        self.between = vec![inlet.clone()];
        self.after = vec![inlet];
        self.gates = vec![Gate::Open];
        for i in 1..self.area.len() {
            let between = area_step(gamma, &self.after[i - 1], &self.area[i - 1], &self.area[i]);
            self.after.push(heat_step(&between, &ratios[i]));
            self.between.push(between);
            let gate = self.gate(gamma, i, ducts[i].actions.is_empty());
            self.gates.push(gate);
        }
    }

    fn gate(&self, gamma: f64, i: usize, passive: bool) -> Gate<T> {
        let (before, between, after) = (&self.after[i - 1], &self.between[i], &self.after[i]);
        let (a1, a2) = (&self.area[i - 1], &self.area[i]);
        let step = (a1 != a2).then(|| {
            let expands = a2.value().re >= a1.value().re;
            let ratio = a1.over(a2);
            let [mass, force, energy] = fluxes(gamma, before, expands);
            let scale = |row: [T; 3]| row.map(|v| v * ratio.clone());
            let force = if expands {
                // p A_2 + rho u^2 A: the face carries the upstream pressure.
                let [p, u, e] = scale(force);
                [p + ratio.real(1.0) - ratio.clone(), u, e]
            } else {
                force
            };
            product(&inverse(&fluxes(gamma, between, expands)), &[scale(mass), force, scale(energy)])
        });
        if passive && between == after {
            return step.map_or(Gate::Open, Gate::Passive);
        }
        let (before, behind) = (fluxes(gamma, between, true), inverse(&fluxes(gamma, after, true)));
        if passive {
            let heat = product(&behind, &before);
            Gate::Passive(step.map_or(heat.clone(), |step| product(&heat, &step)))
        } else {
            Gate::Active { step, before, behind }
        }
    }
}

/// p, u and e.
pub(super) type State<T> = [T; 3];

impl FlowChain {
    /// F at the downstream end; `visit` is told the state upstream of every place and behind it (the same at the ends).
    pub(super) fn sweep<T: Number>(
        &self,
        basis: &Basis<T>,
        s: &T,
        mut visit: impl FnMut(usize, &State<T>, &State<T>),
    ) -> T {
        let mut x = self.start(basis, s);
        for i in 0..self.ducts.len() {
            let behind = if i > 0 { self.cross(basis, i, &x, s) } else { x.clone() };
            visit(i, &x, &behind);
            x = self.pass(basis, i, &behind, s);
        }
        visit(self.ducts.len(), &x, &x);
        self.finish(basis, &x, s)
    }

    fn start<T: Number>(&self, basis: &Basis<T>, s: &T) -> State<T> {
        let mean = &basis.after[0];
        let square = mean.speed_squared(self.gamma);
        let impedance = mean.density.clone() * square.sqrt();
        let one = s.real(1.0);
        let (r, entropy) = match &self.ends[0] {
            FlowEnd::Reflection(law) => (s.law(law) * basis.ends[0].exp(), s.real(0.0)),
            FlowEnd::Choked => {
                let mach = mean.velocity.over(&square.sqrt());
                let below = (mach.clone() * mach.clone()).times(self.gamma - 1.0) + one.clone();
                let m = mach.times(self.gamma).over(&below);
                let share = s.real(self.gamma).over(&below) - one.clone();
                ((one.clone() - m.clone()).over(&(one.clone() + m)), share.over(&square))
            }
        };
        let p = r.clone() + one.clone();
        [p.clone(), (r - one).over(&impedance), entropy * p]
    }

    fn finish<T: Number>(&self, basis: &Basis<T>, [p, u, e]: &State<T>, s: &T) -> T {
        let n = self.ducts.len() - 1;
        let mean = &basis.after[n];
        let c = mean.speed_squared(self.gamma).sqrt();
        let wave = mean.density.clone() * c.clone() * u.clone();
        let (f, g) = ((p.clone() + wave.clone()).times(0.5), (p.clone() - wave).times(0.5));
        match &self.ends[1] {
            FlowEnd::Reflection(law) => g - s.law(law) * basis.ends[1].exp() * f,
            FlowEnd::Choked => {
                // g (1 + m) = f (1 - m) + c U e/2, m = (gamma-1) M/2.
                let m = mean.velocity.over(&c).times(0.5 * (self.gamma - 1.0));
                let one = s.real(1.0);
                let sound = (c * mean.velocity.clone() * e.clone()).times(0.5);
                g - ((one.clone() - m.clone()) * f + sound).over(&(one + m))
            }
        }
    }

    /// [p, u] carried over `length` of duct `i`: e^t (C + S [[d, -P], [-Q, -d]]) with
    /// P = l Z/(1-M^2), Q = l Y/(1-M^2), t, d = l U (rho Y +- Z/(rho c^2))/(2(1-M^2)), C and S at d^2 + P Q.
    pub(super) fn carry<T: Number>(
        &self,
        basis: &Basis<T>,
        i: usize,
        [p, u]: [&T; 2],
        s: &T,
        length: &T,
    ) -> [T; 2] {
        let mean = &basis.after[i];
        let square = mean.speed_squared(self.gamma);
        let compliance = (mean.density.clone() * square.clone()).recip();
        let (mut z, mut y) = (s.clone() * mean.density.clone(), s.clone() * compliance.clone());
        if let Some(wall) = &self.ducts[i].wall {
            let loss = wall.law.loss(&wall.wall, s.value());
            let factor = basis.wall[i].times(wall.factor);
            z = z + s.compose(loss.viscous) * factor.clone();
            y = y + s.compose(loss.thermal) * factor;
        }
        let flow = mean.velocity.clone();
        let scale = length.over(&(s.real(1.0) - (flow.clone() * flow.clone()).over(&square)));
        let (a, b) = (mean.density.clone() * y.clone() * flow.clone(), z.clone() * compliance * flow);
        let half = scale.times(0.5);
        let (t, d) = ((a.clone() + b.clone()) * half.clone(), (a - b) * half);
        let (big_p, big_q) = (z * scale.clone(), y * scale);
        let q = d.clone() * d.clone() + big_p.clone() * big_q.clone();
        let at = line(q.value());
        let c = q.compose([at.c, 0.5 * at.s, 0.5 * at.s1]) * t.exp();
        let sh = q.compose([at.s, at.s1, curvature(q.value(), &at)]) * t.exp();
        [
            c.clone() * p.clone() + sh.clone() * (d.clone() * p.clone() - big_p * u.clone()),
            c * u.clone() - sh * (big_q * p.clone() + d * u.clone()),
        ]
    }

    fn pass<T: Number>(&self, basis: &Basis<T>, i: usize, [p, u, e]: &State<T>, s: &T) -> State<T> {
        let [p, u] = self.carry(basis, i, [p, u], s, &basis.length[i]);
        // An entropy wave that has nothing to meet need not be followed through the last duct.
        let met = i + 1 < self.ducts.len() || self.ends[1] == FlowEnd::Choked;
        let e = if self.entropy_waves && met {
            e.clone() * (-(s.clone() * basis.length[i].over(&basis.after[i].velocity))).exp()
        } else {
            s.real(0.0)
        };
        [p, u, e]
    }

    /// The state behind the place before duct `i`.
    fn cross<T: Number>(&self, basis: &Basis<T>, i: usize, x: &State<T>, s: &T) -> State<T> {
        let gamma = self.gamma;
        let (before, between, after) = (&basis.after[i - 1], &basis.between[i], &basis.after[i]);
        let (step, into, behind) = match &basis.gates[i] {
            Gate::Open => return x.clone(),
            Gate::Passive(matrix) => return apply(matrix, x),
            Gate::Active { step, before, behind } => (step, before, behind),
        };
        let stepped = step.as_ref().map_or_else(|| x.clone(), |step| apply(step, x));
        let duct = &self.ducts[i];
        let [mut mass, mut force, mut energy] = apply(into, &stepped);
        let heat = between.pressure.times(gamma / (gamma - 1.0));
        for action in &duct.actions {
            let k =
                s.law(&action.law) * basis.gain[i].clone() * (-(s.clone() * basis.delay[i].clone())).exp();
            let velocity = if action.reference > 0.0 {
                let back = s.real(-action.reference);
                let [_, u] = self.carry(basis, i - 1, [&x[0], &x[1]], s, &back);
                u
            } else {
                x[1].clone()
            };
            match action.effect {
                Effect::Mu => force = force - k * velocity,
                Effect::Mp => force = force - k * x[0].clone(),
                Effect::Eu => energy = energy - k * velocity * heat.clone(),
                Effect::Ep => energy = energy - k * x[0].clone() * heat.clone(),
                Effect::Flame => {
                    let heated = after.enthalpy(gamma) - between.enthalpy(gamma);
                    let mean = between.density.clone() * between.velocity.clone() * heated;
                    energy = energy + k * velocity * mean.over(&before.velocity);
                }
                Effect::Branch => {
                    let taken = k * x[0].clone() * between.density.clone();
                    mass = mass - taken.clone();
                    force = force - taken.clone() * between.velocity.clone();
                    energy = energy - taken * between.enthalpy(gamma);
                }
            }
        }
        apply(behind, &[mass, force, energy])
    }
}

type Rows<T> = [[T; 3]; 3];

/// Mass, momentum (or p/rho^gamma, if `momentum` is not kept) and energy per area as rows on (p, u, e).
fn fluxes<T: Number>(gamma: f64, mean: &Mean<T>, momentum: bool) -> Rows<T> {
    let Mean { pressure, density, velocity } = mean;
    let zero = pressure.real(0.0);
    let square = mean.speed_squared(gamma);
    let enthalpy = mean.enthalpy(gamma);
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

fn apply<T: Number>(m: &Rows<T>, x: &State<T>) -> State<T> {
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
fn inverse<T: Number>(m: &Rows<T>) -> Rows<T> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::Law;
    use crate::sweep::Dual;
    use rijke_numerics::C64;

    const GAMMA: f64 = 1.4;

    /// The state behind a step of area and heat `power` per area before, from p, u, rho before it: the nonlinear
    /// balances, not linearised.
    fn behind([p, u, rho]: [f64; 3], areas: [f64; 2], power: f64) -> [f64; 3] {
        let one = Dual::constant(C64::ONE);
        let mean = |v: f64| one.real(v);
        let before = Mean { pressure: mean(p), velocity: mean(u), density: mean(rho) };
        let stepped = area_step(GAMMA, &before, &mean(areas[0]), &mean(areas[1]));
        let per_mass = power / (rho * u);
        // The ratio of temperatures that takes this much heat, by bisection.
        let (mut low, mut high) = (1.0, 5.0);
        for _ in 0..200 {
            let ratio = 0.5 * (low + high);
            let heated = heat_step(&stepped, &mean(ratio));
            let taken = (heated.enthalpy(GAMMA) - stepped.enthalpy(GAMMA)).v.re;
            if taken > per_mass { high = ratio } else { low = ratio }
        }
        let ratio = 0.5 * (low + high);
        let heated = if power > 0.0 { heat_step(&stepped, &mean(ratio)) } else { stepped };
        [heated.pressure, heated.velocity, heated.density].map(|v| v.v.re)
    }

    #[test]
    fn oracle_places_are_the_linearised_balances() {
        for (areas, power) in
            [([1.0, 1.8], 0.0), ([1.0, 0.6], 0.0), ([1.0, 1.0], 9e6), ([1.0, 0.7], 2e7), ([1.0, 1.5], 1e7)]
        {
            let inlet = FlowState { pressure: 101_325.0, density: 1.2, velocity: 40.0 };
            let at = [inlet.pressure, inlet.velocity, inlet.density];
            let base = behind(at, areas, power);
            let one = behind(at, areas, 0.0);
            let ratio = base[0] / base[2] * one[2] / one[0];
            let ducts = vec![FlowDuct::new(1.0, areas[0]), FlowDuct::new(1.0, areas[1]).heated(ratio)];
            let closed = || FlowEnd::Reflection(Law::Constant(C64::ONE));
            let chain = FlowChain::new(GAMMA, inlet, ducts, [closed(), closed()]).unwrap();
            let s = Dual::constant(C64::new(0.0, 100.0));
            for k in 0..3 {
                // Unit p, u or rho before the place: e = rho - p/c^2.
                let square = GAMMA * inlet.pressure / inlet.density;
                let mut x = [0.0; 3];
                x[k] = 1.0;
                x[2] -= x[0] / square;
                let got = chain.cross(&chain.basis, 1, &x.map(|v| Dual::constant(C64::new(v, 0.0))), &s);
                let [p, u, e] = got.map(|v| v.v.re);
                let got = [p, u, e + p * base[2] / (GAMMA * base[0])];
                let h = 1e-4 * at[k];
                let nudged = |sign: f64| {
                    let mut at = at;
                    at[k] += sign * h;
                    behind(at, areas, power)
                };
                let (up, down) = (nudged(1.0), nudged(-1.0));
                for i in 0..3 {
                    let slope = (up[i] - down[i]) / (2.0 * h);
                    let scale = base[i] / at[k];
                    assert!(
                        (got[i] - slope).abs() < 1e-6 * scale,
                        "{areas:?} {power} d{i}/d{k}: {} {slope}",
                        got[i]
                    );
                }
            }
        }
    }
}
