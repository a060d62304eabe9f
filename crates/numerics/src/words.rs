//! Numbers in sentences and tables.

/// A value with its standard deviation, both to the second digit of that.
#[must_use]
pub fn with_sd(value: f64, sd: f64) -> String {
    if !(sd > 0.0 && sd.is_finite()) {
        return format!("{value:.6e} +- {sd:.1e}");
    }
    let size = value.abs().max(sd);
    if (1e-3..1e6).contains(&size) {
        let digits = (1.0 - sd.log10().floor()).clamp(0.0, 12.0) as usize;
        return format!("{value:.digits$} +- {sd:.digits$}");
    }
    let digits = ((size / sd).log10().floor() + 1.0).clamp(0.0, 12.0) as usize;
    format!("{value:.digits$e} +- {sd:.1e}")
}

/// A value with its standard deviation and unit; pure numbers have none.
#[must_use]
pub fn quantity(value: f64, sd: f64, unit: &str) -> String {
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    with_sd(value, sd) + &unit
}

/// A clause as the beginning of a sentence: its first letter large.
#[must_use]
pub fn capitalised(clause: &str) -> String {
    let mut letters = clause.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// `1 mode`, `2 modes`.
#[must_use]
pub fn counted(count: usize, one: &str) -> String {
    format!("{count} {one}{}", if count == 1 { "" } else { "s" })
}

/// The first `most` of several names, and how many more there are: `a, b and 3 more`.
#[must_use]
pub fn few<T: AsRef<str>>(names: &[T], most: usize) -> String {
    let shown = names.iter().take(most).map(AsRef::as_ref).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(most) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The number to so many digits: as short as it can be written then.
#[must_use]
pub fn to_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// Five digits.
#[must_use]
pub fn precise(value: f64) -> String {
    if value != 0.0 && !(1e-2..1e5).contains(&value.abs()) {
        return format!("{value:.4e}");
    }
    let places = if value == 0.0 { 0.0 } else { 4.0 - value.abs().log10().floor() };
    format!("{value:.*}", places.max(0.0) as usize)
}

/// Three digits.
#[must_use]
pub fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if (1e-4..1e4).contains(&value.abs()) {
        let places = (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
        return format!("{value:.places$}");
    }
    format!("{value:.2e}")
}

/// With so many decimals; what rounds to zero has no sign.
#[must_use]
pub fn fixed(value: f64, places: usize) -> String {
    let text = format!("{value:.places$}");
    if text.bytes().all(|b| b"-0.".contains(&b)) { text.trim_start_matches('-').to_owned() } else { text }
}

/// The known word within two edits of `name` (one for names of up to four letters, none for a letter), upper
/// and lower case alike, if any. Two neighbours that changed places are one edit.
#[must_use]
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let allowed = match name.chars().count() {
        0 | 1 => 0,
        2..=4 => 1,
        _ => 2,
    };
    let distance = |word: &str| strsim::osa_distance(&name.to_lowercase(), &word.to_lowercase());
    let (distance, best) = known.iter().map(|k| (distance(k), *k)).min_by_key(|(d, _)| *d)?;
    (distance <= allowed).then_some(best)
}

/// The line, from 1, of an offset in bytes.
#[must_use]
pub fn line_of(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|b| *b == b'\n').count()
}

/// What a reader of TOML says, in words of the file: keys and values, the nearest known one, and all known
/// ones.
#[must_use]
pub fn of_toml(message: &str) -> String {
    let message = message.trim().replace('\n', " ");
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    let known = |name: &str| {
        let meant = nearest(name, &quoted[1..]).map_or(String::new(), |s| format!("; did you mean `{s}`?"));
        let all = quoted[1..].join(", ");
        match (all.is_empty(), meant.is_empty()) {
            (true, _) => String::new(),
            (false, true) => format!("; known here: {all}"),
            (false, false) => format!("{meant} Known here: {all}"),
        }
    };
    match quoted.first() {
        Some(name) if message.starts_with("unknown field `") => {
            format!("there is no key `{name}`{}", known(name))
        }
        Some(name) if message.starts_with("unknown variant `") => {
            format!("`{name}` is not known{}", known(name))
        }
        Some(name) if message.starts_with("missing field `") => format!("the key `{name}` is missing"),
        // A number without a digit before its point.
        _ if ["invalid mantissa", "invalid fraction"].iter().any(|said| message.contains(said)) => {
            format!("{message}: a number has a digit on both sides of its point, as 0.3 and 3.0")
        }
        _ if message.starts_with("invalid type: ") => of_another_type(&message).unwrap_or(message),
        _ => message,
    }
}

