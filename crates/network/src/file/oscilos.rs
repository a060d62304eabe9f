//! The text inputs of OSCILOS_lite, as they are: Geometry, Mean_flow, Flame, Inlet, Outlet, Scan_range.
//!
//! Sections, interfaces, mean flow and closures are those of [`crate::flow_chain`]. Where OSCILOS uses fits,
//! the exact law is used: boundary 11 is Levine and Schwinger's integral, 12 Rayleigh's piston in a baffle.
//! Entropy waves are left out, as in that program's own remarks (no indirect noise).

use crate::flow_chain::{ActionKind, FlowChain, FlowDuct, FlowEnd, FlowState};
use crate::laws::Law;
use crate::plane::region::Region;
use rijke_numerics::C64;
use std::f64::consts::PI;

/// The texts of a folder.
#[derive(Clone, Debug, Default)]
pub struct OscilosTexts {
    /// Geometry.txt.
    pub geometry: String,
    /// Mean_flow.txt.
    pub mean_flow: String,
    /// Flame.txt, needed only with a fluctuating heat source (section index 11).
    pub flame: Option<String>,
    /// Inlet.txt.
    pub inlet: String,
    /// Outlet.txt.
    pub outlet: String,
    /// Scan_range.txt.
    pub scan_range: String,
}

/// What is wrong with such a folder.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OscilosError {
    /// A line does not hold the numbers it should.
    #[error("{file}, line {line}: {expected} numbers are needed, found `{found}`")]
    Numbers {
        /// The file.
        file: &'static str,
        /// The line, from 1.
        line: usize,
        /// How many numbers.
        expected: usize,
        /// What is there.
        found: String,
    },
    /// Numbers where the title stands.
    #[error(
        "{file}: the first line, `{found}`, holds numbers, where OSCILOS_lite passes over a title: put a title above it"
    )]
    NoTitle {
        /// The file.
        file: &'static str,
        /// The line.
        found: String,
    },
    /// More than one flame.
    #[error(
        "Geometry.txt, row {row}: a second section has index 11, and there is one fluctuating heat source; write 10 for steady heat"
    )]
    Flames {
        /// The row, from 1.
        row: usize,
    },
    /// A kind of boundary, flame, interface or gas that is not read.
    #[error("{file}: {what} {value} is not supported; supported are {known}")]
    Unsupported {
        /// The file.
        file: &'static str,
        /// What it is.
        what: &'static str,
        /// Its number.
        value: f64,
        /// The numbers that are read.
        known: &'static str,
    },
    /// A number that nothing has.
    #[error("{file}: {what} is {value}; it must be {must}")]
    Value {
        /// The file.
        file: &'static str,
        /// What it is.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        must: &'static str,
    },
    /// Positions do not increase, or there are fewer than two.
    #[error("Geometry.txt: positions must increase and there must be at least two; see row {row}")]
    Positions {
        /// The row, from 1.
        row: usize,
    },
    /// There is a fluctuating heat source but no flame.
    #[error("Geometry.txt has a fluctuating heat source (section index 11) but there is no Flame.txt")]
    NoFlame,
    /// The chain is refused.
    #[error(transparent)]
    Network(#[from] crate::error::NetworkError),
}

/// The rows of numbers below the title; `-` is read as absent (0).
pub(super) fn rows(file: &'static str, text: &str, columns: usize) -> Result<Vec<Vec<f64>>, OscilosError> {
    let mut out = Vec::new();
    let number = |word: &str| if word == "-" { Some(0.0) } else { word.parse::<f64>().ok() };
    if let Some(title) = text.lines().next()
        && title.split_whitespace().count() >= columns
        && title.split_whitespace().all(|word| number(word).is_some())
    {
        return Err(OscilosError::NoTitle { file, found: title.trim().to_owned() });
    }
    for (index, line) in text.lines().enumerate().skip(1) {
        if line.trim().is_empty() {
            continue;
        }
        let numbers: Option<Vec<f64>> = line.split_whitespace().map(number).collect();
        match numbers {
            Some(numbers) if numbers.len() >= columns => out.push(numbers),
            _ => {
                let found = line.trim().to_owned();
                return Err(OscilosError::Numbers { file, line: index + 1, expected: columns, found });
            }
        }
    }
    if out.is_empty() {
        return Err(OscilosError::Numbers { file, line: 2, expected: columns, found: String::new() });
    }
    Ok(out)
}

