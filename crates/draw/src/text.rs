//! Labels: `*italic*`, `_{below}` and `^{above}`, for SVG, HTML and plain text from the same source.

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

/// Size of sub- and superscripts, and how far they leave the baseline, relative to the font size.
const SMALL: f64 = 0.72;
const DROP: f64 = 0.22;
const RISE: f64 = 0.38;

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

/// The label as the content of an SVG `text` element of the given font size. Shifts are absolute, because not
/// every viewer knows `baseline-shift`.
pub(crate) fn svg(label: &str, size: f64) -> String {
    let (mut out, mut height) = (String::new(), 0.0);
    for run in &runs(label) {
        let target = match run.level {
            Level::Base => 0.0,
            Level::Below => DROP * size,
            Level::Above => -RISE * size,
        };
        let mut attributes = String::new();
        if target != height {
            attributes += &format!(" dy=\"{}\"", super::px(target - height));
            height = target;
        }
        if run.level != Level::Base {
            attributes += &format!(" font-size=\"{}\"", super::px(SMALL * size));
        }
        if run.italic {
            attributes += " font-style=\"italic\"";
        }
        // Viewers drop spaces at the edge of an element, unless they do not break.
        let mut text = typeset(run);
        if text.starts_with(' ') {
            text.replace_range(..1, "\u{a0}");
        }
        if text.ends_with(' ') {
            text.replace_range(text.len() - 1.., "\u{a0}");
        }
        out += &if attributes.is_empty() { text } else { format!("<tspan{attributes}>{text}</tspan>") };
    }
    out
}

/// Width of a label in pixels, from the mean width of a letter in common sans-serif fonts; good to about a
/// tenth.
pub(crate) fn width(label: &str, size: f64) -> f64 {
    let widths = runs(label)
        .iter()
        .map(|run| {
            let scale = if run.level == Level::Base { 1.0 } else { SMALL };
            0.53 * scale * run.text.chars().count() as f64
        })
        .sum::<f64>();
    size * widths
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
    let text = format!("{value:.decimals$}");
    let zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
    match text.strip_prefix('-') {
        Some(text) if zero => text.to_owned(),
        Some(text) => format!("\u{2212}{text}"),
        None => text,
    }
}

/// The text of a stretch, escaped, with a true minus sign in exponents.
fn typeset(run: &Run) -> String {
    let text = escape(run.text);
    if run.level == Level::Above { text.replace('-', "\u{2212}") } else { text }
}

/// Text that is safe inside an element or an attribute of HTML, or of SVG.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Cuts a label into stretches. A mark that is not closed is ordinary text, but a `^` before a whole number,
/// as units have it.
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
        } else if let Some(end) = power(tail).filter(|_| mark == "^") {
            runs.push(Run { text: &tail[..end], italic: false, level: Level::Above });
            rest = &tail[end..];
        } else {
            runs.push(Run { text: mark, italic, level: Level::Base });
            rest = tail;
        }
    }
    runs
}

/// Where the whole number ends with which a text begins.
fn power(text: &str) -> Option<usize> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let count = digits.find(|c: char| !c.is_ascii_digit()).unwrap_or(digits.len());
    (count > 0).then_some(text.len() - digits.len() + count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_one_label_three_ways() {
        let label = "*s*_{r} / s^{-1} < 0";
        assert_eq!(html(label), "<i>s</i><sub>r</sub> / s<sup>\u{2212}1</sup> &lt; 0");
        assert_eq!(plain(label), "s_r / s^-1 < 0");
        assert_eq!(
            svg(label, 10.0),
            "<tspan font-style=\"italic\">s</tspan><tspan dy=\"2.2\" font-size=\"7.2\">r</tspan>\
             <tspan dy=\"-2.2\">\u{a0}/ s</tspan><tspan dy=\"-3.8\" font-size=\"7.2\">\u{2212}1</tspan>\
             <tspan dy=\"3.8\">\u{a0}&lt; 0</tspan>"
        );
    }

    #[test]
    fn exact_unclosed_marks_are_text() {
        assert_eq!(html("a_b ^ 5*"), "a_b ^ 5*");
        assert_eq!(html("m^3 s^-1, 2^n, Pr^(-1/2)"), "m<sup>3</sup> s<sup>\u{2212}1</sup>, 2^n, Pr^(-1/2)");
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
