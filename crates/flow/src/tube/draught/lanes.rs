//! Several mass flows at once.

use super::{Balanced, Draught, Search, Step, TRIES};
use crate::error::FlowError;
use crate::number::{Lanes, Number};
use crate::tube::march::{Drive, Flow, March};
use crate::tube::parameters::TubeParameters;
use crate::tube::pipe::Pipe;

/// Lanes that flow the way of most march together until the last has settled; one that has found its flow
/// keeps it meanwhile. The others (the other way, or without a root for the secant) search alone.
impl<const L: usize> Balanced for Lanes<L> {
    fn draught(
        pipe: &Pipe,
        wall: &[Self],
        drive: Drive<Self>,
        p: &TubeParameters<Self>,
        tolerance: f64,
        out: &mut Draught<Self>,
    ) -> Result<(), FlowError> {
        let (flow, slope) = out.guess();
        let mut search: [Search; L] = std::array::from_fn(|k| Search::new(flow.0[k], slope.0[k]));
        let down = 2 * search.iter().filter(|s| s.is_down()).count() > L;
        let mut state =
            search.each_ref().map(|s| if s.is_down() == down { Step::Next(s.flow()) } else { Step::Lost });
        for _ in 0..TRIES {
            let open = state.iter().filter(|s| matches!(s, Step::Next(_))).count();
            if open == 0 {
                break;
            }
            // A lane that searches alone later on marches at any flow.
            out.mass_flow = Lanes(state.map(|s| match s {
                Step::Next(m) | Step::Found(m) => m,
                Step::Lost => 1e-3,
            }));
            let flow = Flow::along(Lanes(out.mass_flow.0.map(f64::abs)), down);
            pipe.march(wall, drive, flow, p, &mut out.march);
            let balance = pipe.balance(&out.march, flow, drive.ambient, p);
            out.marches += open;
            for (k, state) in state.iter_mut().enumerate() {
                if matches!(state, Step::Next(_)) {
                    *state = search[k].judge(balance.buoyancy.0[k], balance.losses.0[k], tolerance);
                }
            }
        }
        out.slope = Lanes(search.each_ref().map(|s| s.slope));
        let mut walls = std::mem::take(&mut out.walls);
        for k in (0..L).filter(|&k| !matches!(state[k], Step::Found(_))) {
            let mut alone = Draught { mass_flow: flow.0[k], slope: slope.0[k], ..Draught::empty() };
            walls.clear();
            walls.extend(wall.iter().map(|w| w.0[k]));
            let drive = Drive { released: drive.released.0[k], ambient: drive.ambient.0[k] };
            pipe.draught(&walls, drive, &p.map(|v| v.0[k]), tolerance, &mut alone)?;
            out.set_lane(k, &alone);
        }
        out.walls = walls;
        Ok(())
    }
}

impl<const L: usize> Draught<Lanes<L>> {
    /// Lane `k` by itself.
    pub(crate) fn lane(&self, k: usize) -> Draught<f64> {
        let of = |values: &[Lanes<L>]| values.iter().map(|v| v.0[k]).collect();
        let march = March {
            face: of(&self.march.face),
            mean: of(&self.march.mean),
            to_wall: of(&self.march.to_wall),
        };
        Draught { slope: self.slope.0[k], ..Draught::at(self.mass_flow.0[k], march) }
    }

    /// Replaces lane `k`.
    pub(crate) fn set_lane(&mut self, k: usize, one: &Draught<f64>) {
        self.march.resize(one.march.mean.len(), Lanes::constant(0.0));
        let set = |to: &mut [Lanes<L>], from: &[f64]| to.iter_mut().zip(from).for_each(|(t, &f)| t.0[k] = f);
        set(&mut self.march.face, &one.march.face);
        set(&mut self.march.mean, &one.march.mean);
        set(&mut self.march.to_wall, &one.march.to_wall);
        (self.mass_flow.0[k], self.slope.0[k]) = (one.mass_flow, one.slope);
        self.marches += one.marches;
    }
}
