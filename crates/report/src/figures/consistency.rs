//! Section 6.1 of the paper: two printed fits of the same measurements, which check the chain without any data.

use crate::{
    comparison::{Comparison, Verdict},
    draw::fixed,
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{Consistency, ConsistencyRow};

/// Everything the page shows of this study.
pub(crate) fn item(study: &Consistency) -> Item {
    let head = [
        "Wall loss",
        "printed |*R*|",
        "printed angle",
        "*s*_{r} / s^{-1}",
        "*s*_{i} / rad s^{-1}",
        "our *\u{3b7}*",
        "from",
        "to",
        "paper",
    ];
    let rows = study.rows.iter().map(|row| {
        let [radius, angle] = row.reflection;
        let [growth, frequency] = row.eigenvalue;
        let [low, high] = row.eta_range;
        vec![
            row.scheme.clone(),
            fixed(radius, 4),
            fixed(angle, 4),
            fixed(growth, 3),
            fixed(frequency, 2),
            fixed(row.eta, 4),
            fixed(low, 4),
            fixed(high, 4),
            fixed(row.published, 4),
        ]
    });
    let table = Table {
        id: "consistency",
        caption: format!(
            "Wall-loss factor with R = R_LS that explains the eigenvalue implied by a printed R with \u{3b7} = 1, at {} K. \
             From, to: its range within the rounding of the printed R.",
            fixed(study.temperature, 2)
        ),
        head: head.map(String::from).to_vec(),
        rows: rows.collect(),
        ..Table::default()
    };
    Item {
        id: "consistency",
        title: "Section 6.1: the paper's two fits of the empty tube".to_owned(),
        introduction: "The paper prints two descriptions of the same two measurements: R fitted with \u{3b7} = 1, and \u{3b7} \
                       fitted with R of Levine and Schwinger. Each can be computed from the other; no data of a rig enter."
            .to_owned(),
        // The first scheme is the paper's.
        comparisons: study.rows.iter().filter(|r| r.scheme == study.rows[0].scheme).map(comparison).collect(),
        figures: Vec::new(),
        tables: vec![table],
        sheets: vec![sheet(study)],
        checks: study.checks.clone(),
        provenance: None,
    }
}

/// The printed eta beside the one that follows from the printed R.
fn comparison(row: &ConsistencyRow) -> Comparison {
    let [low, high] = row.eta_range;
    let holds = (low..=high).contains(&row.published);
    Comparison {
        what: format!("*\u{3b7}* from the printed |*R*| = {}, {}", fixed(row.reflection[0], 4), row.scheme),
        paper: fixed(row.published, 4),
        ours: format!("{} ({} to {})", fixed(row.eta, 4), fixed(low, 4), fixed(high, 4)),
        verdict: Verdict::of(holds),
        sentence: if holds {
            "The two printed fits follow from each other within the rounding of the print.".to_owned()
        } else {
            format!(
                "The difference, {}, is more than the rounding of the print; the reason is below.",
                fixed(row.eta - row.published, 4)
            )
        },
    }
}

fn sheet(study: &Consistency) -> Sheet {
    let head = [
        "wall_loss",
        "printed_abs_r",
        "printed_arg_r_rad",
        "growth_rate_per_s",
        "angular_frequency_rad_per_s",
        "eta",
        "eta_low",
        "eta_high",
        "published_eta",
    ];
    let rows = study.rows.iter().map(|row| {
        let ([radius, angle], [growth, frequency], [low, high]) =
            (row.reflection, row.eigenvalue, row.eta_range);
        let numbers = [radius, angle, growth, frequency, row.eta, low, high, row.published].map(Cell::from);
        [Cell::from(&*row.scheme)].into_iter().chain(numbers).collect()
    });
    Sheet { id: "consistency", head: head.map(String::from).to_vec(), rows: rows.collect() }
}
