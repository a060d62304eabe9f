//! What sound passes on its way along the tube.

use super::geometry::TubeRig;
use super::point::TubePoint;
use rijke_rig::{Stretch, Way};

/// Relative standard deviation of the boundary layers of the insert: threads and fabric have a larger surface
/// than smooth cylinders, by how much is not known.
const INSERT_SURFACE_SD: f64 = 0.5;

impl TubeRig {
    /// What sound passes at an operating point: the insert from the bottom to the plates, and gas that may be
    /// hot if there is power.
    #[must_use]
    pub fn way(&self, point: &TubePoint) -> Way {
        let half = if point.plates { 0.5 * self.plates.length() } else { 0.0 };
        let length = point.position.map_or(0.0, |position| (position - half).max(0.0));
        let (tube, insert) = (&self.tube, &self.insert);
        let wetted = (tube.perimeter() + insert.perimeter()) / (2.0 * (tube.area() - insert.area()));
        let stretch = Stretch { from: 0.0, to: length, wetted, excess_sd: INSERT_SURFACE_SD };
        Way { hot: point.power > 0.0, stretches: (length > 0.0).then_some(stretch).into_iter().collect() }
    }
}

#[cfg(test)]
mod tests {
    use crate::{TubeCampaign, TubeRig};

    #[test]
    fn exact_the_insert_wets_the_tube_below_the_plates() {
        let rig = TubeRig::juniper_yoko_2022();
        let mut point = TubeCampaign::juniper_yoko_2022().points.remove(0);
        (point.position, point.plates) = (Some(0.4), true);
        let way = rig.way(&point);
        let (perimeter, area) =
            (0.0474 + 2.0 * 0.003 + 2.0 * 0.004, 0.0474_f64.powi(2) - 2.0 * (9e-6 + 16e-6));
        let stretch = way.stretches[0];
        assert!((stretch.wetted - 2.0 * perimeter / area).abs() < 1e-9, "{}", stretch.wetted);
        assert!((stretch.to - (0.4 - 0.5 * rig.plates.length())).abs() < 1e-12 && !way.hot);
        (point.position, point.plates, point.power) = (None, false, 3.0);
        assert!(rig.way(&point).stretches.is_empty() && rig.way(&point).hot);
    }
}
