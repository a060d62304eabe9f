//! The text of a rig with numbers in the place of unknowns and factors.

use crate::rig::{interpolate, pairs};
use rijke_formula::{Context, Formula, Scope};
use toml::{Table, Value};

/// Keys whose texts are names and no formulas.
const WORDS: [&str; 8] = ["name", "type", "present", "wall", "outlet", "reference_side", "source", "oscilos"];

/// The network file that `rig.toml` is with these numbers in the place of its unknowns and factors. What
/// still names something else, such as the gas, stays a formula.
///
/// # Errors
/// A text that is no TOML.
pub fn filled_rig(rig: &str, numbers: &[(&str, f64)]) -> Result<String, toml::de::Error> {
    let mut table: Table = toml::from_str(rig)?;
    table.remove("unknown");
    let mut table = Value::Table(table);
    fill(&mut table, numbers);
    // A table that was read can be written.
    Ok(toml::to_string(&table).unwrap_or_default())
}

/// Puts numbers in the place of names in formulas, with or without the sign of an unknown.
fn fill(value: &mut Value, numbers: &[(&str, f64)]) {
    match value {
        Value::String(text) => {
            let filled = filled(text, numbers);
            if filled == *text {
                return;
            }
            let (scope, all) = (Scope::new(), |_| true);
            let nothing = Context { scope: &scope, here: &all, parameters: &[], definitions: &[] };
            // What still names something, such as the gas, stays a formula.
            let number = Formula::parse(&filled, &nothing).map(|formula| formula.real(&[f64::NAN]));
            *value = match number.ok().filter(|number| number.is_finite()) {
                Some(number) => Value::Float(number),
                None => Value::String(filled),
            };
        }
        Value::Array(list) => list.iter_mut().for_each(|v| fill(v, numbers)),
        Value::Table(table) => {
            if let Some(number) = interpolated(table, numbers) {
                *value = Value::Float(number);
                return;
            }
            table
                .iter_mut()
                .filter(|(key, _)| !WORDS.contains(&key.as_str()))
                .for_each(|(_, v)| fill(v, numbers));
        }
        _ => {}
    }
}

/// The number of a table over a factor, `{ over = "Q", rows = [[x, y], ...] }`, at the value of the factor.
fn interpolated(table: &Table, numbers: &[(&str, f64)]) -> Option<f64> {
    let (over, rows) = (table.get("over")?.as_str()?, table.get("rows")?.as_array()?);
    let (_, x) = numbers.iter().find(|(name, _)| *name == over)?;
    Some(interpolate(&pairs(rows)?, *x))
}

/// A formula with numbers in the place of these names, each a word of its own.
fn filled(text: &str, numbers: &[(&str, f64)]) -> String {
    let inside = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let mut out = String::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let length = rest.find(|c| !inside(c)).unwrap_or(rest.len()).max(c.len_utf8());
        let (word, after) = rest.split_at(length);
        rest = after;
        match numbers.iter().find(|(name, _)| *name == word) {
            Some((_, number)) => {
                let plain = out.strip_suffix('$').map_or(out.len(), str::len);
                out.truncate(plain);
                out += &format!("({number:e})");
            }
            None => out += word,
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also of the file itself, and of a part called as a factor is.
    #[test]
    fn exact_names_of_files_and_parts_stay() {
        let text = "name = \"flame with delay\"\n[[element]]\nname = \"delay\"\nlength = \"delay\"\nat = \"$delay/2\"\n";
        let mut file = Value::Table(toml::from_str::<Table>(text).unwrap());
        fill(&mut file, &[("delay", 0.4)]);
        assert_eq!(file["name"].as_str(), Some("flame with delay"));
        let part = &file["element"][0];
        assert_eq!(part["name"].as_str(), Some("delay"));
        assert_eq!((part["length"].as_float(), part["at"].as_float()), (Some(0.4), Some(0.2)));
    }

    #[test]
    fn exact_a_table_over_a_factor_becomes_its_number() {
        let text = "[[element]]\ntemperature = { over = \"Q\", rows = [[0, 293.0], [50, 331.0]] }\n";
        let mut file = Value::Table(toml::from_str::<Table>(text).unwrap());
        fill(&mut file, &[("Q", 25.0)]);
        assert_eq!(file["element"][0]["temperature"].as_float(), Some(312.0));
    }

    #[test]
    fn exact_names_are_filled_in_as_words() {
        let numbers = [("tau", 2.0), ("tau2", 3.0), ("load", 4.0)];
        assert_eq!(filled("$tau2*load/$tau + loads", &numbers), "(3e0)*(4e0)/(2e0) + loads");
        assert_eq!(filled("12 mm", &numbers), "12 mm");
        assert_eq!(filled("$tau", &numbers), "(2e0)");
    }
}
