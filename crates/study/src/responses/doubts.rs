//! What is wrong or doubtful about numbers over frequency.

use super::ObservedResponse;
use crate::StudyProblem;
use rijke_numerics::C64;
use rijke_numerics::slips::FLAME_GAINS;
use rijke_numerics::words::rounded;
use std::f64::consts::PI;

/// Rows of a file: frequency (Hz), value, standard deviation (NaN if there is none), line or row.
pub(super) struct Rows {
    pub(super) frequency_hz: Vec<f64>,
    pub(super) values: Vec<C64>,
    pub(super) sd: Vec<f64>,
    pub(super) lines: Vec<usize>,
    /// The unit in which phases were given; none where there are none, or where these values are quotients of
    /// them.
    pub(super) phases: Option<Angle>,
}

/// Units of phases.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Angle {
    Radians,
    Degrees,
}

impl Angle {
    /// Of a column whose numbers times `factor` are radians.
    pub(super) fn of(factor: f64) -> Self {
        if (factor - PI / 180.0).abs() < 1e-9 { Self::Degrees } else { Self::Radians }
    }
}

/// Neighbours that are the same number to the last bit are one number written several times from this count
/// on.
const REPEATED: usize = 3;
/// A passive load is taken for one up to this |R|: noise makes it 1 and a little.
const PASSIVE: f64 = 1.02;
/// A phase that rises so far, rad, is no wiggle.
const RISES: f64 = 1.0;

/// Refuses frequencies that are none, that stand twice or that do not ascend: the line, and what is wrong.
pub(super) fn refuse(rows: &Rows) -> Result<(), (usize, StudyProblem)> {
    let line = |k: usize| rows.lines.get(k).copied().unwrap_or(0);
    let value = |k: usize, need| {
        let (key, value) = ("f".to_owned(), format!("{} Hz", rows.frequency_hz[k]));
        Err((line(k), StudyProblem::Value { key, value, need }))
    };
    if let Some((k, sd)) = rows.sd.iter().enumerate().find(|(_, sd)| **sd <= 0.0) {
        let need = "above zero, or left out: write `-` for the column in `columns` if no standard deviation was measured";
        return Err((line(k), StudyProblem::Value { key: "sd".into(), value: sd.to_string(), need }));
    }
    if let Some(k) = rows.frequency_hz.iter().position(|f| *f <= 0.0) {
        return value(k, "above zero");
    }
    for (k, pair) in rows.frequency_hz.windows(2).enumerate() {
        if pair[0] == pair[1] {
            return value(
                k + 1,
                "given once; the line before has the same frequency: leave one out, or average them",
            );
        }
        if pair[0] > pair[1] {
            return value(k + 1, "above that of the line before; sort the rows by frequency");
        }
    }
    Ok(())
}

/// Leaves out what repeats one value, and says so.
pub(super) fn without_repeats(rows: &mut Rows) -> Option<String> {
    let mut left_out = Vec::new();
    let mut k = 0;
    while k < rows.values.len() {
        let same = rows.values[k..].iter().take_while(|v| **v == rows.values[k]).count();
        if same >= REPEATED {
            left_out.push(k..k + same);
        }
        k += same;
    }
    let first = left_out.first()?.clone();
    let all: usize = left_out.iter().map(ExactSizeIterator::len).sum();
    let line = |k: usize| rows.lines.get(k).copied().unwrap_or(0);
    let said = format!(
        "{all} rows repeat the value of their neighbours (lines {} to {} first) and were left out: they are no data",
        line(first.start),
        line(first.end - 1)
    );
    let keep = |k: usize| !left_out.iter().any(|range| range.contains(&k));
    let kept: Vec<usize> = (0..rows.values.len()).filter(|k| keep(*k)).collect();
    rows.frequency_hz = kept.iter().map(|&k| rows.frequency_hz[k]).collect();
    rows.values = kept.iter().map(|&k| rows.values[k]).collect();
    rows.lines = kept.iter().filter_map(|&k| rows.lines.get(k).copied()).collect();
    if !rows.sd.is_empty() {
        rows.sd = kept.iter().map(|&k| rows.sd[k]).collect();
    }
    Some(said)
}

/// Whether the band leaves less than half of a file.
pub(super) fn band(rows: &Rows, kept: usize, [low, high]: [f64; 2]) -> Option<String> {
    let (all, f) = (rows.frequency_hz.len(), &rows.frequency_hz);
    (2 * kept < all).then(|| {
        format!(
            "`band_hz` from {low} to {high} Hz leaves {kept} of {all} frequencies, which run from {} to {} Hz: if they are angular, write \
             f [rad/s] in `columns`; else correct `band_hz` if more are meant",
            f[0],
            f[all - 1]
        )
    })
}

/// The first frequency at which two responses of one operating point hold the same number of the rig.
pub(super) fn twice(before: &ObservedResponse, now: &ObservedResponse) -> Option<f64> {
    if before.point != now.point || !before.what.is_same(&now.what) {
        return None;
    }
    let known = before.frequency_hz.iter().zip(&before.values);
    let here = |(f, z): &(&f64, &C64)| {
        now.frequency_hz.iter().zip(&now.values).any(|(other, value)| other == *f && value == *z)
    };
    known.into_iter().find(here).map(|(f, _)| *f)
}

