//! How far modes rest on the noise of measured tables, and on the pieces of what varies along x.

use super::assembly::Redraw;
use super::build::{Built, Reading, build};
use super::error::FileError;
use super::schema::File;
use crate::{Newton, Workspace};
use rijke_numerics::{C64, Streams};

/// How often tables are drawn.
const DRAWS: usize = 40;
/// A mode that a draw moves farther than this, of its |s|, is another one.
const ANOTHER: f64 = 0.1;
/// Zeros closer than this, of |s|, are one.
const SAME: f64 = 1e-6;

/// What the noise of measured tables does to a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// In how many draws of the tables there is such a mode.
    pub found: usize,
    /// How many draws there are.
    pub draws: usize,
    /// Root mean squares by which draws that have it lie off: growth rate, 1/s; angular frequency, rad/s.
    pub sd: [f64; 2],
}

impl Scatter {
    /// Whether a mode may be one of the fit and not of what was measured: a draw in ten or more lacks it.
    #[must_use]
    pub fn is_doubtful(&self) -> bool {
        10 * self.found <= 9 * self.draws
    }
}

impl Built {
    /// The largest noise of a measured table, of its largest value ([`crate::laws::Table::noise`]); 0 without
    /// tables.
    #[must_use]
    pub fn noise(&self) -> f64 {
        self.tables.iter().map(|table| table.noise).fold(0.0, f64::max)
    }
}

/// The scatter of the modes `modes` of a network about where they are, over other functions that the rows of
/// its tables allow: of other orders and delays, and with other noise ([`crate::laws::Likely`]);
/// `text` is the file that `built` was read from. Draws are of one seed.
///
/// # Errors
/// As of [`super::read`].
pub fn scatter(text: &str, built: &Built, modes: &[C64]) -> Result<Vec<Scatter>, FileError> {
    let file: File = toml::from_str(text).map_err(|error| FileError::syntax(&error))?;
    let streams = Streams::new(1);
    let mut moved: Vec<Vec<Option<C64>>> = vec![Vec::new(); modes.len()];
    let mut work = Workspace::default();
    let mut likely = Vec::new();
    for draw in 0..DRAWS {
        let stream = streams.stream(&format!("network/table/{draw}"));
        let redraw = Redraw { stream, known: built.tables.iter(), likely: &mut likely, met: 0 };
        let reading = Reading { redraw: Some(redraw), ..Reading::default() };
        let Ok(other) = build(text, &file, reading) else { continue };
        moved.iter_mut().zip(displaced(&other, modes, &mut work)).for_each(|(all, by)| all.push(by));
    }
    Ok(moved.iter().map(|moved| summary(moved)).collect())
}

/// By how much each of the modes `modes` of a network moves in twice as many pieces of its slopes, cones and
/// spread flames, 1/s and rad/s; none where it is not there any more. `text` is the file that the network was
/// read from. The lumped scheme keeps its pieces, which are what it says. Cost: twice that of reading, and
/// one Newton iteration for each mode.
///
/// # Errors
/// As of [`super::read`].
pub fn moved_by_pieces(text: &str, modes: &[C64]) -> Result<Vec<Option<C64>>, FileError> {
    let file: File = toml::from_str(text).map_err(|error| FileError::syntax(&error))?;
    let finer = build(text, &file, Reading { finer: 2, ..Reading::default() })?;
    Ok(displaced(&finer, modes, &mut Workspace::default()))
}

/// By how much each of the modes `modes` is elsewhere in another network, where it has such a mode.
/// Undeclared poles would be where the function grows without end; Newton's iteration ends at zeros.
fn displaced(other: &Built, modes: &[C64], work: &mut Workspace) -> Vec<Option<C64>> {
    let found: Vec<Option<C64>> =
        modes.iter().map(|s| Some(other.solve(*s, &Newton::default(), work).ok()?.s)).collect();
    let by = |k: usize| found[k].filter(|z| is_of(*z, k, modes, &found)).map(|z| z - modes[k]);
    (0..modes.len()).map(by).collect()
}

/// Whether `z` is the mode `k` of another network, in which each mode was looked for: not far from it, and of
/// no mode nearer. Where two modes end at one, only one of them is there.
fn is_of(z: C64, k: usize, modes: &[C64], found: &[Option<C64>]) -> bool {
    let by = (z - modes[k]).norm();
    let same = |other: &Option<C64>| other.is_some_and(|o| (o - z).norm() <= SAME * z.norm());
    let nearer = |(j, s): (usize, &C64)| j != k && same(&found[j]) && (z - s).norm() < by;
    by <= ANOTHER * modes[k].norm() && !modes.iter().enumerate().any(nearer)
}

fn summary(moved: &[Option<C64>]) -> Scatter {
    let found: Vec<C64> = moved.iter().flatten().copied().collect();
    let count = found.len().max(1) as f64;
    let sd = |part: fn(&C64) -> f64| (found.iter().map(|z| part(z).powi(2)).sum::<f64>() / count).sqrt();
    Scatter { found: found.len(), draws: moved.len(), sd: [sd(|z| z.re), sd(|z| z.im)] }
}
