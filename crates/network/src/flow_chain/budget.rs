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
use gauss_quad::GaussLegendre;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;
use std::num::NonZeroUsize;

/// Mean power over the energy of the mode, 1/s; positive feeds the mode. Half of each is its share of the
/// growth rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FlowBudget {
    /// 2 sigma, what the others must add up to.
    pub growth: f64,
    /// Through the upstream end, convection included.
    pub upstream: f64,
    /// Through the downstream end.
    pub downstream: f64,
    /// Viscous losses.
    pub viscous: f64,
    /// Thermal losses.
    pub thermal: f64,
    /// At places between ducts where something acts or is heated: place and power.
    pub places: Vec<(usize, f64)>,
    /// At all other places: what the mean flow takes at changes of area, by vortices and entropy waves.
    pub mean_flow: f64,
}

impl FlowBudget {
    /// Sum of all entries minus 2 sigma, relative to the sum of their moduli: zero but for rounding if s is
    /// an eigenvalue, and only then.
    #[must_use]
    pub fn mismatch(&self) -> f64 {
        let parts = [self.upstream, self.downstream, self.viscous, self.thermal, self.mean_flow];
        let all = parts.into_iter().chain(self.places.iter().map(|p| p.1));
        let (sum, size) = all.fold((0.0, 0.0), |(sum, size), x| (sum + x, size + f64::abs(x)));
        let scale = size.max(self.growth.abs());
        if scale > 0.0 { (sum - self.growth).abs() / scale } else { 0.0 }
    }
}

fn flux(mean: &Mean<ComplexDual>, [p, u, _]: &State<ComplexDual>) -> f64 {
    let compliance = 1.0 / (mean.gamma * mean.pressure.value.re);
    let (j, m) = flux_factors(&state_of(mean), compliance, [p.value, u.value]);
    0.5 * (j * m.conj()).re
}

fn flux_factors(mean: &FlowState, compliance: f64, [p, u]: [C64; 2]) -> (C64, C64) {
    (p + mean.density * mean.velocity * u, u + mean.velocity * compliance * p)
}

impl FlowChain {
    /// The energy budget of the mode at `root`, which must be an eigenvalue.
    #[must_use]
    pub fn budget(&self, root: &Root) -> FlowBudget {
        self.budget_with(&self.basis, root).0
    }

    /// The same with the chain as `basis` has it, and what attached laws have in the power of their places:
    /// place, law, power.
    pub(super) fn budget_with(
        &self,
        basis: &Basis<ComplexDual>,
        root: &Root,
    ) -> (FlowBudget, Vec<(usize, usize, f64)>) {
        let s = ComplexDual { value: root.s, slope: C64::ONE };
        let mut budget = FlowBudget { growth: 2.0 * root.s.re, ..FlowBudget::default() };
        let (mut energy, n) = (0.0, self.ducts.len());
        let area = |j: usize| basis.area[j].value.re;
        let mut shares: Vec<(usize, usize, f64)> = Vec::new();
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
                budget.places.push((j, outgoing - incoming));
            }
            if j > 0 {
                let here = self.shares(basis, j, [before, behind]);
                shares.extend(here.map(|(law, power)| (j, law, area(j) * power)));
            }
            let [stored, viscous, thermal] = self.integrals(basis, j, behind, &s);
            energy += stored;
            budget.viscous -= viscous;
            budget.thermal -= thermal;
        });
        let parts = [
            &mut budget.upstream,
            &mut budget.downstream,
            &mut budget.viscous,
            &mut budget.thermal,
            &mut budget.mean_flow,
        ];
        for part in parts.into_iter().chain(budget.places.iter_mut().map(|p| &mut p.1)) {
            *part /= energy;
        }
        for share in &mut shares {
            share.2 /= energy;
        }
        (budget, shares)
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
