//! One pair of axes and what is drawn in it, in data coordinates.

use super::axis::is_drawn;
use super::bar::ColourBar;
use super::style::TICK;
use super::{Axis, INK, Stroke, Symbol, number, px, text};

/// Font sizes in pixels of the panel's own coordinates.
const LABEL: f64 = 13.5;
const NOTE: f64 = 11.5;

/// Room around the frame: left, right, top, bottom.
const LEFT: f64 = 68.0;
const RIGHT: f64 = 22.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 44.0;

/// Width of a panel that becomes one column of a journal, pixels: letters then have 7 to 8 points.
pub const COLUMN: f64 = 430.0;

/// Radius of the dot of a measured point.
pub const DOT: f64 = 2.8;

/// A frame with two axes. What is drawn is clipped to the frame.
pub struct Panel {
    /// Width with labels, pixels.
    pub(crate) width: f64,
    /// Height with labels, pixels.
    pub(crate) height: f64,
    tag: String,
    x: Axis,
    y: Axis,
    body: String,
    /// Colour of the dots with which the body ends, if it ends with dots.
    dots: String,
    /// What the colours of areas mean.
    bar: Option<ColourBar>,
}

impl Panel {
    /// An empty panel; `tag` stands above its left corner, such as `(a)`.
    pub fn new(tag: &str, [width, height]: [f64; 2], x: Axis, y: Axis) -> Self {
        Self { width, height, tag: tag.to_owned(), x, y, body: String::new(), dots: String::new(), bar: None }
    }

    /// Puts a bar of colours beside the frame. To be called before anything is drawn.
    pub fn colour_bar(&mut self, bar: ColourBar) {
        self.bar = Some(bar);
    }

    /// A line through points. A point that cannot be drawn interrupts it.
    pub fn curve(&mut self, points: &[[f64; 2]], stroke: &Stroke) {
        for piece in points.split(|p| !(is_drawn(p[0]) && is_drawn(p[1]))).filter(|p| p.len() > 1) {
            let path = self.path(piece);
            self.stroked(&path, stroke);
        }
    }

    /// A line without filling, in one element with the line before it if that looks alike.
    fn stroked(&mut self, path: &str, stroke: &Stroke) {
        let tail = format!("\" fill=\"none\" {}/>", stroke.attributes());
        match self.body.strip_suffix(&tail) {
            Some(before) => self.body.truncate(before.len()),
            None => self.body += "<path d=\"",
        }
        self.body += path;
        self.body += &tail;
    }

    /// The line of one standard deviation of a Gaussian about a mean, with variances and covariance, as two
    /// arcs.
    pub fn ellipse(&mut self, mean: [f64; 2], [xx, yy, xy]: [f64; 3], stroke: &Stroke) {
        let [x, y] = self.at(mean);
        let [right, down] = self.at([mean[0] + 1.0, mean[1] + 1.0]);
        let (sx, sy) = (right - x, down - y);
        let (a, b, c) = (xx * sx * sx, yy * sy * sy, xy * sx * sy);
        let (middle, apart) = (0.5 * (a + b), (0.5 * (a - b)).hypot(c));
        let [long, short] = [middle + apart, middle - apart].map(|v| v.max(0.0).sqrt());
        let turn = 0.5 * (2.0 * c).atan2(a - b);
        let (dx, dy) = (long * turn.cos(), long * turn.sin());
        let arc = format!("A{} {} {} 1 0 ", px(long), px(short), px(turn.to_degrees()));
        let ends = [[x + dx, y + dy], [x - dx, y - dy]].map(|at| at.map(px).join(" "));
        self.stroked(&format!("M{0}{arc}{1}{arc}{0}", ends[0], ends[1]), stroke);
    }

    /// A closed line, such as a contour, with a fill (`none` or a colour) of the given opacity.
    pub fn contour(&mut self, points: &[[f64; 2]], stroke: &Stroke, fill: &str, opacity: f64) {
        let path = self.path(points);
        let opacity = number(opacity);
        self.body += &format!(
            "<path d=\"{path}Z\" fill=\"{fill}\" fill-opacity=\"{opacity}\" {}/>",
            stroke.attributes()
        );
    }

