//! Table 4: competing models of the hot heater.

use super::ranking::Ranking;
use crate::page::Item;
use rijke_studies::HeatRelease;

/// Everything the page shows of this study.
pub(crate) fn item(study: &HeatRelease) -> Item {
    let ranking = Ranking {
        models: &study.models,
        winner: &study.winner,
        published_winner: &study.published_winner,
        kendall_tau: study.kendall_tau,
        checks: &study.checks,
        points: study.measured.len(),
        table: "Table 4",
        files: ["table-4", "table-4-parameters"],
    };
    Item {
        id: "heat-release",
        title: "Table 4: models of the hot heater".to_owned(),
        introduction: format!(
            "{} models of heat release and drag of the hot heater, trained on the same {} operating points and ranked by \
             marginal likelihood. Models whose number starts with + are not in the paper. The model with the most evidence of \
             all is {}; it is the one that is saved and drawn in Figures 10 and 11.",
            study.models.len(),
            study.measured.len(),
            ranking.name(&study.chosen)
        ),
        comparisons: ranking.comparisons(),
        figures: Vec::new(),
        tables: vec![ranking.table(), ranking.parameters()],
        sheets: vec![ranking.evidence(), ranking.values()],
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}
