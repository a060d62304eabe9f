//! Labels: `*italic*`, `_{below}` and `^{above}`, for SVG, HTML and plain text from the same source.

use super::metrics::advance;

/// Size of sub- and superscripts, and how far they leave the baseline, relative to the font size.
const SMALL: f64 = 0.72;
const DROP: f64 = 0.22;
const RISE: f64 = 0.38;

/// Room for fonts that are wider than Helvetica: between stretches that have places of their own, and for a
/// label as a whole.
const LOOSE: f64 = 1.06;
const ROOM: f64 = 1.15;

/// The label as HTML.
pub fn html(label: &str) -> String {
    let element = |run: &Run| {
        let text = typeset(run);
        let text = if run.italic { format!("<i>{text}</i>") } else { text };
        match run.level {
            Level::Base => text,
            Level::Below => format!("<sub>{text}</sub>"),
            Level::Above => format!("<sup>{text}</sup>"),
        }
    };
    runs(label).iter().map(element).collect()
}

/// The label without its marks, for titles.
pub(crate) fn plain(label: &str) -> String {
    let element = |run: &Run| match run.level {
        Level::Base => run.text.to_owned(),
        Level::Below => format!("_{}", run.text),
        Level::Above => format!("^{}", run.text),
    };
    runs(label).iter().map(element).collect()
}

/// The label as an SVG `text` element of the given font size. `anchor` is `start`, `middle` or `end`. A
/// `turned` label reads upward.
///
/// Every stretch of a label with several has a place of its own, because some converters lose count of
/// shifts (`dy`) where a text is turned, and of the width of several stretches where it does not start there.
/// A stretch before a sub- or superscript ends where that begins, so that in a font of other widths the gap
/// falls between words. A level text that is anchored at its start flows, as it may be long.
pub(crate) fn element([x, y]: [f64; 2], turned: bool, anchor: &str, size: f64, label: &str) -> String {
    use super::px;
    let (at, [x, y]) = match turned {
        true => (format!("transform=\"translate({} {}) rotate(-90)\"", px(x), px(y)), [0.0; 2]),
        false => (String::new(), [x, y]),
    };
    let runs = runs(label);
    let large = px(size);
    if let [run] = &runs[..]
        && run.level == Level::Base
        && !run.italic
    {
        let at = if turned { at } else { format!("x=\"{}\" y=\"{}\"", px(x), px(y)) };
        return format!("<text {at} text-anchor=\"{anchor}\" font-size=\"{large}\">{}</text>", typeset(run));
    }
    // Viewers drop spaces at the edge of an element, unless they do not break.
    let unbroken = |run: &Run| {
        let mut text = typeset(run);
        if text.starts_with(' ') {
            text.replace_range(..1, "\u{a0}");
        }
        if text.ends_with(' ') {
            text.replace_range(text.len() - 1.., "\u{a0}");
        }
        text
    };
    let look = |run: &Run| {
        let small = match run.level {
            Level::Base => String::new(),
            _ => format!(" font-size=\"{}\"", px(SMALL * size)),
        };
        small + if run.italic { " font-style=\"italic\"" } else { "" }
    };
    let raised = |run: &Run| match run.level {
        Level::Base => 0.0,
        Level::Below => DROP * size,
        Level::Above => -RISE * size,
    };
    if anchor == "start" && !turned {
        let (mut out, mut height) = (String::new(), 0.0);
        for run in &runs {
            let (step, text) = (raised(run) - height, unbroken(run));
            let step = if step == 0.0 { String::new() } else { format!(" dy=\"{}\"", px(step)) };
            let attributes = step + &look(run);
            out += &if attributes.is_empty() { text } else { format!("<tspan{attributes}>{text}</tspan>") };
            height = raised(run);
        }
        return format!("<text x=\"{}\" y=\"{}\" font-size=\"{large}\">{out}</text>", px(x), px(y));
    }
    let before = match anchor {
        "middle" => 0.5,
        "end" => 1.0,
        _ => 0.0,
    };
    let wide = |run: &Run| LOOSE * size * run.width();
    let mut left = x - before * runs.iter().map(wide).sum::<f64>();
    let mut out = format!("<text {at}{}font-size=\"{large}\">", if turned { " " } else { "" });
    for (k, run) in runs.iter().enumerate() {
        let right = left + wide(run);
        let ends = run.level == Level::Base && runs.get(k + 1).is_some_and(|next| next.level != Level::Base);
        let (x, anchor) = if ends { (right, " text-anchor=\"end\"") } else { (left, "") };
        let (x, y, look, text) = (px(x), px(y + raised(run)), look(run), unbroken(run));
        out += &format!("<tspan x=\"{x}\" y=\"{y}\"{anchor}{look}>{text}</tspan>");
        left = right;
    }
    out + "</text>"
}

/// Width of a label in pixels, with room for fonts that are wider than Helvetica.
pub(crate) fn width(label: &str, size: f64) -> f64 {
    ROOM * size * runs(label).iter().map(Run::width).sum::<f64>()
}

