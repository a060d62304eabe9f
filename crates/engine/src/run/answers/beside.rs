//! What is found of a trained model beside its evidence, as tables and figures: residuals, points given all
//! others, gains of further terms along the rig.

use super::super::found::{Asked, Checks, Missing, PointCheck};
use super::super::frame::{Frame, FrameColumn, FrameRow};
use super::super::record::{MeasuredRecord, StageRecord};
use super::answer::{Answer, AnswerPanel, Layer, LayerLook};
use super::axes::{axis_label, factor_column};
use rijke_study::Factor;

/// Every point given all others, as a table.
#[must_use]
pub fn left_out_table(checks: &Checks) -> Frame {
    let columns = [
        ("ln_left_out", "ln density given all others", "1"),
        ("ahead", "nats ahead of the rival", "1"),
        ("shift", "shift of the parameters", "1"),
    ];
    let row = |p: &PointCheck| FrameRow {
        label: p.point.clone(),
        series: if p.doubtful { "doubtful".to_owned() } else { String::new() },
        values: vec![p.ln_left_out, p.ahead, Some(p.shift)],
        ..FrameRow::default()
    };
    Frame {
        columns: columns.map(|(name, label, unit)| FrameColumn::new(name, label, unit)).to_vec(),
        rows: checks.points.iter().map(row).collect(),
    }
}

/// The residuals of a stage over every factor that varies, and over the frequency; none where nothing varies.
/// `factors` are those of the campaign.
#[must_use]
pub fn residuals_over_factors(factors: &[Factor], stage: &StageRecord) -> Option<Answer> {
    let checks = stage.checks.as_ref()?;
    let mut columns: Vec<FrameColumn> = factors.iter().map(factor_column).collect();
    columns.push(FrameColumn::new("frequency", "Frequency", "Hz"));
    columns.push(FrameColumn::new("residual", "Residual, given all other points", "1"));
    let last = columns.len() - 1;
    let row = |(m, r): (&MeasuredRecord, &[Option<f64>; 2]), k: usize| {
        let frequency = m.angular_frequency.map(|[v, _]| rijke_study::hertz(v));
        let mut values = m.factors.clone();
        values.extend([frequency, r[k]]);
        let series = ["growth rate", "frequency"][k].to_owned();
        FrameRow { label: m.point.clone(), series, mode: m.mode.clone(), values }
    };
    let both = || stage.measured.iter().zip(&checks.residuals);
    let rows: Vec<FrameRow> = (0..2).flat_map(|k| both().map(move |pair| row(pair, k))).collect();
    let varies = |k: &usize| {
        let mut values = rows.iter().filter_map(|r| r.values[*k]);
        let first = values.next();
        values.any(|v| Some(v) != first)
    };
    let shown: Vec<usize> = (0..last).filter(varies).collect();
    let layer = |k: usize| Layer { frame: 0, look: LayerLook::Dots, x: k, y: last, sd: None, mode: None };
    let panel = |&k: &usize| AnswerPanel {
        x: axis_label(&columns[k]),
        y: "Residual / sd".to_owned(),
        layers: vec![layer(k)],
    };
    let panels: Vec<AnswerPanel> = shown.iter().map(panel).collect();
    (!panels.is_empty()).then(|| Answer {
        id: format!("{}-residuals", stage.id),
        title: format!("{}: residuals over every factor", stage.title),
        caption:
            "What was measured less what all other points predict, in standard deviations of this prediction."
                .to_owned(),
        parameters: Vec::new(),
        frames: vec![Frame { columns: columns.clone(), rows: rows.clone() }],
        panels,
    })
}

/// The best terms at ends and parts that the caption of gains along the rig names, at most.
const PARTS: usize = 5;

