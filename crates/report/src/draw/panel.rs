//! One pair of axes and what is drawn in it, in data coordinates.

use super::{Axis, INK, Stroke, px, text};

/// Font sizes in pixels of the panel's own coordinates.
const LABEL: f64 = 13.5;
const TICK: f64 = 12.0;
const NOTE: f64 = 11.5;

/// Room around the frame: left, right, top, bottom.
const LEFT: f64 = 68.0;
const RIGHT: f64 = 22.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 44.0;

/// A frame with two axes. What is drawn is clipped to the frame.
pub(crate) struct Panel {
    /// Width with labels, pixels.
    pub(super) width: f64,
    /// Height with labels, pixels.
    pub(super) height: f64,
    tag: String,
    x: Axis,
    y: Axis,
    body: String,
}

impl Panel {
    /// An empty panel; `tag` stands above its left corner, such as `(a)`.
    pub(crate) fn new(tag: &str, [width, height]: [f64; 2], x: Axis, y: Axis) -> Self {
        Self { width, height, tag: tag.to_owned(), x, y, body: String::new() }
    }

    /// A line through points. A point that is not finite interrupts it.
    pub(crate) fn curve(&mut self, points: &[[f64; 2]], stroke: &Stroke) {
        for piece in points.split(|p| !(p[0].is_finite() && p[1].is_finite())).filter(|p| p.len() > 1) {
            let path = self.path(piece);
            self.body += &format!("<path d=\"{path}\" fill=\"none\" {}/>", stroke.attributes());
        }
    }

    /// A closed line, such as a contour, with a fill (`none` or a colour) of the given opacity.
    pub(crate) fn contour(&mut self, points: &[[f64; 2]], stroke: &Stroke, fill: &str, opacity: f64) {
        let path = self.path(points);
        let opacity = px(opacity);
        self.body += &format!(
            "<path d=\"{path}Z\" fill=\"{fill}\" fill-opacity=\"{opacity}\" {}/>",
            stroke.attributes()
        );
    }

    /// A filled circle with a remark that browsers show under the pointer.
    pub(crate) fn dot(&mut self, at: [f64; 2], radius: f64, colour: &str, remark: &str) {
        self.circle(at, radius, colour, remark, "");
    }

    /// The same for the measured point `name`, by which the page finds it in all figures.
    pub(crate) fn measured(&mut self, at: [f64; 2], radius: f64, colour: &str, remark: &str, name: &str) {
        self.circle(at, radius, colour, remark, &format!(" data-point=\"{}\"", text::escape(name)));
    }