/// Ratio of specific heats.
const GAMMA: f64 = 1.4;

/// A flow chain and the region to search, from the texts of a folder.
///
/// # Errors
/// [`OscilosError`], naming the file.
pub fn read_oscilos(texts: &OscilosTexts) -> Result<(FlowChain, Region), OscilosError> {
    let (inlet, sound_speed, ratio) = mean_flow(&texts.mean_flow)?;
    let flame = match &texts.flame {
        Some(text) => Some(rows("Flame.txt", text, 3)?.swap_remove(0)),
        None => None,
    };
    let geometry = rows("Geometry.txt", &texts.geometry, 4)?;
    let ducts = ducts(&geometry, ratio, flame.as_deref())?;
    let radii = [geometry[0][1], geometry[geometry.len() - 1][1]];
    let upstream = FlowEnd::Reflection(boundary("Inlet.txt", &texts.inlet, radii[0], sound_speed)?);
    let chain = FlowChain::new(GAMMA, inlet, ducts, [upstream.clone(), upstream.clone()])?;
    let outlet_speed = chain.states()[chain.states().len() - 1].sound_speed(GAMMA);
    let downstream = FlowEnd::Reflection(boundary("Outlet.txt", &texts.outlet, radii[1], outlet_speed)?);
    let chain = chain.with_ends([upstream, downstream]).without_entropy_waves();
    let scan = &rows("Scan_range.txt", &texts.scan_range, 6)?[0];
    // Laws of s have a branch point at s = 0: the search starts at 1 Hz at least.
    let omega = [scan[0].max(1.0), scan[1]].map(|f| 2.0 * PI * f);
    Ok((chain, Region { sigma: [scan[3], scan[4]], omega }))
}

/// The state at the inlet with its speed of sound, and the ratio of temperatures behind and before what
/// heats.
fn mean_flow(text: &str) -> Result<(FlowState, f64, f64), OscilosError> {
    const FLOW: &str = "Mean_flow.txt";
    /// Gas constant of air as that program has it, J/(kg K).
    const AIR: f64 = 8.3145 / 28.965_12 * 1000.0;
    let flow = &rows(FLOW, text, 6)?[0];
    let [pressure, temperature, choice, speed, gamma_choice, ratio] =
        [flow[0], flow[1], flow[2], flow[3], flow[4], flow[5]];
    let unsupported = |what, value, known| OscilosError::Unsupported { file: FLOW, what, value, known };
    if gamma_choice != 1.0 {
        return Err(unsupported("Choice_gamma", gamma_choice, "1 (constant)"));
    }
    within(FLOW, "the pressure (Pa)", pressure, [1e2, 1e9], "100 to 1e9 Pa")?;
    within(FLOW, "the temperature (K)", temperature, [100.0, 4000.0], "100 to 4000 K")?;
    within(FLOW, "the Mach number or velocity", speed, [0.0, 1e4], "0 or more")?;
    within(FLOW, "the ratio of temperatures", ratio, [0.1, 20.0], "0.1 to 20")?;
    let sound_speed = (GAMMA * AIR * temperature).sqrt();
    // Both ways that program raises a vanishing flow to a Mach number of 1e-6.
    let velocity = match choice {
        1.0 => speed.max(1e-6) * sound_speed,
        2.0 => speed.max(1e-6 * sound_speed),
        value => return Err(unsupported("choice_M1_u1", value, "1 (Mach number) and 2 (velocity)")),
    };
    let inlet = FlowState { pressure, density: pressure / (AIR * temperature), velocity };
    Ok((inlet, sound_speed, ratio))
}

