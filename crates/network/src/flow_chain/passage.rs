//! How a disturbance (p, u, e) with e = rho' - p/c^2 passes ducts and the places between them.

use super::assembly::FlowChain;
use super::ducts::{ActionKind, FlowEnd};
use super::gate::{Basis, Gate, apply, fluxes, inverse};
use super::number::Number;
use super::reference_point::ReferencePoint;
use crate::chain::line::{curvature, line};
use crate::laws::Law;

/// p, u and e.
pub(super) type State<T> = [T; 3];

impl<T: Number> Basis<T> {
    /// R of an end whose own law is `law`.
    fn reflection(&self, end: usize, law: &Law, s: &T) -> T {
        let own = s.law(law);
        let whole = self.reflections[end].as_ref().map_or(own.clone(), |more| own + more.clone());
        whole * self.ends[end].exp()
    }
}

impl FlowChain {
    /// F at the downstream end; `visit` is told the state upstream of every place and behind it (the same at
    /// the ends).
    pub(super) fn sweep<T: Number>(
        &self,
        basis: &Basis<T>,
        s: &T,
        visit: impl FnMut(usize, &State<T>, &State<T>),
    ) -> T {
        self.sweep_from(basis, s, self.start(basis, s), visit)
    }

    /// As [`FlowChain::sweep`], from the state `x` behind the upstream end.
    pub(super) fn sweep_from<T: Number>(
        &self,
        basis: &Basis<T>,
        s: &T,
        mut x: State<T>,
        mut visit: impl FnMut(usize, &State<T>, &State<T>),
    ) -> T {
        let mut velocities: Vec<Option<T>> = vec![None; self.references.len()];
        let mut loops: Option<T> = None;
        for i in 0..self.ducts.len() {
            let behind = if i > 0 { self.cross(basis, i, &x, s, &velocities, &mut loops) } else { x.clone() };
            for (point, velocity) in
                self.references.iter().zip(&mut velocities).filter(|(e, _)| e.duct == i && !e.is_loop())
            {
                *velocity = Some(self.velocity_at(basis, point, &behind, s));
            }
            visit(i, &x, &behind);
            x = self.pass(basis, i, &behind, s);
        }
        visit(self.ducts.len(), &x, &x);
        let f = self.finish(basis, &x, s);
        loops.map_or(f.clone(), |loops| f * loops)
    }

    pub(super) fn start<T: Number>(&self, basis: &Basis<T>, s: &T) -> State<T> {
        let mean = &basis.after[0];
        let square = mean.speed_squared();
        let impedance = mean.density.clone() * square.sqrt();
        let one = s.real(1.0);
        let (r, entropy) = match &self.ends[0] {
            FlowEnd::Reflection(law) => (basis.reflection(0, law, s), s.real(0.0)),
            FlowEnd::Choked => {
                let mach = mean.velocity.over(&square.sqrt());
                let below = (mach.clone() * mach.clone()).times(mean.gamma - 1.0) + one.clone();
                let m = mach.times(mean.gamma).over(&below);
                let share = s.real(mean.gamma).over(&below) - one.clone();
                ((one.clone() - m.clone()).over(&(one.clone() + m)), share.over(&square))
            }
        };
        let p = r.clone() + one.clone();
        [p.clone(), (r - one).over(&impedance), entropy * p]
    }

