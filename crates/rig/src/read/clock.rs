//! A column of time, compared with the sampling rate.

use crate::column_fault::ColumnFault;
use crate::problem::Problem;
use crate::units::Unit;

/// A column of time, compared with the sampling rate as it passes.
pub(crate) struct Clock {
    unit: Unit,
    rate_hz: f64,
    first: f64,
    last: f64,
    count: usize,
    /// Midnights that have passed: a time of day then begins anew.
    midnights: u32,
}

/// A day, s.
const DAY: f64 = 86_400.0;

/// Relative error of the sampling rate that a column of time may show, beside its rounding by half a sample.
const RATE: f64 = 1e-5;

/// Units that are taken for seconds where the heading states none: parts of a second, name, symbol.
const UNITS: [(f64, &str, &str); 2] = [(1e3, "milliseconds", "ms"), (1e6, "microseconds", "us")];

impl Clock {
    pub(crate) fn new(unit: Unit, rate_hz: f64) -> Self {
        Self { unit, rate_hz, first: 0.0, last: 0.0, count: 0, midnights: 0 }
    }

    /// The next time.
    ///
    /// # Errors
    /// It is not one sample later than the last, to half a sample.
    pub(crate) fn see(&mut self, time: f64) -> Result<(), Problem> {
        let of_day = self.unit.to_si(time);
        let mut time = of_day + DAY * f64::from(self.midnights);
        let step = |time: f64| (time - self.last) * self.rate_hz;
        // A whole day back, to half a sample: no lost sample and no wrong rate does this.
        if self.count > 0 && time < self.last && (step(time + DAY) - 1.0).abs() <= 0.5 {
            self.midnights += 1;
            time += DAY;
        }
        let step = step(time);
        let late = (step - 1.0).abs();
        if self.count > 0 && (late > 0.5 || late.is_nan()) {
            let look = |(times, _, _): &(f64, _, _)| (step / times - 1.0).abs() < 0.5;
            if let Some((_, unit, symbol)) = UNITS.into_iter().find(look) {
                let (step, need) = (time - self.last, 1.0 / self.rate_hz);
                return Err(ColumnFault::TimeUnit { sample: self.count, step, need, unit, symbol }.into());
            }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_time_of_day_begins_anew_at_midnight() {
        let seen = |times: &[f64]| {
            let mut clock = Clock::new(Unit::parse("s").unwrap(), 1e4);
            times.iter().try_for_each(|t| clock.see(*t)).and_then(|()| clock.end())
        };
        seen(&[86_399.999_8, 86_399.999_9, 0.0, 1e-4, 2e-4]).unwrap();
        // Two samples are missing there, and a time that goes back is none of a day.
        let jumps = |times: &[f64]| matches!(seen(times), Err(Problem::TimeJumps { sample: 2, .. }));
        assert!(jumps(&[86_399.999_8, 86_399.999_9, 2e-4]) && jumps(&[9.9998, 9.9999, 0.0]));
    }

    #[test]
    fn message_times_in_milliseconds_are_named() {
        let mut clock = Clock::new(Unit::parse("s").unwrap(), 1e4);
        clock.see(0.0).unwrap();
        let said = clock.see(0.1).unwrap_err().to_string();
        assert!(said.contains("look like milliseconds") && said.contains("`t [ms]`"), "{said}");
        // Five samples are missing.
        let said = clock.see(6e-4).unwrap_err().to_string();
        assert!(said.contains("samples are missing"), "{said}");
    }
}
