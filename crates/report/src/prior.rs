//! What models say before they have seen data: growth rate and frequency that their priors allow.

use crate::draw::{Axis, Figure, INK, Key, Mark, Panel, Stroke, scale_colour};
use rijke_studies::DataKind;

/// Prior predictions of several models, one row of two panels for each.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorFigure {
    /// What is shown, in one line.
    pub title: String,
    /// Measured or virtual, where something was observed.
    pub data: Option<DataKind>,
    /// Whether the horizontal axis is the power, W, and not the position, m.
    pub over_power: bool,
    /// The models, top to bottom.
    pub models: Vec<PriorModel>,
}

/// One model.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorModel {
    /// What it is called.
    pub name: String,
    /// Its predictions, series by series.
    pub series: Vec<PriorSeries>,
}

/// Points that belong together, such as those of one power.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorSeries {
    /// Name in the legend; empty for none.
    pub name: String,
    /// Place on the horizontal axis; lower end, middle and upper end of the growth rate (1/s) and of the frequency (Hz).
    pub bands: Vec<(f64, [[f64; 3]; 2])>,
    /// Place, growth rate (1/s) and frequency (Hz) of what was observed.
    pub measured: Vec<[f64; 3]>,
}

const SIZE: [f64; 2] = [430.0, 250.0];

impl PriorFigure {
    /// The figure as the text of an SVG file.
    #[must_use]
    pub fn svg(&self) -> String {
        let series = || self.models.iter().flat_map(|m| &m.series);
        let count = self.models.iter().map(|m| m.series.len()).max().unwrap_or(1);
        let mut legend: Vec<Key> = Vec::new();
        for (k, one) in self.models.first().iter().flat_map(|m| m.series.iter().enumerate()) {
            let label = if one.name.is_empty() { "prior prediction".to_owned() } else { one.name.clone() };
            legend.push(Key { mark: Mark::Line(Stroke::solid(scale_colour(k, count), 1.6)), label });
        }
        if series().any(|s| !s.measured.is_empty()) {
            legend.push(Key { mark: Mark::Dot(INK), label: "observed".to_owned() });
        }
        let rows = self.models.iter().flat_map(|m| [(m, 0), (m, 1)]);
        let figure = Figure {
            id: "prior",
            title: self.title.clone(),
            caption: String::new(),
            columns: 2,
            panels: rows.map(|(model, part)| self.panel(model, part, count)).collect(),
            legend,
            data: self.data,
        };
        figure.svg()
    }

    /// Growth rate (`part` 0) or frequency (1) of one model.
    fn panel(&self, model: &PriorModel, part: usize, count: usize) -> Panel {
        let label = ["growth rate / s^{-1}", "frequency / Hz"][part];
        let ends = model.series.iter().flat_map(|s| s.bands.iter().flat_map(|(_, b)| b[part]));
        let dots = model.series.iter().flat_map(|s| s.measured.iter().map(|m| m[1 + part]));
        let x = if self.over_power { "power / W" } else { "position / m" };
        let places = model.series.iter().flat_map(|s| s.bands.iter().map(|(x, _)| *x));
        let (x, y) = (Axis::covering(x, places), Axis::covering(label, ends.chain(dots)));
        let mut panel = Panel::new(&model.name, SIZE, x, y);
        for (k, series) in model.series.iter().enumerate() {
            let colour = scale_colour(k, count);
            let band: Vec<[f64; 3]> =
                series.bands.iter().map(|(x, b)| [*x, b[part][0], b[part][2]]).collect();
            panel.band(&band, colour, if count > 1 { 0.12 } else { 0.25 });
            let middle: Vec<[f64; 2]> = series.bands.iter().map(|(x, b)| [*x, b[part][1]]).collect();
            panel.curve(&middle, &Stroke::solid(colour, 1.6));
        }
        if part == 0 {
            panel.horizontal(0.0, &Stroke::dashed("#999", 1.0, "3 3"));
        }
        for (k, series) in model.series.iter().enumerate() {
            let colour = if count > 1 { scale_colour(k, count) } else { INK };
            for dot in &series.measured {
                panel.dot([dot[0], dot[1 + part]], 3.0, colour, "observed");
            }
        }
        panel
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_bands_dots_and_where_the_data_come_from() {
        let series = |name: &str| PriorSeries {
            name: name.to_owned(),
            bands: vec![
                (0.1, [[-8.0, -7.0, -6.0], [170.0, 171.0, 172.0]]),
                (0.3, [[-9.0, -7.0, -5.0], [168.0, 171.0, 174.0]]),
            ],
            measured: vec![[0.1, -7.2, 170.5]],
        };
        let model =
            |name: &str| PriorModel { name: name.to_owned(), series: vec![series("50 W"), series("80 W")] };
        let figure = PriorFigure {
            title: "T".into(),
            data: Some(DataKind::Virtual),
            over_power: false,
            models: vec![model("a.1"), model("a.2")],
        };
        let svg = figure.svg();
        // Two models, two panels, two series.
        assert_eq!(svg.matches("fill-opacity=\"0.12\"").count(), 8);
        assert_eq!(svg.matches(">a.2<").count(), 2);
        assert!(svg.contains("virtual data") && svg.contains(">50 W<") && !svg.contains("NaN"));
        let planned = PriorFigure { data: None, models: vec![], ..figure };
        assert!(!planned.svg().contains("virtual data"));
    }
}
