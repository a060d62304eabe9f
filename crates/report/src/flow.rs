//! Pictures of the base flow, and of a filter on its way.

use crate::Gallery;
use rijke_flow::assimilate::RunReport;
use rijke_flow::shown::{FlowCalibration, FlowDocument, base_flow, filters};
use rijke_numerics::Failed;
use std::path::Path;

/// Writes into `folder` a page with Fig. 2 of the paper, and a figure for every run of a filter. `beside` has
/// the batch fits of the same runs.
pub fn flow_page(document: &FlowDocument, beside: &[RunReport], folder: &Path) -> Result<(), Failed> {
    let mut gallery = Gallery::new(folder, "");
    let filters = filters(&document.runs, beside, document.kind);
    for (name, plot) in base_flow(&document.runs, document.kind).iter().chain(&filters) {
        gallery.show(name, plot)?;
    }
    let end = if filters.is_empty() { String::new() } else { calibration(&FlowCalibration::measured()) };
    gallery.write("Base flow", &end)
}

/// As an HTML table.
fn calibration(found: &FlowCalibration) -> String {
    let heads = found.methods.iter().map(|(m, twins)| format!("<th colspan=\"2\">{m}, {twins} twins</th>"));
    let row = |(quantity, cells): &(&str, Vec<[&str; 2]>)| {
        let cells = cells.iter().map(|[a, b]| format!("<td>{a}</td><td>{b}</td>"));
        format!("<tr><td>{quantity}</td>{}</tr>\n", cells.collect::<String>())
    };
    format!(
        "<h2>How far to trust the error bars</h2>\n<p>{}</p>\n<table>\n<tr><th></th>{}</tr>\n{}</table>\n",
        FlowCalibration::CAPTION,
        heads.collect::<String>(),
        found.quantities.iter().map(row).collect::<String>()
    )
}
