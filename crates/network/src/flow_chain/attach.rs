//! Laws of a caller in a chain with flow.

use super::gate::Basis;
use super::number::Number;
use super::{Effect, FlowChain, FlowEnd};
use crate::chain::{Network, Slot};
use crate::coefficients::{Coefficients, Laws};
use crate::error::NetworkError;
use crate::flow_chain::{FlowDuct, FlowState};
use crate::laws::Law;
use crate::sweep::Dual;
use rijke_numerics::C64;

/// A number of a chain with flow that laws can change: what it is in the chain plus the sum of weight times law over
/// everything attached to it. Ducts and places are numbered from 0; place j lies before duct j.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowSlot {
    /// Length of a duct, m. References of actions keep their distances.
    Length(usize),
    /// Area of a duct, m^2; the mean flow follows.
    Area(usize),
    /// Temperature ratio at the upstream end of a duct; the mean flow follows.
    Ratio(usize),
    /// Pressure of the inlet state, Pa.
    Pressure,
    /// Density of the inlet state, kg/m^3.
    Density,
    /// Velocity of the inlet state, m/s.
    Velocity,
    /// Viscous loss per metre of a duct, Pa s/m^2.
    Viscous(usize),
    /// Thermal loss per metre of a duct, 1/(Pa s).
    Thermal(usize),
    /// Feedback at a place from the velocity or pressure in front of it.
    At(usize, Effect),
    /// The coefficient of an action that the duct has: duct, number of the action. It hears where the action does.
    Action(usize, usize),
    /// R_u; not of a choked end.
    Upstream,
    /// R_d; not of a choked end.
    Downstream,
}

impl FlowSlot {
    /// Whether the mean flow depends on it.
    fn is_mean(self) -> bool {
        matches!(self, Self::Area(_) | Self::Ratio(_) | Self::Pressure | Self::Density | Self::Velocity)
    }
}

impl TryFrom<Slot> for FlowSlot {
    type Error = NetworkError;

    /// # Errors
    /// [`NetworkError::SlotOfRest`] for sound speeds and densities, which follow from the inlet with flow.
    fn try_from(slot: Slot) -> Result<Self, NetworkError> {
        Ok(match slot {
            Slot::Length(i) => Self::Length(i),
            Slot::Area(i) => Self::Area(i),
            Slot::Viscous(i) => Self::Viscous(i),
            Slot::Thermal(i) => Self::Thermal(i),
            Slot::Mu(j) => Self::At(j, Effect::Mu),
            Slot::Mp(j) => Self::At(j, Effect::Mp),
            Slot::Eu(j) => Self::At(j, Effect::Eu),
            Slot::Ep(j) => Self::At(j, Effect::Ep),
            Slot::Upstream => Self::Upstream,
            Slot::Downstream => Self::Downstream,
            Slot::SoundSpeed(_) | Slot::Density(_) => return Err(NetworkError::SlotOfRest { slot }),
        })
    }
}

/// A law in a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Attached {
    pub(super) slot: FlowSlot,
    pub(super) law: usize,
    pub(super) weight: f64,
}

impl Attached {
    pub(super) fn acts_at(&self, place: usize) -> bool {
        matches!(self.slot, FlowSlot::At(j, _) if j == place)
    }
}

impl FlowChain {
    /// Adds `weight` times law number `law` to a slot. The laws themselves come with each question, as [`Coefficients`]:
    /// see [`crate::Chain`]. Laws of the mean flow (areas, temperature ratios, the inlet) must not depend on s.
    ///
    /// # Errors
    /// [`NetworkError::NoDuct`], [`NetworkError::ActionAtInlet`], [`NetworkError::ChokedEnd`].
    pub fn attach(&mut self, slot: FlowSlot, law: usize, weight: f64) -> Result<(), NetworkError> {
        let n = self.ducts.len();
        let (index, count) = match slot {
            FlowSlot::Pressure | FlowSlot::Density | FlowSlot::Velocity => (0, 1),
            FlowSlot::Upstream | FlowSlot::Downstream => {
                let end = usize::from(slot == FlowSlot::Downstream);
                if self.ends[end] == FlowEnd::Choked {
                    return Err(NetworkError::ChokedEnd { end });
                }
                (end, 2)
            }
            FlowSlot::At(0, _) => return Err(NetworkError::ActionAtInlet),
            FlowSlot::Length(i)
            | FlowSlot::Area(i)
            | FlowSlot::Ratio(i)
            | FlowSlot::Viscous(i)
            | FlowSlot::Thermal(i)
            | FlowSlot::At(i, _) => (i, n),
            FlowSlot::Action(i, k) if i < n => (k, self.ducts[i].actions.len()),
            FlowSlot::Action(i, _) => (i, n),
        };
        if index >= count {
            return Err(NetworkError::NoDuct { index, ducts: count });
        }
        if slot == FlowSlot::Ratio(0) {
            return Err(NetworkError::ActionAtInlet);
        }
        self.attached.push(Attached { slot, law, weight });
        self.basis.settle(self.gamma, &self.ducts, &self.attached);
        Ok(())
    }

