//! The gas at moments of a run in which the power changes, before the flow has settled.

use super::draught::Draught;
use super::parameters::Unknowns;
use super::pipe::Pipe;
use super::transient::{TIGHT, Transient};
use crate::apparatus::ramp::{Logged, Ramp};
use crate::error::FlowError;

/// Time after a change of power in which the longest step doubles, s: some three lags of the heater.
const CALM: f64 = 120.0;
/// Longest step over the one after a change of power: the implicit matrix has typical slopes of the losses,
/// not those of the state.
const LONGEST: f64 = 8.0;

impl Pipe {
    /// The gas at each of the `moments` (s, ascending) of the run `ramp`, which starts from the tube at rest
    /// at the indicated `ambient` temperature (K). Every change of power and every moment ends a step. Steps
    /// are at most `step` (s) long after a change, and grow as the flow calms: what is left to happen at a
    /// time t after a change has time constants of the order of t. The error is second order in `step`.
    ///
    /// # Errors
    /// As [`Transient::step`], and [`FlowError::Setting`] for a moment before the run or before the last one.
    pub fn gas_along(
        &self,
        ramp: &Ramp,
        unknowns: &Unknowns,
        ambient: f64,
        moments: &[f64],
        step: f64,
    ) -> Result<Vec<Draught<f64>>, FlowError> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(FlowError::Setting { name: "step", value: step, must: "above zero, s" });
        }
        if let Some(row) = ramp.log.iter().find(|row| !(row.power.is_finite() && row.time.is_finite())) {
            let must = "finite, at finite times";
            return Err(FlowError::Setting { name: "power", value: row.power, must });
        }
        let mut time = ramp.log.first().map_or(f64::INFINITY, |first| first.time);
        let (mut power, mut changed) = (0.0, time);
        let mut left = ramp.log.as_slice();
        let mut state = Transient::cold(self, unknowns, ambient)?;
        let mut list = Vec::with_capacity(moments.len());
        for &moment in moments {
            if moment.is_nan() || moment < time {
                let must = "within its ramp, and not before the moment ahead of it";
                return Err(FlowError::Setting { name: "time_s", value: moment, must });
            }
            loop {
                // The next row that changes the power, if it comes before the moment.
                let same = left.iter().take_while(|row| row.power == power).count();
                let next: Option<&Logged> = left.get(same).filter(|row| row.time < moment);
                let end = next.map_or(moment, |row| row.time);
                while time < end {
                    let longest = step * (1.0 + (time - changed) / CALM).min(LONGEST);
                    let steps = ((end - time) / longest).ceil();
                    let implicit = self.implicit((end - time) / steps);
                    state.step(self, &implicit, unknowns, power, ambient, TIGHT)?;
                    time = if steps > 1.0 { time + implicit.dt() } else { end };
                }
                let Some(row) = next else { break };
                (power, changed, left) = (row.power, end, &left[same..]);
            }
            list.push(state.gas.clone());
        }
        Ok(list)
    }
}
