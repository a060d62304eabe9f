//! A map of stability: growth rate and probability of instability over two factors, filled.

use rijke_draw::{
    Axis, ColourBar, DOT, Figure, INK, Key, Mark, Panel, Stroke, fill_colour, fixed, multiples, round_step,
};
use rijke_engine::run::{Answer, AnswerPanel, FrameRow, Layer, LayerLook, MapNodes};
use rijke_numerics::Lines;
use rijke_rig::DataKind;

/// Levels of the growth rate between the least and the largest, at most.
const LEVELS: f64 = 5.0;

/// Growth rates in their standard deviations that separate probabilities, and those.
const CHANCES: [(f64, &str); 5] =
    [(-2.0, "2.3 %"), (-1.0, "16 %"), (0.0, "50 %"), (1.0, "84 %"), (2.0, "97.7 %")];

/// The boundary of stability, and where it is two standard deviations off.
const BOUNDARY: Stroke = Stroke::solid(INK, 2.0);
const EDGE: Stroke = Stroke::dashed(INK, 1.2, "4 3");
const CROSS: Stroke = Stroke::solid(INK, 2.2);
/// The band lightens what is below it.
const BAND: (&str, f64) = ("#fff", 0.5);
/// Half the size of a cross, pixels.
const ARM: f64 = 5.0;

/// Whether an answer is a map.
pub(super) fn is_one(answer: &Answer) -> bool {
    let mut layers = answer.panels.iter().flat_map(|p| &p.layers);
    layers.any(|l| matches!(l.look, LayerLook::GrowthMap | LayerLook::ChanceMap))
}

pub(super) fn of(kind: Option<DataKind>, answer: &Answer, size: [f64; 2]) -> Figure {
    let mut legend = Vec::new();
    let mut panels = Vec::new();
    for (tag, panel) in
        ["(a) Growth rate / s^{-1}", "(b) Probability of instability"].into_iter().zip(&answer.panels)
    {
        panels.push(drawn(answer, panel, tag, size, &mut legend));
    }
    let layers = || answer.panels.first().into_iter().flat_map(|p| &p.layers);
    let rows =
        |look| layers().filter(move |l: &&Layer| l.look == look).flat_map(|l| &answer.frames[l.frame].rows);
    if rows(LayerLook::Dots).next().is_some() {
        legend.push(Key { mark: Mark::Dot(INK), label: "points that trained the model".into() });
    }
    for row in rows(LayerLook::Cross) {
        legend.push(Key {
            mark: Mark::Cross(CROSS),
            label: row.label.replace(" 1/s", " s^{-1}").replace(" -", " \u{2212}"),
        });
    }
    Figure {
        title: answer.title.clone(),
        caption: answer.caption.clone(),
        columns: 2,
        panels,
        legend,
        data: kind,
    }
}

fn drawn(answer: &Answer, panel: &AnswerPanel, tag: &str, size: [f64; 2], legend: &mut Vec<Key>) -> Panel {
    let maps = panel.layers.iter().find(|l| matches!(l.look, LayerLook::GrowthMap | LayerLook::ChanceMap));
    let nodes = maps.map(|l| MapNodes::of(&answer.frames[l.frame], l));
    let points = |layer: &Layer| {
        let (x, y) = (layer.x, layer.y);
        let at = move |row: &FrameRow| Some(([*row.values.get(x)?, *row.values.get(y)?], row.label.clone()));
        let rows = answer.frames[layer.frame].rows.iter().filter_map(at);
        rows.filter_map(|([x, y], label)| Some(([x?, y?], label))).collect::<Vec<_>>()
    };
    let [x, y] = nodes.as_ref().map_or([&[][..], &[]], |n| [&n.x, &n.y]);
    let axis = |label: &str, all: &[f64]| Axis::covering(label, all.iter().copied());
    let mut out = Panel::new(tag, size, axis(&panel.x, x), axis(&panel.y, y));
    if let (Some(layer), Some(nodes)) = (maps, &nodes) {
        let (levels, bounds) = if layer.look == LayerLook::GrowthMap {
            let levels = levels(nodes.range());
            let words = levels.iter().map(|v| fixed(*v, decimals(&levels))).collect();
            (levels.iter().map(|v| (*v, 0.0)).collect::<Vec<_>>(), words)
        } else {
            let words = CHANCES.iter().map(|(_, words)| (*words).to_owned()).collect::<Vec<_>>();
            (CHANCES.iter().map(|(sds, _)| (0.0, -sds)).collect(), words)
        };
        let colours = (0..=levels.len()).map(|k| fill_colour(k, levels.len() + 1)).collect();
        out.colour_bar(ColourBar { colours, bounds });
        filled(&mut out, nodes, &levels);
        boundary(&mut out, nodes, layer.look, legend);
    }
    for layer in &panel.layers {
        for (at, label) in points(layer) {
            match layer.look {
                LayerLook::Dots => out.dot(at, 0.7 * DOT, INK, &format!("{label}: trained the model")),
                LayerLook::Cross => out.cross(at, ARM, &CROSS),
                _ => {}
            }
        }
    }
    out
}

