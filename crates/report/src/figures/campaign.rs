//! Table 1: the campaign as it was read.

use crate::{
    comparison::{Comparison, Verdict},
    draw::fixed,
    page::Item,
    sheet::{Cell, Sheet},
    table::Table,
};
use rijke_studies::{CampaignRead, CampaignRow, PointRead};

/// Everything the page shows of this study.
pub(crate) fn item(study: &CampaignRead) -> Item {
    Item {
        id: "campaign",
        title: "Table 1: the campaign as read".to_owned(),
        introduction: format!(
            "{} pings and {} clicks at {} operating points are used; {} records are not, for the reasons listed at the end.",
            study.provenance.pings,
            study.clicks,
            study.provenance.points,
            study.provenance.rejected.len()
        ),
        comparisons: vec![comparison(study)],
        figures: Vec::new(),
        tables: vec![table(study)],
        sheets: vec![sheet(study)],
        checks: study.checks.clone(),
        provenance: Some(study.provenance.clone()),
    }
}

fn points(study: &CampaignRead) -> impl Iterator<Item = &PointRead> {
    study.rows.iter().flat_map(|row| &row.points)
}

fn comparison(study: &CampaignRead) -> Comparison {
    let experiments: u32 = points(study).map(|p| p.recorded).sum();
    let known = points(study).filter(|p| p.published.is_some()).count();
    let whole = known == 175 && experiments == 7000;
    Comparison {
        what: "operating points and experiments".to_owned(),
        paper: "175 and 7000".to_owned(),
        ours: format!("{known} and {experiments}"),
        verdict: Verdict::of(whole),
        sentence: if whole {
            "The operating points and repeats are those of the paper; the experiments are the laboratory's."
                .to_owned()
        } else {
            "This is a part of the campaign, or fewer repeats of it.".to_owned()
        },
    }
}

/// Positions in cm, the empty tube first.
fn positions(study: &CampaignRead) -> Vec<Option<i64>> {
    let mut all: Vec<_> = points(study).map(centimetres).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn centimetres(point: &PointRead) -> Option<i64> {
    point.position_m.map(|x| (100.0 * x).round() as i64)
}

fn table(study: &CampaignRead) -> Table {
    let positions = positions(study);
    let mut head = ["", "T", "*Q* / W"].map(String::from).to_vec();
    head.extend(positions.iter().map(|p| p.map_or_else(|| "E".to_owned(), |cm| cm.to_string())));
    let row = |row: &CampaignRow| {
        let mark = if row.thermocouples { "\u{2713}" } else { "\u{2013}" };
        let mut cells = vec![row.id.clone(), mark.to_owned(), fixed(row.power_w, 0)];
        cells.extend(positions.iter().map(|at| {
            let here = row.points.iter().find(|p| centimetres(p) == *at);
            here.map_or_else(|| "\u{2013}".to_owned(), |p| p.pings.to_string())
        }));
        cells
    };
    let most = points(study).map(|p| p.recorded).max().unwrap_or(0);
    Table {
        id: "table-1",
        caption: format!(
            "Number of pings used at each operating point, of {most} recorded; the paper has 40 in every cell. T: thermocouples \
             in place; *Q*: power of the heater; then its position in cm, E for the empty tube. C1 and C2: prongs and heater, \
             switched off; C3: prongs only; H: prongs, heater and thermocouples."
        ),
        head,
        rows: study.rows.iter().map(row).collect(),
        dense: true,
        ..Table::default()
    }
}

fn sheet(study: &CampaignRead) -> Sheet {
    let head = [
        "point",
        "row",
        "thermocouples",
        "power_w",
        "position_m",
        "recorded",
        "pings_used",
        "clicks_used",
        "growth_rate_per_s",
        "angular_frequency_rad_per_s",
    ];
    let optional = |value: Option<f64>| value.map_or(Cell::Empty, Cell::Number);
    let rows = study.rows.iter().flat_map(|row| {
        row.points.iter().map(move |p| {
            vec![
                Cell::from(&*p.id),
                Cell::from(&*row.id),
                Cell::from(f64::from(u8::from(row.thermocouples))),
                Cell::from(row.power_w),
                optional(p.position_m),
                Cell::from(f64::from(p.recorded)),
                Cell::from(f64::from(p.pings)),
                Cell::from(f64::from(p.clicks)),
                optional(p.growth_rate),
                optional(p.angular_frequency),
            ]
        })
    });
    Sheet { id: "table-1", head: head.map(String::from).to_vec(), rows: rows.collect() }
}
