//! Rows of a table of gain and phase over frequency, and what is doubtful about them.

use std::f64::consts::PI;

/// The largest tolerance of a table, of its largest gain: a fit farther off says nothing of the table.
pub(super) const COARSE: f64 = 0.5;

/// A mean delay that no flame has, s; in degrees one of a millisecond looks like it.
const LATE: f64 = 0.05;

/// A phase that rises so far over a table, rad, is no wiggle.
const RISES: f64 = 1.0;

/// The same where all gains exceed this: the phase of what reflects nearly all falls as by the mass that it
/// moves, less than a radian.
const RISES_OF_NEARLY_ALL: (f64, f64) = (0.7, 0.2);

/// Gains of a flame that fall by less than this part of them show no dip, beyond which a phase may rise.
const NO_DIP: f64 = 0.5;
/// Standard deviations beyond which a phase rises by no accident.
const CLEARLY: f64 = 4.0;

/// A row of a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableRow {
    /// Hz.
    pub frequency: f64,
    /// Modulus.
    pub gain: f64,
    /// rad; e^{-i omega tau} has the phase -omega tau.
    pub phase: f64,
}

impl From<[f64; 3]> for TableRow {
    fn from([frequency, gain, phase]: [f64; 3]) -> Self {
        Self { frequency, gain, phase }
    }
}

/// What is possible in a table, but most often a mistake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// Phases seem to be in degrees: half of the steps between neighbours are larger than this, rad.
    Degrees {
        /// The median of the steps, rad.
        step: f64,
    },
    /// Neighbours are so far apart that a delay cannot be told from one of another turn for each step.
    Coarse {
        /// The median of the steps of the phase, to the nearest turn, rad.
        step: f64,
        /// Delay by which another reading of the phases differs, s.
        other: f64,
    },
    /// The phase rises: the answer comes before the question.
    Rises {
        /// By how much over the table, rad.
        rise: f64,
    },
}

/// What is doubtful about the table of a flame. Where the gain falls, and has no dip, the phase falls too: by
/// Bode's relation of gain and phase, and by any delay.
#[must_use]
pub fn doubt_of_flame(rows: &[TableRow]) -> Option<Doubt> {
    let usual = doubt(rows);
    let [least, most] =
        rows.iter().fold([f64::INFINITY, 0.0], |[a, b], e| [a.min(e.gain), f64::max(b, e.gain)]);
    if usual.is_some() || rows.len() < 4 || least < NO_DIP * most {
        return usual;
    }
    let hertz: Vec<f64> = rows.iter().map(|e| e.frequency).collect();
    let [gain, _] = line(&hertz, &rows.iter().map(|e| e.gain).collect::<Vec<_>>());
    let [phase, sd] = line(&hertz, &unwrapped(rows));
    let rise = phase * (hertz[rows.len() - 1] - hertz[0]);
    (gain < 0.0 && phase > CLEARLY * sd && rise > RISES_OF_NEARLY_ALL.1).then_some(Doubt::Rises { rise })
}

/// The slope of the straight line through points by least squares, and its standard deviation.
fn line(x: &[f64], y: &[f64]) -> [f64; 2] {
    let n = x.len() as f64;
    let [mean, level] = [x, y].map(|all| all.iter().sum::<f64>() / n);
    let spread: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
    let slope = x.iter().zip(y).map(|(x, y)| (x - mean) * (y - level)).sum::<f64>() / spread;
    let left: f64 = x.iter().zip(y).map(|(x, y)| (y - level - slope * (x - mean)).powi(2)).sum();
    [slope, (left / (n - 2.0) / spread).sqrt()]
}

