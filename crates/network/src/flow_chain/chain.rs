//! A chain with flow and laws of a caller, behind the trait that it shares with the chain at rest.

use super::assembly::FlowChain;
use super::ducts::FlowEnd;
use super::gate::Basis;
use super::number::Seeded;
use super::slots::Attached;
use crate::chain::coefficients::{At, Coefficients, Laws, Pole};
use crate::chain::workspace::Workspace;
use crate::chains::Chain;
use crate::error::NetworkError;
use crate::modes::contour::check_analytic;
use crate::plane::modes::Modes;
use crate::plane::newton::{Newton, Root, iterate};
use crate::plane::poles::PolesByPlace;
use crate::plane::region::Region;
use crate::plane::zeros::zeros;
use crate::respond::answer::{Places, Response};
use crate::sense::along::{Station, bounded};
use crate::sense::budget::Budget;
use crate::slot::Slot;
use rijke_numerics::ComplexDual;
use rijke_numerics::{C64, Jet, Order};
use std::f64::consts::PI;

impl FlowChain {
    /// The laws at `s`, values and slopes, and the chain with them.
    fn with_laws(
        &self,
        laws: &dyn Coefficients,
        s: C64,
        at_s: &mut Laws,
    ) -> Result<Basis<ComplexDual>, NetworkError> {
        self.check_numbers(laws)?;
        fill(laws, s, at_s);
        let basis = self.basis_at(at_s, laws)?;
        let negative = |(_, length): &(usize, &ComplexDual)| length.value.re <= 0.0;
        match basis.length.iter().enumerate().find(negative) {
            Some((index, length)) => {
                Err(NetworkError::Property { index, quantity: "length", value: length.value.re })
            }
            None => Ok(basis),
        }
    }

    /// Fails for a law that is attached and not there.
    fn check_numbers(&self, laws: &dyn Coefficients) -> Result<(), NetworkError> {
        let count = laws.laws();
        match self.attached.iter().find(|a| a.law >= count) {
            Some(a) => Err(NetworkError::NoLaw { slot: a.slot, law: a.law, laws: count }),
            None => Ok(()),
        }
    }

    /// F and its slope, with `basis` brought to `s`.
    fn characteristic_with(
        &self,
        laws: &dyn Coefficients,
        s: C64,
        basis: &mut Basis<ComplexDual>,
        at_s: &mut Laws,
    ) -> ComplexDual {
        fill(laws, s, at_s);
        self.renew(basis, at_s);
        self.sweep(basis, &ComplexDual { value: s, slope: C64::ONE }, |_, _, _| ())
    }
}

fn fill(laws: &dyn Coefficients, s: C64, at_s: &mut Laws) {
    let at = At::search(s);
    at_s.reset(laws.laws(), &at);
    laws.fill(&at, at_s);
}

impl Chain for FlowChain {
    fn count(&self) -> usize {
        self.ducts.len()
    }

    fn position(&self, place: usize) -> f64 {
        self.ducts.iter().take(place).map(|d| d.length).sum()
    }

    fn travel_time(&self) -> f64 {
        Self::travel_time(self)
    }

    fn attach(&mut self, slot: Slot, law: usize, weight: f64) -> Result<(), NetworkError> {
        let attached = Attached { slot, law, weight };
        let (action, n) = (attached.action(), self.ducts.len());
        match (slot, slot.index()) {
            (Slot::SoundSpeed(_) | Slot::Density(_), _) => return Err(NetworkError::SlotOfRest { slot }),
            (_, None) => {
                let end = usize::from(slot == Slot::Downstream);
                if self.ends[end] == FlowEnd::Choked {
                    return Err(NetworkError::ChokedEnd { end });
                }
            }
            (_, Some(0)) if action.is_some() => return Err(NetworkError::ActionAtInlet),
            (_, Some(index)) if index >= n => return Err(NetworkError::NoDuct { index, ducts: n }),
            _ => {}
        }
        self.attached.push(attached);
        if let Some((place, _)) = action {
            self.basis.activate(place, self.ducts[place].smooth);
        }
        Ok(())
    }