/// Whether phases in radians may be degrees, for neighbours then lie turns apart, or phases in degrees
/// radians: none is then beyond pi, and some are near it.
pub(super) fn phase(rows: &Rows) -> Option<String> {
    let unit = rows.phases?;
    if rows.values.len() < 4 {
        return None;
    }
    if unit == Angle::Degrees {
        let widest = rows.values.iter().map(|z| z.arg().abs().to_degrees()).fold(0.0, f64::max);
        return (0.8 * PI..=PI).contains(&widest).then(|| {
            format!("no phase is beyond {widest:.2} deg: if they are radians, write arg [rad] in `columns`")
        });
    }
    let step = |pair: &[C64]| (pair[1] * pair[0].conj()).arg().abs();
    let mut steps: Vec<f64> = rows.values.windows(2).map(step).collect();
    steps.sort_by(f64::total_cmp);
    let middle = steps[steps.len() / 2];
    (middle > 0.4 * PI).then(|| {
        format!(
            "the phase differs by {middle:.1} rad between neighbouring frequencies, half of them by more: if it is in degrees, write \
             arg [deg] in `columns`"
        )
    })
}

/// Whether all frequencies lie far below those in which modes are sought, or most far above.
pub(super) fn far(frequency_hz: &[f64], [low, high]: [f64; 2]) -> Option<String> {
    let (first, last) = (*frequency_hz.first()?, *frequency_hz.last()?);
    if frequency_hz.iter().filter(|f| **f > high).count() * 4 > 3 * frequency_hz.len() {
        return Some(format!(
            "most of its frequencies, which run from {first} to {last} Hz, lie above those in which modes are sought, {low} to {high} Hz (`[search]` of \
             rig.toml): if these are angular, write f [rad/s] in `columns`"
        ));
    }
    (last < 0.05 * low).then(|| {
        format!(
            "its frequencies run from {first} to {last} Hz, but modes are sought from {low} to {high} Hz (`[search]` of rig.toml): if these are in kHz, \
             write f [kHz] in `columns`"
        )
    })
}

/// What is said of gains of a flame that are far from 1, as in per cent: of half of them above
/// [`FLAME_GAINS`], or of all below.
pub(super) fn gains(rows: &Rows) -> Option<String> {
    let mut gains: Vec<f64> = rows.values.iter().map(|z| z.norm()).collect();
    gains.sort_by(f64::total_cmp);
    let (least, most) = (*gains.first()?, *gains.last()?);
    let [small, large] = FLAME_GAINS;
    let remedy = match (gains[gains.len() / 2] > large, most < small) {
        (true, _) => {
            "if they are per cent, write abs [%] in `columns`, or divide both parts by 100; if they are another quantity, give its `factor`"
        }
        (_, true) => "check their unit and normalisation, and give the `factor` that they need",
        _ => return None,
    };
    Some(format!(
        "its gains are {} to {}, and a flame answers with about 1: {remedy}",
        rounded(least),
        rounded(most)
    ))
}

/// Whether the phase rises with frequency on the whole, as if what answers did so before it is asked.
pub(super) fn early(rows: &Rows) -> Option<String> {
    let steps = || rows.values.windows(2).map(|pair| pair[1] * pair[0].conj());
    let (sum, sizes) = (steps().sum::<C64>(), steps().map(|z| z.norm()).sum::<f64>());
    let (step, n) = (sum.arg(), rows.values.len().saturating_sub(1) as f64);
    // Steps of any size tell no direction; those of a quarter turn and more may be another turn.
    let told = sum.norm() > 0.5 * sizes;
    if told && step.abs() >= 0.5 * PI && n > 1.0 {
        let width = (rows.frequency_hz[rows.values.len() - 1] - rows.frequency_hz[0]) / n;
        return Some(format!(
            "the phase {} by {:.1} rad from frequency to frequency: such steps cannot distinguish a delay from one that is {:.2} ms longer or shorter, \
             nor the convention exp(i omega t), which is assumed, from exp(-i omega t); give finer frequencies, or a narrower prior of the delay",
            if step > 0.0 { "rises" } else { "falls" },
            step.abs(),
            1e3 / width
        ));
    }
    (told && step * n > RISES).then(|| {
        format!(
            "the phase rises by {:.1} rad from {} to {} Hz, but a delay lowers it: rijke takes numbers that vary as exp(i omega t); if these \
             are for exp(-i omega t), turn the signs of the phases or of the imaginary parts",
            step * n,
            rows.frequency_hz[0],
            rows.frequency_hz[rows.values.len() - 1]
        )
    })
}

/// Whether a passive load reflects more than it gets.
pub(super) fn passive(rows: &Rows, reflection: &[C64]) -> Option<String> {
    let over: Vec<usize> = (0..reflection.len()).filter(|&k| reflection[k].norm() > PASSIVE).collect();
    let worst = *over.iter().max_by(|a, b| reflection[**a].norm().total_cmp(&reflection[**b].norm()))?;
    Some(format!(
        "|R| is above 1 at {} of {} frequencies, {:.3} at {} Hz (line {}), but a passive load has at most 1: check sign, reference and \
         calibration, or limit the band",
        over.len(),
        reflection.len(),
        reflection[worst].norm(),
        rows.frequency_hz[worst],
        rows.lines.get(worst).copied().unwrap_or(0)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_gains_of_a_flame_far_from_one_are_said() {
        let of = |factor: f64| {
            let values = [0.6, 0.93, 1.4].map(|gain| C64::from(factor * gain)).to_vec();
            gains(&Rows {
                frequency_hz: vec![50.0, 60.0, 70.0],
                values,
                sd: Vec::new(),
                lines: Vec::new(),
                phases: None,
            })
        };
        assert_eq!(of(1.0), None);
        let said = of(100.0).unwrap();
        assert!(said.contains("gains are 60.0 to 140") && said.contains("per cent"), "{said}");
        assert!(of(1e-3).unwrap().contains("normalisation"));
    }
}