/// The ducts between the rows of `Geometry.txt`; `ratio` is that of temperatures, and `flame` the row of
/// `Flame.txt`.
fn ducts(geometry: &[Vec<f64>], ratio: f64, flame: Option<&[f64]>) -> Result<Vec<FlowDuct>, OscilosError> {
    const FILE: &str = "Geometry.txt";
    if geometry.len() < 2 {
        return Err(OscilosError::Positions { row: geometry.len() });
    }
    let mut ducts: Vec<FlowDuct> = Vec::new();
    for (row, pair) in geometry.windows(2).enumerate() {
        let ([x, r, section, tube], [x_end, r_end]) =
            ([pair[0][0], pair[0][1], pair[0][2], pair[0][3]], [pair[1][0], pair[1][1]]);
        if x_end <= x {
            return Err(OscilosError::Positions { row: row + 2 });
        }
        if let Some(&value) = [r, r_end].iter().find(|r| !(**r > 0.0 && r.is_finite())) {
            let (what, known) = ("radius", "positive radii");
            return Err(OscilosError::Unsupported { file: FILE, what, value, known });
        }
        let (heat, law) = match section {
            0.0 => (1.0, None),
            _ if row == 0 => (1.0, None),
            10.0 => (ratio, None),
            11.0 if ducts.iter().any(|duct| !duct.actions.is_empty()) => {
                return Err(OscilosError::Flames { row: row + 1 });
            }
            11.0 => (ratio, Some(flame_law(flame.ok_or(OscilosError::NoFlame)?)?)),
            value => {
                let (what, known) = ("SectionIndex", "0, 10 and 11");
                return Err(OscilosError::Unsupported { file: FILE, what, value, known });
            }
        };
        // A gradual change is a staircase of 49 steps, each with the radius at its upstream end.
        let pieces = if tube >= 1.0 { 49 } else { 1 };
        for k in 0..pieces {
            let radius = r + (r_end - r) * f64::from(k) / 49.0;
            let mut duct = FlowDuct::new((x_end - x) / f64::from(pieces), PI * radius * radius);
            if k == 0 {
                duct = duct.heated(heat);
                if let Some(law) = &law {
                    duct = duct.with(ActionKind::Flame, law.clone());
                }
            }
            ducts.push(duct);
        }
    }
    Ok(ducts)
}

/// Q'/Q = n e^{-s tau} u'/U.
fn flame_law(row: &[f64]) -> Result<Law, OscilosError> {
    const FILE: &str = "Flame.txt";
    let [kind, gain, delay] = [row[0], row[1], row[2]];
    if kind != 1.0 {
        let (what, known) = ("Type", "1 (n-tau)");
        return Err(OscilosError::Unsupported { file: FILE, what, value: kind, known });
    }
    within(FILE, "the delay (ms)", delay, [0.0, 1e4], "0 to 10 000 ms")?;
    Ok(Law::Transfer { gain, numerator: vec![1.0], denominator: vec![1.0], delay: delay * 1e-3 })
}

/// A reflection beyond is a slip of the pen: an active end may exceed 1, but not by far.
const REFLECTS: [f64; 2] = [-2.0, 2.0];

fn within(
    file: &'static str,
    what: &'static str,
    value: f64,
    [low, high]: [f64; 2],
    must: &'static str,
) -> Result<(), OscilosError> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(OscilosError::Value { file, what, value, must }) }
}

/// Kinds of ends that are read.
const KINDS: [f64; 6] = [1.0, 2.0, 4.0, 5.0, 11.0, 12.0];

fn boundary(file: &'static str, text: &str, radius: f64, sound_speed: f64) -> Result<Law, OscilosError> {
    // Kinds that are not read have rows of words below the first.
    let word = text.lines().skip(1).find_map(|line| line.split_whitespace().next());
    let known = "1, 2, 4, 5, 11 and 12";
    if let Some(value) = word.and_then(|word| word.parse().ok()).filter(|kind| !KINDS.contains(kind)) {
        return Err(OscilosError::Unsupported { file, what: "Type", value, known });
    }
    let row = &rows(file, text, 4)?[0];
    let [kind, one, two, three] = [row[0], row[1], row[2], row[3]];
    let constant = |r: C64| Law::Constant(r);
    match kind {
        1.0 => Ok(constant(C64::new(-1.0, 0.0))),
        2.0 => Ok(constant(C64::ONE)),
        4.0 => {
            within(file, "the modulus of the reflection", one, REFLECTS, "-2 to 2")?;
            within(file, "the delay (ms)", two, [0.0, 1e4], "0 to 10 000 ms")?;
            let (numerator, denominator) = (vec![1.0], vec![1.0]);
            Ok(Law::Transfer { gain: one, numerator, denominator, delay: two * 1e-3 })
        }
        5.0 => {
            within(file, "the modulus of the reflection", one, REFLECTS, "-2 to 2")?;
            let phase = if three == 0.0 { two } else { two.to_radians() };
            Ok(constant(C64::from_polar(one, -phase)))
        }
        11.0 => Ok(Law::Unflanged { radius, sound_speed, correction: 0.0 }),
        12.0 => Ok(Law::Flanged { radius, sound_speed }),
        value => Err(OscilosError::Unsupported { file, what: "Type", value, known }),
    }
}
