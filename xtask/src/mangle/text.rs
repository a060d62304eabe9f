//! Changes of text: of numbers, lines, cells, keys, units and names, and of the bytes that hold them.

use super::{
    binary,
    changed::{Changed, replaced},
    lines,
    stream::Stream,
};
use std::ops::Range;

/// Numbers that a reader must refuse, or compute with.
const NUMBERS: &str = "0|-0.0|-1|1|2|1e308|-1e308|1e-308|-1e-308|5e-324|1e400|nan|NaN|inf|-inf|1e9|-1e9|1e-9|\
    1e17|99999999999999999999|9223372036854775807|4294967296|0x10|1_000|0.5.5|\"\"|true|[]|\
    {}|[[1e308, nan], [0]]";

/// Units, each in place of another.
const UNITS: &str = "1|m|mm|m^2|s|ms|Hz|kHz|rpm|rad/s|1/s|K|degC|degF|Pa|kPa|bar|W|kW|L/min|%|deg|V|furlong";

/// Names of files, ids and words of the language, which stand for what they are not.
const WORDS: &str = "| |..|/|/dev/zero|/dev/full|.|a/b|nul\\u0000|\u{1F525}|open|closed|duct|x_g|s|1/0|\
    exp(exp(exp(s)))|s^s^s^s|0/0|$nothing";

/// One of several words with a bar between.
fn one(words: &'static str, stream: &mut Stream) -> &'static str {
    let all: Vec<&str> = words.split('|').collect();
    all[stream.below(all.len())]
}

/// Changes `bytes` at one place, as text if they are text.
pub(super) fn change(bytes: &[u8], stream: &mut Stream) -> Changed {
    let Ok(text) = std::str::from_utf8(bytes) else { return binary::change(bytes, stream) };
    for _ in 0..20 {
        let changed = match stream.below(100) {
            0..45 => number(text, stream),
            45..70 => lines::change(text, stream),
            70..78 => unit(text, stream),
            78..86 => word(text, stream),
            86..89 => deep(text, stream),
            89..94 => Some(whole(text, stream)),
            _ => Some(binary::change(bytes, stream)),
        };
        if let Some((new, told)) = changed.filter(|(new, _)| new != bytes) {
            return (new, told);
        }
    }
    binary::change(bytes, stream)
}

/// Where numbers stand, but not those of comments.
fn numbers(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let (mut found, mut k, mut comment) = (Vec::new(), 0, false);
    while k < bytes.len() {
        let before = if k == 0 { b' ' } else { bytes[k - 1] };
        comment = before != b'\n' && (comment || bytes[k] == b'#');
        let signed = bytes[k] == b'-' && bytes.get(k + 1).is_some_and(u8::is_ascii_digit);
        let name = before.is_ascii_alphanumeric() || matches!(before, b'_' | b'.');
        if comment || name || !(bytes[k].is_ascii_digit() || signed) {
            k += 1;
            continue;
        }
        let start = k;
        k += 1;
        while k < bytes.len() {
            let exponent = matches!(bytes[k], b'-' | b'+') && matches!(bytes[k - 1], b'e' | b'E');
            if !(bytes[k].is_ascii_digit() || matches!(bytes[k], b'.' | b'e' | b'E') || exponent) {
                break;
            }
            k += 1;
        }
        found.push(start..k);
    }
    found
}

fn number(text: &str, stream: &mut Stream) -> Option<Changed> {
    let at = stream.pick(&numbers(text))?.clone();
    let old = text.get(at.clone())?;
    let new = match stream.below(10) {
        0 => old.strip_prefix('-').map_or_else(|| format!("-{old}"), String::from),
        1 => old.replace('.', ","),
        2 => format!("{old}e{}", stream.below(700) as i64 - 350),
        3 => format!("{:e}", old.parse::<f64>().ok()? * [1e3, 1e-3, 1e6, 1e-6, 0.99, 1.01][stream.below(6)]),
        4 => String::new(),
        _ => one(NUMBERS, stream).to_owned(),
    };
    replaced(text, at, &new)
}

/// What stands between two characters on one line.
fn between(text: &str, open: char, close: char) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut start = None;
    for (k, c) in text.char_indices() {
        match start {
            Some(s) if c == close => {
                found.push(s..k);
                start = None;
            }
            _ if c == '\n' => start = None,
            None if c == open => start = Some(k + 1),
            _ => {}
        }
    }
    found
}

/// Another unit in brackets or behind a number in quotes.
fn unit(text: &str, stream: &mut Stream) -> Option<Changed> {
    let mut all: Vec<Range<usize>> = between(text, '[', ']');
    all.retain(|r| text.get(r.clone()).is_some_and(|t| t.len() < 12 && !t.contains(['"', ',', '[', '='])));
    for quoted in between(text, '"', '"') {
        let inner = text.get(quoted.clone()).unwrap_or_default();
        if let Some(blank) = inner.find(' ').filter(|_| inner.starts_with(|c: char| c.is_ascii_digit())) {
            all.push(quoted.start + blank + 1..quoted.end);
        }
    }
    let at = stream.pick(&all)?.clone();
    replaced(text, at, one(UNITS, stream))
}

/// Another word in quotes: one of the file, a strange one, or a long one.
fn word(text: &str, stream: &mut Stream) -> Option<Changed> {
    let all = between(text, '"', '"');
    let (at, other) = (stream.pick(&all)?.clone(), stream.pick(&all)?.clone());
    let new = match stream.below(4) {
        0 => text.get(other)?.to_owned(),
        1 => "long".repeat([30, 70, 1000, 100_000][stream.below(4)]),
        _ => one(WORDS, stream).to_owned(),
    };
    replaced(text, at, &new)
}

/// Brackets within brackets in the place of a value, or in a formula.
fn deep(text: &str, stream: &mut Stream) -> Option<Changed> {
    let depth = [50, 1000, 200_000][stream.below(3)];
    let (open, inner, close) =
        [("[", "", "]"), ("(", "s", ")"), ("{a=", "1", "}"), ("-", "1", ""), ("{\"a\":", "1", "}")]
            [stream.below(5)];
    let all = if stream.chance(50) { between(text, '"', '"') } else { numbers(text) };
    let at = stream.pick(&all)?.clone();
    replaced(text, at, &format!("{}{inner}{}", open.repeat(depth), close.repeat(depth)))
}

/// Changes of the file as a whole.
fn whole(text: &str, stream: &mut Stream) -> Changed {
    let name = |name: &str| name.to_owned();
    match stream.below(7) {
        0 => ([b"\xef\xbb\xbf", text.as_bytes()].concat(), name("byte order mark")),
        1 => (text.replace('\n', "\r\n").into_bytes(), name("line ends CR LF")),
        2 => (text.replace('\n', "\r").into_bytes(), name("line ends CR")),
        3 => (Vec::new(), name("empty")),
        4 => (text.encode_utf16().flat_map(u16::to_le_bytes).collect(), name("UTF-16")),
        5 => (text.replace(',', ";").into_bytes(), name("semicolons for commas")),
        _ => {
            let at = stream.below(text.len());
            let mut bytes = text.as_bytes().to_vec();
            bytes.splice(at..at, *b"\xff\xc3\x28");
            (bytes, format!("bytes at {at} that are no UTF-8"))
        }
    }
}
