//! Series of a figure: the colour of each, those that cannot be seen apart, and the legend.

use super::groups::{Groups, factors_of};
use rijke_draw::{INK, Key, Mark, Stroke, Symbol, model_stroke, scale_stroke};
use rijke_engine::run::{Answer, AnswerPanel, FrameRow, Layer, LayerLook, symbol};
use rijke_numerics::range;

/// Curves nearer than this share of the range of an axis are one line to the eye.
const ONE_LINE: f64 = 0.008;

/// The colour of each series, in the order in which they appear.
pub(super) struct Series {
    names: Vec<String>,
    /// For each series the one whose line stands for its own.
    stands_for: Vec<usize>,
}

impl Series {
    pub(super) fn of(answer: &Answer) -> Self {
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
        let mut stands_for: Vec<usize> = Vec::new();
        for k in 0..names.len() {
            let like = (0..k).find(|&j| stands_for[j] == j && one_line(answer, &names[j], &names[k]));
            stands_for.push(like.unwrap_or(k));
        }
        Self { names, stands_for }
    }

    fn place(&self, series: &str) -> Option<usize> {
        self.names.iter().position(|n| n == series)
    }

    /// Whether the line of a series is drawn, and not another that lies over it.
    pub(super) fn is_drawn(&self, series: &str) -> bool {
        self.place(series).is_none_or(|k| self.stands_for[k] == k)
    }

    /// Ordered series have ordered colours.
    pub(super) fn stroke(&self, series: &str) -> Stroke {
        match self.place(series) {
            Some(k) if self.names.len() > 2 && value(series).is_some() => {
                scale_stroke(k, self.names.len(), 1.4)
            }
            Some(k) => model_stroke(k),
            None => Stroke::solid(INK, 1.2),
        }
    }

    /// What symbols, colours and bars mean.
    pub(super) fn legend(&self, answer: &Answer, groups: &Groups) -> Vec<Key> {
        let mut keys: Vec<Key> = Vec::new();
        let all = || answer.panels.iter().flat_map(|p| &p.layers);
        let dots = || all().filter(|l| l.look == LayerLook::Dots);
        let is_there = |l: &Layer| l.rows(&answer.frames[l.frame]).any(|r| r.number(l.y).is_some());
        let has_bars = dots().any(|l| l.sd.is_some() && is_there(l));
        let in_ink = dots().any(|l| !is_coloured(l.look, answer) && is_there(l));
        let key = |mark, label: &str| Key { mark, label: label.to_owned() };
        let ellipses = all().any(|l| l.look == LayerLook::Ellipse);
        keys.extend(match (in_ink, has_bars) {
            (true, _) if ellipses => Some(key(Mark::Dot(INK), "prior mean")),
            (true, true) if groups.any() => {
                Some(key(Mark::Bar(INK), "filled: measured; bars: two standard deviations"))
            }
            (true, true) => Some(key(Mark::Bar(INK), "measured; bars: two standard deviations")),
            (true, false) => Some(key(Mark::Dot(INK), "measured")),
            (false, true) => Some(key(Mark::Bar(INK), "bars: two standard deviations")),
            (false, false) => None,
        });
        let point = |(k, name): (usize, &String)| key(Mark::Point(Symbol::of(k), INK), name);
        keys.extend(groups.names.iter().enumerate().map(point));
        for (k, name) in self.names.iter().enumerate().filter(|(k, _)| self.stands_for[*k] == *k) {
            let stroke = self.stroke(name);
            let mark = match all().find(|l| l.look != LayerLook::Dots).map(|l| l.look) {
                None => Mark::Dot(stroke.colour),
                Some(LayerLook::Dashes) if groups.any() => Mark::DashedRing(stroke),
                Some(LayerLook::Dashes) => Mark::Dash(stroke),
                Some(_) => Mark::Line(stroke),
            };
            let like = (0..self.names.len()).filter(|j| self.stands_for[*j] == k);
            let all: Vec<String> = like.map(|j| label(answer, &self.names[j])).collect();
            let label = match &all[..] {
                [one] => one.clone(),
                many => {
                    let each = many.iter().enumerate().map(|(k, name)| format!("({}) {name}", k + 1));
                    format!("{} lines that coincide: {}", many.len(), each.collect::<Vec<_>>().join(", "))
                }
            };
            keys.push(Key { mark, label });
        }
        keys
    }
}

/// The name of a series in the markup of labels. Of a row of the campaign the factors follow that tell it
/// from the other rows.
fn label(answer: &Answer, name: &str) -> String {
    if let Some((factor, rest)) = name.split_once(" = ") {
        return format!("{} = {rest}", symbol(factor));
    }
    let own = answer.frames.first().and_then(|frame| Some((frame, frame.column("growth_rate")?)));
    let Some((frame, factors)) = own else { return name.to_owned() };
    let rows: Vec<&FrameRow> = frame.rows.iter().filter(|r| r.series == name).collect();
    let Some(first) = rows.first() else { return name.to_owned() };
    let tells = |k: &usize| {
        rows.iter().all(|r| r.number(*k) == first.number(*k))
            && frame.rows.iter().any(|r| r.number(*k) != first.number(*k))
    };
    let told: Vec<usize> = (0..factors).filter(tells).collect();
    if told.is_empty() { name.to_owned() } else { format!("{name}: {}", factors_of(frame, first, &told)) }
}

/// The number in the name of a series, `Q_h = 7 W` or `3 microphones`.
fn value(series: &str) -> Option<f64> {
    let after = series.split_once(" = ").map_or(series, |(_, after)| after);
    after.split(' ').next()?.parse().ok()
}

/// Everything but dots has the colour of its series; dots have where nothing else says which series is which.
pub(super) fn is_coloured(look: LayerLook, answer: &Answer) -> bool {
    let mut layers = answer.panels.iter().flat_map(|p| &p.layers);
    look != LayerLook::Dots || !layers.any(|l| !matches!(l.look, LayerLook::Dots | LayerLook::Band))
}

/// Whether the lines of two series lie on each other in every panel. Only lines through the same places do.
fn one_line(answer: &Answer, one: &str, other: &str) -> bool {
    let is_line = |l: &&Layer| l.look == LayerLook::Line;
    let lines = |panel: &AnswerPanel| panel.layers.iter().filter(is_line).count();
    let mut all = answer.panels.iter().flat_map(|p| &p.layers).filter(is_line);
    !answer.panels.is_empty()
        && answer.panels.iter().all(|p| lines(p) > 0)
        && all.all(|layer| {
            let rows = || layer.rows(&answer.frames[layer.frame]);
            let [low, high] = range(rows().filter_map(|r| r.number(layer.y)));
            let near = |(a, b): (&FrameRow, &FrameRow)| {
                let both = a.number(layer.y).zip(b.number(layer.y));
                a.mode == b.mode
                    && a.number(layer.x) == b.number(layer.x)
                    && both.is_some_and(|(y, z)| (y - z).abs() <= ONE_LINE * (high - low))
            };
            let of = |series: &str| rows().filter(|r| r.series == series).collect::<Vec<_>>();
            let (first, second) = (of(one), of(other));
            first.len() > 1 && first.len() == second.len() && first.into_iter().zip(second).all(near)
        })
}
