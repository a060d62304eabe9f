//! The figure of an answer: any question, any factor. One table, one colour per series.

use super::groups::Groups;
use super::map;
use super::series::{Series, is_coloured};
use rijke_draw::{Axis, COLUMN, DOT, Figure, INK, Panel, Stroke};
use rijke_engine::run::{Answer, AnswerPanel, Frame, FrameRow, Layer, LayerLook};
use rijke_numerics::range;
use rijke_rig::DataKind;

/// Where a figure will be seen.
pub(super) struct Place {
    /// Size of a panel, pixels.
    size: [f64; 2],
    /// Panels in a row at most.
    columns: usize,
}

/// The page of the study.
pub(super) const PAGE: Place = Place { size: [520.0, 360.0], columns: 3 };
/// A journal, of two columns.
pub(super) const PAPER: Place = Place { size: [COLUMN, 300.0], columns: 2 };

/// Radius of the open symbol of a prediction, which lies around that of what was measured.
const RING: f64 = DOT + 1.4;

/// Of more ellipses than these the inner one is drawn alone.
const FEW: usize = 8;

/// The figure of an answer; none where there is nothing to draw.
pub(super) fn of(kind: Option<DataKind>, answer: &Answer, place: &Place) -> Option<Figure> {
    if answer.panels.is_empty() {
        return None;
    }
    let answer = &answer.in_print();
    if map::is_one(answer) {
        return Some(map::of(kind, answer, place.size));
    }
    let series = Series::of(answer);
    let groups = Groups::of(answer, is_coloured(LayerLook::Dots, answer));
    let tag = |k: usize| {
        if answer.panels.len() > 1 { format!("({})", char::from(b'a' + k as u8)) } else { String::new() }
    };
    let panels = answer
        .panels
        .iter()
        .enumerate()
        .map(|(k, p)| panel(answer, p, &tag(k), (&series, &groups), place.size))
        .collect();
    Some(Figure {
        title: answer.title.clone(),
        caption: answer.caption.clone(),
        columns: answer.panels.len().min(if answer.panels.len() == 3 { place.columns } else { 2 }),
        panels,
        legend: series.legend(answer, &groups),
        data: kind,
    })
}

fn panel(
    answer: &Answer,
    panel: &AnswerPanel,
    tag: &str,
    (series, groups): (&Series, &Groups),
    size: [f64; 2],
) -> Panel {
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    for layer in &panel.layers {
        for row in layer.rows(&answer.frames[layer.frame]) {
            let (Some(x), Some(y)) = (row.number(layer.x), row.number(layer.y)) else { continue };
            let half = match (layer.look, layer.sd) {
                (LayerLook::Ellipse, Some(c)) => {
                    let variance = |k: usize| row.number(c - k).map_or(0.0, f64::sqrt);
                    [2.0 * variance(2), 2.0 * variance(1)]
                }
                _ => [0.0, layer.sd.and_then(|k| row.number(k)).map_or(0.0, |sd| 2.0 * sd)],
            };
            xs.push((x, half[0]));
            ys.push((y, half[1]));
        }
    }
    let x_axis = Axis::covering(&panel.x, spans(&xs));
    let mut ys = spans(&ys);
    // What is missed is read from zero.
    if panel.layers.iter().any(|l| is_residual(&answer.frames[l.frame], l)) {
        ys.push(0.0);
    }
    let y_axis = Axis::covering(&panel.y, ys);
    let dash = 0.012 * (x_axis.high - x_axis.low);
    let has_zero = y_axis.low < 0.0 && y_axis.high > 0.0;
    let mut drawn = Panel::new(tag, size, x_axis, y_axis);
    if has_zero {
        drawn.horizontal(0.0, &ZERO);
    }
    for layer in &panel.layers {
        let colours = is_coloured(layer.look, answer).then_some(series);
        draw(&mut drawn, &answer.frames[layer.frame], layer, (colours, groups), dash);
    }
    drawn
}

/// The line at zero.
const ZERO: Stroke = Stroke::solid("#bbb", 1.0);

/// Whether a layer shows what a model misses.
fn is_residual(frame: &Frame, layer: &Layer) -> bool {
    frame.columns.get(layer.y).is_some_and(|c| c.name == "residual" || c.name.ends_with("_missed"))
}

