//! Curves over time, frequency or place, panel by panel.

use crate::{Axis, COLUMN, Figure, INK, Key, Mark, Panel, Stroke, model_stroke, scale_colour, scale_stroke};
use rijke_rig::{Look, Plot, PlotCurve, PlotPanel};

const SIZE: [f64; 2] = [COLUMN, 240.0];

/// The figure as the text of an SVG file.
#[must_use]
pub fn plot_svg(plot: &Plot) -> String {
    let mut legend: Vec<Key> = Vec::new();
    for curve in plot.panels.iter().flat_map(|p| &p.curves) {
        if !curve.name.is_empty()
            && !curve.points.is_empty()
            && legend.iter().all(|key| key.label != curve.name)
        {
            let same = || plot.panels.iter().flat_map(|p| &p.curves).filter(|c| c.name == curve.name);
            let mark = match curve.look {
                Look::Dots(index) => Mark::Dot(model_stroke(index).colour),
                look if same().all(is_point) => Mark::Dot(stroke(look).colour),
                Look::Patch(index) => Mark::Patch(model_stroke(index).colour),
                look => Mark::Line(stroke(look)),
            };
            legend.push(Key { mark, label: curve.name.clone() });
        }
    }
    let tagged = plot.panels.iter().enumerate();
    let figure = Figure {
        title: plot.title.clone(),
        caption: String::new(),
        columns: plot.panels.len().min(2),
        panels: tagged.map(|(k, p)| drawn(p, &format!("({})", char::from(b'a' + k as u8)))).collect(),
        legend,
        data: Some(plot.data),
    };
    figure.svg()
}

fn drawn(plot: &PlotPanel, tag: &str) -> Panel {
    let points = || plot.curves.iter().flat_map(|c| &c.points);
    let limits = points().fold([f64::INFINITY, f64::NEG_INFINITY], |l, p| [l[0].min(p[0]), l[1].max(p[0])]);
    let dots = plot.curves.iter().any(|c| matches!(c.look, Look::Dots(_)) || is_point(c));
    let x = match limits[0] < limits[1] && !dots {
        _ if !plot.places.is_empty() => Axis::named(&plot.x, &plot.places),
        true => Axis::new(&plot.x, limits[0], limits[1]),
        false => Axis::covering(&plot.x, points().map(|p| p[0])),
    };
    let mut panel = Panel::new(tag, SIZE, x, Axis::covering(&plot.y, points().map(|p| p[1])));
    for mark in &plot.marks {
        panel.vertical(*mark, &Stroke::dashed("#999", 1.0, "3 3"));
    }
    for curve in plot.curves.iter().filter(|c| !c.points.is_empty()) {
        match curve.look {
            Look::Dots(index) => {
                for point in &curve.points {
                    panel.dot(*point, 3.5, model_stroke(index).colour, &curve.name);
                }
            }
            Look::Patch(index) => {
                let edge = Stroke::solid("none", 0.0);
                panel.contour(&curve.points, &edge, model_stroke(index).colour, 0.3);
            }
            look if is_point(curve) => panel.dot(curve.points[0], 3.5, stroke(look).colour, &curve.name),
            look => panel.curve(&curve.points, &stroke(look)),
        }
    }
    panel
}

/// Whether a line has one point only, through which nothing can be drawn.
fn is_point(curve: &PlotCurve) -> bool {
    curve.points.len() == 1 && !matches!(curve.look, Look::Patch(_))
}

fn stroke(look: Look) -> Stroke {
    match look {
        Look::Record => Stroke::solid("#86b3d1", 2.0),
        Look::Fit => Stroke::solid(INK, 0.9),
        // Neighbours of so many are told apart by their dashes.
        Look::Channel(index, count) if count > 7 => scale_stroke(index, count, 1.2),
        Look::Channel(index, count) => Stroke::solid(scale_colour(index, count), 1.2),
        Look::Dots(index) | Look::Patch(index) => model_stroke(index),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::DataKind;

    #[test]
    fn exact_every_curve_is_drawn_and_named_once() {
        let curve = |name: &str, look| PlotCurve {
            name: name.to_owned(),
            look,
            points: vec![[0.0, 1.0], [1.0, -1.0], [2.0, 0.5]],
        };
        let panel = |curves| PlotPanel {
            x: "time / s".into(),
            y: "p / Pa".into(),
            curves,
            marks: vec![0.4],
            places: vec![],
        };
        let panels = vec![
            panel(vec![curve("record", Look::Record), curve("fit", Look::Fit)]),
            panel(vec![curve("record", Look::Record), curve("", Look::Dots(1))]),
            panel(vec![]),
        ];
        let svg = plot_svg(&Plot { title: "T".into(), data: DataKind::Virtual, panels });
        assert_eq!(svg.matches(">record<").count(), 1);
        assert_eq!(svg.matches("<circle").count(), 3);
        // On every panel, and in the description of the whole.
        assert_eq!(svg.matches("virtual data").count(), 4);
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }
    #[test]
    fn exact_a_line_of_one_point_is_a_dot_and_places_have_their_names() {
        let curve = |name: &str, look, at| PlotCurve { name: name.to_owned(), look, points: vec![at] };
        let one = PlotPanel::new(
            "x / m",
            "U",
            vec![
                curve("50 W", Look::Channel(0, 2), [0.25, 0.1]),
                curve("80 W", Look::Channel(1, 2), [0.25, 0.2]),
            ],
        );
        let places: Vec<String> = ["p1", "p2", "inlet"].map(String::from).to_vec();
        let dots = PlotCurve { points: vec![[0.0, 1.0], [2.0, 3.0]], ..curve("d", Look::Dots(0), [0.0; 2]) };
        let named = PlotPanel { places, ..PlotPanel::new("microphone", "d", vec![dots]) };
        let svg = plot_svg(&Plot { title: "T".into(), data: DataKind::Virtual, panels: vec![one, named] });
        assert_eq!(svg.matches("<circle").count(), 4 + 3, "four points and three marks of the legend: {svg}");
        assert!(svg.contains(">0.25<") && !svg.contains("0.2499"), "{svg}");
        for name in ["p1", "p2", "inlet"] {
            assert_eq!(svg.matches(&format!(">{name}<")).count(), 1, "{svg}");
        }
    }
}
