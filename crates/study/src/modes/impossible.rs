//! Modes that cannot be as a row states them.

use crate::StudyProblem;
use crate::rig::Rig;
use rijke_numerics::C64;

/// Distance of the reference's pressure from 1 that rounding does not explain.
const OVER_ITSELF: f64 = 1e-3;

/// What loggers and tables write where nothing was measured, but for the sign.
const FILLERS: [f64; 3] = [999.0, 9999.0, 99999.0];

/// What is wrong with the growth rate (1/s), the frequency (Hz) and the pressures of a mode, by microphone,
/// if anything is.
pub(super) fn problem(
    [growth_rate, frequency_hz]: [Option<f64>; 2],
    pressures: &[(usize, C64)],
    rig: &Rig,
) -> Option<StudyProblem> {
    filler(growth_rate, pressures, rig)
        .or_else(|| outside(growth_rate, frequency_hz, rig))
        .or_else(|| over_another(pressures, rig))
}

/// What is wrong with a microphone that reads nothing in all rows of a table of two or more.
pub(super) fn silent<'a>(rows: impl Iterator<Item = &'a [(usize, C64)]>, rig: &Rig) -> Option<StudyProblem> {
    let mut rows_of = vec![[0, 0]; rig.microphones.names.len()];
    for (m, p) in rows.flatten() {
        rows_of[*m][usize::from(*p != C64::ZERO)] += 1;
    }
    let m = rows_of.iter().position(|[none, some]| *none > 1 && *some == 0)?;
    Some(StudyProblem::Value {
        key: format!("pressure of {}", rig.microphones.names[m]),
        value: "0 in every row".to_owned(),
        need: "what was measured: leave the cells of a dead microphone empty",
    })
}

/// What is wrong with a number that stands for none.
fn filler(growth_rate: Option<f64>, pressures: &[(usize, C64)], rig: &Rig) -> Option<StudyProblem> {
    let stands_for_none = |v: f64| FILLERS.iter().any(|filler| (v.abs() / filler - 1.0).abs() < 1e-12);
    let pressure = |(m, p): &(usize, C64)| {
        let part = [p.re, p.im, p.norm()].into_iter().find(|v| stands_for_none(*v))?;
        Some((format!("pressure of {}", rig.microphones.names[*m]), part))
    };
    let growth = growth_rate.filter(|g| *g < 0.0 && stands_for_none(*g));
    let growth = growth.map(|g| ("growth_rate".to_owned(), g));
    let (key, value) = growth.or_else(|| pressures.iter().find_map(pressure))?;
    let need = "what was measured: leave a cell empty where nothing was";
    Some(StudyProblem::Value { key, value: value.to_string(), need })
}

/// What is wrong with a pressure of the reference over itself that is not 1.
fn over_another(pressures: &[(usize, C64)], rig: &Rig) -> Option<StudyProblem> {
    let (names, reference) = (&rig.microphones.names, rig.microphones.reference);
    let (_, p) = pressures.iter().find(|(m, p)| *m == reference && (*p - 1.0).norm() > OVER_ITSELF)?;
    Some(StudyProblem::Value {
        key: format!("pressure of {}", names[reference]),
        value: format!("{:.4} {:+.4}i", p.re, p.im),
        need: "1, because it is the reference, over which all are given: name the microphone over which this table has them as `reference` \
             of [microphones] in rig.toml",
    })
}

/// What is wrong with a mode that lies outside of the stated search: a growth rate by more than its width,
/// for a strongly damped mode may be followed from within.
fn outside(growth_rate: Option<f64>, frequency_hz: Option<f64>, rig: &Rig) -> Option<StudyProblem> {
    let beyond = |k: usize, v: &f64| {
        let [low, high] = rig.search[k];
        let allowed = if k == 0 { high - low } else { 0.0 };
        rig.search_is_stated[k] && !(low - allowed..=high + allowed).contains(v)
    };
    if let Some(f) = frequency_hz.filter(|f| beyond(1, f)) {
        return Some(StudyProblem::Value {
            key: "frequency".to_owned(),
            value: format!("{f:.2} Hz"),
            need: "within frequency_hz of [search] in the rig's file; correct the \
             number or its unit, or widen the search",
        });
    }
    let growth = growth_rate.filter(|g| beyond(0, g))?;
    Some(StudyProblem::Value {
        key: "growth_rate".to_owned(),
        value: format!("{growth:.2} 1/s"),
        need: "within or near growth_rate of [search] in the rig's file; correct the \
         number, its sign or its unit, or widen the search",
    })
}