    fn circle(&mut self, [x, y]: [f64; 2], radius: f64, colour: &str, remark: &str, more: &str) {
        let ([x, y], radius, remark) = (self.at([x, y]).map(px), px(radius), text::escape(remark));
        self.body += &format!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{colour}\"{more}><title>{remark}</title></circle>"
        );
    }

    /// A patch between a lower and an upper line over the same places, `[x, low, high]`. A gap is a point not finite.
    pub(crate) fn band(&mut self, points: &[[f64; 3]], colour: &str, opacity: f64) {
        let finite = |p: &[f64; 3]| p.iter().all(|v| v.is_finite());
        for piece in points.split(|p| !finite(p)).filter(|p| p.len() > 1) {
            let low = piece.iter().map(|p| [p[0], p[1]]);
            let around: Vec<_> = low.chain(piece.iter().rev().map(|p| [p[0], p[2]])).collect();
            let (path, opacity) = (self.path(&around), px(opacity));
            self.body += &format!("<path d=\"{path}Z\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>");
        }
    }

    /// A diagonal cross.
    pub(crate) fn cross(&mut self, point: [f64; 2], size: f64, stroke: &Stroke) {
        let [x, y] = self.at(point);
        let [left, right, top, bottom] = [x - size, x + size, y - size, y + size].map(px);
        self.body += &format!(
            "<path d=\"M{left} {top}L{right} {bottom}M{left} {bottom}L{right} {top}\" fill=\"none\" {}/>",
            stroke.attributes()
        );
    }

    /// A vertical bar of half-length `half` with caps, moved sideways by `offset` pixels.
    pub(crate) fn error_bar(&mut self, [x, y]: [f64; 2], half: f64, offset: f64, stroke: &Stroke) {
        let [centre, low] = self.at([x, y - half]);
        let [_, high] = self.at([x, y + half]);
        let [left, centre, right] = [-1.3, 0.0, 1.3].map(|cap| px(centre + offset + cap));
        let (low, high) = (px(low), px(high));
        self.body += &format!(
            "<path d=\"M{left} {low}H{right}M{centre} {low}V{high}M{left} {high}H{right}\" fill=\"none\" {}/>",
            stroke.attributes()
        );
    }

    /// A vertical line across the frame.
    pub(crate) fn vertical(&mut self, x: f64, stroke: &Stroke) {
        let (low, high) = (self.y.low, self.y.high);
        self.curve(&[[x, low], [x, high]], stroke);
    }

    /// A horizontal line across the frame.
    pub(crate) fn horizontal(&mut self, y: f64, stroke: &Stroke) {
        let (low, high) = (self.x.low, self.x.high);
        self.curve(&[[low, y], [high, y]], stroke);
    }

    /// The panel as SVG elements with its origin at the upper left corner; `note` stands above the right corner.
    pub(super) fn elements(&self, note: &str) -> String {
        let [width, height] = self.frame();
        let (bottom, right) = (TOP + height, LEFT + width);
        let mut out = format!(
            "<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\">{}</svg>",
            px(LEFT),
            px(TOP),
            px(width),
            px(height),
            self.body
        );
        let (x, y) = (self.x.ticks(), self.y.ticks());
        let mut marks = String::new();
        for (ticks, length) in [(&x.major, 6.0), (&x.minor, 3.0)] {
            for at in ticks.iter().map(|&v| px(LEFT + width * self.x.place(v))) {
                let (up, down) = (px(bottom - length), px(TOP + length));
                marks += &format!("M{at} {}V{up}M{at} {}V{down}", px(bottom), px(TOP));
            }
        }
        for (ticks, length) in [(&y.major, 6.0), (&y.minor, 3.0)] {
            for at in ticks.iter().map(|&v| px(bottom - height * self.y.place(v))) {
                let (inward, outward) = (px(LEFT + length), px(right - length));
                marks += &format!("M{} {at}H{inward}M{} {at}H{outward}", px(LEFT), px(right));
            }
        }
        let frame = format!("M{} {}H{}V{}H{}Z", px(LEFT), px(TOP), px(right), px(bottom), px(LEFT));
        out += &format!("<path d=\"{frame}{marks}\" fill=\"none\" stroke=\"{INK}\"/>");
        for &value in &x.major {
            let at = LEFT + width * self.x.place(value);
            out += &write([at, bottom + 17.0], "middle", TICK, &text::fixed(value, x.decimals));
        }
        for &value in &y.major {
            let at = bottom - height * self.y.place(value);
            out += &write([LEFT - 6.0, at + 0.35 * TICK], "end", TICK, &text::fixed(value, y.decimals));
        }
        out += &write([LEFT + 0.5 * width, bottom + 37.0], "middle", LABEL, &self.x.label);
        let middle = px(TOP + 0.5 * height);
        out += &format!(
            "<text transform=\"translate(16 {middle}) rotate(-90)\" text-anchor=\"middle\" font-size=\"{}\">{}</text>",
            px(LABEL),
            text::svg(&self.y.label, LABEL)
        );
        out += &write([LEFT, TOP - 8.0], "start", LABEL, &self.tag);
        out += &format!("<g fill=\"#666\">{}</g>", write([right, TOP - 8.0], "end", NOTE, note));
        out
    }

    /// Width and height of the frame.
    fn frame(&self) -> [f64; 2] {
        [self.width - LEFT - RIGHT, self.height - TOP - BOTTOM]
    }

    /// Pixels within the frame.
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.frame();
        [width * self.x.place(x), height * (1.0 - self.y.place(y))]
    }

    fn path(&self, points: &[[f64; 2]]) -> String {
        let words = points.iter().enumerate().map(|(i, &point)| {
            let [x, y] = self.at(point).map(px);
            format!("{}{x} {y}", if i == 0 { "M" } else { "L" })
        });
        words.collect()
    }
}

/// A text element; `anchor` is `start`, `middle` or `end`.
pub(super) fn write([x, y]: [f64; 2], anchor: &str, size: f64, label: &str) -> String {
    let (x, y, content, size) = (px(x), px(y), text::svg(label, size), px(size));
    format!("<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" font-size=\"{size}\">{content}</text>")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel() -> Panel {
        // A frame of 100 by 50 pixels.
        let size = [100.0 + LEFT + RIGHT, 50.0 + TOP + BOTTOM];
        Panel::new("(a)", size, Axis::new("x", 0.0, 1.0), Axis::new("y", -1.0, 1.0))
    }

    #[test]
    fn exact_y_points_up_and_gaps_interrupt() {
        let mut panel = panel();
        let nan = f64::NAN;
        panel.curve(
            &[[0.0, -1.0], [0.5, 1.0], [nan, nan], [0.6, 0.0], [1.0, 0.0]],
            &Stroke::solid("red", 1.0),
        );
        assert!(
            panel.body.contains("M0 50L50 0\"") && panel.body.contains("M60 25L100 25\""),
            "{}",
            panel.body
        );
    }

    #[test]
    fn exact_error_bar_spans_plus_and_minus() {
        let mut panel = panel();
        panel.error_bar([0.5, 0.0], 0.5, 10.0, &Stroke::solid("red", 1.0));
        assert!(panel.body.contains("M60 37.5V12.5"), "{}", panel.body);
    }
}
