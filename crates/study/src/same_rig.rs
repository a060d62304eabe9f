//! Whether the rig of records or observations, which has files of its own, is the rig of the study.

use crate::rig::GasModel;
use crate::source::Source;
use crate::{Study, StudyError, StudyProblem};
use rijke_rig::Gas;
use serde::Deserialize;
use std::f64::consts::PI;
use std::path::Path;

/// Temperature at which the geometry is laid out, K.
const LAID_OUT: f64 = 293.15;
/// Places and sizes that differ by less are the same, m.
const SAME: f64 = 1e-6;
/// Numbers that differ by less of their size are the same: constants are rounded in print.
const ROUNDED: f64 = 1e-4;
/// What a rig is called by a file that was made of the study's own.
const OWN: &str = "study";
/// Files of a rig beside records or observations: of any rig, and of a heated tube.
const BESIDE: [&str; 2] = ["rig.toml", "tube.toml"];

impl Study {
    /// Compares what the files of a rig in `folder`, of records or observations, state with the study's
    /// `rig.toml`: length and inner diameter of the tube, places of the microphones and their reference,
    /// pressure and gas. A file that is missing, or that was made of the study's rig, contradicts nothing;
    /// nor do lengths and places that the study does not know, or that differ from point to point.
    ///
    /// # Errors
    /// Both files, both numbers, and the remedy.
    pub fn is_the_rig_of(&self, folder: &Path) -> Result<(), StudyError> {
        let files = BESIDE.map(|file| folder.join(file));
        files.iter().filter(|path| path.exists()).try_for_each(|path| self.agrees_with(path))
    }

    fn agrees_with(&self, path: &Path) -> Result<(), StudyError> {
        let stated: Stated = Source::read(path)?.toml()?;
        if stated.source == OWN {
            return Ok(());
        }
        let layouts = self.campaign.points.iter().map(|point| self.rig.at(point, LAID_OUT));
        let Ok(layouts) = layouts.collect::<Result<Vec<_>, _>>() else { return Ok(()) };
        let Some(layout) = layouts.first() else { return Ok(()) };
        let near = |a: f64, b: f64| (a - b).abs() <= SAME;
        let all_near =
            |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(*a, *b));
        let own = self.folder.join("rig.toml").display().to_string();
        let differ = |what: &str, ours: String, theirs: String| {
            let text = format!(
                "{what} is {ours}, and {} says {theirs}: correct the file that is wrong; if that is the latter, process the records again",
                path.display()
            );
            Err(StudyError { file: own.clone(), line: None, problem: Box::new(StudyProblem::Toml(text)) })
        };
        let pair = |what: &str, unit: &str, ours: f64, theirs: Option<f64>, same: f64| match theirs {
            Some(theirs) if (ours - theirs).abs() > same || theirs.is_nan() => {
                differ(what, format!("{ours} {unit}"), format!("{theirs} {unit}"))
            }
            _ => Ok(()),
        };
        let known = self.rig.own.parameters.is_empty();
        let [long, heard] = [
            layouts.iter().all(|other| near(other.length, layout.length)),
            layouts.iter().all(|other| all_near(&other.microphones, &layout.microphones)),
        ];
        if let Some(tube) = stated.tube.as_ref().filter(|_| known) {
            if long {
                pair("the length of the rig", "m", layout.length, tube.length, SAME)?;
            }
            let diameter = |area: f64| (4.0 * area / PI).sqrt();
            let mut wide = layouts.iter().flat_map(|l| &l.ducts).flat_map(|d| d.area).map(diameter);
            let first = wide.next().unwrap_or(f64::NAN);
            if wide.all(|other| near(other, first)) {
                pair("the inner diameter", "m", (1e9 * first).round() / 1e9, tube.inner_diameter, SAME)?;
            }
        }
        let heard = known && heard && !layout.microphones.is_empty();
        if let Some(heard) = stated.microphones.as_ref().filter(|_| heard) {
            let count = |list: &[f64]| format!("{} microphones at {list:?} m", list.len());
            let (ours, theirs) = (&layout.microphones, &heard.positions);
            if !all_near(ours, theirs) {
                return differ("the rig", count(ours), count(theirs));
            }
            let reference = self.rig.microphones.reference;
            if heard.reference.is_some_and(|r| r != reference) {
                let number = |k: usize| format!("the one of place {k}, counted from 0");
                return differ(
                    "the reference microphone",
                    number(reference),
                    number(heard.reference.unwrap_or(0)),
                );
            }
        }
        let rounded = ROUNDED * self.rig.pressure;
        pair("the pressure", "Pa", self.rig.pressure, stated.pressure, rounded)?;
        if let (GasModel::Real(ours), Some(theirs)) = (&self.rig.gas, &stated.gas) {
            let list = |gas: &Gas| {
                let Gas { molar_mass, heat_capacity, viscosity, conductivity } = gas;
                [&[*molar_mass][..], heat_capacity, viscosity, conductivity].concat()
            };
            let off = |(a, b): (&f64, &f64)| (a - b).abs() > ROUNDED * a.abs().max(b.abs());
            if list(ours).iter().zip(&list(theirs)).any(off) {
                return differ("the gas", format!("{:?}", list(ours)), format!("{:?}", list(theirs)));
            }
        }
        Ok(())
    }
}

/// What such a file states that a study states too.
#[derive(Deserialize)]
struct Stated {
    #[serde(default)]
    source: String,
    #[serde(alias = "duct")]
    tube: Option<Size>,
    pressure: Option<f64>,
    gas: Option<Gas>,
    microphones: Option<Microphones>,
}

#[derive(Deserialize)]
struct Size {
    length: Option<f64>,
    inner_diameter: Option<f64>,
}

#[derive(Deserialize)]
struct Microphones {
    positions: Vec<f64>,
    reference: Option<usize>,
}
