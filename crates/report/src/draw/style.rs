//! Colours and line styles.

/// Colour of axes, text and measured points.
pub(crate) const INK: &str = "#1a1a1a";

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    /// Colour.
    pub(crate) colour: &'static str,
    /// Width in pixels.
    pub(crate) width: f64,
    /// Lengths of dashes and gaps; empty for a solid line.
    pub(crate) dash: &'static str,
}

impl Stroke {
    pub(crate) const fn solid(colour: &'static str, width: f64) -> Self {
        Self { colour, width, dash: "" }
    }

    pub(crate) const fn dashed(colour: &'static str, width: f64, dash: &'static str) -> Self {
        Self { colour, width, dash }
    }

    pub(super) fn attributes(&self) -> String {
        let dash =
            if self.dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{}\"", self.dash) };
        format!("stroke=\"{}\" stroke-width=\"{}\"{dash}", self.colour, super::number(self.width))
    }
}

/// Colours that people with any common colour vision tell apart (Okabe and Ito 2008, "Color Universal Design"), yellow
/// left out because it vanishes on white. Dashes tell models apart on a grey print, and where lines coincide.
const MODELS: [Stroke; 7] = [
    Stroke::solid("#0072b2", 1.6),
    Stroke::dashed("#e69f00", 1.6, "6 3"),
    Stroke::dashed("#009e73", 1.6, "2 2.5"),
    Stroke::dashed("#cc79a7", 1.8, "9 3"),
    Stroke::dashed("#56b4e9", 1.8, "1.5 2 6 2"),
    Stroke::solid("#d55e00", 2.0),
    Stroke::dashed("#6b6b6b", 1.6, "4 2"),
];

/// The style of the model at a place in its table; styles repeat after seven.
pub(crate) fn model_stroke(index: usize) -> Stroke {
    MODELS[index % MODELS.len()]
}

/// Colours of an ordered quantity, such as the power of the gauze: from blue over green to red, each darker than the paper.
const SCALE: [&str; 7] = ["#2b4c7e", "#3c7bb0", "#2f9c95", "#6a9c3f", "#c29a1b", "#de6f26", "#b3202c"];

/// The colour of step `index` of `count` on an ordered scale.
pub(crate) fn scale_colour(index: usize, count: usize) -> &'static str {
    let last = SCALE.len() - 1;
    SCALE[(index * last).checked_div(count.saturating_sub(1)).unwrap_or(last).min(last)]
}
