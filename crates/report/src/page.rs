//! The page: one HTML file that needs nothing else.

use crate::{
    ReportError,
    comparison::Comparison,
    draw::{Figure, html},
    sheet::Sheet,
    table::Table,
};
use minijinja::{Environment, value::Serde};
use rijke_studies::{Check, DataKind, Provenance};
use serde_json::{Value, json};

const TEMPLATE: &str = include_str!("page.html");

/// What the page shows of one study.
pub(crate) struct Item {
    /// Anchor on the page.
    pub(crate) id: &'static str,
    /// Heading.
    pub(crate) title: String,
    /// A paragraph: what was asked, what came out, and how it compares with the paper.
    pub(crate) introduction: String,
    /// What the paper says beside what came out here.
    pub(crate) comparisons: Vec<Comparison>,
    /// Figures.
    pub(crate) figures: Vec<Figure>,
    /// Tables.
    pub(crate) tables: Vec<Table>,
    /// The same and more as CSV files.
    pub(crate) sheets: Vec<Sheet>,
    /// Statements of the paper, tried on these data.
    pub(crate) checks: Vec<Check>,
    /// Where the data come from; none if the study uses no data of a rig.
    pub(crate) provenance: Option<Provenance>,
}

/// Renders the page.
pub(crate) fn render(items: &[Item]) -> Result<String, ReportError> {
    let mut environment = Environment::new();
    environment.add_template("page.html", TEMPLATE)?;
    // The study that used most of the records describes them: the campaign, where it was read as a whole.
    let provenance = items.iter().filter_map(|i| i.provenance.as_ref()).max_by_key(|p| (p.points, p.pings));
    let page = environment.get_template("page.html")?.render(Serde(json!({
        "items": items.iter().map(values).collect::<Vec<_>>(),
        "virtual_data": provenance.is_some_and(|p| p.data == DataKind::Virtual),
        "provenance": provenance,
    })))?;
    // One blank line at the end, no trailing spaces: the file is compared byte by byte.
    Ok(page.lines().map(|l| format!("{}\n", l.trim_end())).collect())
}

fn values(item: &Item) -> Value {
    let figures = item
        .figures
        .iter()
        .map(|f| json!({ "id": f.id, "caption": html(&f.caption), "html": f.html(), "note": f.note() }));
    let tables = item
        .tables
        .iter()
        .map(|t| json!({ "id": t.id, "caption": html(&t.caption), "html": t.html(), "dense": t.dense }));
    json!({
        "id": item.id,
        "title": item.title,
        "short": item.title.split(':').next(),
        "introduction": item.introduction,
        "comparisons": item.comparisons.iter().map(Comparison::value).collect::<Vec<_>>(),
        "figures": figures.collect::<Vec<_>>(),
        "tables": tables.collect::<Vec<_>>(),
        "sheets": item.sheets.iter().map(|s| s.id).collect::<Vec<_>>(),
        "checks": checks(&item.checks),
    })
}

/// The checks, with an explanation that several in a row share given after the last of them.
fn checks(checks: &[Check]) -> Vec<Check> {
    let mut shown = checks.to_vec();
    for i in 1..shown.len() {
        if shown[i - 1].explanation == shown[i].explanation {
            shown[i - 1].explanation = None;
        }
    }
    shown
}