    /// A filled symbol with a remark that browsers show under the pointer. Of a measured point it begins with
    /// the name and a colon, by which the page finds it in all figures.
    pub fn point(&mut self, at: [f64; 2], radius: f64, symbol: Symbol, colour: &str, remark: &str) {
        let (at, remark) = (self.at(at), text::escape(remark));
        match self.body.strip_suffix("</g>").filter(|_| self.dots == colour) {
            Some(before) => self.body.truncate(before.len()),
            None => self.body += &format!("<g fill=\"{colour}\">"),
        }
        colour.clone_into(&mut self.dots);
        let ([x, y], r) = (at.map(px), px(radius));
        self.body += &match symbol {
            Symbol::Dot => {
                format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"><title>{remark}</title></circle></g>")
            }
            shape => format!("<path d=\"{}\"><title>{remark}</title></path></g>", shape.outline(at, radius)),
        };
    }

    /// A filled circle, as [`Panel::point`] draws it.
    pub fn dot(&mut self, at: [f64; 2], radius: f64, colour: &str, remark: &str) {
        self.point(at, radius, Symbol::Dot, colour, remark);
    }

    /// An open symbol.
    pub fn ring(&mut self, at: [f64; 2], radius: f64, symbol: Symbol, stroke: &Stroke) {
        let outline = symbol.outline(self.at(at), radius);
        self.stroked(&outline, stroke);
    }

    /// A patch between a lower and an upper line over the same places, `[x, low, high]`. A gap is a point not
    /// finite.
    pub fn band(&mut self, points: &[[f64; 3]], colour: &str, opacity: f64) {
        let finite = |p: &[f64; 3]| p.iter().all(|v| v.is_finite());
        for piece in points.split(|p| !finite(p)).filter(|p| p.len() > 1) {
            let low = piece.iter().map(|p| [p[0], p[1]]);
            let around: Vec<_> = low.chain(piece.iter().rev().map(|p| [p[0], p[2]])).collect();
            let (path, opacity) = (self.path(&around), number(opacity));
            self.body += &format!("<path d=\"{path}Z\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>");
        }
    }

    /// The area within closed lines; those that turn the other way are holes.
    pub fn area(&mut self, lines: &[Vec<[f64; 2]>], colour: &str, opacity: f64) {
        let path: String = lines.iter().map(|line| self.path(line) + "Z").collect();
        let opacity = number(opacity);
        self.body += &format!("<path d=\"{path}\" fill=\"{colour}\" fill-opacity=\"{opacity}\"/>");
    }

    /// A diagonal cross.
    pub fn cross(&mut self, point: [f64; 2], size: f64, stroke: &Stroke) {
        let [x, y] = self.at(point);
        let [left, right, top, bottom] = [x - size, x + size, y - size, y + size].map(px);
        self.stroked(&format!("M{left} {top}L{right} {bottom}M{left} {bottom}L{right} {top}"), stroke);
    }

    /// A vertical bar of half-length `half`, but none that a dot of radius [`DOT`] hides.
    pub fn error_bar(&mut self, [x, y]: [f64; 2], half: f64, stroke: &Stroke) {
        let [centre, low] = self.at([x, y - half]);
        let [_, high] = self.at([x, y + half]);
        if 0.5 * (low - high) >= DOT {
            self.stroked(&format!("M{} {}V{}", px(centre), px(low), px(high)), stroke);
        }
    }

    /// A vertical line across the frame.
    pub fn vertical(&mut self, x: f64, stroke: &Stroke) {
        let (low, high) = (self.y.low, self.y.high);
        self.curve(&[[x, low], [x, high]], stroke);
    }

    /// A horizontal line across the frame.
    pub fn horizontal(&mut self, y: f64, stroke: &Stroke) {
        let (low, high) = (self.x.low, self.x.high);
        self.curve(&[[low, y], [high, y]], stroke);
    }

    /// The panel as SVG elements with its origin at the upper left corner; `note` stands above the right
    /// corner.
    pub(crate) fn elements(&self, note: &str) -> String {
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
        let x = self.x.ticks_within(width, |label| text::width(label, TICK));
        let y = self.y.ticks();
        let mut marks = String::new();
        for (ticks, length) in [(&x.major, 6.0), (&x.minor, 3.0)] {
            let (length, across) = (px(length), px(height - 2.0 * length));
            for at in ticks.iter().map(|&v| px(LEFT + width * self.x.place(v))) {
                marks += &format!("M{at} {}v-{length}m0-{across}v-{length}", px(bottom));
            }
        }
        for (ticks, length) in [(&y.major, 6.0), (&y.minor, 3.0)] {
            let (length, across) = (px(length), px(width - 2.0 * length));
            for at in ticks.iter().map(|&v| px(bottom - height * self.y.place(v))) {
                marks += &format!("M{} {at}h{length}m{across} 0h{length}", px(LEFT));
            }
        }
        let frame = format!("M{} {}H{}V{}H{}Z", px(LEFT), px(TOP), px(right), px(bottom), px(LEFT));
        out += &format!("<path d=\"{frame}{marks}\" fill=\"none\" stroke=\"{INK}\"/>");
        let size = px(TICK);
        out += &format!("<g text-anchor=\"middle\" font-size=\"{size}\">");
        for (&value, label) in x.major.iter().zip(&x.labels) {
            let (at, y) = (px(LEFT + width * self.x.place(value)), px(bottom + 17.0));
            out += &format!("<text x=\"{at}\" y=\"{y}\">{}</text>", text::escape(label));
        }
        out += &format!("</g><g text-anchor=\"end\" font-size=\"{size}\">");
        for (&value, label) in y.major.iter().zip(&y.labels) {
            let (x, at) = (px(LEFT - 6.0), px(bottom - height * self.y.place(value) + 0.35 * TICK));
            out += &format!("<text x=\"{x}\" y=\"{at}\">{}</text>", text::escape(label));
        }
        out += "</g>";
        if let Some(bar) = &self.bar {
            out += &bar.elements([right + 12.0, TOP], height);
        }
        out += &text::element([LEFT + 0.5 * width, bottom + 37.0], false, "middle", LABEL, &self.x.label);
        // A label that is longer than the panel would run into others.
        let middle = TOP + 0.5 * height;
        let room = 2.0 * middle.min(self.height - middle);
        let size = LABEL * (room / text::width(&self.y.label, LABEL).max(room));
        out += &text::element([16.0, middle], true, "middle", size, &self.y.label);
        out += &text::element([LEFT, TOP - 8.0], false, "start", LABEL, &self.tag);
        out += &format!(
            "<g fill=\"#666\">{}</g>",
            text::element([self.width - RIGHT, TOP - 8.0], false, "end", NOTE, note)
        );
        out
    }

    /// Width and height of the frame.
    fn frame(&self) -> [f64; 2] {
        let beside = self.bar.as_ref().map_or(0.0, ColourBar::room);
        [self.width - LEFT - RIGHT - beside, self.height - TOP - BOTTOM]
    }

    /// Pixels within the frame.
    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.frame();
        [width * self.x.place(x), height * (1.0 - self.y.place(y))]
    }

    /// A line in steps from each point to the next, in tenths of a pixel, so that rounding does not add up.
    fn path(&self, points: &[[f64; 2]]) -> String {
        let mut all = points.iter().map(|&point| self.at(point).map(|v| (10.0 * v).round()));
        let Some(mut last) = all.next() else { return String::new() };
        let mut path = format!("M{} {}", px(0.1 * last[0]), px(0.1 * last[1]));
        for (k, [x, y]) in all.enumerate() {
            let [dx, dy] = [x - last[0], y - last[1]].map(|v| px(0.1 * v));
            // The marks of predictions are thousands.
            if points.len() == 2 && dy == "0" {
                return path + &format!("h{dx}");
            }
            let first = if k == 0 {
                "l"
            } else if dx.starts_with('-') {
                ""
            } else {
                " "
            };
            path += &format!("{first}{dx}{}{dy}", if dy.starts_with('-') { "" } else { " " });
            last = [x, y];
        }
        path
    }
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
            panel.body.contains("\"M0 50l50-50M60 25h40\"") && panel.body.matches("<path").count() == 1,
            "{}",
            panel.body
        );
    }

    #[test]
    fn exact_an_ellipse_touches_its_standard_deviations() {
        let mut panel = panel();
        // 10 and 5 pixels along the axes; then turned by 45 degrees, where the variances are 62.5 and the
        // covariance up is 37.5.
        panel.ellipse([0.5, 0.0], [0.01, 0.04, 0.0], &Stroke::solid("red", 1.0));
        assert!(panel.body.contains("M60 25A10 5 0 1 0 40 25A10 5 0 1 0 60 25"), "{}", panel.body);
        panel.ellipse([0.5, 0.0], [62.5e-4, 0.1, 37.5 / 2500.0], &Stroke::solid("blue", 1.0));
        assert!(panel.body.contains("M57.1 17.9A10 5 -45 1 0 42.9 32.1"), "{}", panel.body);
    }

    #[test]
    fn exact_a_long_label_stays_within_its_panel() {
        let size = |label: &str| {
            let panel = Panel::new("", [430.0, 240.0], Axis::new("x", 0.0, 1.0), Axis::new(label, 0.0, 1.0));
            let drawn = panel.elements("");
            let turned = drawn.split("rotate(-90)").nth(1).unwrap().split("font-size=\"").nth(1).unwrap();
            turned.split('"').next().unwrap().parse::<f64>().unwrap()
        };
        assert_eq!(size("Growth rate"), LABEL);
        let long = "ln Bayes factor between the drags of the gauze / nats";
        assert!(size(long) < LABEL && text::width(long, size(long)) < 222.0, "{}", size(long));
    }

    #[test]
    fn exact_symbols_are_drawn_and_found_by_their_remark() {
        let mut panel = panel();
        panel.dot([0.5, 0.0], 3.0, "red", "a: 1");
        panel.point([0.5, 0.0], 3.0, Symbol::of(1), "red", "b: 2");
        panel.ring([0.5, 0.0], 5.0, Symbol::of(1), &Stroke::solid("blue", 1.0));
        assert!(panel.body.contains("<path d=\"M47.3 22.3"), "{}", panel.body);
        assert!(panel.body.contains("<title>b: 2</title></path></g>"), "{}", panel.body);
        assert!(panel.body.contains("<path d=\"M45.5 20.5") && panel.body.ends_with("/>"), "{}", panel.body);
    }

    #[test]
    fn exact_error_bar_spans_plus_and_minus() {
        let mut panel = panel();
        panel.error_bar([0.5, 0.0], 0.5, &Stroke::solid("red", 1.0));
        assert!(panel.body.contains("M50 37.5V12.5"), "{}", panel.body);
        let before = panel.body.clone();
        panel.error_bar([0.5, 0.0], 0.08, &Stroke::solid("red", 1.0));
        assert_eq!(panel.body, before, "a dot of 2.8 pixels hides a bar of 2");
    }
}
