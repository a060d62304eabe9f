//! What signal processing needs to know of the rig of a study: microphones, gas, the width of the duct; and
//! its operating points by their factors.

use crate::campaign::{Campaign, Point};
use crate::rig::GasModel;
use crate::{Study, StudyError, StudyProblem};
use rijke_rig::{Apparatus, DuctSize, FactorValue, Gas, Microphones, OperatingPoint, Recording};

/// Temperature at which the geometry is laid out, K; positions that depend on it are of no use to a
/// laboratory.
const LAID_OUT: f64 = 293.15;

impl Study {
    /// The rig as records are processed with it: one duct as wide as the widest.
    ///
    /// # Errors
    /// File and remedy: microphones must stay where they are, and the rig needs at least one.
    pub fn apparatus(&self) -> Result<Apparatus, StudyError> {
        let file = self.folder.join("rig.toml").display().to_string();
        let fail = |problem| StudyError { file: file.clone(), line: None, problem: Box::new(problem) };
        let Some(first) = self.campaign.points.first() else {
            return Err(fail(StudyProblem::Empty {
                what: "operating point",
                need: "add it to the campaign",
            }));
        };
        let layout = self.rig.at(first, LAID_OUT).map_err(fail)?;
        for point in &self.campaign.points {
            let there = self.rig.at(point, LAID_OUT).map_err(fail)?;
            let moved = there.microphones.iter().zip(&layout.microphones).any(|(a, b)| (a - b).abs() > 1e-9);
            if moved {
                let (key, value) =
                    ("microphones.at".to_owned(), format!("another place at point {}", point.id));
                let need = "the same at all points, because channels are calibrated once";
                return Err(fail(StudyProblem::Value { key, value, need }));
            }
        }
        if layout.microphones.is_empty() {
            let need = "give [microphones] with at = [...] to process records";
            return Err(fail(StudyProblem::Empty { what: "microphone", need }));
        }
        let widest = layout.ducts.iter().flat_map(|d| d.area).fold(0.0, f64::max);
        let gas = match &self.rig.gas {
            GasModel::Real(gas) => gas.clone(),
            // Only its sound speed and its boundary layers matter here.
            GasModel::Perfect { .. } => Gas::air(),
        };
        Ok(Apparatus {
            name: self.plan.name.clone(),
            source: "study".into(),
            duct: DuctSize {
                length: layout.length,
                inner_diameter: (4.0 * widest / std::f64::consts::PI).sqrt(),
            },
            gas,
            pressure: self.rig.pressure,
            microphones: Microphones {
                positions: layout.microphones,
                reference: self.rig.microphones.reference,
            },
            recording: Recording {
                arrival_setting_sd_s: self.rig.arrival_setting_sd_s,
                ping_decay_times: self.rig.ping_decay_times,
            },
        })
    }
}

impl Campaign {
    /// The operating points as records know them.
    #[must_use]
    pub fn operating_points(&self) -> Vec<OperatingPoint> {
        self.points.iter().map(|point| self.operating_point(point)).collect()
    }

    fn operating_point(&self, point: &Point) -> OperatingPoint {
        let known = self.factors.iter().zip(&point.factors).filter(|(_, value)| !value.is_nan());
        let factor = |(factor, value): (&crate::Factor, &f64)| {
            (factor.name.clone(), FactorValue { value: *value, unit: factor.unit_in_print() })
        };
        OperatingPoint {
            id: point.id.clone(),
            row: point.row.clone(),
            repeats: point.repeats,
            factors: known.map(factor).collect(),
        }
    }
}
