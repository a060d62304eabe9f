//! Colours and line styles.

/// Colour of axes, text and measured points.
pub const INK: &str = "#1a1a1a";

/// Font size of numbers at ticks, in pixels of a panel's own coordinates.
pub(crate) const TICK: f64 = 12.0;

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Colour.
    pub colour: &'static str,
    /// Width in pixels.
    pub width: f64,
    /// Lengths of dashes and gaps; empty for a solid line.
    pub dash: &'static str,
}

impl Stroke {
    /// An unbroken line.
    #[must_use]
    pub const fn solid(colour: &'static str, width: f64) -> Self {
        Self { colour, width, dash: "" }
    }

    /// A line with dashes, lengths in pixels as SVG has them.
    #[must_use]
    pub const fn dashed(colour: &'static str, width: f64, dash: &'static str) -> Self {
        Self { colour, width, dash }
    }

    pub(crate) fn attributes(&self) -> String {
        let dash =
            if self.dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{}\"", self.dash) };
        format!("stroke=\"{}\" stroke-width=\"{}\"{dash}", self.colour, super::number(self.width))
    }
}

/// Colours that people with any common colour vision tell apart (Okabe and Ito 2008, "Color Universal
/// Design"), yellow left out because it vanishes on white. Each has dashes of its own, for a grey print and
/// where lines coincide.
const MODELS: [Stroke; 10] = [
    Stroke::solid("#0072b2", 1.6),
    Stroke::dashed("#e69f00", 1.6, "6 3"),
    Stroke::dashed("#009e73", 1.6, "2 2.5"),
    Stroke::dashed("#cc79a7", 1.8, "12 2.5 2 2.5"),
    Stroke::dashed("#56b4e9", 1.8, "1.5 2 6 2"),
    Stroke::dashed("#d55e00", 1.8, "15 4"),
    Stroke::dashed("#6b6b6b", 1.6, "8 2 1.5 2 1.5 2"),
    Stroke::dashed("#7a4fa3", 1.6, "3 1.5"),
    Stroke::dashed("#8c6d1f", 1.8, "10 2 4 2"),
    Stroke::dashed("#1a1a1a", 1.4, "1 3"),
];

/// The style of the model at a place in its table; styles repeat after ten.
pub fn model_stroke(index: usize) -> Stroke {
    MODELS[index % MODELS.len()]
}

/// Colours of an ordered quantity, such as the power of the gauze: from dark blue over red to light orange.
/// On a grey print they have equal steps from dark to light, 10 of 255.
const SCALE: [&str; 13] = [
    "#22306e", "#3b3184", "#54329a", "#6f3699", "#8a3a98", "#a0428f", "#b54a86", "#c45773", "#d3645f",
    "#db7550", "#e28640", "#e39939", "#e3ab32",
];

/// The colour of step `index` of `count` on an ordered scale. Up to thirteen steps have colours of their own.
pub fn scale_colour(index: usize, count: usize) -> &'static str {
    let last = SCALE.len() - 1;
    let steps = count.saturating_sub(1);
    SCALE[(index * last + steps / 2).checked_div(steps).unwrap_or(last).min(last)]
}

/// Colours of areas between levels of a quantity, from blue over rose to light yellow: lines and dots of
/// [`INK`] are read on each of them, and on a grey print they have equal steps from dark to light.
const FILLS: [&str; 7] = ["#4a6fb5", "#8377bd", "#b986af", "#df9f98", "#f0bf8c", "#f7dd9a", "#fdf8cf"];

/// The colour of area `index` of `count`, from the lowest.
pub fn fill_colour(index: usize, count: usize) -> &'static str {
    let last = FILLS.len() - 1;
    FILLS[(index * last).checked_div(count.saturating_sub(1)).unwrap_or(last / 2).min(last)]
}

/// The line of step `index` of `count`: every other one is dashed, so that neighbours differ without colour
/// too.
pub fn scale_stroke(index: usize, count: usize, width: f64) -> Stroke {
    Stroke { colour: scale_colour(index, count), width, dash: if index % 2 == 1 { "5 2.5" } else { "" } }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lightness on a grey print, 0 to 255 (luma of ITU-R BT.601).
    fn grey(colour: &str) -> f64 {
        let part = |k: usize| f64::from(u8::from_str_radix(&colour[k..k + 2], 16).unwrap());
        0.299 * part(1) + 0.587 * part(3) + 0.114 * part(5)
    }

    #[test]
    fn exact_lines_differ_without_colour() {
        let dashes: std::collections::BTreeSet<_> = MODELS.iter().map(|m| m.dash).collect();
        assert_eq!(dashes.len(), MODELS.len());
        assert!(MODELS.iter().all(|m| grey(m.colour) < 170.0), "too light on white");
        assert!(
            SCALE.windows(2).all(|w| (7.0..13.0).contains(&(grey(w[1]) - grey(w[0])))),
            "{:?}",
            SCALE.map(grey)
        );
        assert!(grey(SCALE[12]) < 180.0, "too light on white");
        assert!(
            FILLS.windows(2).all(|w| (20.0..26.0).contains(&(grey(w[1]) - grey(w[0])))),
            "{:?}",
            FILLS.map(grey)
        );
        assert!(grey(FILLS[0]) > grey(INK) + 75.0, "lines are not read on it");
        assert_eq!((0..6).map(|k| fill_colour(k, 6)).collect::<std::collections::BTreeSet<_>>().len(), 6);
        for count in [2, 7, 8, 13] {
            let all: std::collections::BTreeSet<_> = (0..count).map(|k| scale_colour(k, count)).collect();
            assert_eq!(all.len(), count, "two of {count} have one colour");
        }
        assert_eq!([0, 3, 6].map(|k| scale_colour(k, 7)), [SCALE[0], SCALE[6], SCALE[12]]);
        assert_ne!(scale_stroke(2, 7, 1.0).dash, scale_stroke(3, 7, 1.0).dash);
    }
}
