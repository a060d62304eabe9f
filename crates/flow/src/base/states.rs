//! The base states of a campaign, on disk: what `rijke flow` hands to acoustics.

use super::state::BaseState;
use crate::error::FlowError;
use rijke_rig::DataKind;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A base state per operating point, by the point's name.
///
/// **Errors are shared between points.** Two components with the same `cause` are one random number: the
/// state of every point is its mean plus, over all causes, z(cause) times the point's component of that
/// cause, with the z independent and standard normal. A systematic covariance of a prediction over several
/// points is therefore the sum over causes of j j', with j the change of the whole prediction when all points
/// are displaced along that cause.
///
/// The ambient temperature of a point is that of the gas at the inlet, `temperature[0]`, with its error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseStates {
    /// Whether the data behind them were measured.
    pub kind: DataKind,
    /// Where they come from.
    pub source: String,
    /// Name of the operating point, and its state.
    pub points: BTreeMap<String, BaseState>,
}

impl BaseStates {
    /// The file's name in the folder that `rijke flow` writes.
    pub const FILE: &'static str = "base-states.json";

    /// Reads a file (or the file [`BaseStates::FILE`] of a folder) and checks every state.
    ///
    /// # Errors
    /// [`FlowError::File`] with the file and the place in it, or the operating point and what is wrong with
    /// its state.
    pub fn read(path: &Path) -> Result<Self, FlowError> {
        let path = if path.is_dir() { path.join(Self::FILE) } else { path.to_path_buf() };
        let problem = |problem: String| FlowError::File { file: path.clone(), problem };
        let text = rijke_numerics::read_text(&path).map_err(|e| problem(e.to_string()))?;
        let states: Self = serde_json::from_str(&text).map_err(|e| problem(e.to_string()))?;
        for (id, state) in &states.points {
            state.clone().checked().map_err(|e| problem(format!("operating point {id}: {e}")))?;
        }
        Ok(states)
    }

    /// Writes the file.
    ///
    /// # Errors
    /// [`FlowError::File`].
    pub fn write(&self, path: &Path) -> Result<(), FlowError> {
        let problem =
            |e: &dyn std::fmt::Display| FlowError::File { file: path.to_path_buf(), problem: e.to_string() };
        let text = serde_json::to_string(self).map_err(|e| problem(&e))?;
        std::fs::write(path, text + "\n").map_err(|e| problem(&e))
    }

    /// All causes of error of the points `ids`, each once, in alphabetical order: the random numbers that a
    /// prediction over these points depends on.
    #[must_use]
    pub fn causes<'a>(&'a self, ids: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
        let states = ids.into_iter().filter_map(|id| self.points.get(id));
        let causes: BTreeSet<&str> = states.flat_map(|s| s.errors.iter().map(|e| e.cause.as_str())).collect();
        causes.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::state::ErrorComponent;
    use rijke_rig::Gas;

    fn states() -> BaseStates {
        let state = |cause: &str, kelvin: f64| {
            let mut state = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, kelvin, 0.1).unwrap();
            state.errors.push(ErrorComponent {
                cause: cause.into(),
                mass_flux: 0.01,
                heater_velocity: 0.02,
                temperature: vec![0.0, 3.0],
            });
            state
        };
        let points =
            [("H7-25", state("a", 300.0)), ("H15-25", state("a", 310.0)), ("H7-30", state("b", 300.0))];
        let points = points.into_iter().map(|(id, s)| (id.to_string(), s)).collect();
        BaseStates { kind: DataKind::Virtual, source: "test".into(), points }
    }

    #[test]
    fn exact_states_survive_the_disk_and_bad_ones_are_named() {
        let folder = std::env::temp_dir().join(format!("rijke-base-states-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (path, mut states) = (folder.join(BaseStates::FILE), states());
        states.write(&path).unwrap();
        assert_eq!(BaseStates::read(&path).unwrap(), states);
        assert_eq!(BaseStates::read(&folder).unwrap(), states);
        states.points.get_mut("H7-30").unwrap().temperature[1] = -4.0;
        states.write(&path).unwrap();
        let word = BaseStates::read(&folder).unwrap_err().to_string();
        assert!(word.contains("operating point H7-30") && word.contains("-4 K"), "{word}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn exact_causes_are_shared_by_name() {
        let states = states();
        assert_eq!(states.causes(["H7-25", "H15-25"]), ["a", "ambient temperature"]);
        assert_eq!(states.causes(["H7-25", "H7-30", "none"]), ["a", "ambient temperature", "b"]);
    }
}
