//! What further points would tell, over the factors.

use super::super::answers::{axis_label, factor_column};
use super::{Next, Suggestion};
use rijke_rig::{DataKind, Look, Plot, PlotCurve, PlotPanel};
use rijke_study::Campaign;

impl Next {
    /// Information over every factor that has more than one value; the points of the plan again in another
    /// colour.
    #[must_use]
    pub fn plot(&self, campaign: &Campaign, data: DataKind) -> Plot {
        let planned = |s: &&Suggestion| self.plan.iter().any(|step| step.point == s.point);
        let panel = |k: usize| {
            let factor = &campaign.factors[k];
            let dots = |list: Vec<&Suggestion>| -> Vec<[f64; 2]> {
                list.into_iter().filter_map(|s| Some([factor.shown_of(s.factors[k]?), s.nats])).collect()
            };
            let all = dots(self.points.iter().collect());
            let varies = all.windows(2).any(|w| w[0][0] != w[1][0]);
            let plan = dots(self.points.iter().filter(planned).collect());
            let curves = vec![
                PlotCurve::new("a possible point, measured alone", Look::Dots(0), all),
                PlotCurve::new("a point of the plan, measured alone", Look::Dots(1), plan),
            ];
            varies.then(|| {
                PlotPanel::new(&axis_label(&factor_column(factor)), "Expected information / nats", curves)
            })
        };
        Plot {
            title: format!("What further points would tell: {}", self.stage),
            data,
            panels: (0..campaign.factors.len()).filter_map(panel).collect(),
        }
    }
}
