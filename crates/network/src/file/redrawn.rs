//! How far modes rest on the noise of measured tables.

use super::assembly::Redraw;
use super::build::{Built, build};
use super::error::FileError;
use super::schema::File;
use crate::{Newton, Workspace};
use rijke_numerics::{C64, Streams};

/// How often tables are drawn.
const DRAWS: usize = 20;
/// A mode that a draw moves farther than this, of its |s|, is another one.
const ANOTHER: f64 = 0.1;

/// What the noise of measured tables does to a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// In how many draws of the tables there is such a mode.
    pub found: usize,
    /// How many draws there are: those of which a fit could be made.
    pub draws: usize,
    /// Standard deviations of growth rate, 1/s, and angular frequency, rad/s, over the draws that have it.
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

/// The scatter of the modes `modes` of a network over tables that could as well have been measured, each with
/// the noise that its fit leaves ([`crate::laws::Table::redrawn`]); `text` is the file that `built` was read
/// from. Draws are of one seed.
///
/// # Errors
/// As of [`super::read`].
pub fn scatter(text: &str, built: &Built, modes: &[C64]) -> Result<Vec<Scatter>, FileError> {
    let file: File = toml::from_str(text).map_err(|error| FileError::syntax(&error))?;
    let streams = Streams::new(1);
    let mut moved: Vec<Vec<Option<C64>>> = vec![Vec::new(); modes.len()];
    let mut work = Workspace::default();
    for draw in 0..DRAWS {
        let stream = streams.stream(&format!("network/table/{draw}"));
        let redraw = Redraw { stream, known: built.tables.iter() };
        // A draw that no rational function meets says nothing.
        let Ok(other) = build(text, &file, Some(redraw)) else { continue };
        for (s, moved) in modes.iter().zip(&mut moved) {
            moved.push(step(&other, *s, &mut work).filter(|by| by.norm() <= ANOTHER * s.norm()));
        }
    }
    Ok(moved.iter().map(|moved| summary(moved)).collect())
}

/// How far the mode at `s` lies from there in another network; nothing if there is none.
fn step(other: &Built, s: C64, work: &mut Workspace) -> Option<C64> {
    let root = other.solve(s, &Newton::default(), work).ok()?;
    // An undeclared pole would be where the function grows without end; Newton's iteration ends at zeros.
    Some(root.s - s)
}

fn summary(moved: &[Option<C64>]) -> Scatter {
    let found: Vec<C64> = moved.iter().flatten().copied().collect();
    let free = found.len().saturating_sub(1).max(1) as f64;
    let mean = found.iter().sum::<C64>() / found.len().max(1) as f64;
    let sd = |part: fn(C64) -> f64| (found.iter().map(|z| part(z - mean).powi(2)).sum::<f64>() / free).sqrt();
    Scatter { found: found.len(), draws: moved.len(), sd: [sd(|z| z.re), sd(|z| z.im)] }
}
