//! A bar of colours beside a panel, which says what the colours of its areas mean.

use super::{INK, px, style::TICK, text};

/// Width of the bar, and between it and its numbers, pixels.
const WIDE: f64 = 14.0;
const GAP: f64 = 5.0;

/// Colours from the lowest to the highest, and the values at which one follows another.
pub struct ColourBar {
    /// One colour for each area.
    pub colours: Vec<&'static str>,
    /// Between every two of them.
    pub bounds: Vec<String>,
}

impl ColourBar {
    /// Pixels that it takes from the frame.
    pub(crate) fn room(&self) -> f64 {
        let widest = self.bounds.iter().map(|b| text::width(b, TICK)).fold(0.0, f64::max);
        WIDE + GAP + widest
    }

    /// The bar as SVG elements, its upper left corner at `at`.
    pub(crate) fn elements(&self, [x, top]: [f64; 2], height: f64) -> String {
        let step = height / self.colours.len() as f64;
        let (wide, high) = (px(WIDE), px(step));
        let from = |k: usize| px(top + height - k as f64 * step);
        let area = |(k, colour): (usize, &&str)| {
            let d = format!("M{} {}h{wide}v-{high}h-{wide}Z", px(x), from(k));
            format!("<path d=\"{d}\" fill=\"{colour}\" stroke=\"{INK}\" stroke-width=\"0.5\"/>")
        };
        let bound = |(k, value): (usize, &String)| {
            let y = top + height - (k + 1) as f64 * step + 0.35 * TICK;
            text::element([x + WIDE + GAP, y], false, "start", TICK, value)
        };
        let areas = self.colours.iter().enumerate().map(area);
        areas.chain(self.bounds.iter().enumerate().map(bound)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_values_stand_where_colours_meet() {
        let bar = ColourBar { colours: vec!["#000", "#888", "#fff"], bounds: vec!["0".into(), "5".into()] };
        let drawn = bar.elements([10.0, 20.0], 90.0);
        assert_eq!(drawn.matches("<path").count(), 3);
        // 30 and 60 pixels above the bottom, which is at 110; letters stand 4.2 lower.
        assert!(drawn.contains("y=\"84.2\"") && drawn.contains("y=\"54.2\""), "{drawn}");
        assert!(bar.room() > 20.0);
    }
}
