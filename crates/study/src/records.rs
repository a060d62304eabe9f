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
        let gas = match &self.rig.gas {
            GasModel::Real(gas) => gas.clone(),
            perfect @ GasModel::Perfect { .. } => {
                let gas = Gas::of_state(&perfect.at(LAID_OUT, self.rig.pressure));
                // The keys of the message are those of a gas that follows temperature: name what is stated.
                gas.validate().map_err(|(key, problem)| {
                    let text = format!(
                        "[gas]: by gamma, gas_constant, viscosity and prandtl, {key}: {problem}: no gas is like that, and records are not processed with it"
                    );
                    fail(StudyProblem::Toml(text))
                })?;
                gas
            }
        };
        Ok(Apparatus {
            name: self.plan.name.clone(),
            source: "study".into(),
            duct: DuctSize { length: layout.length, inner_diameter: layout.widest() },
            gas,
            pressure: self.rig.pressure,
            microphones: Microphones {
                positions: layout.microphones,
                reference: self.rig.microphones.reference,
                names: self.own_names(),
            },
            recording: Recording {
                arrival_setting_sd_s: self.rig.arrival_setting_sd_s,
                ping_decay_times: self.rig.ping_decay_times,
            },
        })
    }

    /// What the microphones are called; nothing if they go by their numbers.
    fn own_names(&self) -> Vec<String> {
        let names = &self.rig.microphones.names;
        if *names == Microphones::by_number(names.len()) { Vec::new() } else { names.clone() }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_clicks_run_in_the_gas_of_the_rig() {
        let folder = std::env::temp_dir().join(format!("rijke-gas-of-records-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("candidates")).unwrap();
        let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).unwrap();
        write(
            "candidates/all.toml",
            "[[candidate]]\nid = \"end\"\nrole = \"end\"\nname = \"end\"\ncite = [\"a test\"]\n[[candidate.effect]]\nacts_at = \"downstream\"\n\
             reflection = \"-1\"\n",
        );
        write("campaign.csv", "point,row,Q [W],T_amb [K]\na,cold,0,293\n");
        write(
            "study.toml",
            "name = \"gas\"\nbase = \"rig\"\n[[stage]]\nid = \"cold\"\npoints = {}\ncompete = [\"end\"]\n",
        );
        let open = |gas: &str| {
            let rig = format!(
                "name = \"gas\"\n[gas]\ntemperature = 293.15\n{gas}\n[upstream]\ntype = \"closed\"\n[downstream]\ntype = \"free\"\n\
                 [[element]]\nname = \"tube\"\ntype = \"duct\"\nlength = 0.8\ndiameter = 0.05\nwall = \"none\"\n\
                 [microphones]\nat = [0.1, 0.5]\nnames = [\"p1\", \"p2\"]\n"
            );
            write("rig.toml", &rig);
            Study::open(&folder).unwrap()
        };
        // The default, a heavy gas, helium.
        for (gamma, constant) in [(1.4, 287.05), (1.29, 188.9), (1.667, 2077.0)] {
            let study = open(&format!("gamma = {gamma}\ngas_constant = {constant}"));
            let gas = study.apparatus().unwrap().gas;
            for kelvin in [273.15, 293.15, 313.15_f64] {
                let (found, own) = (gas.at(kelvin, 101_325.0), study.rig.gas.at(kelvin, 101_325.0));
                let close =
                    |a: f64, b: f64, by: f64| assert!((a / b - 1.0).abs() < by, "{gamma} {kelvin}: {a} {b}");
                close(found.sound_speed, (gamma * constant * kelvin).sqrt(), 1e-12);
                close(found.density, own.density, 1e-12);
                close(found.prandtl, own.prandtl, 1e-12);
                close(found.viscosity, own.viscosity, 5e-4);
            }
        }
        let refused = open("gamma = 1.9").apparatus().unwrap_err().to_string();
        assert!(refused.contains("rig.toml") && refused.contains("[gas]"), "{refused}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
