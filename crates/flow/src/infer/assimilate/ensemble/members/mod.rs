//! The filter's members: rows of an ensemble, run through the model some at a time.

#[cfg(test)]
mod tests;

use crate::error::FlowError;
use crate::infer::assimilate::record::{FlowRecord, observe};
use crate::infer::scores::unknowns_from;
use crate::number::Lanes;
use crate::tube::air::in_range;
use crate::tube::draught::Balanced;
use crate::tube::parameters::UNKNOWNS;
use crate::tube::pipe::Pipe;
use crate::tube::transient::{Implicit, Transient};
use rand_distr::{Distribution, StandardNormal};
use rijke_inference::Parameter;
use rijke_inference::ensemble::Ensemble;
use rijke_numerics::{Matrix, Stream};
use std::array::from_fn;
use std::sync::{Mutex, PoisonError};

/// Members that march side by side.
pub(super) const GROUP: usize = 8;

/// Tolerance of the mass flow in ln(buoyancy/losses): 4e-5 of U_h, 0.01 us in an arrival time.
const TOLERANCE: f64 = 1e-4;

/// Columns of the filter's state: scores, ambient temperature, released power, walls.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) scores: usize,
    pub(super) walls: usize,
}

impl Layout {
    pub(super) fn ambient(&self) -> usize {
        self.scores
    }
    pub(super) fn released(&self) -> usize {
        self.scores + 1
    }
    pub(super) fn wall(&self) -> usize {
        self.scores + 2
    }
    pub(super) fn columns(&self) -> usize {
        self.scores + 2 + self.walls
    }
}

/// What the members need beside their rows: the model, and the gas from which the next search for a mass flow
/// starts.
pub(super) struct Members<'a> {
    pipe: &'a Pipe,
    record: &'a FlowRecord,
    priors: &'a [Parameter; UNKNOWNS],
    layout: Layout,
    implicit: Implicit,
    groups: Vec<Mutex<Transient<Lanes<GROUP>>>>,
}

/// What one member says of a sample.
pub(super) struct Seen {
    /// One reading per sensor, then the ambient thermometer's.
    pub(super) readings: Vec<f64>,
    /// U_h, m/s.
    pub(super) velocity: f64,
}

impl<'a> Members<'a> {
    /// `count` draws from the prior, cold.
    pub(super) fn draw(
        pipe: &'a Pipe,
        record: &'a FlowRecord,
        priors: &'a [Parameter; UNKNOWNS],
        layout: Layout,
        count: usize,
        stream: &mut Stream,
    ) -> Result<(Ensemble, Self), FlowError> {
        let first = record.samples.first().map_or(f64::NAN, |s| s.ambient);
        let mut normal = || -> f64 { StandardNormal.sample(&mut *stream) };
        let mut rows = Matrix::zeros(count, layout.columns());
        let mut states = Vec::with_capacity(count);
        for i in 0..count {
            for j in 0..layout.scores {
                rows[(i, j)] = normal();
            }
            let u = unknowns_from(priors, &rows.row(i)[..UNKNOWNS])?;
            // The tube and the room start at the same temperature, known from one reading.
            let indicated = first + record.ambient_sd * normal();
            let state = Transient::cold(pipe, &u, indicated)?;
            rows[(i, layout.ambient())] = state.ambient;
            for k in 0..layout.walls {
                rows[(i, layout.wall() + k)] = state.ambient;
            }
            states.push(state);
        }
        let groups = states.chunks(GROUP).filter_map(Transient::gather).map(Mutex::new).collect();
        let implicit = pipe.implicit(record.interval);
        Ok((Ensemble::new(rows)?, Self { pipe, record, priors, layout, implicit, groups }))
    }

    /// One step of the members whose `rows` lie one after the other, the first of them member `first`: side
    /// by side if there are several, and one by one if that fails, to know which of them does.
    pub(super) fn step(&self, power: f64, first: usize, rows: &mut [f64]) -> Vec<Result<Seen, FlowError>> {
        let columns = self.layout.columns();
        let group = &mut *self.groups[first / GROUP].lock().unwrap_or_else(PoisonError::into_inner);
        let guess = group.gas.guess();
        if rows.len() > columns {
            match self.together(group, power, rows) {
                Ok(seen) => return seen.into_iter().map(Ok).collect(),
                Err(_) => group.gas.start_from(guess),
            }
        }
        let one = |(k, row): (usize, &mut [f64])| {
            let lane = first % GROUP + k;
            let mut state = group.lane(lane);
            let seen = self.alone(&mut state, power, row);
            group.set_lane(lane, &state);
            seen
        };
        rows.chunks_mut(columns).enumerate().map(one).collect()
    }

    fn alone(&self, state: &mut Transient<f64>, power: f64, row: &mut [f64]) -> Result<Seen, FlowError> {
        let (readings, velocity) = self.advance(state, power, |column| row[column])?;
        row[self.layout.wall()..].copy_from_slice(&state.wall);
        row[self.layout.released()] = state.released;
        Ok(Seen { readings, velocity })
    }

    fn together(
        &self,
        group: &mut Transient<Lanes<GROUP>>,
        power: f64,
        rows: &mut [f64],
    ) -> Result<Vec<Seen>, FlowError> {
        let columns = self.layout.columns();
        let count = rows.len() / columns;
        // Lanes beyond the last member repeat it.
        let column = |j: usize| Lanes(from_fn(|k| rows[k.min(count - 1) * columns + j]));
        let (readings, velocity) = self.advance(group, power, column)?;
        for (k, row) in rows.chunks_mut(columns).enumerate() {
            row[self.layout.wall()..].iter_mut().zip(&group.wall).for_each(|(r, w)| *r = w.0[k]);
            row[self.layout.released()] = group.released.0[k];
        }
        let seen =
            |k: usize| Seen { readings: readings.iter().map(|r| r.0[k]).collect(), velocity: velocity.0[k] };
        Ok((0..count).map(seen).collect())
    }

    /// Writes columns of the ensemble into the state, steps it, and observes it: readings, and U_h.
    fn advance<N: Balanced>(
        &self,
        state: &mut Transient<N>,
        power: f64,
        column: impl Fn(usize) -> N,
    ) -> Result<(Vec<N>, N), FlowError> {
        let (pipe, layout) = (self.pipe, &self.layout);
        let scores: Vec<N> = (0..UNKNOWNS).map(&column).collect();
        let u = unknowns_from(self.priors, &scores)?;
        state.wall.iter_mut().enumerate().for_each(|(k, w)| *w = column(layout.wall() + k));
        state.released = column(layout.released());
        state.ambient = column(layout.ambient());
        let indicated = state.ambient - u.ambient_offset;
        state.refresh(pipe, &u, TOLERANCE)?;
        state.step_each(pipe, &self.implicit, &u, power, indicated, TOLERANCE)?;
        // A step that is too long for a member sends its wall anywhere, and may still find a flow.
        state.wall.iter().try_for_each(|&t| in_range("a wall", t))?;
        state.gas.march.face.iter().try_for_each(|&t| in_range("the gas", t))?;
        let (mut times, mut seen) = (Vec::new(), Vec::new());
        observe(pipe, &self.record.sensors, &state.gas, &u, &mut times, &mut seen);
        for (k, (sensor, sd)) in self.record.biased().enumerate() {
            seen[sensor] = seen[sensor] + column(UNKNOWNS + k) * sd;
        }
        seen.push(indicated);
        Ok((seen, pipe.heater_velocity(&state.gas)))
    }
}
