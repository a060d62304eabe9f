//! Responses at frequencies at which the sound of a rig is not in plane waves alone.

use super::{ObservedResponse, ResponseKind, ResponseStage};
use crate::{DuctAt, Study};
use rijke_numerics::slips::cut_on;

impl Study {
    /// Says that stages take responses above the cut-on of the first higher mode of a duct. Those of a law
    /// alone, such as a flame transfer function, do not count.
    pub(crate) fn above_cut_on(&self, list: &[ObservedResponse]) -> Option<String> {
        let point = self.campaign.points.first()?;
        let ambient = point.ambient.map_or(self.rig.temperature, |[kelvin, _]| kelvin);
        let rig = self.rig.at(point, ambient).ok()?;
        let cut_on_of = |duct: &DuctAt| {
            let middle = 0.5 * (duct.span[0] + duct.span[1]);
            let gas = duct.gas.as_ref().unwrap_or(&self.rig.gas);
            let gas = gas.at(duct.temperature_at(middle).unwrap_or(ambient), self.rig.pressure);
            (cut_on(duct.widest(), gas.sound_speed), duct.widest())
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
