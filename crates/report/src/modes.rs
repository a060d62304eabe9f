//! Acoustic modes of a network: where they lie in the s-plane, their shapes, and what small changes along the
//! tube do.

use rijke_draw::{Axis, COLUMN, Figure, Key, Mark, Panel, Stroke, fixed, model_stroke};
use rijke_network::{Device, ModeCurves, SmallChange};

/// Numbers of the figure. Curves are over `x` of their mode.
#[derive(Clone, Debug, PartialEq)]
pub struct ModesFigure {
    /// What is shown, in one line.
    pub title: String,
    /// The rectangle that was searched: growth rates, 1/s.
    pub growth_rate: [f64; 2],
    /// And frequencies, Hz.
    pub frequency_hz: [f64; 2],
    /// The modes, in the order of their colours.
    pub modes: Vec<ModeCurves>,
    /// Poles of the laws: growth rate and frequency.
    pub poles: Vec<[f64; 2]>,
    /// Where devices lie, m.
    pub devices: Vec<f64>,
}

const SIZE: [f64; 2] = [COLUMN, 250.0];
/// More curves than this cannot be told apart.
const MOST: usize = 7;

impl ModesFigure {
    /// The figure as the text of an SVG file. Only the first seven modes have curves.
    #[must_use]
    pub fn svg(&self) -> String {
        let drawn = &self.modes[..self.modes.len().min(MOST)];
        let mut panels = vec![self.plane()];
        let changes = drawn.first().map_or(0, |m| m.changes.len());
        for k in 0..2 + changes {
            let curve = |m: &ModeCurves| -> Vec<[f64; 2]> {
                let y = match k {
                    0 => &m.pressure,
                    1 => &m.velocity,
                    k => &m.changes[k - 2].1,
                };
                m.x.iter().zip(y).map(|(x, y)| [*x, *y]).collect()
            };
            let [name, label] = match k {
                0 => ["", "|*p*| / max |*p*|"],
                1 => ["", "|*\u{3c1}c u*| / max |*p*|"],
                k => label(drawn[0].changes[k - 2].0),
            };
            let curves: Vec<Vec<[f64; 2]>> = drawn.iter().map(curve).collect();
            let values = curves.iter().flatten().map(|p| p[1]).chain([0.0]);
            let end = curves.iter().flatten().map(|p| p[0]).fold(0.0, f64::max);
            let tag = format!("({}) {name}", char::from(b'b' + k as u8));
            let mut panel =
                Panel::new(&tag, SIZE, Axis::new("*x* / m", 0.0, end), Axis::covering(label, values));
            for &x in &self.devices {
                panel.vertical(x, &Stroke::dashed("#bbb", 1.0, "2 3"));
            }
            panel.horizontal(0.0, &Stroke::solid("#bbb", 1.0));
            for (index, points) in curves.iter().enumerate() {
                panel.curve(points, &model_stroke(index));
            }
            panels.push(panel);
        }
        let mut legend: Vec<Key> = drawn
            .iter()
            .enumerate()
            .map(|(index, m)| Key {
                mark: Mark::Line(model_stroke(index)),
                label: format!("{} Hz, {} s^{{-1}}", fixed(m.frequency_hz, 1), fixed(m.growth_rate, 2)),
            })
            .collect();
        if !self.poles.is_empty() {
            legend.push(Key { mark: Mark::Cross(POLE), label: "pole of a law".to_owned() });
        }
        let figure = Figure {
            title: self.title.clone(),
            caption: String::new(),
            columns: 2,
            panels,
            legend,
            data: None,
        };
        figure.svg()
    }

    fn plane(&self) -> Panel {
        let [left, right] = self.growth_rate;
        let [low, high] = self.frequency_hz;
        let wide = |[a, b]: [f64; 2]| [a - 0.06 * (b - a), b + 0.06 * (b - a)];
        let (x, y) = (wide(self.growth_rate), wide(self.frequency_hz));
        let x = Axis::new("Growth rate / s^{-1}", x[0], x[1]);
        let y = Axis::new("Frequency / Hz", y[0], y[1]);
        let mut panel = Panel::new("(a)", SIZE, x, y);
        let border = [[left, low], [right, low], [right, high], [left, high]];
        panel.contour(&border, &Stroke::dashed("#999", 1.0, "5 3"), "#56b4e9", 0.06);
        panel.vertical(0.0, &Stroke::solid("#bbb", 1.0));
        for pole in &self.poles {
            panel.cross(*pole, 4.0, &POLE);
        }
        for (index, m) in self.modes.iter().enumerate() {
            let colour = if index < MOST { model_stroke(index).colour } else { "#1a1a1a" };
            let remark = format!("{} Hz, {} 1/s", fixed(m.frequency_hz, 2), fixed(m.growth_rate, 3));
            panel.dot([m.growth_rate, m.frequency_hz], 4.0, colour, &remark);
        }
        panel
    }
}

/// The name of the curve of a change, which defines *e*, and what its axis counts.
fn label(change: SmallChange) -> [&'static str; 2] {
    const DEVICE: &str = "d*\u{3c3}*/d*e* / s^{-1}";
    const ALONG: &str = "d*\u{3c3}*/d*e* / s^{-1} m^{-1}";
    match change {
        SmallChange::Device(Device::Drag) => ["screen: *p* drops by *e\u{3c1}cu*", DEVICE],
        SmallChange::Device(Device::Heat) => ["heat: *u* rises by *eu*", DEVICE],
        SmallChange::Device(Device::Leak) => ["leak: *u* drops by *ep*/(*\u{3c1}c*)", DEVICE],
        SmallChange::Area => ["more area by share *e*", ALONG],
        SmallChange::Temperature => ["hotter by share *e*", ALONG],
    }
}

const POLE: Stroke = Stroke::solid("#1a1a1a", 1.3);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_mode_and_pole_is_drawn() {
        let mode = |f: f64| ModeCurves {
            growth_rate: -3.0,
            frequency_hz: f,
            x: vec![0.0, 1.0],
            pressure: vec![0.0, 1.0],
            velocity: vec![1.0, 0.0],
            changes: vec![(SmallChange::Area, vec![-1.0, 0.0])],
        };
        let figure = ModesFigure {
            title: "T".to_owned(),
            growth_rate: [-10.0, 10.0],
            frequency_hz: [50.0, 900.0],
            modes: (0..9).map(|k| mode(100.0 + 80.0 * f64::from(k))).collect(),
            poles: vec![[-5.0, 300.0]],
            devices: vec![0.25],
        };
        let svg = figure.svg();
        assert_eq!(svg.matches("<circle").count(), 9);
        assert_eq!(svg.matches(">(d) more area by share").count(), 1, "a curve says what is changed: {svg}");
        assert!(svg.contains("pole of a law") && !svg.contains("NaN"));
        let empty = ModesFigure { modes: vec![], poles: vec![], ..figure };
        assert!(empty.svg().contains("(c)"));
    }
}
