//! The mode with flow and what a small change anywhere does to its eigenvalue.
//!
//! A piece of length dx whose area or temperature is larger by a fraction a turns the state x into x + K x a
//! dx, with one matrix K for a whole duct: the mixed second derivative, at dx = a = 0, of what two places
//! with the piece between them do, mean flow included. The two closures of steps of area agree to first order
//! in a, so that K is that of a smooth change.

use super::adjoint::{Back, EFFECTS, Passed, Row, dot, fixed, through};
use super::assembly::FlowChain;
use super::ducts::{FlowDuct, FlowEnd};
use super::gate::Basis;
use super::mean::state_of;
use super::number::{Number, Seeded};
use super::passage::State;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use crate::sense::along::{Station, of_loudest};
use rijke_numerics::ComplexDual;
use rijke_numerics::{C64, JetSpace, Order};

/// By columns: what unit p, u and e become.
type Change = [Row; 3];

/// What every station of a duct shares.
struct Effects {
    area: Change,
    temperature: Change,
    /// By effect: what a unit of it adds to the state.
    devices: [State<ComplexDual>; 5],
    impedance: f64,
}

impl FlowChain {
    /// The mode at `root` and its sensitivities at `samples` points of every duct, ends included (at least
    /// 2), as [`crate::Network::along`], with the chain as `basis` has it. The mean flow goes along with area
    /// and temperature; weak devices leave it as it is.
    pub(super) fn along_with(
        &self,
        basis: &Basis<ComplexDual>,
        root: &Root,
        samples: usize,
    ) -> Result<Vec<Station>, NetworkError> {
        let passed = Passed::new(self, basis, root)?;
        let back = passed.eigenvalue();
        let (mut stations, mut start) = (Vec::new(), 0.0);
        let last = samples.max(2) - 1;
        for i in 0..self.ducts.len() {
            let (effects, length) = (self.effects(&passed.basis, i, root.s)?, basis.length[i].value.re);
            for k in 0..=last {
                let within = length * (k as f64 / last as f64);
                let station = self.station(&passed, &back, &effects, i, within);
                stations.push(Station { x: start + within, ..station });
            }
            start += length;
        }
        of_loudest(stations, root.s)
    }

    fn station(&self, passed: &Passed<'_>, back: &Back, effects: &Effects, i: usize, within: f64) -> Station {
        let (basis, s) = (&passed.basis, &passed.s);
        let real = |v: f64| ComplexDual::constant(C64::new(v, 0.0));
        let here = self.convey(basis, i, &fixed(&passed.behind[i]), s, &real(within));
        let left = real(basis.length[i].value.re - within);
        let mut row = through(&back.ends[i], |x| self.convey(basis, i, x, s, &left));
        for (point, weight) in self.references.iter().zip(&back.weights).filter(|(e, _)| e.duct == i) {
            let distance = point.offset(basis).value.re - within;
            if distance >= 0.0 {
                let velocity = |[p, u, _]: &State<ComplexDual>| {
                    let [_, velocity] = self.carry(basis, i, [p, u], s, &real(distance));
                    [velocity, *s, *s]
                };
                let added = through(&[*weight, C64::ZERO, C64::ZERO], velocity);
                row = std::array::from_fn(|k| row[k] + added[k]);
            }
        }
        let by = |effect: usize| {
            let cause = if EFFECTS[effect].of_velocity() { here[1].value } else { here[0].value };
            dot(&row, &effects.devices[effect]) * cause
        };
        let changed = |change: &Change| -> C64 {
            (0..3).map(|k| here[k].value * (0..3).map(|r| row[r] * change[k][r]).sum::<C64>()).sum()
        };
        Station {
            x: within,
            segment: i,
            pressure: here[0].value,
            velocity: here[1].value * effects.impedance,
            feedback: [by(0), by(1), by(2), by(3)],
            branch: by(4),
            impedance: effects.impedance,
            area: changed(&effects.area),
            temperature: changed(&effects.temperature),
        }
    }

    fn effects(&self, basis: &Basis<ComplexDual>, i: usize, s: C64) -> Result<Effects, NetworkError> {
        let state = state_of(&basis.after[i]);
        let plain = FlowDuct { actions: Vec::new(), ratio: 1.0, gamma: None, ..self.ducts[i].clone() };
        let ends = [FlowEnd::Choked, FlowEnd::Choked];
        let mut local = Self::new(basis.gammas[i], state, vec![plain.clone(), plain.clone(), plain], ends)?;
        local.losses = vec![basis.loss[i].map_or([C64::ZERO; 2], |loss| loss.map(|k| k.value)); 3];
        let constant = &local.basis;
        let devices = EFFECTS.map(|effect| local.effect(constant, 1, effect, 0));
        let impedance = state.density * state.sound_speed(basis.gammas[i]);
        Ok(Effects { area: local.change(s, true), temperature: local.change(s, false), devices, impedance })
    }

    /// K of a chain of three equal ducts, the middle one being the piece: of area, or else of temperature.
    fn change(&self, s: C64, of_area: bool) -> Change {
        let space = JetSpace::new(2, Order::Second);
        let one = Seeded::Fixed(C64::ONE);
        let larger = one.clone() + Seeded::Varying(space.seed(0, C64::ZERO));
        let mut basis = self.unsettled_with(&one, &|_| one.real(0.0));
        basis.length[1] = Seeded::Varying(space.seed(1, C64::ZERO));
        if of_area {
            basis.area[1] = basis.area[1].clone() * larger;
        } else {
            basis.ratios[2] = larger.recip();
            basis.ratios[1] = larger;
        }
        basis.settle(&self.ducts, &[]);
        let s = one.like(s);
        std::array::from_fn(|k| {
            let mut x = [one.real(0.0), one.real(0.0), one.real(0.0)];
            x[k] = one.clone();
            x = self.cross_alone(&basis, 1, &x, &s);
            x = self.pass(&basis, 1, &x, &s);
            self.cross_alone(&basis, 2, &x, &s).map(|v| match v {
                Seeded::Fixed(_) => C64::ZERO,
                Seeded::Varying(jet) => jet.hessian(1, 0),
            })
        })
    }
}
