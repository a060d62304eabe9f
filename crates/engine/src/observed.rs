//! What was measured at an operating point, and where its numbers stand in a prediction.

use crate::Conditions;
use rijke_numerics::{C64, Matrix};
use rijke_rig::ModeRows;
use rijke_study::ObservedMode;
use std::sync::Arc;

/// A measured mode and the conditions under which it was measured.
#[derive(Clone, Debug)]
pub struct Observed {
    /// The operating point and the state of its gas.
    pub conditions: Arc<Conditions>,
    /// What was measured.
    pub mode: ObservedMode,
    /// Where the mode is sought, growth rate and angular frequency.
    pub near: C64,
}

/// The numbers of one observation that a training uses, and where they stand in its prediction: s, then the
/// pressures of the microphones that were heard, real and imaginary parts in turn.
#[derive(Clone, Debug)]
pub(crate) struct Used {
    /// Microphones that are predicted: those used, the reference among them if any.
    pub(crate) microphones: Vec<usize>,
    /// Microphones but the reference, in the order of their pressures.
    pub(crate) others: Vec<usize>,
    /// Their measured pressures.
    pub(crate) pressures: Vec<C64>,
    /// The measured numbers.
    pub(crate) values: Vec<f64>,
    /// Their covariance, without what all modes have in common.
    pub(crate) covariance: Matrix,
    /// For each of them its row in the prediction: 0 growth rate, 1 angular frequency, then the pressures.
    pub(crate) rows: Vec<usize>,
}

impl Observed {
    /// What the microphones `chosen` measured of this mode; `reference` is the one to which pressures are
    /// relative.
    pub(crate) fn used(&self, chosen: &[usize], reference: usize) -> Used {
        let mode = &self.mode;
        let mut rows = Vec::new();
        let mut keep = Vec::new();
        let mut place = 0;
        for (row, there) in [(0, mode.growth_rate.is_some()), (1, mode.angular_frequency.is_some())] {
            if there {
                rows.push(row);
                keep.push(place);
                place += 1;
            }
        }
        let (mut others, mut pressures) = (Vec::new(), Vec::new());
        for (k, (microphone, pressure)) in mode.pressures.iter().enumerate() {
            if *microphone != reference && chosen.contains(microphone) {
                let row = ModeRows::pressure(others.len());
                rows.extend([row, row + 1]);
                keep.extend([place + 2 * k, place + 2 * k + 1]);
                others.push(*microphone);
                pressures.push(*pressure);
            }
        }
        let mut microphones = others.clone();
        if !others.is_empty() {
            // In the order of the rig, as predictions are made.
            microphones.push(reference);
            microphones.sort_unstable();
        }
        let all = mode.numbers();
        let mut covariance = mode.covariance.select(&keep);
        if let Some(k) = rows.iter().position(|row| *row == 1) {
            // It is common to all: see [`crate::errors::of_drift`].
            covariance[(k, k)] -= mode.drift_sd.powi(2);
        }
        Used {
            values: keep.iter().map(|&k| all[k]).collect(),
            covariance,
            microphones,
            others,
            pressures,
            rows,
        }
    }
}

impl Used {
    /// How many numbers the prediction has.
    pub(crate) fn size(&self) -> usize {
        ModeRows::count(self.others.len())
    }

    /// Places among the measured numbers of the pressures.
    pub(crate) fn of_the_pressures(&self) -> Vec<usize> {
        (0..self.rows.len()).filter(|&k| self.rows[k] >= 2).collect()
    }
}

/// Whether two observations share an assembly of the rig.
pub(crate) fn same_installation(a: &Observed, b: &Observed) -> bool {
    a.conditions.point.installation == b.conditions.point.installation
}
