//! The heated tube beside records and observations: `tube.toml` and `ramps.csv` in their folder.

use super::geometry::TubeRig;
use super::point::TubePoint;
use super::ramp::Ramp;
use rijke_rig::files::write_toml;
use rijke_rig::{OperatingPoint, RigError, Way};
use std::path::Path;

/// What a folder of records or of observations says of a heated tube, beside what any rig has.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatedTube {
    /// The tube.
    pub rig: TubeRig,
    /// The runs in which points were measured before the flow had settled.
    pub ramps: Vec<Ramp>,
}

impl HeatedTube {
    /// Name of the file of the tube.
    pub const FILE: &'static str = "tube.toml";

    /// Reads the files of `folder`; there is no heated tube without [`HeatedTube::FILE`].
    ///
    /// # Errors
    /// The file, the place in it and the remedy.
    pub fn read_within<'a>(
        folder: &Path,
        points: impl Iterator<Item = &'a OperatingPoint>,
    ) -> Result<Option<Self>, RigError> {
        let path = folder.join(Self::FILE);
        if !path.exists() {
            return Ok(None);
        }
        let rig = TubeRig::read(&path)?;
        let points = points
            .map(|point| {
                rig.point(point).map_err(|(place, problem)| RigError::invalid(&path, place, problem))
            })
            .collect::<Result<Vec<_>, _>>()?;
        let ramps = Ramp::read_within(folder, points.iter())?;
        Ok(Some(Self { rig, ramps }))
    }

    /// Writes the files into `folder`: the ramps with those of their points for which `there` holds.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write_within(&self, folder: &Path, there: &dyn Fn(&str) -> bool) -> Result<(), RigError> {
        let head = "# A heated tube, for the flow in it. SI units; x = 0 is the bottom of the tube.\n\n";
        write_toml(&self.rig, head, &folder.join(Self::FILE))?;
        Ramp::write_within(&Ramp::restricted(&self.ramps, there), folder)
    }

    /// What sound passes at a point; none if the point is none of a heated tube.
    #[must_use]
    pub fn way(&self, point: &OperatingPoint) -> Option<Way> {
        self.rig.point(point).ok().map(|point| self.rig.way(&point))
    }
}

impl TubeRig {
    /// A point of this tube, by its factors.
    ///
    /// # Errors
    /// Those of [`TubePoint::of`], and a place outside the tube.
    pub fn point(&self, point: &OperatingPoint) -> Result<TubePoint, (String, rijke_rig::Problem)> {
        let point = TubePoint::of(point)?;
        let length = self.tube.length;
        match point.position {
            Some(position) if !(position > 0.0 && position < length) => {
                let place = format!("point `{}`", point.id);
                Err((place, rijke_rig::Problem::OutsideTube { position, length }))
            }
            _ => Ok(point),
        }
    }
}