/// The label in lines that are no wider than `room` where it has spaces; italics stay on one line.
pub(crate) fn wrapped(label: &str, size: f64, room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in label.split_inclusive(' ') {
        match lines.last_mut() {
            Some(line)
                if line.matches('*').count() % 2 == 1
                    || width(line, size) + width(word.trim_end(), size) <= room =>
            {
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A number with `decimals` decimals and a true minus sign.
pub fn fixed(value: f64, decimals: usize) -> String {
    rijke_numerics::words::fixed(value, decimals).replace('-', "\u{2212}")
}

/// Text that is safe inside an element or an attribute of HTML, or of SVG.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// A stretch of a label in one style.
#[derive(Debug, PartialEq, Eq)]
struct Run<'a> {
    text: &'a str,
    italic: bool,
    level: Level,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Level {
    Base,
    Below,
    Above,
}

impl Run<'_> {
    /// Width at size 1.
    fn width(&self) -> f64 {
        let text = if self.level == Level::Above {
            self.text.replace('-', "\u{2212}")
        } else {
            self.text.to_owned()
        };
        let scale = if self.level == Level::Base { 1.0 } else { SMALL };
        scale * advance(&text, self.italic)
    }
}

/// The text of a stretch, escaped, with a true minus sign in exponents.
fn typeset(run: &Run) -> String {
    let text = escape(run.text);
    if run.level == Level::Above { text.replace('-', "\u{2212}") } else { text }
}

/// Cuts a label into stretches. A mark that is not closed is ordinary text, but a `^` before a number, as
/// units have it.
fn runs(label: &str) -> Vec<Run<'_>> {
    let (mut runs, mut rest, mut italic) = (Vec::new(), label, false);
    while !rest.is_empty() {
        let special = rest.find(['*', '_', '^']).unwrap_or(rest.len());
        if special > 0 {
            runs.push(Run { text: &rest[..special], italic, level: Level::Base });
            rest = &rest[special..];
            continue;
        }
        let (mark, tail) = rest.split_at(1);
        if mark == "*" && (italic || tail.contains('*')) {
            italic = !italic;
            rest = tail;
        } else if let Some((inside, after)) = tail.strip_prefix('{').and_then(|t| t.split_once('}')) {
            let level = if mark == "_" { Level::Below } else { Level::Above };
            runs.push(Run { text: inside, italic: false, level });
            rest = after;
        } else if let Some((inside, after)) = power(tail).filter(|_| mark == "^") {
            runs.push(Run { text: inside, italic: false, level: Level::Above });
            rest = after;
        } else {
            runs.push(Run { text: mark, italic, level: Level::Base });
            rest = tail;
        }
    }
    runs
}

/// The whole number, or the number in brackets such as `(-1/2)`, with which a text begins; and what follows.
fn power(text: &str) -> Option<(&str, &str)> {
    if let Some((inside, after)) = text.strip_prefix('(').and_then(|t| t.split_once(')')) {
        let number = |c: char| c.is_ascii_digit() || "-/.".contains(c);
        return (inside.contains(|c: char| c.is_ascii_digit()) && inside.chars().all(number))
            .then_some((inside, after));
    }
    let digits = text.strip_prefix('-').unwrap_or(text);
    let count = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    (count > 0).then(|| text.split_at(text.len() - digits.len() + count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_one_label_three_ways() {
        let label = "*s*_{r} / s^{-1} < 0";
        assert_eq!(html(label), "<i>s</i><sub>r</sub> / s<sup>\u{2212}1</sup> &lt; 0");
        assert_eq!(plain(label), "s_r / s^-1 < 0");
        // s is 5 wide, r 0.72 of 3.33, all with 6 %; each stretch stands where the one before it ends.
        let text = element([0.0, 50.0], true, "start", 10.0, label);
        assert_eq!(
            text,
            "<text transform=\"translate(0 50) rotate(-90)\" font-size=\"10\">\
             <tspan x=\"5.3\" y=\"0\" text-anchor=\"end\" font-style=\"italic\">s</tspan>\
             <tspan x=\"5.3\" y=\"2.2\" font-size=\"7.2\">r</tspan>\
             <tspan x=\"22\" y=\"0\" text-anchor=\"end\">\u{a0}/ s</tspan>\
             <tspan x=\"22\" y=\"-3.8\" font-size=\"7.2\">\u{2212}1</tspan>\
             <tspan x=\"30.7\" y=\"0\">\u{a0}&lt; 0</tspan></text>"
        );
        assert_eq!(
            element([1.0, 2.0], false, "start", 10.0, "*s*_{r} a"),
            "<text x=\"1\" y=\"2\" font-size=\"10\"><tspan font-style=\"italic\">s</tspan><tspan dy=\"2.2\" \
             font-size=\"7.2\">r</tspan><tspan dy=\"-2.2\">\u{a0}a</tspan></text>"
        );
        let plain = element([1.0, 2.0], false, "middle", 10.0, "a < b");
        assert_eq!(plain, "<text x=\"1\" y=\"2\" text-anchor=\"middle\" font-size=\"10\">a &lt; b</text>");
    }

    #[test]
    fn exact_unclosed_marks_are_text() {
        assert_eq!(html("a_b ^ 5*"), "a_b ^ 5*");
        assert_eq!(html("m^3 s^-1, 2^n, f^(a)"), "m<sup>3</sup> s<sup>\u{2212}1</sup>, 2^n, f^(a)");
        assert_eq!(html("Pr^(-1/2) w"), "Pr<sup>\u{2212}1/2</sup> w");
    }

    #[test]
    fn exact_long_labels_are_wrapped() {
        let room = width("a delay and x", 10.0);
        let lines = wrapped("a delay and *two words* of it", 10.0, room);
        assert_eq!(lines, ["a delay and ", "*two words* of ", "it"]);
        assert_eq!(wrapped("endless", 10.0, 1.0), ["endless"]);
    }

    #[test]
    fn exact_minus_signs() {
        assert_eq!([fixed(-1.25, 1), fixed(-0.001, 2), fixed(2.0, 0)], ["\u{2212}1.2", "0.00", "2"]);
    }
}
