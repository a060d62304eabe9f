//! The figure of an answer: any question, any factor. One table, one colour per series.

use super::map;
use rijke_draw::{Axis, COLUMN, DOT, Figure, INK, Key, Mark, Panel, Stroke, model_stroke, scale_stroke};
use rijke_engine::run::{Answer, AnswerPanel, Frame, FrameRow, Layer, LayerLook, symbol};
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
    let colours = Colours::of(answer);
    let tag = |k: usize| {
        if answer.panels.len() > 1 { format!("({})", char::from(b'a' + k as u8)) } else { String::new() }
    };
    let panels = answer
        .panels
        .iter()
        .enumerate()
        .map(|(k, p)| panel(answer, p, &tag(k), &colours, place.size))
        .collect();
    Some(Figure {
        title: answer.title.clone(),
        caption: answer.caption.clone(),
        columns: answer.panels.len().min(if answer.panels.len() == 3 { place.columns } else { 2 }),
        panels,
        legend: colours.legend(answer),
        data: kind,
    })
}

/// The colour of each series, in the order in which they appear.
struct Colours {
    names: Vec<String>,
}

impl Colours {
    fn of(answer: &Answer) -> Self {
        let mut names: Vec<String> = Vec::new();
        for layer in answer.panels.iter().flat_map(|p| &p.layers).filter(|l| is_coloured(l.look, answer)) {
            for row in layer.rows(&answer.frames[layer.frame]) {
                if !names.contains(&row.series) {
                    names.push(row.series.clone());
                }
            }
        }
        // Series of one factor, and numbers of microphones, stand in the order of their values.
        if names.iter().all(|n| value(n).is_some()) {
            names.sort_by(|a, b| value(a).unwrap_or(0.0).total_cmp(&value(b).unwrap_or(0.0)));
        }
        Self { names }
    }

    fn place(&self, series: &str) -> Option<usize> {
        self.names.iter().position(|n| n == series)
    }

    /// Ordered series have ordered colours.
    fn stroke(&self, series: &str) -> Stroke {
        match self.place(series) {
            Some(k) if self.names.len() > 2 && value(series).is_some() => {
                scale_stroke(k, self.names.len(), 1.4)
            }
            Some(k) => model_stroke(k),
            None => Stroke::solid(INK, 1.2),
        }
    }

    fn legend(&self, answer: &Answer) -> Vec<Key> {
        let mut keys: Vec<Key> = Vec::new();
        let dots = |l: &&Layer| l.look == LayerLook::Dots;
        let all = || answer.panels.iter().flat_map(|p| &p.layers);
        if all().filter(dots).any(|l| !is_coloured(l.look, answer)) {
            let label = if all().any(|l| l.look == LayerLook::Ellipse) { "prior mean" } else { "measured" };
            keys.push(Key { mark: Mark::Dot(INK), label: label.into() });
        }
        for name in &self.names {
            let stroke = self.stroke(name);
            let line = all().any(|l| l.look != LayerLook::Dots);
            let mark = if line { Mark::Line(stroke) } else { Mark::Dot(stroke.colour) };
            let label = match name.split_once(" = ") {
                Some((factor, rest)) => format!("{} = {rest}", symbol(factor)),
                None => name.clone(),
            };
            keys.push(Key { mark, label });
        }
        keys
    }
}

/// The number in the name of a series, `Q_h = 7 W` or `3 microphones`.
fn value(series: &str) -> Option<f64> {
    let after = series.split_once(" = ").map_or(series, |(_, after)| after);
    after.split(' ').next()?.parse().ok()
}

/// Everything but dots has the colour of its series; dots have where nothing else says which series is which.
fn is_coloured(look: LayerLook, answer: &Answer) -> bool {
    let mut layers = answer.panels.iter().flat_map(|p| &p.layers);
    look != LayerLook::Dots || !layers.any(|l| !matches!(l.look, LayerLook::Dots | LayerLook::Band))
}