/// What is doubtful about the table of a flame or an end.
#[must_use]
pub fn doubt(rows: &[TableRow]) -> Option<Doubt> {
    let (first, last) = (rows.first()?, rows.last()?);
    let mut steps: Vec<f64> = rows.windows(2).map(|w| (w[1].phase - w[0].phase).abs()).collect();
    steps.sort_by(f64::total_cmp);
    if let Some(step) = steps.get(steps.len() / 2).copied().filter(|step| *step > PI) {
        return Some(Doubt::Degrees { step });
    }
    let rise = phase_slope(rows) * 2.0 * PI * (last.frequency - first.frequency);
    let (much, least) = RISES_OF_NEARLY_ALL;
    let limit = if rows.iter().all(|e| e.gain > much) { least } else { RISES };
    if rise > limit {
        return Some(Doubt::Rises { rise });
    }
    let nearest = |w: &[TableRow]| {
        let turn = (w[1].phase - w[0].phase) / (2.0 * PI);
        2.0 * PI * (turn - turn.round()).abs()
    };
    let mut steps: Vec<f64> = rows.windows(2).map(nearest).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().filter(|step| *step > 0.5 * PI)?;
    let width = (last.frequency - first.frequency) / (rows.len() - 1) as f64;
    Some(Doubt::Coarse { step, other: 1.0 / width })
}

/// The mean delay of the table of a flame, s, if its phase falls by more than a turn and as by a delay that
/// no flame has: then it seems to be in degrees. A long duct beyond an end has such delays.
#[must_use]
pub fn too_late(rows: &[TableRow]) -> Option<f64> {
    let (first, last) = (rows.first()?, rows.last()?);
    let fall = first.phase - last.phase;
    let delay = fall / (2.0 * PI * (last.frequency - first.frequency));
    (delay > LATE && fall > 2.0 * PI).then_some(delay)
}

/// The slope of the unwrapped phase in the angular frequency, by least squares weighted with the gain, s:
/// minus the mean delay; 0 where the rows have none.
#[must_use]
pub fn phase_slope(rows: &[TableRow]) -> f64 {
    let omega: Vec<f64> = rows.iter().map(|e| 2.0 * PI * e.frequency).collect();
    let unwrapped = unwrapped(rows);
    let total: f64 = rows.iter().map(|e| e.gain).sum();
    let mean = |values: &[f64]| values.iter().zip(rows).map(|(v, e)| v * e.gain).sum::<f64>() / total;
    let (w, p) = (mean(&omega), mean(&unwrapped));
    let of = |f: fn(f64, f64) -> f64| -> f64 {
        (0..rows.len()).map(|k| rows[k].gain * f(omega[k] - w, unwrapped[k] - p)).sum()
    };
    let slope = of(|w, p| w * p) / of(|w, _| w * w);
    if slope.is_finite() { slope } else { 0.0 }
}