    fn solve(
        &self,
        laws: &dyn Coefficients,
        guess: C64,
        settings: &Newton,
        work: &mut Workspace,
    ) -> Result<Root, NetworkError> {
        let mut basis = self.with_laws(laws, guess, &mut work.laws)?;
        let spacing = PI / self.travel_time();
        iterate(guess, spacing, settings, |s| self.characteristic_with(laws, s, &mut basis, &mut work.laws))
    }

    fn modes(
        &self,
        laws: &dyn Coefficients,
        region: &Region,
        work: &mut Workspace,
    ) -> Result<Modes, NetworkError> {
        region.check()?;
        self.bound_entropy_waves(region)?;
        let step = 0.25 * PI / self.travel_time();
        let poles = Chain::poles(self, laws, &region.widened(4.0 * step))?;
        check_analytic(laws, region, &poles, work)?;
        let inside = poles.iter().filter(|p| region.contains(p.0)).map(|p| p.1).sum();
        let middle = region.sigma.map(|v| 0.5 * v).iter().sum::<f64>();
        let middle = C64::new(middle, region.omega.map(|v| 0.5 * v).iter().sum());
        let mut basis = self.with_laws(laws, middle, &mut work.laws)?;
        let f = |s: C64| {
            let f = self.characteristic_with(laws, s, &mut basis, &mut work.laws);
            [f.value, f.slope]
        };
        zeros(f, region, step, poles, inside)
    }

    fn poles(&self, laws: &dyn Coefficients, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError> {
        let mut poles = PolesByPlace::default();
        for Pole { law, at, order } in laws.poles_in(region)? {
            for a in self.attached.iter().filter(|a| a.law == law && a.weight != 0.0) {
                let place = match (a.slot, a.action()) {
                    (_, Some((place, _))) => [Some(place), None],
                    (Slot::Upstream, _) => [None, Some(0)],
                    (Slot::Downstream, _) => [None, Some(1)],
                    _ => return Err(NetworkError::PoleInSegment { law: laws.name(law), at }),
                };
                poles.add((at, order), law, |other| *other == place, place);
            }
        }
        let mut all = self.own_poles(region)?;
        all.extend(poles.all());
        Ok(all)
    }

    fn respond(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        places: &Places,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Response, NetworkError> {
        let n = self.ducts.len();
        if let Some(&place) = places.at.iter().chain([&places.reference]).find(|&&j| j > n) {
            return Err(NetworkError::NoDuct { index: place, ducts: n });
        }
        if order == Order::Value {
            // Slopes in s alone, in which F is swept as in a search.
            let basis = self.with_laws(laws, root.s, &mut work.laws)?;
            let mut pressures = vec![None; n + 1];
            let f = self.sweep(&basis, &ComplexDual { value: root.s, slope: C64::ONE }, |j, x, _| {
                pressures[j] = Some(Jet::from_parts(x[0].value, vec![x[0].slope], Vec::new()));
            });
            if !f.slope.inv().is_finite() {
                return Err(NetworkError::NotFinite { s: root.s });
            }
            let s = Jet::from_parts(root.s, Vec::new(), Vec::new());
            return Response::relative(s, &pressures, places, order);
        }
        self.check_numbers(laws)?;
        let at = At::full(root.s, laws.parameters(), order);
        let filled = &mut work.laws;
        filled.reset(laws.laws(), &at);
        laws.fill(&at, filled);
        let law = |k: usize| {
            let parts = (filled.gradient(k).to_vec(), filled.hessian(k).to_vec());
            Seeded::new(Jet::from_parts(filled.value(k), parts.0, parts.1))
        };
        let basis = self.basis_with(&Seeded::Fixed(C64::ONE), &law);
        let (s, pressures) = self.of_seeds(&basis, at.s_jet())?;
        Response::relative(s, &pressures, places, order)
    }

    fn along(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        samples: usize,
        work: &mut Workspace,
    ) -> Result<Vec<Station>, NetworkError> {
        bounded(samples, self.ducts.len())?;
        let basis = self.with_laws(laws, root.s, &mut work.laws)?;
        self.along_with(&basis, root, samples)
    }

    fn budget(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<Budget, NetworkError> {
        let basis = self.with_laws(laws, root.s, &mut work.laws)?;
        Ok(self.budget_with(&basis, root))
    }

    fn condition(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<f64, NetworkError> {
        let basis = self.with_laws(laws, root.s, &mut work.laws)?;
        self.condition_with(&basis, root, &work.laws)
    }
}
