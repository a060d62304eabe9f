//! Trained quantities beside the truth of the virtual laboratory.

use super::ranking::rounded;
use crate::{
    draw::fixed,
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};

use rijke_studies::{TruthRow, Truths};

/// Everything the page shows of this study.
pub(crate) fn item(study: &Truths) -> Item {
    let row = |r: &TruthRow| {
        vec![
            r.quantity.clone(),
            rounded(r.value, r.sd),
            rounded(r.sd, r.sd),
            rounded(r.truth, r.sd),
            fixed((r.value - r.truth) / r.sd, 1),
        ]
    };
    let sheet_row = |r: &TruthRow| {
        vec![Cell::from(&*r.quantity), Cell::from(r.value), Cell::from(r.sd), Cell::from(r.truth)]
    };
    Item {
        id: "truths",
        title: "Trained parameters and the truth of the laboratory".to_owned(),
        introduction: "Where a parameter of the models and a value of the virtual laboratory mean the same thing, the two can be \
                       compared. The paper has no such test: the truth of a real rig is not known."
            .to_owned(),
        comparisons: Vec::new(),
        figures: Vec::new(),
        tables: vec![Table {
            id: "truths",
            caption: "Trained value, its standard deviation, the truth, and their difference in standard deviations.".to_owned(),
            head: ["Quantity", "Trained", "sd", "Truth", "off by / sd"].map(String::from).to_vec(),
            rows: study.rows.iter().map(row).collect(),
            ..Table::default()
        }],
        sheets: vec![Sheet {
            id: "truths",
            head: ["quantity", "trained", "sd", "truth"].map(String::from).to_vec(),
            rows: study.rows.iter().map(sheet_row).collect(),
        }],
        checks: study.checks.clone(),
        provenance: None,
    }
}
