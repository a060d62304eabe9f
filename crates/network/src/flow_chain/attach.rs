//! Laws of a caller in a chain with flow.

use super::assembly::FlowChain;
use super::ducts::{ActionKind, FlowDuct, FlowEnd, FlowState};
use super::gate::Basis;
use super::number::Number;
use crate::chain::coefficients::{Coefficients, Laws};
use crate::chain::network::{Network, Segment};
use crate::chains::Chain as _;
use crate::error::NetworkError;
use crate::laws::Law;
use crate::slot::Slot;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

impl FlowChain {
    /// The chain `rest` with a mean flow that enters it at `velocity` (m/s): same ducts, losses, feedback,
    /// ends and attached laws. The inlet has the density of the first segment and the pressure rho c^2/gamma
    /// there; temperatures behind follow from the speeds of sound.
    ///
    /// `gamma` is that of the first segment. Where rho c^2 = gamma p differs from segment to segment, the gas
    /// has another gamma there.
    ///
    /// # Errors
    /// As [`FlowChain::new`] and [`crate::Chain::attach`]; [`NetworkError::ActionAtInlet`] for feedback at an
    /// end, [`NetworkError::SlotOfRest`] for laws of densities and sound speeds.
    pub fn of(rest: &Network, gamma: f64, velocity: f64) -> Result<Self, NetworkError> {
        let first = rest.segments[0];
        let pressure = first.density * first.sound_speed * first.sound_speed / gamma;
        let inlet = FlowState { pressure, density: first.density, velocity };
        let n = rest.segments.len();
        let gamma_of = |s: &Segment| s.density * s.sound_speed * s.sound_speed / pressure;
        let mut ducts: Vec<FlowDuct> = Vec::with_capacity(n);
        for (i, segment) in rest.segments.iter().enumerate() {
            let mut duct = FlowDuct::new(segment.length, segment.area).of_gas(gamma_of(segment));
            if i > 0 {
                // p/rho = c^2/gamma, at one pressure.
                duct.ratio = rest.segments[i - 1].density / segment.density;
            }
            for (effect, k) in [ActionKind::Mu, ActionKind::Mp, ActionKind::Eu, ActionKind::Ep]
                .into_iter()
                .zip(rest.feedback[i])
            {
                if k != C64::ZERO {
                    duct = duct.with(effect, Law::Constant(k));
                }
            }
            ducts.push(duct);
        }
        if rest.feedback[n].iter().any(|k| *k != C64::ZERO) {
            return Err(NetworkError::NoDuct { index: n, ducts: n });
        }
        let ends = rest.ends.map(|r| FlowEnd::Reflection(Law::Constant(r)));
        let mut chain = Self::new(gamma, inlet, ducts, ends)?;
        chain.losses.clone_from(&rest.losses);
        for (loss, constant) in chain.basis.loss.iter_mut().zip(&chain.losses) {
            *loss = (*constant != [C64::ZERO; 2]).then(|| constant.map(ComplexDual::constant));
        }
        for (slot, law, weight) in rest.attachments() {
            chain.attach(slot, law, weight)?;
        }
        Ok(chain)
    }

    /// The basis with laws, mean flow included.
    pub(super) fn basis_with<T: Number>(&self, one: &T, law: &dyn Fn(usize) -> T) -> Basis<T> {
        let mut basis = self.unsettled_with(one, law);
        if self.attached.iter().any(|a| a.is_mean()) {
            basis.settle(&self.ducts, &self.attached);
        } else {
            basis.settle_as(&self.basis);
        }
        basis
    }

    /// The same before [`Basis::settle`].
    pub(super) fn unsettled_with<T: Number>(&self, one: &T, law: &dyn Fn(usize) -> T) -> Basis<T> {
        let mut basis = Basis::unsettled(one, self.gamma, self.inlet, &self.ducts);
        for a in &self.attached {
            let target = match a.slot {
                Slot::Length(i) => &mut basis.length[i],
                Slot::Area(i) => &mut basis.area[i],
                _ => continue,
            };
            *target = target.clone() + law(a.law).times(a.weight);
        }
        self.refresh(&mut basis, one, law);
        basis
    }

    /// Writes what laws add that the mean flow does not depend on.
    fn refresh<T: Number>(&self, basis: &mut Basis<T>, one: &T, law: &dyn Fn(usize) -> T) {
        for (loss, constant) in basis.loss.iter_mut().zip(&self.losses) {
            *loss = (*constant != [C64::ZERO; 2]).then(|| constant.map(|k| one.like(k)));
        }
        basis.beside.iter_mut().for_each(Vec::clear);
        basis.reflections = [None, None];
        for a in &self.attached {
            let share = law(a.law).times(a.weight);
            if let Some((place, effect)) = a.action() {
                basis.beside[place].push((effect, share));
                continue;
            }
            let to = match a.slot {
                Slot::Viscous(i) | Slot::Thermal(i) => {
                    let part = usize::from(matches!(a.slot, Slot::Thermal(_)));
                    &mut basis.loss[i].get_or_insert_with(|| [one.real(0.0), one.real(0.0)])[part]
                }
                Slot::Upstream => basis.reflections[0].get_or_insert_with(|| one.real(0.0)),
                Slot::Downstream => basis.reflections[1].get_or_insert_with(|| one.real(0.0)),
                _ => continue,
            };
            *to = to.clone() + share;
        }
    }

    /// The basis of a search, with values and slopes in s; laws of the mean flow are taken at `s`.
    pub(super) fn basis_at(
        &self,
        laws: &Laws,
        names: &dyn Coefficients,
    ) -> Result<Basis<ComplexDual>, NetworkError> {
        if let Some(a) = self.attached.iter().find(|a| a.is_mean() && laws.slope(a.law) != C64::ZERO) {
            return Err(NetworkError::MeanFlowOfS { law: names.name(a.law) });
        }
        let law = |k: usize| ComplexDual { value: laws.value(k), slope: laws.slope(k) };
        let one = ComplexDual::constant(C64::ONE);
        if self.attached.iter().any(|a| a.is_mean()) {
            let basis = self.basis_with(&one, &law);
            basis.check()?;
            return Ok(basis);
        }
        let mut basis = self.basis.clone();
        self.renew(&mut basis, laws);
        Ok(basis)
    }

    /// Brings the laws of `basis` to another s; the mean flow stays.
    pub(super) fn renew(&self, basis: &mut Basis<ComplexDual>, laws: &Laws) {
        for a in &self.attached {
            if let Slot::Length(i) = a.slot {
                basis.length[i] = ComplexDual::constant(C64::new(self.ducts[i].length, 0.0));
            }
        }
        let law = |k: usize| ComplexDual { value: laws.value(k), slope: laws.slope(k) };
        for a in &self.attached {
            if let Slot::Length(i) = a.slot {
                basis.length[i] = basis.length[i] + law(a.law).times(a.weight);
            }
        }
        self.refresh(basis, &ComplexDual::constant(C64::ONE), &law);
    }
}
