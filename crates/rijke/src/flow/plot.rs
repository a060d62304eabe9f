//! Pictures of the base flow, and of a filter on its way.

use super::document::Document;
use crate::failure::{Classify, Failure};
use crate::figure::both;
use rijke_flow::assimilate::{CALIBRATION, RunReport, SnapshotReport};
use rijke_report::{Look, RecordCurve, RecordFigure, RecordPanel, gallery};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Writes `plots/index.html`, Fig. 2, and a figure for every run of a filter. `beside` has the batch fits of
/// the same runs.
pub(super) fn write(document: &Document, beside: &[RunReport], folder: &Path) -> Result<(), Failure> {
    let folder = folder.join("plots");
    std::fs::create_dir_all(&folder).or_failed().map_err(|f| f.at(&folder))?;
    let mut page = String::new();
    let mut show = |name: &str, title: &str, svg: &str| -> Result<(), Failure> {
        both(&folder, name, svg)?;
        let _ = writeln!(page, "<h2>{title}</h2>\n<p><img src=\"{name}.svg\" alt=\"{title}\"></p>");
        Ok(())
    };
    if !document.runs.is_empty() {
        show("figure-2", "Velocity at the heater and speed of sound", &base_flow(document).svg())?;
    }
    let mut filtered = false;
    for run in document.runs.iter().filter(|r| !r.history.is_empty()) {
        filtered = true;
        let title = format!("Filter with the heater at {} m", run.heater_m);
        let batch = beside.iter().find(|b| b.heater_m == run.heater_m);
        let panels = panels(run, batch);
        let figure = RecordFigure { title: title.clone(), data: document.kind, panels };
        show(&format!("filter-{:02.0}", 100.0 * run.heater_m), &title, &figure.svg())?;
    }
    if filtered {
        page += &calibration();
    }
    let path = folder.join("index.html");
    std::fs::write(&path, gallery("Base flow", &page)).or_failed().map_err(|f| f.at(&path))
}

/// Fig. 2: velocity at the heater over its position, a curve per power, and the speed of sound along the tube
/// at the highest power.
fn base_flow(document: &Document) -> RecordFigure {
    let mut powers: Vec<f64> = document.runs.iter().flat_map(|r| &r.powers).map(|p| p.power_w).collect();
    powers.sort_by(f64::total_cmp);
    powers.dedup();
    let velocity = |(k, power): (usize, &f64)| {
        let at = |r: &RunReport| {
            Some([r.heater_m, r.powers.iter().find(|p| p.power_w == *power)?.heater_velocity])
        };
        curve(
            &format!("{power} W"),
            Look::Channel(k, powers.len()),
            document.runs.iter().filter_map(at).collect(),
        )
    };
    let highest = powers.last().copied().unwrap_or(0.0);
    let count = document.runs.len();
    let along = |(k, r): (usize, &RunReport)| {
        let points =
            r.powers.iter().find(|p| p.power_w == highest)?.profile.iter().map(|p| [p.x, p.sound_speed]);
        Some(curve("", Look::Channel(k, count), points.collect()))
    };
    let panel =
        |x: &str, y: &str, curves| RecordPanel { x: x.into(), y: y.into(), curves, marks: Vec::new() };
    RecordFigure {
        title: "Velocity at the heater and speed of sound".into(),
        data: document.kind,
        panels: vec![
            panel(
                "heater / m",
                "velocity at the heater / m s^{-1}",
                powers.iter().enumerate().map(velocity).collect(),
            ),
            panel(
                &format!("x / m, at {highest} W"),
                "speed of sound / m s^{-1}",
                document.runs.iter().enumerate().filter_map(along).collect(),
            ),
        ],
    }
}

