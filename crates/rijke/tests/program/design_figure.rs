//! The figure of docs/records/designs.md, drawn from its table.

use crate::example;
use rijke_draw::plot_svg;
use rijke_rig::{DataKind, Look, Plot, PlotCurve, PlotPanel};
use std::fs;

/// Layouts by the beginning of their names, and what the legend calls them.
const KINDS: [(&str, &str); 4] = [
    ("even", "even"),
    ("next", "planned by `next`"),
    ("the paper's eight", "the paper's eight"),
    ("random", "random"),
];

/// Layout, hours, rms error of growth rates in 1/s, and ln Bayes factor of the drags.
type Row = (String, f64, Option<f64>, Option<f64>);

/// Every row of the table.
fn rows(record: &str) -> Vec<Row> {
    let cells = |line: &str| line.split('|').map(|c| c.trim().to_owned()).collect::<Vec<_>>();
    let table = record.lines().skip_while(|l| !l.starts_with("| layout |")).skip(2);
    let number = |cell: &str| cell.split(' ').next().and_then(|n| n.parse().ok());
    let row = |line: &str| {
        let cells = cells(line);
        Some((cells[1].clone(), number(&cells[2])?, number(&cells[6]), number(&cells[3])))
    };
    table.take_while(|l| l.starts_with('|')).filter_map(row).collect()
}

/// Set `RIJKE_WRITE` to write it anew after the record has changed.
#[test]
fn exact_the_figure_of_designs_shows_the_table_of_its_record() {
    let docs = example("..").join("docs");
    let rows = rows(&fs::read_to_string(docs.join("records/designs.md")).unwrap());
    assert!(rows.len() > 20, "{} rows", rows.len());
    let panel = |y: &str, of: &dyn Fn(&Row) -> Option<f64>| {
        let curve = |(k, (start, name)): (usize, &(&str, &str))| {
            let own = rows.iter().filter(|r| r.0.starts_with(start) && r.1 <= 20.0);
            PlotCurve::new(name, Look::Dots(k), own.filter_map(|r| Some([r.1, of(r)?])).collect())
        };
        PlotPanel::new("Rig time / h", y, KINDS.iter().enumerate().map(curve).collect())
    };
    let figure = Plot {
        title: "Layouts of a campaign: medians of five rigs".to_owned(),
        data: DataKind::Virtual,
        panels: vec![
            panel("Rms error of growth rates / s^{-1}", &|r| r.2),
            panel("ln Bayes factor, drags / nats", &|r| r.3),
        ],
    };
    assert!(figure.panels.iter().all(|p| p.curves[0].points.len() > 5));
    let (path, svg) = (docs.join("images/designs.svg"), plot_svg(&figure));
    if std::env::var_os("RIJKE_WRITE").is_some() {
        fs::write(&path, &svg).unwrap();
    }
    assert!(fs::read_to_string(&path).unwrap_or_default() == svg, "{} is of another table", path.display());
}
