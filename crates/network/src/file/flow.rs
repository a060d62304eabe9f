//! The chain with mean flow of a file.

use super::assembly::{Assembly, Attached, Role};
use super::error::FileError;
use super::layout::Placed;
use super::problem::ElementProblem;
use super::schema::Flow;
use crate::error::NetworkError;
use crate::flow_chain::{Action, ActionKind, FlowChain, FlowDuct, FlowEnd, FlowState, Reference};
use crate::laws::Law;
use crate::slot::Slot;
use rijke_numerics::C64;

impl Assembly<'_> {
    /// The chain of everything read so far, with choked ends for the time being.
    pub(super) fn flow(&self, line: usize, flow: &Flow, placed: &[Placed]) -> Result<FlowChain, FileError> {
        let fail = |problem| FileError::Flow { line, problem };
        let first = self.segments[0];
        let velocity = match (flow.mach, flow.velocity) {
            (Some(mach), None) => mach * first.sound_speed,
            (None, Some(velocity)) => velocity,
            _ => return Err(fail(ElementProblem::OneOf { one: "mach", other: "velocity" })),
        };
        let mach = velocity / first.sound_speed;
        if !(mach > 0.0 && mach < 0.3) {
            return Err(fail(ElementProblem::TooFast { mach }));
        }
        let n = self.segments.len();
        let mut ducts: Vec<FlowDuct> = (0..n)
            .map(|i| FlowDuct {
                wall: self.walls[i].clone(),
                smooth: i > 0 && self.owners[i] == self.owners[i - 1],
                ratio: if i == 0 { 1.0 } else { self.gases[i].heat / self.gases[i - 1].heat },
                gamma: Some(self.gases[i].gamma),
                ..FlowDuct::new(self.segments[i].length, self.segments[i].area)
            })
            .collect();
        if let Some((_, name)) = self.devices.iter().find(|(place, _)| *place == 0 || *place == n) {
            let device = placed.iter().find(|p| p.item.place == *name);
            return Err(device.map_or(FileError::NoDuct, |d| d.item.fail(ElementProblem::AtEnd)));
        }
        for Attached { slot, law, weight, role } in &self.attach {
            let (place, effect) = match (slot, role) {
                (_, Role::Flame) => continue,
                (Slot::Ep(j), Role::Branch) => (*j, ActionKind::Branch),
                (Slot::Mu(j), _) => (*j, ActionKind::Mu),
                (Slot::Mp(j), _) => (*j, ActionKind::Mp),
                (Slot::Eu(j), _) => (*j, ActionKind::Eu),
                (Slot::Ep(j), _) => (*j, ActionKind::Ep),
                // Wall losses in the propagation are in the walls.
                _ => continue,
            };
            let law = self.laws.laws[*law].1.clone();
            let law = if *weight == 1.0 { law } else { Law::Scaled(Box::new(law), C64::new(*weight, 0.0)) };
            ducts[place].actions.push(Action { effect, law, reference: Reference::Upstream(0.0) });
        }
        for flame in &self.flames {
            let (law, effect, distance) = (flame.law.clone(), flame.effect, flame.reference);
            let reference = if flame.downstream {
                Reference::Downstream(distance)
            } else {
                Reference::Upstream(distance)
            };
            ducts[flame.place].actions.push(Action { effect, law, reference });
        }
        let inlet = FlowState { pressure: self.gas.pressure, density: first.density, velocity };
        let of = |ducts: Vec<FlowDuct>| {
            let chain = FlowChain::new(self.gas.gamma, inlet, ducts, [FlowEnd::Choked, FlowEnd::Choked]);
            chain.map_err(|error| match error {
                NetworkError::TooFast { index, mach } => {
                    placed[self.owners[index]].item.fail(ElementProblem::TooFast { mach })
                }
                error => error.into(),
            })
        };
        let mut chain = of(ducts)?;
        if self.screens.iter().any(|screen| screen.1 > 0.0) {
            // d(K rho U^2/2)/dU in the flow before the screen, whose own pressure drop the mean flow leaves
            // out.
            let mut ducts = chain.ducts().to_vec();
            for &(place, loss) in &self.screens {
                let before = chain.states()[place - 1];
                let drag = C64::new(loss * before.density * before.velocity, 0.0);
                ducts[place] = ducts[place].clone().with(ActionKind::Mu, Law::Constant(drag));
            }
            chain = of(ducts)?;
        }
        Ok(if flow.entropy_waves { chain } else { chain.without_entropy_waves() })
    }
}
