//! Which noises act on the data of a training.

use crate::errors::Scatter;
use crate::noise::{BETWEEN, MEASURED, NONE, Noise, UNITS};
use rijke_inference::NoiseGroup;

/// The groups of noise that act on any block, and where the optional ones stand.
pub(crate) struct Groups {
    pub(crate) list: Vec<NoiseGroup>,
    pub(crate) near_field: Option<usize>,
    pub(crate) installation: Option<[usize; 2]>,
    /// The first of the parameters that vary between installations.
    pub(crate) varying: usize,
}

impl Groups {
    /// Those of the measured numbers: of growth rates and frequencies only where there are any, because a
    /// noise that nothing tells of cannot float; pressures likewise.
    pub(crate) fn new(there: [bool; 2], pressures: bool, noise: &Noise) -> Self {
        let measured = if pressures { 3 } else { 2 };
        let told = |k: usize| k == 2 || there[k];
        let group = |k: usize| NoiseGroup {
            name: MEASURED[k].into(),
            unit: UNITS[k].into(),
            mode: if told(k) { noise.of_a_point[k] } else { NONE },
        };
        Self { list: (0..measured).map(group).collect(), near_field: None, installation: None, varying: 0 }
    }

    /// And that of microphones near a part whose near field they feel, where there are any.
    pub(crate) fn near_field(mut self, any: bool) -> Self {
        if any {
            self.near_field = Some(self.list.len());
            self.list.push(NoiseGroup::fixed("near field", "1", 1.0));
        }
        self
    }

    /// And those of parameters that vary between installations.
    pub(crate) fn varying(mut self, scatter: &[Scatter]) -> Self {
        self.varying = self.list.len();
        self.list.extend(scatter.iter().map(|s| s.group.clone()));
        self
    }

    /// And those that the points of one installation share, of growth rates and frequencies that are `there`.
    pub(crate) fn shared(mut self, there: [bool; 2], noise: &Noise) -> Self {
        if noise.of_an_installation != [NONE; 2] {
            let first = self.list.len();
            self.list.extend((0..2).map(|k| NoiseGroup {
                name: format!("{}{BETWEEN}", MEASURED[k]),
                unit: UNITS[k].into(),
                mode: if there[k] { noise.of_an_installation[k] } else { NONE },
            }));
            self.installation = Some([first, first + 1]);
        }
        self
    }
}
