//! Observations of a heated tube.

use super::folder::HeatedTube;
use super::geometry::TubeRig;
use super::point::{POSITION, POWER, TubePoint};
use super::ramp::Ramp;
use rijke_rig::{Click, DataKind, Day, Observations, PointObservations, Problem, RigError};
use std::path::Path;

/// What was observed of a heated tube, as far as the flow asks for it.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeObservations {
    /// The tube, with the microphones of the observations.
    pub rig: TubeRig,
    /// Measured or virtual.
    pub kind: DataKind,
    /// Where the data come from.
    pub source: String,
    /// Operating point by operating point.
    pub points: Vec<ObservedTube>,
    /// The runs in which points were measured before the flow had settled.
    pub ramps: Vec<Ramp>,
}

/// What was observed at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedTube {
    /// The operating point.
    pub point: TubePoint,
    /// Day and ambient temperature.
    pub ambient: Day,
    /// Mean over the accepted clicks.
    pub click: Option<Click>,
    /// Whether nothing was measured there yet, neither pings nor clicks.
    pub is_planned: bool,
}

/// Relative difference of two numbers that are the same in two files.
const SAME: f64 = 1e-6;

impl TubeObservations {
    /// Reads observations and, beside them, the tube.
    ///
    /// # Errors
    /// Those of [`Observations::read`] and [`TubeObservations::of`].
    pub fn read(folder: &Path) -> Result<Self, RigError> {
        Self::of(&Observations::read(folder)?, folder)
    }

    /// Observations with the tube that `folder` describes.
    ///
    /// # Errors
    /// There is no [`HeatedTube::FILE`], or it is of another rig than the observations; no point has a power
    /// or a place of the plates; a factor has another unit.
    pub fn of(observations: &Observations, folder: &Path) -> Result<Self, RigError> {
        let path = folder.join(HeatedTube::FILE);
        let wrong = |(place, problem): (String, Problem)| RigError::invalid(&path, place, problem);
        let keys = |place: &str, what: &'static str| wrong((place.to_owned(), Problem::Keys { what }));
        let points = || observations.points.iter().map(|p| &p.point);
        for name in [POSITION, POWER] {
            if path.is_file() && points().all(|p| p.factor(name).is_none()) {
                let known: std::collections::BTreeSet<String> =
                    points().flat_map(|p| p.factors.keys().cloned()).collect();
                let problem =
                    Problem::NoSuchHeading { name: name.into(), known: known.into_iter().collect() };
                return Err(RigError::invalid(&folder.join("points.csv"), "factors", problem));
            }
        }
        let Some(HeatedTube { mut rig, ramps }) = HeatedTube::read_within(folder, points())? else {
            let what =
                "put the geometry of the heated tube there, or beside the records and process them again";
            return Err(keys("no such file", what));
        };
        let known = &observations.rig;
        let close = |a: f64, b: f64| (a - b).abs() <= SAME * b.abs();
        let speed = |gas: &rijke_rig::Gas, kelvin: f64| gas.at(kelvin, rig.pressure).sound_speed;
        let same = [
            ("tube.length", rig.tube.length, known.duct.length),
            ("tube.inner_diameter", rig.tube.inner_diameter, known.duct.inner_diameter),
            ("pressure", rig.pressure, known.pressure),
            ("gas", speed(&rig.gas, 300.0), speed(&known.gas, 300.0)),
            ("gas", speed(&rig.gas, 600.0), speed(&known.gas, 600.0)),
        ];
        let other = "is not that of rig.toml beside it; correct one of the two";
        if let Some((place, ..)) = same.iter().find(|(_, own, theirs)| !close(*own, *theirs)) {
            return Err(keys(place, other));
        }
        // Dead microphones are missing in the observations.
        let there = |x: &f64| rig.microphones.positions.iter().any(|own| close(*own, *x));
        if !known.microphones.positions.iter().all(there) {
            return Err(keys("microphones.positions", other));
        }
        rig.microphones = known.microphones.clone();
        rig.recording.arrival_setting_sd_s = known.recording.arrival_setting_sd_s;
        let point = |p: &PointObservations| {
            Ok(ObservedTube {
                point: rig.point(&p.point).map_err(wrong)?,
                ambient: p.ambient.clone(),
                click: p.click.clone(),
                is_planned: p.ping.is_none() && p.click.is_none(),
            })
        };
        let points = observations.points.iter().map(point).collect::<Result<_, RigError>>()?;
        let (kind, source) = (observations.kind, observations.source.clone());
        Ok(Self { rig, kind, source, points, ramps })
    }
}
