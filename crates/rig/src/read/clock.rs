//! A column of time, compared with the sampling rate.

use crate::problem::Problem;
use crate::units::Unit;

/// A column of time, compared with the sampling rate as it passes.
pub(crate) struct Clock {
    unit: Unit,
    rate_hz: f64,
    first: f64,
    last: f64,
    count: usize,
}

/// Relative error of the sampling rate that a column of time may show, beside its rounding by half a sample.
const RATE: f64 = 1e-5;

impl Clock {
    pub(crate) fn new(unit: Unit, rate_hz: f64) -> Self {
        Self { unit, rate_hz, first: 0.0, last: 0.0, count: 0 }
    }

    /// The next time.
    ///
    /// # Errors
    /// It is not one sample later than the last, to half a sample.
    pub(crate) fn see(&mut self, time: f64) -> Result<(), Problem> {
        let time = self.unit.to_si(time);
        let step = (time - self.last) * self.rate_hz;
        let late = (step - 1.0).abs();
        if self.count > 0 && (late > 0.5 || late.is_nan()) {
            return Err(Problem::TimeJumps {
                sample: self.count,
                step: time - self.last,
                need: 1.0 / self.rate_hz,
            });
        }
        if self.count == 0 {
            self.first = time;
        }
        (self.last, self.count) = (time, self.count + 1);
        Ok(())
    }

    /// Compares the whole with the sampling rate.
    ///
    /// # Errors
    /// Another rate.
    pub(crate) fn end(&self) -> Result<(), Problem> {
        let steps = self.count.saturating_sub(1) as f64;
        let off = ((self.last - self.first) * self.rate_hz - steps).abs();
        match off <= 0.5 + RATE * steps {
            true => Ok(()),
            false => Err(Problem::WrongRate { have: steps / (self.last - self.first), need: self.rate_hz }),
        }
    }
}