/// `invalid type: string "x", expected f64` in words of the file.
fn of_another_type(message: &str) -> Option<String> {
    let (found, wanted) = message.strip_prefix("invalid type: ")?.split_once(", expected ")?;
    let found = match (found, found.strip_prefix("string ")) {
        ("sequence", _) => "a list".to_owned(),
        ("map", _) => "a table".to_owned(),
        (_, Some(text)) => format!("the text {text}"),
        // Numbers and truth values stand between accents, behind their kind.
        _ => found.split('`').nth(1)?.to_owned(),
    };
    let wanted = match wanted {
        "f64" | "f32" => "a number",
        "usize" | "u8" | "u16" | "u32" | "u64" => "a whole number, zero or more",
        "i8" | "i16" | "i32" | "i64" => "a whole number",
        "a string" => "a text in quotes",
        "a boolean" => "true or false",
        "a sequence" => "a list in brackets",
        "a map" => "a table",
        wanted if wanted.starts_with("struct ") => "a table",
        "an array of length 2" => "a list of two numbers",
        wanted => wanted,
    };
    Some(format!("{found} stands where {wanted} is needed"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_values_have_the_digits_that_their_errors_leave() {
        assert_eq!(with_sd(0.982_848, 1.04e-3), "0.9828 +- 0.0010");
        assert_eq!(with_sd(4.078e-7, 2.9e-9), "4.078e-7 +- 2.9e-9");
        assert_eq!(with_sd(-1234.56, 7.0), "-1234.6 +- 7.0");
        assert_eq!((capitalised("the sum"), capitalised("")), ("The sum".to_owned(), String::new()));
        assert_eq!(with_sd(2.0, 0.0), "2.000000e0 +- 0.0e0");
        assert_eq!(quantity(0.982_848, 1.04e-3, "1"), "0.9828 +- 0.0010");
        let precise = [0.0, 243.58, 1.0334, -0.0125, 2.3528e-3, -4.2e7].map(precise);
        assert_eq!(precise, ["0", "243.58", "1.0334", "-0.012500", "2.3528e-3", "-4.2000e7"]);
        assert_eq!([to_digits(2.0 / 3.0, 4), to_digits(-48.214_285, 6)], [0.6667, -48.2143]);
        let fixed = [-0.0004, -0.0006, 0.0, 12.0].map(|v| fixed(v, 3));
        assert_eq!(fixed, ["0.000", "-0.001", "0.000", "12.000"]);
        let rounded = [0.0, 0.102, 1.557, 123.4, 5.42e-5, 3.5e-10].map(rounded);
        assert_eq!(rounded, ["0", "0.102", "1.56", "123", "5.42e-5", "3.50e-10"]);
        let said = [
            "unknown field `diamter`, expected one of `length`, `diameter`",
            "unknown field `colour`, expected `length` or `diameter`",
            "unknown variant `horn`, expected `duct`",
            "missing field `cite`",
            "invalid basic string",
            "invalid type: string \"x\", expected f64",
            "invalid type: floating point `0.1`, expected an array of length 2",
            "invalid type: sequence, expected usize",
            "invalid type: boolean `true`, expected a string",
        ]
        .map(of_toml);
        assert_eq!(
            said,
            [
                "there is no key `diamter`; did you mean `diameter`? Known here: length, diameter",
                "there is no key `colour`; known here: length, diameter",
                "`horn` is not known; known here: duct",
                "the key `cite` is missing",
                "invalid basic string",
                "the text \"x\" stands where a number is needed",
                "0.1 stands where a list of two numbers is needed",
                "a list stands where a whole number, zero or more is needed",
                "true stands where a text in quotes is needed"
            ]
        );
        let few = [2, 3].map(|most| few(&["a", "b", "c"], most));
        assert_eq!(few, ["a, b and 1 more", "a, b, c"]);
    }
}