/// Areas between levels, the higher over the lower. A level is a growth rate and how many deviations are
/// added before it is compared.
fn filled(panel: &mut Panel, nodes: &MapNodes, levels: &[(f64, f64)]) {
    let above = |level: Option<&(f64, f64)>| -> Lines {
        let of = |[mean, sd]: [f64; 2]| match level {
            Some((value, sds)) => mean + sds * sd - value,
            None if mean.is_finite() => 1.0,
            None => f64::NAN,
        };
        nodes.field().zero(&nodes.each(of)).area
    };
    let areas: Vec<Lines> =
        std::iter::once(above(None)).chain(levels.iter().map(|l| above(Some(l)))).collect();
    for (k, area) in areas.iter().enumerate() {
        // What the next level covers is not seen.
        if area.is_empty() || areas.get(k + 1).is_some_and(|next| next == area) {
            continue;
        }
        panel.area(area, fill_colour(k, levels.len() + 1), 1.0);
    }
}

/// The line on which the growth rate is zero, and the band in which zero lies within two standard deviations.
fn boundary(panel: &mut Panel, nodes: &MapNodes, look: LayerLook, legend: &mut Vec<Key>) {
    let sure = |sds: f64| nodes.field().zero(&nodes.each(|[mean, sd]| mean + sds * sd));
    let (least, most) = (sure(-2.0), sure(2.0));
    let is_growth = look == LayerLook::GrowthMap;
    // Probabilities have their own colours there.
    if is_growth && most.area != least.area {
        let holes = least.area.iter().map(|line| line.iter().rev().copied().collect());
        let band: Lines = most.area.iter().cloned().chain(holes).collect();
        panel.area(&band, BAND.0, BAND.1);
    }
    if is_growth && !(least.lines.is_empty() && most.lines.is_empty()) {
        let label = "boundary two standard deviations off (probability 2.3 % and 97.7 %)";
        legend.push(Key { mark: Mark::Line(EDGE), label: label.into() });
    }
    for line in least.lines.iter().chain(&most.lines) {
        panel.curve(line, &EDGE);
    }
    let middle = sure(0.0).lines;
    middle.iter().for_each(|line| panel.curve(line, &BOUNDARY));
    if is_growth && !middle.is_empty() {
        legend.push(Key { mark: Mark::Line(BOUNDARY), label: "boundary of stability".into() });
    }
}

/// Round levels between two values, zero among them if it is between.
fn levels([low, high]: [f64; 2]) -> Vec<f64> {
    // A map of one value, but for rounding, has none.
    let is_range = high - low > 1e-9 * low.abs().max(high.abs());
    if !is_range {
        return Vec::new();
    }
    let step = round_step((high - low) / LEVELS);
    multiples(step, low, high).filter(|v| low < *v && *v < high).collect()
}

fn decimals(levels: &[f64]) -> usize {
    let step = levels.windows(2).map(|w| w[1] - w[0]).chain(levels.first().map(|v| v.abs()));
    let step = step.filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min);
    if step < 1.0 { (-step.log10() - 1e-9).ceil() as usize } else { 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_levels_are_round_and_have_the_digits_they_need() {
        assert_eq!(levels([-1.5, 1.5]), [-1.0, 0.0, 1.0]);
        assert_eq!(levels([-10.8, -1.9]), [-10.0, -8.0, -6.0, -4.0, -2.0]);
        assert!(levels([2.0, 2.0]).is_empty());
        assert_eq!([decimals(&[-0.2, 0.0, 0.2]), decimals(&[5.0, 10.0]), decimals(&[0.05])], [1, 0, 2]);
        // Tests of other files hold the areas; here that all of them have a colour of their own.
        for low in [-9.99, -3.0, -0.1] {
            assert!(levels([low, low + 10.0]).len() < 7, "{low}");
        }
    }
}
