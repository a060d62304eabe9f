//! The lines of `d` attributes.

use super::drawing;
use pdf_writer::Content;
use rijke_numerics::Failed;

/// Length of the handles of a quarter of a circle of radius 1 as a cubic curve.
const QUARTER: f64 = 0.552_284_749_830_793_4;

/// Adds the path to a page. An arc must be half an ellipse.
pub(super) fn add(d: &str, content: &mut Content) -> Result<(), Failed> {
    let bad = || drawing(&format!("the path {d}"));
    let (mut at, mut start) = ([0.0; 2], [0.0; 2]);
    let mut rest = d.trim_start();
    while let Some(letter) = rest.chars().next() {
        rest = &rest[letter.len_utf8()..];
        let numbers = numbers(&mut rest).ok_or_else(bad)?;
        let count = match letter {
            'M' | 'm' | 'L' | 'l' => 2,
            'H' | 'h' | 'V' | 'v' => 1,
            'A' => 7,
            'Z' if numbers.is_empty() => {
                content.close_path();
                at = start;
                continue;
            }
            _ => return Err(bad()),
        };
        if numbers.is_empty() || numbers.len() % count != 0 {
            return Err(bad());
        }
        for (k, n) in numbers.chunks(count).enumerate() {
            let from = if letter.is_lowercase() { at } else { [0.0; 2] };
            let before = at;
            at = match letter.to_ascii_lowercase() {
                'h' => [from[0] + n[0], at[1]],
                'v' => [at[0], from[1] + n[0]],
                'a' => [n[5], n[6]],
                _ => [from[0] + n[0], from[1] + n[1]],
            };
            let [x, y] = at.map(|v| v as f32);
            match letter {
                'M' | 'm' if k == 0 => {
                    start = at;
                    content.move_to(x, y);
                }
                'A' if n[4] == 0.0 => half(before, at, n[1], n[2].to_radians(), content),
                'A' => return Err(bad()),
                _ => {
                    content.line_to(x, y);
                }
            }
        }
    }
    Ok(())
}

/// A circle.
pub(super) fn circle([x, y]: [f64; 2], radius: f64, content: &mut Content) {
    content.move_to((x + radius) as f32, y as f32);
    half([x + radius, y], [x - radius, y], radius, 0.0, content);
    half([x - radius, y], [x + radius, y], radius, 0.0, content);
    content.close_path();
}

/// Half an ellipse between the ends of one of its axes, which is turned by an angle; `other` is half the
/// other axis. Runs against the hand of the clock, as an SVG arc whose last flag is 0.
fn half(from: [f64; 2], to: [f64; 2], other: f64, turn: f64, content: &mut Content) {
    let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
    let u = [from[0] - middle[0], from[1] - middle[1]];
    let side = if u[0] * turn.cos() + u[1] * turn.sin() > 0.0 { -other } else { other };
    let w = [-side * turn.sin(), side * turn.cos()];
    let at = |a: f64, b: f64| [0, 1].map(|k| (middle[k] + a * u[k] + b * w[k]) as f32);
    for [p, q, r] in [
        [at(1.0, QUARTER), at(QUARTER, 1.0), at(0.0, 1.0)],
        [at(-QUARTER, 1.0), at(-1.0, QUARTER), at(-1.0, 0.0)],
    ] {
        content.cubic_to(p[0], p[1], q[0], q[1], r[0], r[1]);
    }
}

/// The numbers before the next letter; none if something else stands there. A minus sign begins a number.
fn numbers(rest: &mut &str) -> Option<Vec<f64>> {
    let end = rest.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(rest.len());
    let (these, after) = rest.split_at(end);
    *rest = after;
    these.replace('-', " -").split_whitespace().map(|n| n.parse().ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(d: &str) -> String {
        let mut content = Content::new();
        add(d, &mut content).unwrap();
        String::from_utf8(content.finish().to_vec()).unwrap()
    }

    #[test]
    fn exact_relative_steps_add_up() {
        assert_eq!(lines("M10 20l1-2 3 4h5v-6Z"), "10 20 m\n11 18 l\n14 22 l\n19 22 l\n19 16 l\nh");
        assert_eq!(lines("M1 2H3V4m0-1v-1"), "1 2 m\n3 2 l\n3 4 l\n3 3 m\n3 2 l");
        assert!(add("M1 2Q3 4", &mut Content::new()).is_err() && add("M1", &mut Content::new()).is_err());
    }

    #[test]
    fn exact_half_an_ellipse_runs_as_the_arc_does() {
        // Of half axes 10 and 5; against the clock from its right end lies its top, whose y is less.
        let arc = lines("M60 25A10 5 0 1 0 40 25");
        assert!(arc.contains("50 20 c") && arc.ends_with("40 25 c"), "{arc}");
        let back = lines("M40 25A10 5 0 1 0 60 25");
        assert!(back.contains("50 30 c") && back.ends_with("60 25 c"), "{back}");
        // Turned by 90 degrees with the clock: its first axis points down, and against the clock from its
        // lower end lies its right end.
        let turned = lines("M50 35A10 5 90 1 0 50 15");
        assert!(turned.contains("55 25 c"), "{turned}");
    }
}
