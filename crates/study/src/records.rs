//! What signal processing needs to know of the rig of a study: microphones, gas, the width of the tube.

use crate::rig::GasModel;
use crate::{Study, StudyError, StudyProblem};
use rijke_rig::{Gas, Insert, Microphones, OperatingPoint, Plates, Recording, Tube, TubeCampaign, TubeRig};

/// Temperature at which the geometry is laid out, K; positions that depend on it are of no use to a
/// laboratory.
const LAID_OUT: f64 = 293.15;

impl Study {
    /// Rig and campaign as records are processed with them: one tube as wide as the widest duct, nothing in
    /// it.
    ///
    /// # Errors
    /// File and remedy: microphones must stay where they are, and the rig needs at least one.
    pub fn for_records(&self) -> Result<(TubeRig, TubeCampaign), StudyError> {
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
        let rig = TubeRig {
            name: self.plan.name.clone(),
            source: "study".into(),
            tube: Tube {
                length: layout.length,
                inner_diameter: (4.0 * widest / std::f64::consts::PI).sqrt(),
                wall_thickness: 0.0,
            },
            gas,
            pressure: self.rig.pressure,
            microphones: Microphones {
                positions: layout.microphones,
                reference: self.rig.microphones.reference,
            },
            thermometers: Vec::new(),
            insert: Insert { rods: 0, rod_diameter: 0.0, wires: 0, wire_diameter: 0.0 },
            plates: Plates {
                outer_diameter: 0.0,
                inner_diameter: 0.0,
                plate_thickness: 0.0,
                plate_gap: 0.0,
                wire_diameter: 0.0,
            },
            recording: Recording {
                ping_rate_hz: 1.0,
                click_rate_hz: 1.0,
                arrival_setting_sd_s: 0.0,
                ping_decay_times: self.rig.ping_decay_times,
            },
        };
        let point = |p: &crate::Point| OperatingPoint {
            id: p.id.clone(),
            row: p.row.clone(),
            position: None,
            plates: false,
            thermometers: false,
            power: 0.0,
            repeats: p.repeats,
        };
        let points = self.campaign.points.iter().map(point).collect();
        Ok((rig, TubeCampaign { name: self.plan.name.clone(), points, ramps: Vec::new() }))
    }
}
