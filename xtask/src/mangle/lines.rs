//! Changes of lines, of cells between commas, and of keys before `=` or `:`.

use super::{
    changed::{Changed, replaced, short},
    stream::Stream,
};

/// Changes one line, or exchanges two.
pub(super) fn change(text: &str, stream: &mut Stream) -> Option<Changed> {
    let mut all: Vec<String> = text.lines().map(String::from).collect();
    let real: Vec<usize> =
        (0..all.len()).filter(|k| !all[*k].trim().is_empty() && !all[*k].starts_with('#')).collect();
    let (a, b) = (*stream.pick(&real)?, *stream.pick(&real)?);
    let told = match stream.below(12) {
        0 | 1 => format!("line {} ({}) left out", a + 1, short(&all.remove(a))),
        2 => {
            all.insert(a, all[a].clone());
            format!("line {} ({}) doubled", a + 1, short(&all[a]))
        }
        3 => {
            all.swap(a, b);
            format!("lines {} and {} exchanged", a + 1, b + 1)
        }
        4 => {
            let times = [20, 2000][stream.below(2)];
            let line = all[a].clone();
            all.splice(a..a, std::iter::repeat_n(line, times));
            format!("line {} ({}) {times} times", a + 1, short(&all[a]))
        }
        5..8 => cells(&mut all[a], a, stream)?,
        8 | 9 => return key(text, stream),
        10 => keys(&mut all, a, b)?,
        _ => {
            all.truncate(a);
            format!("ends before line {}", a + 1)
        }
    };
    Some(((all.join("\n") + "\n").into_bytes(), told))
}

/// A cell left out, doubled, emptied, or exchanged with another of the line.
fn cells(line: &mut String, number: usize, stream: &mut Stream) -> Option<String> {
    let mut all: Vec<String> = line.split(',').map(String::from).collect();
    if all.len() < 2 {
        return None;
    }
    let (a, b) = (stream.below(all.len()), stream.below(all.len()));
    let (place, what) = (format!("line {} ({}), cell {}", number + 1, short(line), a + 1), short(&all[a]));
    let done = match stream.below(4) {
        0 => {
            all.remove(a);
            "left out".to_owned()
        }
        1 => {
            all.insert(a, all[a].clone());
            "doubled".to_owned()
        }
        2 => {
            all[a].clear();
            "emptied".to_owned()
        }
        _ => {
            all.swap(a, b);
            format!("exchanged with {}", b + 1)
        }
    };
    *line = all.join(",");
    Some(format!("{place} ({what}) {done}"))
}

/// A key of another name, or of that of another.
fn key(text: &str, stream: &mut Stream) -> Option<Changed> {
    let mut all = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let end = line.find(['=', ':']).filter(|_| !line.starts_with('#'));
        let name = end.and_then(|e| line.get(..e)).unwrap_or_default();
        let name = name.rsplit(['{', ',']).next().unwrap_or_default();
        if let Some(end) = end.filter(|_| !name.trim().is_empty()) {
            let from = end - name.trim_start().len();
            all.push(start + from..start + from + name.trim().len());
        }
        start += line.len();
    }
    let (at, other) = (stream.pick(&all)?.clone(), stream.pick(&all)?.clone());
    let old = text.get(at.clone())?;
    let new = match stream.below(3) {
        0 => text.get(other)?.to_owned(),
        1 => format!("{old}s"),
        _ => "__proto__".to_owned(),
    };
    replaced(text, at, &new)
}

/// The keys of two lines exchanged.
fn keys(all: &mut [String], a: usize, b: usize) -> Option<String> {
    let (left, right) = (all[a].split_once('=')?, all[b].split_once('=')?);
    let (one, two) = (format!("{}={}", right.0, left.1), format!("{}={}", left.0, right.1));
    (all[a], all[b]) = (one, two);
    Some(format!("keys of lines {} and {} exchanged", a + 1, b + 1))
}
