//! Figures of answers, from tables made by hand.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use rijke_engine::run::{Answer, AnswerPanel, Frame, FrameColumn, FrameRow, Layer, LayerLook};
use rijke_report::answer_svg;

/// Four points of two series.
pub(crate) fn answer(look: LayerLook) -> Answer {
    let columns = ["x", "y", "y_sd"].map(|name| FrameColumn::new(name, name, "1")).to_vec();
    let row = |k: usize| FrameRow {
        label: format!("p{k}"),
        series: if k < 2 { "Q = 7 W".into() } else { "Q = 50 W".into() },
        values: vec![Some(k as f64), Some(2.0 * k as f64), if k == 1 { None } else { Some(0.1) }],
        ..FrameRow::default()
    };
    Answer {
        id: "question".into(),
        title: "What & how".into(),
        caption: "c".into(),
        parameters: Vec::new(),
        frames: vec![Frame { columns, rows: (0..4).map(row).collect() }],
        panels: vec![AnswerPanel {
            x: "x".into(),
            y: "y".into(),
            layers: vec![Layer { frame: 0, look, x: 0, y: 1, sd: Some(2), mode: None }],
        }],
    }
}

/// A map over three values of two factors, of two modes.
fn map(growth: &dyn Fn(f64, f64) -> f64) -> Answer {
    let columns = ["x", "y", "growth_rate", "growth_rate_sd"].map(|name| FrameColumn::new(name, name, "1"));
    let row = |label: &str, mode: &str, values: &[f64]| FrameRow {
        label: label.into(),
        series: String::new(),
        mode: mode.into(),
        values: values.iter().map(|v| Some(*v).filter(|v| v.is_finite())).collect(),
    };
    let node = |k: usize, mode: &str, below: f64| {
        let (x, y) = ((k % 3) as f64, (k / 3) as f64);
        row("node", mode, &[x, y, growth(x, y) - below, 0.3])
    };
    let nodes = (0..9).flat_map(|k| [node(k, "1", 0.0), node(k, "2", 5.0)]).collect();
    let others = |row| Frame { columns: columns[..2].to_vec(), rows: vec![row] };
    let frames = vec![
        Frame { rows: nodes, columns: columns.to_vec() },
        others(row("p0", "trained", &[1.0, 1.0])),
        others(row("stable: x", "", &[2.0, 2.0])),
    ];
    let panels = [LayerLook::GrowthMap, LayerLook::ChanceMap].map(|look| AnswerPanel {
        x: "x".into(),
        y: "y".into(),
        layers: [(look, Some(3)), (LayerLook::Dots, None), (LayerLook::Cross, None)]
            .into_iter()
            .enumerate()
            .map(|(frame, (look, sd))| Layer { frame, look, x: 0, y: 1, sd, mode: None })
            .collect(),
    });
    Answer { frames, panels: panels.to_vec(), ..answer(LayerLook::Dots) }
}

#[test]
fn behaviour_every_look_is_drawn_without_holes_in_the_text() {
    for (look, drawn) in [
        (LayerLook::Dots, "<circle"),
        (LayerLook::Dashes, "<path"),
        (LayerLook::Line, "<path"),
        (LayerLook::Band, "fill-opacity"),
    ] {
        let svg = answer_svg(None, &answer(look)).unwrap();
        assert!(svg.contains(drawn) && svg.contains("computed, no data") && !svg.contains("NaN"), "{look:?}");
        assert!(svg.contains("= 7 W") && svg.contains("= 50 W"), "{look:?}");
    }
    for (growth, words) in [
        (&(|x: f64, y: f64| x + y - 2.5) as &dyn Fn(f64, f64) -> f64, "boundary of stability"),
        (&|_, _| -3.0, ">2.3 %<"),
        (&|x, y| if x + y > 3.5 { 0.1 } else { -3.0 }, "97.7 %"),
        (&|x, y| if x + y < 0.5 { f64::NAN } else { x - 1.0 }, "boundary of stability"),
    ] {
        let map = answer_svg(None, &map(growth)).unwrap();
        assert!(map.contains(words) && map.contains("stable: x") && !map.contains("NaN"), "{map}");
        assert!(rijke_draw::pdf(&map).unwrap().starts_with(b"%PDF"));
    }
    // The colours of each panel stand beside it, and the legend has no sentence of them.
    let svg = answer_svg(None, &map(&|x, y| x + y - 2.5)).unwrap();
    assert!(svg.contains("(b) Probability of instability") && !svg.contains("(b) 50 %"), "{svg}");
    assert_eq!(svg.matches("stroke-width=\"0.5\"").count(), 5 + 6, "two bars of colours: {svg}");
    // Modes of one point lie far apart: no line leads from one to another, and each has a panel.
    let mut two = answer(LayerLook::Line);
    two.frames[0].rows = (0..4)
        .map(|k| FrameRow {
            mode: (k % 2).to_string(),
            values: [(k / 2) as f64, 100.0 * (k % 2) as f64 + (k / 2) as f64, 0.1].map(Some).to_vec(),
            ..FrameRow::default()
        })
        .collect();
    two.panels = ["0", "1"]
        .map(|mode| {
            let mut panel = two.panels[0].clone();
            panel.layers[0].mode = Some(mode.to_owned());
            panel
        })
        .to_vec();
    let svg = answer_svg(None, &two).unwrap();
    assert!(svg.contains(">101<") || svg.contains(">101.0<"), "{svg}");
    assert_eq!(svg.matches("stroke=\"#0072b2\"").count(), 3, "two lines of one step, and the legend: {svg}");
    let nothing = Answer { panels: Vec::new(), ..answer(LayerLook::Dots) };
    assert!(answer_svg(None, &nothing).is_none());
}