    pub(super) fn finish<T: Number>(&self, basis: &Basis<T>, [p, u, e]: &State<T>, s: &T) -> T {
        let n = self.ducts.len() - 1;
        let mean = &basis.after[n];
        let c = mean.speed_squared().sqrt();
        let wave = mean.density.clone() * c.clone() * u.clone();
        let (f, g) = ((p.clone() + wave.clone()).times(0.5), (p.clone() - wave).times(0.5));
        match &self.ends[1] {
            FlowEnd::Reflection(law) => g - basis.reflection(1, law, s) * f,
            FlowEnd::Choked => {
                // g (1 + m) = f (1 - m) + c U e/2, m = (gamma-1) M/2.
                let m = mean.velocity.over(&c).times(0.5 * (mean.gamma - 1.0));
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
        let square = mean.speed_squared();
        let compliance = (mean.density.clone() * square.clone()).recip();
        let (mut z, mut y) = (s.clone() * mean.density.clone(), s.clone() * compliance.clone());
        if let Some(wall) = &self.ducts[i].wall {
            let loss = wall.law.loss(&wall.wall, s.value());
            let factor = basis.wall[i].times(wall.factor);
            z = z + s.compose(loss.viscous) * factor.clone();
            y = y + s.compose(loss.thermal) * factor;
        }
        if let Some([viscous, thermal]) = &basis.loss[i] {
            z = z + viscous.clone() * basis.wall[i].clone();
            y = y + thermal.clone() * basis.wall[i].clone();
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

    pub(super) fn pass<T: Number>(&self, basis: &Basis<T>, i: usize, x: &State<T>, s: &T) -> State<T> {
        // An entropy wave that has nothing to meet need not be followed through the last duct.
        let met = i + 1 < self.ducts.len() || self.ends[1] == FlowEnd::Choked;
        let [p, u, e] = self.convey(basis, i, x, s, &basis.length[i]);
        [p, u, if met { e } else { s.real(0.0) }]
    }

    /// The whole state carried over `length` of duct `i`.
    pub(super) fn convey<T: Number>(
        &self,
        basis: &Basis<T>,
        i: usize,
        [p, u, e]: &State<T>,
        s: &T,
        length: &T,
    ) -> State<T> {
        let [p, u] = self.carry(basis, i, [p, u], s, length);
        let e = if self.entropy_waves {
            e.clone() * (-(s.clone() * length.over(&basis.after[i].velocity))).exp()
        } else {
            s.real(0.0)
        };
        [p, u, e]
    }

    /// The state behind the place before duct `i`, with the velocities of its references; `loops` gathers the
    /// factors of F.
    fn cross<T: Number>(
        &self,
        basis: &Basis<T>,
        i: usize,
        x: &State<T>,
        s: &T,
        velocities: &[Option<T>],
        loops: &mut Option<T>,
    ) -> State<T> {
        let mut state = self.cross_alone(basis, i, x, s);
        for (point, known) in self.references.iter().zip(velocities).filter(|(e, _)| e.place == i) {
            let unit = self.amplified(basis, point, s);
            let velocity = if point.is_loop() {
                let base = self.velocity_ahead(basis, point, state.clone(), s);
                let open = s.real(1.0) - self.velocity_ahead(basis, point, unit.clone(), s);
                *loops = Some(loops.as_ref().map_or(open.clone(), |l| l.clone() * open.clone()));
                base.over(&open)
            } else {
                known.clone().unwrap_or_else(|| s.real(f64::NAN))
            };
            let [p, u, e] = state;
            let [a, b, c] = unit.map(|v| v * velocity.clone());
            state = [p + a, u + b, e + c];
        }
        state
    }

    /// What unit velocity at a reference adds to the state behind its place.
    pub(super) fn amplified<T: Number>(&self, basis: &Basis<T>, point: &ReferencePoint, s: &T) -> State<T> {
        let action = &self.ducts[point.place].actions[point.action];
        let k = self.strength(basis, point.place, point.action, s);
        self.effect(basis, point.place, action.effect, point.duct).map(|v| v * k.clone())
    }

    /// The velocity at a reference, from the state at the upstream end of its duct.
    pub(super) fn velocity_at<T: Number>(
        &self,
        basis: &Basis<T>,
        point: &ReferencePoint,
        [p, u, _]: &State<T>,
        s: &T,
    ) -> T {
        let [_, velocity] = self.carry(basis, point.duct, [p, u], s, &point.offset(basis));
        velocity
    }

    /// The velocity at the reference of a loop, from the state behind its place.
    fn velocity_ahead<T: Number>(&self, basis: &Basis<T>, point: &ReferencePoint, x: State<T>, s: &T) -> T {
        let mut x = x;
        for i in point.place..point.duct {
            x = self.cross_alone(basis, i + 1, &self.pass(basis, i, &x, s), s);
        }
        self.velocity_at(basis, point, &x, s)
    }

    /// The coefficient of action `k` of duct `i`.
    fn strength<T: Number>(&self, basis: &Basis<T>, i: usize, k: usize, s: &T) -> T {
        s.law(&self.ducts[i].actions[k].law) * basis.gain[i].clone()
    }

    /// The mass, momentum and energy that a unit of an effect adds at the place before duct `i`; `reference`
    /// is the duct of its velocity.
    fn push<T: Number>(&self, basis: &Basis<T>, i: usize, effect: ActionKind, reference: usize) -> [T; 3] {
        let (between, after) = (&basis.between[i], &basis.after[i]);
        let gamma = after.gamma;
        let one = between.density.real(1.0);
        let zero = one.real(0.0);
        match effect {
            ActionKind::Mu | ActionKind::Mp => [zero.clone(), -one, zero],
            ActionKind::Eu | ActionKind::Ep => {
                [zero.clone(), zero, -between.pressure.times(gamma / (gamma - 1.0))]
            }
            ActionKind::Flame => {
                let heated = after.enthalpy() - between.enthalpy_as(gamma);
                let mean = between.density.clone() * between.velocity.clone() * heated;
                [zero.clone(), zero, mean.over(&basis.after[reference].velocity)]
            }
            ActionKind::Branch => {
                let taken = -between.density.clone();
                let [force, energy] =
                    [between.velocity.clone(), between.enthalpy_as(gamma)].map(|v| taken.clone() * v);
                [taken, force, energy]
            }
        }
    }

    /// What a unit of an effect adds to the state behind the place before duct `i`.
    pub(super) fn effect<T: Number>(
        &self,
        basis: &Basis<T>,
        i: usize,
        effect: ActionKind,
        reference: usize,
    ) -> State<T> {
        let push = self.push(basis, i, effect, reference);
        match &basis.gates[i] {
            Gate::Active { behind, .. } => apply(behind, &push),
            _ => {
                let after = &basis.after[i];
                apply(&inverse(&fluxes(after, true, after.gamma)), &push)
            }
        }
    }

    /// The state behind the place before duct `i`, without the velocities of its references.
    pub(super) fn cross_alone<T: Number>(&self, basis: &Basis<T>, i: usize, x: &State<T>, s: &T) -> State<T> {
        let (step, into, behind) = match &basis.gates[i] {
            Gate::Open => return x.clone(),
            Gate::Passive(matrix) => return apply(matrix, x),
            Gate::Active { step, before, behind } => (step, before, behind),
        };
        let stepped = step.as_ref().map_or_else(|| x.clone(), |step| apply(step, x));
        let mut flux = apply(into, &stepped);
        let mut act = |effect: ActionKind, k: T| {
            let cause = if effect.of_velocity() { &x[1] } else { &x[0] };
            let amount = k * cause.clone();
            let added = self.push(basis, i, effect, i - 1);
            for (sum, v) in flux.iter_mut().zip(added) {
                *sum = sum.clone() + v * amount.clone();
            }
        };
        for (k, action) in self.ducts[i].actions.iter().enumerate() {
            if !self.references.iter().any(|e| e.place == i && e.action == k) {
                act(action.effect, self.strength(basis, i, k, s));
            }
        }
        for (effect, k) in &basis.beside[i] {
            act(*effect, k.clone());
        }
        apply(behind, &flux)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow_chain::ducts::{FlowDuct, FlowState};
    use crate::flow_chain::mean::{Mean, area_step, heat_step};
    use rijke_numerics::C64;
    use rijke_numerics::ComplexDual;

    const GAMMA: f64 = 1.4;

    /// The state behind a step of area and heat `power` per area before, from p, u, rho before it: the
    /// nonlinear balances, not linearised.
    fn behind([p, u, rho]: [f64; 3], areas: [f64; 2], power: f64) -> [f64; 3] {
        let one = ComplexDual::constant(C64::ONE);
        let mean = |v: f64| one.real(v);
        let before = Mean { pressure: mean(p), velocity: mean(u), density: mean(rho), gamma: GAMMA };
        let stepped = area_step(&before, [&mean(areas[0]), &mean(areas[1])], false);
        let per_mass = power / (rho * u);
        // The ratio of temperatures that takes this much heat, by bisection.
        let (mut low, mut high) = (1.0, 5.0);
        for _ in 0..200 {
            let ratio = 0.5 * (low + high);
            let heated = heat_step(&stepped, &mean(ratio), GAMMA);
            let taken = (heated.enthalpy() - stepped.enthalpy()).value.re;
            if taken > per_mass { high = ratio } else { low = ratio }
        }
        let ratio = 0.5 * (low + high);
        let heated = if power > 0.0 { heat_step(&stepped, &mean(ratio), GAMMA) } else { stepped };
        [heated.pressure, heated.velocity, heated.density].map(|v| v.value.re)
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
            let s = ComplexDual::constant(C64::new(0.0, 100.0));
            for k in 0..3 {
                // Unit p, u or rho before the place: e = rho - p/c^2.
                let square = GAMMA * inlet.pressure / inlet.density;
                let mut x = [0.0; 3];
                x[k] = 1.0;
                x[2] -= x[0] / square;
                let got = chain.cross_alone(
                    &chain.basis,
                    1,
                    &x.map(|v| ComplexDual::constant(C64::new(v, 0.0))),
                    &s,
                );
                let [p, u, e] = got.map(|v| v.value.re);
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