/// The gain of each kind of effect along the rig, and the most that chance gives. Those at ends, and at parts
/// that may move, are in the caption.
#[must_use]
pub fn gains_along(stage: &StageRecord, missing: &Missing) -> Answer {
    let columns = [("x", "Place", "m"), ("gain", "Expected gain", "nats")];
    let columns = columns.map(|(name, label, unit)| FrameColumn::new(name, label, unit)).to_vec();
    let row = |label: &str, series: &str, x: f64, gain: f64| FrameRow {
        label: label.to_owned(),
        series: series.to_owned(),
        values: vec![Some(x), Some(gain)],
        ..FrameRow::default()
    };
    // Ends and parts that move have no one place along the rig.
    let along = |a: &&Asked| a.place.starts_with("x = ");
    let at = || missing.best.iter().filter(along).filter_map(|a| Some((a, a.x?)));
    let mut rows: Vec<FrameRow> = at().map(|(a, x)| row(&a.words(), &a.effect, x, a.gain)).collect();
    let last = at().map(|(_, x)| x).fold(0.0, f64::max);
    rows.extend([0.0, last].map(|x| row("by chance", "by chance: 95 % level", x, missing.by_chance)));
    let parts: Vec<String> = missing
        .best
        .iter()
        .filter(|a| !along(a))
        .take(PARTS)
        .map(|a| format!("{} at {} {:.1}", a.effect, a.place, if a.gain.abs() < 0.05 { 0.0 } else { a.gain }))
        .collect();
    let parts = match &parts[..] {
        [] => String::new(),
        best => format!(" At ends and parts, in nats: {}.", best.join(", ")).replace(" -", " \u{2212}"),
    };
    Answer {
        id: format!("{}-missing", stage.id),
        title: format!("{}: what the data still ask for", stage.title),
        caption: format!(
            "Expected gain in ln evidence of one more term of each kind at each place, in proportion to whichever factor gains most at that place. A \
             term describes what is missing, and is no cause.{parts}"
        ),
        parameters: Vec::new(),
        frames: vec![Frame { columns, rows }],
        panels: vec![AnswerPanel {
            x: "*x* / m".to_owned(),
            y: "Expected gain / nats".to_owned(),
            layers: vec![Layer { frame: 0, look: LayerLook::Line, x: 0, y: 1, sd: None, mode: None }],
        }],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_point_that_alone_decides_is_doubtful_in_the_table() {
        let point = |name: &str, ln: Option<f64>, doubtful: bool| PointCheck {
            point: name.into(),
            ln_left_out: ln,
            ahead: Some(0.5),
            shift: 2.0,
            doubtful,
        };
        let points = vec![point("a", Some(-3.0), false), point("b", None, true)];
        let checks = Checks { rival: None, points, residuals: Vec::new(), sums: Vec::new() };
        let table = left_out_table(&checks);
        assert_eq!(table.numbers(0), [Some(-3.0), None]);
        assert_eq!([table.rows[0].series.as_str(), &table.rows[1].series], ["", "doubtful"]);
    }

    #[test]
    fn exact_parts_that_move_are_no_place_of_the_curve() {
        let term = |place: &str, x: f64, gain: f64| Asked {
            effect: "leak".into(),
            place: place.into(),
            x: Some(x),
            times: String::new(),
            strength: [0.1, 0.01],
            unit: "1".into(),
            prior_sd: 0.1,
            gain,
            probability: 0.5,
            moves: [0.0; 2],
        };
        let best = vec![
            term("rods, end", 0.5, 12.34),
            term("x = 0.300 m", 0.3, 2.0),
            term("upstream end", 0.0, -0.04),
        ];
        let missing = Missing { tried: 3, by_chance: 3.0, families: Vec::new(), best, laws: Vec::new() };
        let stage = r#"{"id": "s", "title": "S", "measured": [], "models": [], "winner": "", "chosen": "", "decides": 3}"#;
        let stage: StageRecord = serde_json::from_str(stage).unwrap();
        let answer = gains_along(&stage, &missing);
        let places = answer.frames[0].numbers(0);
        assert_eq!(places, [Some(0.3), Some(0.0), Some(0.3)], "one term, and the level by chance");
        assert!(
            answer.caption.ends_with("in nats: leak at rods, end 12.3, leak at upstream end 0.0."),
            "{}",
            answer.caption
        );
    }
}