fn panel(answer: &Answer, panel: &AnswerPanel, tag: &str, colours: &Colours, size: [f64; 2]) -> Panel {
    let number = |row: &FrameRow, column: usize| row.values.get(column).copied().flatten();
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    for layer in &panel.layers {
        for row in layer.rows(&answer.frames[layer.frame]) {
            let (Some(x), Some(y)) = (number(row, layer.x), number(row, layer.y)) else { continue };
            let half = match (layer.look, layer.sd) {
                (LayerLook::Ellipse, Some(c)) => {
                    let variance = |k: usize| number(row, c - k).map_or(0.0, f64::sqrt);
                    [2.0 * variance(2), 2.0 * variance(1)]
                }
                _ => [0.0, layer.sd.and_then(|k| number(row, k)).map_or(0.0, |sd| 2.0 * sd)],
            };
            xs.push((x, half[0]));
            ys.push((y, half[1]));
        }
    }
    let x_axis = Axis::covering(&panel.x, spans(&xs));
    let y_axis = Axis::covering(&panel.y, spans(&ys));
    let dash = 0.012 * (x_axis.high - x_axis.low);
    let mut drawn = Panel::new(tag, size, x_axis, y_axis);
    for layer in &panel.layers {
        draw(
            &mut drawn,
            &answer.frames[layer.frame],
            layer,
            is_coloured(layer.look, answer).then_some(colours),
            dash,
        );
    }
    drawn
}

/// The ends of every value with its error; an error larger than all values are apart does not stretch the
/// axis.
fn spans(values: &[(f64, f64)]) -> Vec<f64> {
    let [low, high] = range(values.iter().map(|v| v.0));
    let room = if high > low && values.len() > 2 { high - low } else { f64::INFINITY };
    values.iter().flat_map(|(v, half)| [v - half.min(room), v + half.min(room)]).collect()
}

fn draw<'a>(panel: &mut Panel, frame: &'a Frame, layer: &'a Layer, colours: Option<&Colours>, dash: f64) {
    let number = |row: &FrameRow, column: usize| row.values.get(column).copied().flatten();
    let stroke = |row: &FrameRow| colours.map_or(Stroke::solid(INK, 1.2), |c| c.stroke(&row.series));
    let rows: Vec<&FrameRow> = layer.rows(frame).collect();
    // No line leads from one mode to another.
    let mut series: Vec<[&str; 2]> = rows.iter().map(|r| [r.series.as_str(), r.mode.as_str()]).collect();
    match layer.look {
        LayerLook::Dots => {
            let all = || {
                let at = |row: &&'a FrameRow| Some(([number(row, layer.x)?, number(row, layer.y)?], *row));
                rows.iter().filter_map(at)
            };
            for (at, row) in all() {
                if let Some(sd) = layer.sd.and_then(|k| number(row, k)) {
                    panel.error_bar(at, 2.0 * sd, &Stroke::solid(stroke(row).colour, 1.0));
                }
            }
            for ([x, y], row) in all() {
                let Stroke { colour, .. } = stroke(row);
                panel.dot([x, y], DOT, colour, &format!("{}: {y:.4}", row.label));
            }
        }
        LayerLook::Dashes => {
            let mut rows = rows;
            rows.sort_by(|a, b| a.series.cmp(&b.series));
            for row in rows {
                if let (Some(x), Some(y)) = (number(row, layer.x), number(row, layer.y)) {
                    panel.curve(&[[x - dash, y], [x + dash, y]], &stroke(row));
                }
            }
        }
        LayerLook::Line | LayerLook::Band => {
            series.sort_unstable();
            series.dedup();
            for [name, mode] in series {
                let mut rows: Vec<(f64, f64, f64, &FrameRow)> = rows
                    .iter()
                    .copied()
                    .filter(|r| r.series == name && r.mode == mode)
                    .filter_map(|r| {
                        let sd = layer.sd.and_then(|k| number(r, k)).unwrap_or(0.0);
                        Some((number(r, layer.x)?, number(r, layer.y)?, sd, r))
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
                let all = [layer.x, layer.y, c - 2, c - 1, c].map(|k| number(row, k));
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