    /// The chain `rest` with a mean flow that enters it at `velocity` (m/s): same ducts, losses, feedback, ends and attached
    /// laws. The inlet has the density of the first segment and the pressure rho c^2/gamma there; temperatures behind follow
    /// from the ratios of densities.
    ///
    /// # Errors
    /// As [`FlowChain::new`] and [`FlowChain::attach`]; [`NetworkError::ActionAtInlet`] for feedback at an end,
    /// [`NetworkError::SlotOfRest`] for laws of densities and sound speeds.
    pub fn of(rest: &Network, gamma: f64, velocity: f64) -> Result<Self, NetworkError> {
        let first = rest.segments[0];
        let pressure = first.density * first.sound_speed * first.sound_speed / gamma;
        let inlet = FlowState { pressure, density: first.density, velocity };
        let n = rest.segments.len();
        let mut ducts: Vec<FlowDuct> = Vec::with_capacity(n);
        for (i, segment) in rest.segments.iter().enumerate() {
            let mut duct = FlowDuct::new(segment.length, segment.area);
            if i > 0 {
                duct.ratio = rest.segments[i - 1].density / segment.density;
            }
            for (effect, k) in
                [Effect::Mu, Effect::Mp, Effect::Eu, Effect::Ep].into_iter().zip(rest.feedback[i])
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
        for (loss, constant) in chain.basis.loss.iter_mut().zip(&rest.losses) {
            *loss = (*constant != [C64::ZERO; 2]).then(|| constant.map(Dual::constant));
        }
        chain.losses = rest.losses.clone();
        for (slot, law, weight) in rest.attachments() {
            chain.attach(FlowSlot::try_from(slot)?, law, weight)?;
        }
        Ok(chain)
    }

    /// The basis with laws, mean flow included.
    pub(super) fn basis_with<T: Number>(&self, one: &T, law: &dyn Fn(usize) -> T) -> Basis<T> {
        let mut basis = self.unsettled_with(one, law);
        basis.settle(self.gamma, &self.ducts, &self.attached);
        basis
    }

    /// The same before [`Basis::settle`].
    pub(super) fn unsettled_with<T: Number>(&self, one: &T, law: &dyn Fn(usize) -> T) -> Basis<T> {
        let mut basis = Basis::unsettled(one, self.inlet, &self.ducts);
        for a in &self.attached {
            let target = match a.slot {
                FlowSlot::Length(i) => &mut basis.length[i],
                FlowSlot::Area(i) => &mut basis.area[i],
                FlowSlot::Ratio(i) => &mut basis.ratios[i],
                FlowSlot::Pressure => &mut basis.inlet.pressure,
                FlowSlot::Density => &mut basis.inlet.density,
                FlowSlot::Velocity => &mut basis.inlet.velocity,
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
        basis.extra.clear();
        basis.reflections = [None, None];
        for a in &self.attached {
            let add = |to: &mut T| *to = to.clone() + law(a.law).times(a.weight);
            match a.slot {
                FlowSlot::Viscous(i) | FlowSlot::Thermal(i) => {
                    let zero = || [one.real(0.0), one.real(0.0)];
                    let part = usize::from(matches!(a.slot, FlowSlot::Thermal(_)));
                    add(&mut basis.loss[i].get_or_insert_with(zero)[part]);
                }
                FlowSlot::At(j, effect) => basis.beside[j].push((effect, law(a.law).times(a.weight))),
                FlowSlot::Action(i, k) => basis.extra.push((i, k, law(a.law).times(a.weight))),
                FlowSlot::Upstream | FlowSlot::Downstream => {
                    let end = usize::from(a.slot == FlowSlot::Downstream);
                    add(basis.reflections[end].get_or_insert_with(|| one.real(0.0)));
                }
                _ => {}
            }
        }
    }

    /// The basis of a search, with values and slopes in s; laws of the mean flow are taken at `s`.
    pub(super) fn basis_at(
        &self,
        laws: &Laws,
        names: &dyn Coefficients,
    ) -> Result<Basis<Dual>, NetworkError> {
        if let Some(a) = self.attached.iter().find(|a| a.slot.is_mean() && laws.slope(a.law) != C64::ZERO) {
            return Err(NetworkError::MeanFlowOfS { law: names.name(a.law) });
        }
        let law = |k: usize| Dual { v: laws.value(k), d: laws.slope(k) };
        let one = Dual::constant(C64::ONE);
        if self.attached.iter().any(|a| a.slot.is_mean()) {
            let basis = self.basis_with(&one, &law);
            basis.check(self.gamma)?;
            return Ok(basis);
        }
        let mut basis = self.basis.clone();
        self.renew(&mut basis, laws);
        Ok(basis)
    }

    /// Brings the laws of `basis` to another s; the mean flow stays.
    pub(super) fn renew(&self, basis: &mut Basis<Dual>, laws: &Laws) {
        for a in &self.attached {
            if let FlowSlot::Length(i) = a.slot {
                basis.length[i] = Dual::constant(C64::new(self.ducts[i].length, 0.0));
            }
        }
        let law = |k: usize| Dual { v: laws.value(k), d: laws.slope(k) };
        for a in &self.attached {
            if let FlowSlot::Length(i) = a.slot {
                basis.length[i] = basis.length[i] + law(a.law).times(a.weight);
            }
        }
        self.refresh(basis, &Dual::constant(C64::ONE), &law);
    }
}
