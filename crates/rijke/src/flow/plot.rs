//! Pictures of the base flow, and of a filter on its way.

use crate::failure::{Classify, Failure};
use crate::figure::both;
use rijke_flow::assimilate::RunReport;
use rijke_flow::shown::{
    CurveRole, FlowCalibration, FlowCurve, FlowDocument, FlowFigure, FlowPanel, base_flow, filters,
};
use rijke_report::{Look, RecordCurve, RecordFigure, RecordPanel, gallery};
use rijke_rig::DataKind;
use std::fmt::Write as _;
use std::path::Path;

/// Writes `plots/index.html`, Fig. 2, and a figure for every run of a filter. `beside` has the batch fits of
/// the same runs.
pub(super) fn write(document: &FlowDocument, beside: &[RunReport], folder: &Path) -> Result<(), Failure> {
    let folder = folder.join("plots");
    std::fs::create_dir_all(&folder).or_failed().map_err(|f| f.at(&folder))?;
    let mut page = String::new();
    let filters = filters(&document.runs, beside);
    for figure in base_flow(&document.runs).iter().chain(&filters) {
        let FlowFigure { name, title, .. } = figure;
        both(&folder, name, &drawn(figure, document.kind).svg())?;
        let _ = writeln!(page, "<h2>{title}</h2>\n<p><img src=\"{name}.svg\" alt=\"{title}\"></p>");
    }
    if !filters.is_empty() {
        page += &calibration(&FlowCalibration::measured());
    }
    let path = folder.join("index.html");
    std::fs::write(&path, gallery("Base flow", &page)).or_failed().map_err(|f| f.at(&path))
}

fn drawn(figure: &FlowFigure, data: DataKind) -> RecordFigure {
    let look = |role: CurveRole| match role {
        CurveRole::One(k, of) => Look::Channel(k, of),
        CurveRole::Batch => Look::Channel(5, 7),
        CurveRole::BatchBand => Look::Patch(1),
        CurveRole::Filter => Look::Fit,
        CurveRole::FilterBand => Look::Patch(0),
        CurveRole::Expected => Look::Record,
    };
    let curve =
        |c: &FlowCurve| RecordCurve { name: c.name.clone(), look: look(c.role), points: c.points.clone() };
    let panel = |p: &FlowPanel| RecordPanel {
        x: p.x.clone(),
        y: p.y.clone(),
        curves: p.curves.iter().map(curve).collect(),
        marks: p.marks.clone(),
    };
    RecordFigure { title: figure.title.clone(), data, panels: figure.panels.iter().map(panel).collect() }
}

/// As an HTML table.
fn calibration(found: &FlowCalibration) -> String {
    let caption = FlowCalibration::CAPTION;
    let mut text =
        format!("<h2>How far to trust the error bars</h2>\n<p>{caption}</p>\n<table>\n<tr><th></th>");
    for (method, twins) in &found.methods {
        let _ = write!(text, "<th colspan=\"2\">{method}, {twins} twins</th>");
    }
    text += "</tr>\n";
    for (quantity, cells) in &found.quantities {
        let row: String = cells.iter().map(|[a, b]| format!("<td>{a}</td><td>{b}</td>")).collect();
        let _ = writeln!(text, "<tr><td>{quantity}</td>{row}</tr>");
    }
    text + "</table>\n"
}
