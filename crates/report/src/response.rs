//! Forced response of a network over frequency: modulus and phase of complex ratios.

use rijke_draw::{Axis, COLUMN, Figure, Key, Mark, Panel, Stroke, model_stroke};

/// Numbers of the figure.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseFigure {
    /// What is shown, in one line.
    pub title: String,
    /// The frequencies, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// The ratios, in the order of their colours.
    pub curves: Vec<ResponseCurve>,
}

/// A complex ratio at every frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseCurve {
    /// What it is, with its unit.
    pub label: String,
    /// Modulus.
    pub modulus: Vec<f64>,
    /// Phase, degrees, -180 to 180.
    pub phase_deg: Vec<f64>,
}

const SIZE: [f64; 2] = [COLUMN, 230.0];
/// A step of the phase beyond this is a turn, across which no line is drawn, degrees.
const TURN: f64 = 180.0;

impl ResponseFigure {
    /// The figure as the text of an SVG file: a panel of the modulus in dB and one of the phase.
    #[must_use]
    pub fn svg(&self) -> String {
        let ends = |v: &[f64]| [v.first(), v.last()].map(|x| x.copied().unwrap_or(0.0));
        let [low, high] = ends(&self.frequency_hz);
        let x = || Axis::covering("frequency / Hz", [low, high]);
        let level = |v: f64| 20.0 * v.log10();
        let levels = self.curves.iter().flat_map(|c| c.modulus.iter().map(|v| level(*v)));
        let mut size = Panel::new("(a)", SIZE, x(), Axis::covering("modulus / dB", levels));
        let mut phase = Panel::new("(b)", SIZE, x(), Axis::new("phase / deg", -190.0, 190.0));
        phase.horizontal(0.0, &Stroke::solid("#bbb", 1.0));
        for (index, curve) in self.curves.iter().enumerate() {
            let stroke = model_stroke(index);
            let points = self.frequency_hz.iter().zip(&curve.modulus).map(|(f, v)| [*f, level(*v)]);
            size.curve(&points.collect::<Vec<_>>(), &stroke);
            let mut turning: Vec<[f64; 2]> = Vec::with_capacity(curve.phase_deg.len());
            for (f, angle) in self.frequency_hz.iter().zip(&curve.phase_deg) {
                if turning.last().is_some_and(|last| (last[1] - angle).abs() > TURN) {
                    turning.push([f64::NAN; 2]);
                }
                turning.push([*f, *angle]);
            }
            phase.curve(&turning, &stroke);
        }
        let key = |(index, curve): (usize, &ResponseCurve)| Key {
            mark: Mark::Line(model_stroke(index)),
            label: curve.label.clone(),
        };
        let figure = Figure {
            title: self.title.clone(),
            caption: String::new(),
            columns: 1,
            panels: vec![size, phase],
            legend: self.curves.iter().enumerate().map(key).collect(),
            data: None,
        };
        figure.svg()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn behaviour_a_turn_of_the_phase_interrupts_the_line() {
        let curve = |phase_deg: Vec<f64>| ResponseFigure {
            title: "A tube".into(),
            frequency_hz: vec![100.0, 200.0, 300.0],
            curves: vec![ResponseCurve { label: "R".into(), modulus: vec![1.0, 0.5, 1.0], phase_deg }],
        };
        let lines = |figure: ResponseFigure| figure.svg().matches("<path d=\"M").count();
        let (whole, turned) = (curve(vec![10.0, 20.0, 30.0]), curve(vec![170.0, 175.0, -175.0]));
        // The single point behind the turn is no line, but the piece before it is shorter.
        assert_eq!(lines(whole.clone()), lines(turned.clone()));
        assert_ne!(whole.svg(), turned.svg());
        assert!(whole.svg().contains("computed, no data"));
    }
}
