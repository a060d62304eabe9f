//! Responses at frequencies at which the sound of a rig is not in plane waves alone.

use super::{ObservedResponse, ResponseKind, ResponseStage};
use crate::{DuctAt, Study};
use std::f64::consts::PI;

/// Temperature at which the rig is looked at, K.
const LAID_OUT: f64 = 293.15;

/// k a at which the first higher mode of a round duct is cut on: the first zero of J1'.
const CUT_ON: f64 = 1.841_183_78;

impl Study {
    /// Responses, and stages that take them, above the cut-on of the first higher mode of a duct, in
    /// a sentence. What a law of a place alone was measured as does not count.
    pub(crate) fn above_cut_on(&self, list: &[ObservedResponse]) -> Option<String> {
        let rig = self.campaign.points.first().and_then(|point| self.rig.at(point, LAID_OUT).ok())?;
        let ambient =
            self.campaign.points.first()?.ambient.map_or(self.rig.temperature, |[kelvin, _]| kelvin);
        let cut_on_of = |duct: &DuctAt| {
            let diameter = (4.0 * duct.area[0].max(duct.area[1]) / PI).sqrt();
            let gas = self.rig.gas.at(duct.temperature_at(0.5).unwrap_or(ambient), self.rig.pressure);
            (CUT_ON * gas.sound_speed / (PI * diameter), diameter)
        };
        let (cut_on, widest) = rig.ducts.iter().map(cut_on_of).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let of_waves = list.iter().filter(|r| !matches!(r.what, ResponseKind::Law { .. }));
        let highest = of_waves.flat_map(|r| r.frequency_hz.last()).fold(0.0, |a: f64, f| a.max(*f));
        let taken = |stage: &ResponseStage| stage.band_hz.map_or(f64::INFINITY, |[_, high]| high);
        let highest = highest.min(self.plan.responses.iter().map(taken).fold(0.0, f64::max));
        (highest > cut_on).then(|| {
            format!(
                "responses up to {highest:.0} Hz, but a duct {:.1} mm wide lets a higher mode through from {cut_on:.0} Hz on, where the sound is not in plane \
                 waves alone: stop below with `band_hz`",
                1e3 * widest
            )
        })
    }
}
