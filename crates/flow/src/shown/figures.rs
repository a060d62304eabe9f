//! Figures of inferred flows as numbers, each with the name of its file.

use crate::infer::assimilate::CALIBRATION;
use crate::infer::report::{RunReport, SnapshotReport};
use rijke_rig::{DataKind, Look, Plot, PlotCurve, PlotPanel};
use std::collections::BTreeMap;

/// Fig. 2 of the paper: velocity at the heater over its position, a curve per power, and the speed of sound
/// along the tube at the highest power. Name and figure; none without runs.
#[must_use]
pub fn base_flow(runs: &[RunReport], data: DataKind) -> Option<(String, Plot)> {
    let mut powers: Vec<f64> = runs.iter().flat_map(|r| &r.powers).map(|p| p.power_w).collect();
    powers.sort_by(f64::total_cmp);
    powers.dedup();
    let velocity = |(k, power): (usize, &f64)| {
        let at = |r: &RunReport| {
            Some([r.heater_m, r.powers.iter().find(|p| p.power_w == *power)?.heater_velocity])
        };
        PlotCurve::new(
            &format!("{power} W"),
            Look::Channel(k, powers.len()),
            runs.iter().filter_map(at).collect(),
        )
    };
    let highest = powers.last().copied().unwrap_or(0.0);
    // The speed of sound jumps at the heater, which tells the runs apart; colours are of powers.
    let along = |r: &RunReport| {
        let points =
            r.powers.iter().find(|p| p.power_w == highest)?.profile.iter().map(|p| [p.x, p.sound_speed]);
        Some(PlotCurve::new("", Look::Fit, points.collect()))
    };
    let title = "Velocity at the heater and speed of sound".into();
    let plot = || Plot {
        title,
        data,
        panels: vec![
            PlotPanel::new(
                "Place of the heater / m",
                "Velocity at the heater / m s^{-1}",
                powers.iter().enumerate().map(velocity).collect(),
            ),
            PlotPanel::new(
                "*x* / m",
                &format!("Speed of sound at {highest} W / m s^{{-1}}"),
                runs.iter().filter_map(along).collect(),
            ),
        ],
    };
    (!runs.is_empty()).then(|| ("figure-2".to_owned(), plot()))
}

/// A figure for every run of a filter; `beside` has the batch fits of the same runs.
#[must_use]
pub fn filters(runs: &[RunReport], beside: &[RunReport], data: DataKind) -> Vec<(String, Plot)> {
    let figure = |run: &RunReport| {
        let title = format!("Filter with the heater at {} m", run.heater_m);
        let panels = panels(run, beside.iter().find(|b| b.heater_m == run.heater_m));
        (format!("filter-{:02.0}", 100.0 * run.heater_m), Plot { title, data, panels })
    };
    runs.iter().filter(|r| !r.history.is_empty()).map(figure).collect()
}

/// The unknowns of the paper and U_h with two spreads, and the innovations, against time.
fn panels(run: &RunReport, batch: Option<&RunReport>) -> Vec<PlotPanel> {
    let hours = |s: &SnapshotReport| s.time / 3600.0;
    let ends = [run.history.first().map_or(0.0, hours), run.history.last().map_or(0.0, hours)];
    let changes = run.history.windows(2).filter(|w| w[0].power != w[1].power);
    let marks: Vec<f64> = changes.map(|w| hours(&w[0])).collect();
    let series = |label: &str, of: &dyn Fn(&SnapshotReport) -> [f64; 3], fitted: Option<[f64; 3]>| {
        let rows = run.history.iter().map(|s| (hours(s), of(s)));
        let mut curves = Vec::new();
        if let Some([low, value, high]) = fitted {
            let area = vec![[ends[0], low], [ends[1], low], [ends[1], high], [ends[0], high]];
            curves.push(PlotCurve::new("batch fit, two standard deviations", Look::Patch(1), area));
            let line = vec![[ends[0], value], [ends[1], value]];
            curves.push(PlotCurve::new("batch fit", Look::Channel(5, 7), line));
        }
        let below = rows.clone().map(|(t, [low, ..])| [t, low]);
        let around = below.chain(rows.clone().rev().map(|(t, [.., high])| [t, high])).collect();
        curves.push(PlotCurve::new("filter, two standard deviations", Look::Patch(0), around));
        let middle = rows.map(|(t, [_, value, _])| [t, value]).collect();
        curves.push(PlotCurve::new("filter", Look::Fit, middle));
        over_time(label, curves, &marks)
    };
    let mut panels: Vec<PlotPanel> = (0..6.min(run.unknowns.len()))
        .map(|k| {
            let u = &run.unknowns[k];
            let unit = if u.unit == "1" { String::new() } else { format!(" / {}", u.unit) };
            let label = format!("{}{unit}", in_print(&u.name));
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
            settled.curves.push(PlotCurve::new("batch fit", Look::Channel(5, 7), points));
        }
    }
    panels.push(settled);
    let innovations = run.history.iter().map(|s| [hours(s), s.innovation_chi_squared]).collect();
    let one = PlotCurve::new(
        "expected of the filter: 1",
        Look::Channel(0, 7),
        vec![[ends[0], 1.0], [ends[1], 1.0]],
    );
    let curves = vec![one, PlotCurve::new("filter", Look::Fit, innovations)];
    panels.push(over_time("*\u{3c7}*^{2} of innovations per datum", curves, &marks));
    panels
}