/// The phases, each within half a turn of the one before.
fn unwrapped(rows: &[TableRow]) -> Vec<f64> {
    let mut all: Vec<f64> = rows.iter().take(1).map(|e| e.phase).collect();
    for pair in rows.windows(2) {
        let turn = (pair[1].phase - pair[0].phase) / (2.0 * PI);
        let before = all[all.len() - 1];
        all.push(before + 2.0 * PI * (turn - turn.round()));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behaviour_phases_that_rise_or_turn_fast_are_doubted() {
        let of = |delay: f64| -> Vec<TableRow> {
            let row = |k: i32| {
                let frequency = 50.0 * f64::from(k);
                let phase = -2.0 * PI * frequency * delay;
                TableRow { frequency, gain: 1.0, phase: phase - 2.0 * PI * (phase / (2.0 * PI)).round() }
            };
            (1..10).map(row).collect()
        };
        assert_eq!(doubt(&of(3e-3)), None);
        // The end correction of a tube of 25 mm of radius, for exp(+i omega t) and for the other sign.
        let mouth = |sign: f64| -> Vec<TableRow> {
            let row = |k: i32| {
                let frequency = 50.0 * f64::from(k);
                let phase = PI - sign * 4.0 * PI * frequency * 0.015 / 343.0;
                TableRow { frequency, gain: 0.95, phase }
            };
            (1..15).map(row).collect()
        };
        assert_eq!(doubt(&mouth(1.0)), None);
        assert!(matches!(doubt(&mouth(-1.0)), Some(Doubt::Rises { rise }) if (rise - 0.36).abs() < 0.01));
        assert!(matches!(doubt(&of(-3e-3)), Some(Doubt::Rises { .. })));
        // 7 ms turn the phase by 2.2 rad for each step; numbers for exp(-i omega t) would tell 13 ms.
        let Some(Doubt::Coarse { step, other }) = doubt(&of(7e-3)) else { panic!() };
        assert!((step - 0.7 * PI).abs() < 1e-9 && (other - 0.02).abs() < 1e-12, "{step} {other}");
        let Some(Doubt::Coarse { .. }) = doubt(&of(-13e-3)) else { panic!() };
    }

    /// A low-pass of 500 Hz behind 0.2 ms, for exp(+i omega t) and for the other sign; and what a gain with a
    /// dip does near it.
    #[test]
    fn behaviour_a_phase_that_rises_with_a_falling_gain_is_doubted() {
        let of = |sign: f64, scatter: f64| -> Vec<TableRow> {
            let row = |k: i32| {
                let frequency = 20.0 * f64::from(k);
                let (gain, delay) = (0.8 / (frequency / 500.0).hypot(1.0), 2.0 * PI * frequency * 2e-4);
                let noise = scatter * (7.0 * f64::from(k)).sin();
                TableRow { frequency, gain, phase: -sign * ((frequency / 500.0).atan() + delay) + noise }
            };
            (1..=14).map(row).collect()
        };
        assert_eq!(doubt(&of(-1.0, 0.02)), None);
        assert!(matches!(doubt_of_flame(&of(-1.0, 0.02)), Some(Doubt::Rises { rise }) if rise > 0.7));
        assert_eq!(doubt_of_flame(&of(1.0, 0.02)), None);
        // A rise that noise makes.
        assert_eq!(doubt_of_flame(&of(-1.0, 3.0)).filter(|d| matches!(d, Doubt::Rises { .. })), None);
        let rising: Vec<TableRow> =
            of(-1.0, 0.0).iter().map(|e| TableRow { gain: 1.0 - e.gain, ..*e }).collect();
        assert_eq!(doubt_of_flame(&rising), None);
    }

    #[test]
    fn behaviour_phases_in_degrees_fall_as_by_a_delay_that_no_flame_has() {
        let of = |delay: f64, turn: f64| -> Vec<TableRow> {
            let row = |k: i32| {
                let frequency = 100.0 + f64::from(k);
                TableRow { frequency, gain: 1.0, phase: -turn * frequency * delay }
            };
            (0..60).map(row).collect()
        };
        // Steps of a degree or two are no steps between degrees.
        assert_eq!(doubt(&of(3e-3, 360.0)), None);
        let late = too_late(&of(3e-3, 360.0)).unwrap();
        assert!((late - 3e-3 * 180.0 / PI).abs() < 1e-12, "{late}");
        assert_eq!(too_late(&of(3e-3, 2.0 * PI)), None);
        assert_eq!(too_late(&of(-3e-3, 360.0)), None);
    }

    #[test]
    fn exact_the_mean_delay_of_a_pure_delay_is_that_delay() {
        // Unequal steps and gains; the phase is kept within one turn.
        let delay = 3e-3;
        let row = |(frequency, gain): (f64, f64)| {
            let phase = -2.0 * PI * frequency * delay + 0.4;
            TableRow { frequency, gain, phase: phase - 2.0 * PI * (phase / (2.0 * PI)).round() }
        };
        let rows = [(20.0, 1.2), (110.0, 0.4), (150.0, 2.0), (290.0, 0.7), (430.0, 0.1)].map(row);
        assert!((phase_slope(&rows) / -delay - 1.0).abs() < 1e-12, "{}", phase_slope(&rows));
    }
}
