//! Rust sources as the rules read them: without comments, the content of strings, and tests.

/// The text with comments, strings and characters blanked out; every line stays where it is.
pub(super) fn blanked(text: &str) -> String {
    let bytes: Vec<char> = text.chars().collect();
    let at = |k: usize| bytes.get(k).copied().unwrap_or('\0');
    let mut out = String::with_capacity(text.len());
    let mut k = 0;
    while k < bytes.len() {
        let end = match (at(k), at(k + 1)) {
            ('/', '/') => (k..).find(|&e| matches!(at(e), '\n' | '\0')).unwrap_or(k),
            ('/', '*') => end_of_block(&bytes, k),
            ('"', _) => end_of_string(&bytes, k),
            ('r', '"' | '#') if !is_word(&out) => end_of_raw(&bytes, k),
            ('\'', '\\') => (k + 3..bytes.len()).find(|&e| bytes[e] == '\'').map_or(bytes.len(), |e| e + 1),
            // A lifetime has no second quote.
            ('\'', _) if at(k + 2) == '\'' => k + 3,
            _ => k,
        };
        if end == k {
            out.push(at(k));
            k += 1;
        } else {
            out.extend(bytes[k..end.min(bytes.len())].iter().map(|&c| if c == '\n' { '\n' } else { ' ' }));
            k = end;
        }
    }
    out
}

/// Whether the text ends in the middle of a word, so that an `r` belongs to a name.
fn is_word(text: &str) -> bool {
    text.chars().next_back().is_some_and(|c| c.is_alphanumeric() || c == '_')
}

fn end_of_block(bytes: &[char], start: usize) -> usize {
    let (mut depth, mut k) = (0, start);
    while k + 1 < bytes.len() {
        match (bytes[k], bytes[k + 1]) {
            ('/', '*') => (depth, k) = (depth + 1, k + 2),
            ('*', '/') => (depth, k) = (depth - 1, k + 2),
            _ => k += 1,
        }
        if depth == 0 {
            return k;
        }
    }
    bytes.len()
}

fn end_of_string(bytes: &[char], start: usize) -> usize {
    let mut k = start + 1;
    while k < bytes.len() {
        match bytes[k] {
            '\\' => k += 2,
            '"' => return k + 1,
            _ => k += 1,
        }
    }
    bytes.len()
}

/// A string r#"..."#, or the start itself where none begins, as in r#name.
fn end_of_raw(bytes: &[char], start: usize) -> usize {
    let hashes = bytes[start + 1..].iter().take_while(|&&c| c == '#').count();
    let open = start + 1 + hashes;
    if bytes.get(open) != Some(&'"') {
        return start;
    }
    let closes = |&e: &usize| {
        bytes[e] == '"' && bytes[e + 1..].iter().take(hashes).filter(|&&c| c == '#').count() == hashes
    };
    (open + 1..bytes.len()).find(closes).map_or(bytes.len(), |e| e + 1 + hashes)
}

/// The blanked text up to its module of tests, which ends a file here.
pub(super) fn without_tests(code: &str) -> &str {
    code.find("#[cfg(test)]\nmod tests {").map_or(code, |end| &code[..end])
}

/// A function of a file.
pub(super) struct Function<'a> {
    /// Its name.
    pub(super) name: &'a str,
    /// Number of the line that holds `fn`, from 1.
    pub(super) line: usize,
    /// Whether `#[test]` stands before it.
    pub(super) is_test: bool,
    /// Everything from its name to the end of its body.
    pub(super) text: &'a str,
}

/// Every function of a blanked text that has a body.
pub(super) fn functions(code: &str) -> Vec<Function<'_>> {
    let mut found = Vec::new();
    for (start, _) in code.match_indices("fn ") {
        let before = &code[..start];
        if is_word(before) {
            continue;
        }
        let text = &code[start + 3..];
        let name = text.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("");
        let Some(length) = body(text) else { continue };
        let attributes = before.rfind(['}', ';', '{']).map_or(before, |last| &before[last..]);
        found.push(Function {
            name,
            line: before.matches('\n').count() + 1,
            is_test: attributes.contains("#[test]"),
            text: &text[..length],
        });
    }
    found
}

/// Length up to the end of the first block in braces, unless a declaration ends before.
fn body(text: &str) -> Option<usize> {
    let (mut depth, mut brackets) = (0, 0);
    for (k, c) in text.char_indices() {
        match c {
            '[' | '(' => brackets += 1,
            ']' | ')' => brackets -= 1,
            ';' if depth == 0 && brackets == 0 => return None,
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if c == '}' && depth == 0 {
            return Some(k + 1);
        }
    }
    None
}

/// The words of a blanked text.
pub(super) fn words(code: &str) -> impl Iterator<Item = &str> {
    code.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|w| !w.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_what_is_no_code_is_blanked() {
        let text = "a('\"', 'x', '\\'') // \"b\n/* c /* d */ e */ f<'g>(\"h \\\" i\", r#\"j \" k\"#, r#l)";
        let words: Vec<String> = words(&blanked(text)).map(String::from).collect();
        assert_eq!(words, ["a", "f", "g", "r", "l"]);
        assert_eq!(blanked(text).lines().count(), 2);
    }

    #[test]
    fn exact_functions_have_names_lines_and_bodies() {
        let code = "trait T { fn a(); }\n#[test]\n#[ignore]\nfn b(x: [u8; 2]) { if x { c } }\nfn d() { e }";
        let found: Vec<_> = functions(code).iter().map(|f| (f.name, f.line, f.is_test)).collect();
        assert_eq!(found, [("b", 4, true), ("d", 5, false)]);
        assert!(functions(code)[0].text.ends_with("{ if x { c } }"));
    }
}