/// An unknown on an axis, with the symbol that the theory has for it.
fn in_print(name: &str) -> String {
    match name {
        "heater_drag" => "*C*_{d}, heater drag",
        "outer_nusselt" => "*\u{3b8}*_{o}, outer Nusselt number",
        "mount_resistance" => "*R*_{m}, mount resistance",
        "wall_share" => "*\u{3c6}*, wall share",
        "inner_nusselt" => "*n*_{1}, inner Nusselt number",
        "jet_enhancement" => "*n*_{2}, jet enhancement",
        other => return other.replace('_', " "),
    }
    .to_owned()
}

fn over_time(y: &str, curves: Vec<PlotCurve>, marks: &[f64]) -> PlotPanel {
    PlotPanel { marks: marks.to_vec(), ..PlotPanel::new("Time / h", y, curves) }
}

/// What twin experiments say of the error bars of each method.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FlowCalibration {
    /// Name of each method, and number of its twins.
    pub methods: Vec<(&'static str, &'static str)>,
    /// Name of each quantity; for each method that has it the share of twins within two standard deviations,
    /// and the rms error over the standard deviation.
    pub quantities: Vec<(&'static str, Vec<[&'static str; 2]>)>,
}

impl FlowCalibration {
    /// What the twins were.
    pub const CAPTION: &'static str = "Twin experiments of the model itself with truth drawn from the prior, the paper's \
         staircase of powers, heater at 0.25 m: share of twins whose truth lies within two stated standard deviations (0.95 is right), and rms \
         error over the stated standard deviation (1 is right). A chi-squared of the innovations near 1 proves nothing.";

    /// As measured (docs/records/flow.md).
    #[must_use]
    pub fn measured() -> Self {
        let mut methods: Vec<(&str, &str)> = Vec::new();
        let mut names: Vec<&str> = Vec::new();
        let mut cells: BTreeMap<(&str, &str), [&str; 2]> = BTreeMap::new();
        for line in CALIBRATION.lines().skip(1) {
            let fields: Vec<&str> = line.split(',').collect();
            let [method, quantity, twins, coverage, _, scaled, ..] = fields[..] else { continue };
            if !methods.iter().any(|m| m.0 == method) {
                methods.push((method, twins));
            }
            if !names.contains(&quantity) {
                names.push(quantity);
            }
            cells.insert((method, quantity), [coverage, scaled]);
        }
        let row = |name: &&'static str| {
            (*name, methods.iter().filter_map(|(m, _)| cells.get(&(*m, *name)).copied()).collect())
        };
        let quantities = names.iter().map(row).collect();
        Self { methods, quantities }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_method_says_how_far_its_error_bars_are_right() {
        let found = FlowCalibration::measured();
        assert!(found.methods.len() == 2 && found.quantities.len() >= 6, "{found:?}");
        let batch = found.methods.iter().position(|m| m.0 == "batch").unwrap();
        for (name, cells) in &found.quantities {
            let share: f64 = cells[batch][0].parse().unwrap();
            assert!((0.85..=1.0).contains(&share), "{name}: {share}");
        }
    }

    #[test]
    fn exact_a_run_of_a_filter_has_a_figure_and_a_fit_has_none() {
        let at = |time: f64, power: f64| SnapshotReport {
            time,
            power,
            value: Vec::new(),
            band: Vec::new(),
            heater_velocity: [0.5, 0.01],
            innovation_chi_squared: 1.1,
        };
        let history = vec![at(0.0, 0.0), at(3600.0, 30.0), at(7200.0, 30.0)];
        let filtered = RunReport { heater_m: 0.25, history, ..RunReport::empty() };
        let figures = filters(&[RunReport::empty(), filtered.clone()], &[], DataKind::Virtual);
        assert_eq!((figures.len(), figures[0].0.as_str()), (1, "filter-25"));
        let [velocity, innovations] = &figures[0].1.panels[..] else { panic!("{figures:?}") };
        assert_eq!(velocity.marks, [0.0]);
        assert_eq!(in_print("outer_nusselt"), "*\u{3b8}*_{o}, outer Nusselt number");
        assert_eq!(innovations.curves[1].points, [[0.0, 1.1], [1.0, 1.1], [2.0, 1.1]]);
        assert!(
            base_flow(&[], DataKind::Virtual).is_none()
                && base_flow(&[filtered], DataKind::Virtual).is_some()
        );
    }
}