/// The ends of every value with its error. A few errors that are far larger than the others and than all
/// values are apart do not stretch the axis.
fn spans(values: &[(f64, f64)]) -> Vec<f64> {
    let [low, high] = range(values.iter().map(|v| v.0));
    let mut halves: Vec<f64> = values.iter().map(|v| v.1).collect();
    halves.sort_by(f64::total_cmp);
    let usual = halves.get(halves.len() / 2).copied().unwrap_or(0.0);
    let room = if high > low && values.len() > 2 { (high - low).max(3.0 * usual) } else { f64::INFINITY };
    values.iter().flat_map(|(v, half)| [v - half.min(room), v + half.min(room)]).collect()
}

fn draw<'a>(
    panel: &mut Panel,
    frame: &'a Frame,
    layer: &'a Layer,
    (colours, groups): (Option<&Series>, &Groups),
    dash: f64,
) {
    let stroke = |row: &FrameRow| colours.map_or(Stroke::solid(INK, 1.2), |c| c.stroke(&row.series));
    let rows: Vec<&FrameRow> = layer.rows(frame).collect();
    match layer.look {
        LayerLook::Dots => {
            let all = || {
                let at = |row: &&'a FrameRow| Some(([row.number(layer.x)?, row.number(layer.y)?], *row));
                rows.iter().filter_map(at)
            };
            for (at, row) in all() {
                if let Some(sd) = layer.sd.and_then(|k| row.number(k)) {
                    panel.error_bar(at, 2.0 * sd, &Stroke::solid(stroke(row).colour, 1.0));
                }
            }
            for ([x, y], row) in all() {
                let (Stroke { colour, .. }, symbol) = (stroke(row), groups.symbol(&row.label));
                panel.point([x, y], DOT, symbol, colour, &format!("{}: {y:.4}", row.label));
            }
        }
        LayerLook::Dashes => {
            let mut rows = rows;
            rows.sort_by(|a, b| a.series.cmp(&b.series));
            for row in rows {
                if let (Some(x), Some(y)) = (row.number(layer.x), row.number(layer.y)) {
                    panel.curve(&[[x - dash, y], [x + dash, y]], &stroke(row));
                    if groups.any() {
                        panel.ring([x, y], RING, groups.symbol(&row.label), &stroke(row));
                    }
                }
            }
        }
        LayerLook::Line | LayerLook::Band => {
            // No line leads from one mode to another, or from one group of points to another.
            let of = |r: &FrameRow| (r.series.clone(), r.mode.clone(), groups.of_point(&r.label));
            let mut lines: Vec<(String, String, usize)> = rows.iter().map(|r| of(r)).collect();
            lines.sort_unstable();
            lines.dedup();
            for line in lines.iter().filter(|l| colours.is_none_or(|c| c.is_drawn(&l.0))) {
                let mut rows: Vec<(f64, f64, f64, &FrameRow)> = rows
                    .iter()
                    .copied()
                    .filter(|r| of(r) == *line)
                    .filter_map(|r| {
                        let sd = layer.sd.and_then(|k| r.number(k)).unwrap_or(0.0);
                        Some((r.number(layer.x)?, r.number(layer.y)?, sd, r))
                    })
                    .collect();
                rows.sort_by(|a, b| a.0.total_cmp(&b.0));
                let Some((.., first)) = rows.first() else { continue };
                let look = stroke(first);
                if layer.look == LayerLook::Band {
                    let band: Vec<[f64; 3]> =
                        rows.iter().map(|r| [r.0, r.1 - 2.0 * r.2, r.1 + 2.0 * r.2]).collect();
                    panel.band(&band, look.colour, 0.25);
                }
                let line: Vec<[f64; 2]> = rows.iter().map(|r| [r.0, r.1]).collect();
                panel.curve(&line, &look);
            }
        }
        LayerLook::Cross | LayerLook::GrowthMap | LayerLook::ChanceMap => {}
        LayerLook::Ellipse => {
            let Some(c) = layer.sd else { return };
            for row in rows.iter().copied() {
                let all = [layer.x, layer.y, c - 2, c - 1, c].map(|k| row.number(k));
                let [Some(x), Some(y), Some(xx), Some(yy), Some(xy)] = all else { continue };
                let sizes: &[f64] = if rows.len() > FEW { &[1.0] } else { &[1.0, 2.0] };
                for &size in sizes {
                    let look = Stroke { width: if rows.len() > FEW { 0.7 } else { 1.6 }, ..stroke(row) };
                    panel.ellipse([x, y], [xx, yy, xy].map(|v| size * size * v), &look);
                }
            }
        }
    }
}