/// Measured modes over x at two powers, and two models as short lines.
fn competition(powers: [f64; 2]) -> Answer {
    let columns = ["x", "Q", "growth_rate", "growth_rate_sd"];
    let units = ["m", "W", "1/s", "1/s"];
    let column = |k: usize| FrameColumn::new(columns[k], columns[k], units[k]);
    let measured = |k: usize| FrameRow {
        label: format!("p{k}"),
        series: "hot".into(),
        values: [(k / 2) as f64, powers[k % 2], k as f64, 0.1].map(Some).to_vec(),
        ..FrameRow::default()
    };
    let predicted = |(k, series): (usize, &str)| FrameRow {
        label: format!("p{k}"),
        series: series.into(),
        values: [(k / 2) as f64, k as f64 + 0.5].map(Some).to_vec(),
        ..FrameRow::default()
    };
    let models = ["one law", "another"].into_iter().flat_map(|m| (0..4).map(move |k| (k, m)));
    let frames = vec![
        Frame { columns: (0..4).map(column).collect(), rows: (0..4).map(measured).collect() },
        Frame { columns: [0, 2].map(column).to_vec(), rows: models.map(predicted).collect() },
    ];
    let layer = |frame, look, y, sd| Layer { frame, look, x: 0, y, sd, mode: None };
    let layers = vec![layer(1, LayerLook::Dashes, 1, None), layer(0, LayerLook::Dots, 2, Some(3))];
    let panels = vec![AnswerPanel { x: "x".into(), y: "y".into(), layers }];
    Answer { frames, panels, ..answer(LayerLook::Dots) }
}

#[test]
fn behaviour_points_of_one_place_have_symbols_of_their_own() {
    let svg = answer_svg(None, &competition([50.0, 130.0])).unwrap();
    // Circles at 50 W, squares at 130 W, each named; models are open symbols around short lines.
    for (k, drawn) in ["circle", "path", "circle", "path"].into_iter().enumerate() {
        assert!(svg.contains(&format!("<title>p{k}: {k}.0000</title></{drawn}>")), "p{k}: {svg}");
    }
    for words in ["= 50 W", "= 130 W", ">filled: measured; bars: two standard deviations<", ">one law<"] {
        assert!(svg.contains(words), "no {words} in {svg}");
    }
    assert!(rijke_draw::pdf(&svg).unwrap().starts_with(b"%PDF"));
    // Points that differ by their place need no telling apart; the legend then shows what the panel has.
    let alike = answer_svg(None, &competition([50.0, 50.0])).unwrap();
    assert!(!alike.contains("= 50 W") && alike.contains("M8.5 0H17.5") && !alike.contains("M5.5 0H20.5"));
}

#[test]
fn behaviour_lines_that_coincide_are_drawn_once() {
    let mut twice = answer(LayerLook::Line);
    let line = |series: &str, up: f64| {
        let row = |k: usize| FrameRow {
            label: format!("p{k}"),
            series: series.into(),
            values: [k as f64, k as f64 + up, 0.1].map(Some).to_vec(),
            ..FrameRow::default()
        };
        (0..4).map(row).collect::<Vec<_>>()
    };
    twice.frames[0].rows = [line("a", 0.0), line("b", 1.0), line("c", 0.005)].concat();
    let svg = answer_svg(None, &twice).unwrap();
    assert!(svg.contains(">2 lines that coincide: (1) a, (2) c<") && svg.contains(">b<"), "{svg}");
}

#[test]
fn behaviour_what_is_missed_is_read_from_zero_and_bars_lie_within_the_panel() {
    let mut missed = answer(LayerLook::Dots);
    missed.frames[0].columns[1].name = "growth_rate_missed".into();
    for (k, row) in missed.frames[0].rows.iter_mut().enumerate() {
        row.values = [k as f64, 2.0 + 0.1 * k as f64, 0.8].map(Some).to_vec();
    }
    let svg = answer_svg(None, &missed).unwrap();
    assert!(svg.contains("stroke=\"#bbb\""), "a line at zero: {svg}");
    assert!(svg.contains(">bars: two standard deviations<"), "{svg}");
    // 2.3 and twice 0.8: the ticks reach it.
    assert!(svg.contains(">3<") || svg.contains(">3.0<"), "{svg}");
}
