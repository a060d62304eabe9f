//! Where the energy of a mode with flow comes from and where it goes.
//!
//! The acoustic energy of a uniform flow (Cantrell & Hart 1964) is w = rho |u|^2/4 + |p|^2/(4 rho c^2) + U
//! Re(u* p)/(2 c^2) and its flux I = Re(J m*)/2 with J = p + rho U u, m = u + U p/(rho c^2). The equations of
//! a duct give exactly d(A I)/dx = -A [2 sigma w + Re(kappa_mu u m*)/2 + Re(kappa_ep p J*)/2].

use super::assembly::FlowChain;
use super::ducts::FlowState;
use super::gate::Basis;
use super::mean::{Mean, state_of};
use super::number::Number as _;
use super::passage::State;
use crate::plane::newton::Root;
use crate::sense::budget::{Budget, Power};
use gauss_quad::GaussLegendre;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;
use std::num::NonZeroUsize;

fn flux(mean: &Mean<ComplexDual>, [p, u, _]: &State<ComplexDual>) -> f64 {
    let compliance = 1.0 / (mean.gamma * mean.pressure.value.re);
    let (j, m) = flux_factors(&state_of(mean), compliance, [p.value, u.value]);
    0.5 * (j * m.conj()).re
}

fn flux_factors(mean: &FlowState, compliance: f64, [p, u]: [C64; 2]) -> (C64, C64) {
    (p + mean.density * mean.velocity * u, u + mean.velocity * compliance * p)
}

impl FlowChain {
    /// The energy budget of the mode at `root`, which must be an eigenvalue. The chain is as `basis` has it.
    pub(super) fn budget_with(&self, basis: &Basis<ComplexDual>, root: &Root) -> Budget {
        let s = ComplexDual { value: root.s, slope: C64::ONE };
        let mut budget = Budget { growth: 2.0 * root.s.re, ..Budget::default() };
        let (mut energy, n) = (0.0, self.ducts.len());
        let area = |j: usize| basis.area[j].value.re;
        self.sweep(basis, &s, |j, before, behind| {
            if j == n {
                // The wave that comes back is that of the end, which is that of the sweep at an eigenvalue
                // alone.
                let (mean, [p, u, e]) = (&basis.after[n - 1], before);
                let off = self.finish(basis, before, &s);
                let impedance = mean.density * mean.speed_squared().sqrt();
                let left = [*p - off, *u + off * impedance.recip(), *e];
                budget.downstream = -area(n - 1) * flux(mean, &left);
                return;
            }
            let incoming = if j > 0 { area(j - 1) * flux(&basis.after[j - 1], before) } else { 0.0 };
            let outgoing = area(j) * flux(&basis.after[j], behind);
            if j == 0 {
                budget.upstream = outgoing;
            } else if self.ducts[j].actions.is_empty()
                && basis.beside[j].is_empty()
                && basis.ratios[j].value == C64::ONE
            {
                budget.mean_flow += outgoing - incoming;
            } else {
                let shares = self.shares(basis, j, [before, behind]);
                let laws = shares.map(|(law, power)| (law, area(j) * power)).collect();
                budget.places.push(Power { place: j, power: outgoing - incoming, laws });
            }
            let [stored, viscous, thermal] = self.integrals(basis, j, behind, &s);
            energy += stored;
            budget.viscous -= viscous;
            budget.thermal -= thermal;
        });
        budget.per_energy(energy);
        budget
    }

    /// What laws that are attached at place `j` have in the power per area that the state behind it carries
    /// away: with d_k what law k adds to the state x behind the place, D their sum and B the symmetric form
    /// of the flux, B(d_k, 2x - D).
    fn shares(
        &self,
        basis: &Basis<ComplexDual>,
        j: usize,
        [before, behind]: [&State<ComplexDual>; 2],
    ) -> impl Iterator<Item = (usize, f64)> {
        let mean = state_of(&basis.after[j]);
        let compliance = 1.0 / (basis.gammas[j] * mean.pressure);
        let parts = |x: &State<ComplexDual>| flux_factors(&mean, compliance, [x[0].value, x[1].value]);
        let added = basis.beside[j].iter().map(|(effect, k)| {
            let cause = if effect.of_velocity() { before[1].value } else { before[0].value };
            let unit = parts(&self.effect(basis, j, *effect, j - 1));
            (unit.0 * k.value * cause, unit.1 * k.value * cause)
        });
        let added: Vec<(C64, C64)> = added.collect();
        let whole = parts(behind);
        let sum = added.iter().fold((2.0 * whole.0, 2.0 * whole.1), |x, d| (x.0 - d.0, x.1 - d.1));
        let laws = self.attached.iter().filter(move |a| a.acts_at(j)).map(|a| a.law);
        let laws: Vec<usize> = laws.collect();
        laws.into_iter()
            .zip(added.into_iter().map(move |d| 0.25 * (d.0 * sum.1.conj() + sum.0 * d.1.conj()).re))
    }

    /// Energy in duct `i` and what viscosity and conduction at its wall take, from the state at its upstream
    /// end, by Gauss's rule on pieces over which the phase turns by less than one radian.
    fn integrals(
        &self,
        basis: &Basis<ComplexDual>,
        i: usize,
        [p, u, _]: &State<ComplexDual>,
        s: &ComplexDual,
    ) -> [f64; 3] {
        const POINTS: NonZeroUsize = NonZeroUsize::new(8).unwrap();
        let (duct, mean, gamma) = (&self.ducts[i], state_of(&basis.after[i]), basis.gammas[i]);
        let (length, area) = (basis.length[i].value.re, basis.area[i].value.re);
        let compliance = 1.0 / (gamma * mean.pressure);
        let slow = mean.sound_speed(gamma) - mean.velocity;
        let pieces = (s.value.norm() * length / slow).ceil().clamp(1.0, 1e4);
        let (mut viscous, mut thermal) = duct.wall.as_ref().map_or((C64::ZERO, C64::ZERO), |wall| {
            let loss = wall.law.loss(&wall.wall, s.value);
            (loss.viscous[0] * wall.factor, loss.thermal[0] * wall.factor)
        });
        if let Some(more) = &basis.loss[i] {
            viscous += more[0].value;
            thermal += more[1].value;
        }
        let rule = GaussLegendre::new(POINTS);
        let step = length / pieces;
        let mut sums = [0.0; 3];
        for k in 0..pieces as usize {
            for (node, weight) in rule.iter() {
                let x = step * (k as f64 + 0.5 * (node + 1.0));
                let x = ComplexDual::constant(C64::new(x, 0.0));
                let [p, u] = self.carry(basis, i, [p, u], s, &x).map(|v| v.value);
                let (j, m) = flux_factors(&mean, compliance, [p, u]);
                let convected = 2.0 * mean.density * mean.velocity * compliance * (u * p.conj()).re;
                let density = mean.density * u.norm_sqr() + compliance * p.norm_sqr() + convected;
                let here =
                    [0.25 * density, 0.5 * (viscous * u * m.conj()).re, 0.5 * (thermal * p * j.conj()).re];
                for (sum, v) in sums.iter_mut().zip(here) {
                    *sum += 0.5 * step * weight * area * v;
                }
            }
        }
        sums
    }
}