/// The unknowns of the paper and U_h with two spreads, and the innovations, against time.
fn panels(run: &RunReport, batch: Option<&RunReport>) -> Vec<RecordPanel> {
    let hours = |s: &SnapshotReport| s.time / 3600.0;
    let ends = [run.history.first().map_or(0.0, hours), run.history.last().map_or(0.0, hours)];
    let changes = run.history.windows(2).filter(|w| w[0].power != w[1].power);
    let marks: Vec<f64> = changes.map(|w| hours(&w[0])).collect();
    let series = |label: &str, of: &dyn Fn(&SnapshotReport) -> [f64; 3], fitted: Option<[f64; 3]>| {
        let rows = run.history.iter().map(|s| (hours(s), of(s)));
        let mut curves = Vec::new();
        if let Some([low, value, high]) = fitted {
            let area = vec![[ends[0], low], [ends[1], low], [ends[1], high], [ends[0], high]];
            curves.push(curve("batch fit, 2 sd", Look::Patch(1), area));
            curves.push(curve("batch fit", Look::Channel(5, 7), vec![[ends[0], value], [ends[1], value]]));
        }
        let below = rows.clone().map(|(t, [low, ..])| [t, low]);
        let around = below.chain(rows.clone().rev().map(|(t, [.., high])| [t, high])).collect();
        curves.push(curve("filter, 2 spreads", Look::Patch(0), around));
        curves.push(curve("filter", Look::Fit, rows.map(|(t, [_, value, _])| [t, value]).collect()));
        panel(label, curves, &marks)
    };
    let mut panels: Vec<RecordPanel> = (0..6.min(run.unknowns.len()))
        .map(|k| {
            let u = &run.unknowns[k];
            let unit = if u.unit == "1" { String::new() } else { format!(" / {}", u.unit) };
            let label = format!("{}{unit}", u.name.replace('_', " "));
            let fitted = batch.map(|b| [b.unknowns[k].low, b.unknowns[k].value, b.unknowns[k].high]);
            series(&label, &|s| [s.band[k][0], s.value[k], s.band[k][1]], fitted)
        })
        .collect();
    let velocity = |s: &SnapshotReport| {
        let [mean, spread] = s.heater_velocity;
        [mean - 2.0 * spread, mean, mean + 2.0 * spread]
    };
    // The batch fit knows the settled states, one per power.
    let mut settled = series("*U*_{h} / m s^{-1}", &velocity, None);
    for p in batch.iter().flat_map(|b| &b.powers) {
        let at = |s: &&SnapshotReport| s.power == p.power_w;
        let times: Vec<f64> = run.history.iter().filter(at).map(hours).collect();
        if let (Some(&from), Some(&to)) = (times.first(), times.last()) {
            let points = vec![[from, p.heater_velocity], [to, p.heater_velocity]];
            settled.curves.push(curve("batch fit", Look::Channel(5, 7), points));
        }
    }
    panels.push(settled);
    let innovations = run.history.iter().map(|s| [hours(s), s.innovation_chi_squared]).collect();
    let one = curve("1, as it should be", Look::Record, vec![[ends[0], 1.0], [ends[1], 1.0]]);
    panels.push(panel(
        "innovations: *\u{3c7}*^{2} per datum",
        vec![one, curve("filter", Look::Fit, innovations)],
        &marks,
    ));
    panels
}

fn curve(name: &str, look: Look, points: Vec<[f64; 2]>) -> RecordCurve {
    RecordCurve { name: name.to_owned(), look, points }
}

fn panel(y: &str, curves: Vec<RecordCurve>, marks: &[f64]) -> RecordPanel {
    RecordPanel { x: "Time / h".to_owned(), y: y.to_owned(), curves, marks: marks.to_vec() }
}

/// What twin experiments say of the methods, as an HTML table.
fn calibration() -> String {
    let mut methods: Vec<(&str, &str)> = Vec::new();
    let mut cells: BTreeMap<(&str, &str), String> = BTreeMap::new();
    let mut quantities: Vec<&str> = Vec::new();
    for line in CALIBRATION.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [method, quantity, twins, coverage, _, scaled, ..] = fields[..] else { continue };
        if !methods.iter().any(|m| m.0 == method) {
            methods.push((method, twins));
        }
        if !quantities.contains(&quantity) {
            quantities.push(quantity);
        }
        cells.insert((method, quantity), format!("<td>{coverage}</td><td>{scaled}</td>"));
    }
    let mut text = String::from(
        "<h2>How far to trust the error bars</h2>\n<p>Twin experiments of the model itself with truth drawn from the prior, the paper's \
         staircase of powers, heater at 0.25 m: share of twins whose truth lies within two stated standard deviations (0.95 is right), and rms \
         error over the stated standard deviation (1 is right). A chi-squared of the innovations near 1 proves nothing.</p>\n<table>\n<tr><th></th>",
    );
    for (method, twins) in &methods {
        let _ = write!(text, "<th colspan=\"2\">{method}, {twins} twins</th>");
    }
    text += "</tr>\n";
    for quantity in quantities {
        let row: String = methods.iter().filter_map(|(m, _)| cells.get(&(m, quantity)).cloned()).collect();
        let _ = writeln!(text, "<tr><td>{quantity}</td>{row}</tr>");
    }
    text + "</table>\n"
}
