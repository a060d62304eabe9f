//! The table of units.

/// Exponents of kg, m, s, K, A, mol, rad and cycles. The last two are numbers in SI; they are kept apart here
/// because a frequency in Hz and an angular frequency in rad/s differ by 2 pi.
pub(super) type Dimension = [i32; BASES];

/// How many base units there are.
pub(super) const BASES: usize = 8;
pub(super) const KELVIN: usize = 3;
pub(super) const RADIAN: usize = 6;
pub(super) const TURN: usize = 7;

/// A unit of the table.
pub(super) struct Known {
    pub(super) name: &'static str,
    /// Other spellings.
    also: &'static [&'static str],
    /// Prefixes that it may have, of [`PREFIXES`].
    prefixes: &'static str,
    pub(super) factor: f64,
    pub(super) offset: f64,
    pub(super) dimension: Dimension,
}

/// SI brochure, 9th edition, Table 7; `u` stands for the micro sign.
const PREFIXES: [(char, f64); 9] = [
    ('p', 1e-12),
    ('n', 1e-9),
    ('u', 1e-6),
    ('m', 1e-3),
    ('c', 1e-2),
    ('h', 1e2),
    ('k', 1e3),
    ('M', 1e6),
    ('G', 1e9),
];

const fn unit(name: &'static str, prefixes: &'static str, factor: f64, dimension: Dimension) -> Known {
    Known { name, also: &[], prefixes, factor, offset: 0.0, dimension }
}

const fn also(also: &'static [&'static str], known: Known) -> Known {
    Known { also, ..known }
}

const NUMBER: Dimension = [0; BASES];
const MASS: Dimension = [1, 0, 0, 0, 0, 0, 0, 0];
const LENGTH: Dimension = [0, 1, 0, 0, 0, 0, 0, 0];
const TIME: Dimension = [0, 0, 1, 0, 0, 0, 0, 0];
const TEMPERATURE: Dimension = [0, 0, 0, 1, 0, 0, 0, 0];
const CURRENT: Dimension = [0, 0, 0, 0, 1, 0, 0, 0];
const AMOUNT: Dimension = [0, 0, 0, 0, 0, 1, 0, 0];
const ANGLE: Dimension = [0, 0, 0, 0, 0, 0, 1, 0];
const CYCLES: Dimension = [0, 0, 0, 0, 0, 0, 0, 1];
const FREQUENCY: Dimension = [0, 0, -1, 0, 0, 0, 0, 1];
const FORCE: Dimension = [1, 1, -2, 0, 0, 0, 0, 0];
const PRESSURE: Dimension = [1, -1, -2, 0, 0, 0, 0, 0];
const ENERGY: Dimension = [1, 2, -2, 0, 0, 0, 0, 0];
const POWER: Dimension = [1, 2, -3, 0, 0, 0, 0, 0];
const VOLTAGE: Dimension = [1, 2, -3, 0, -1, 0, 0, 0];
const RESISTANCE: Dimension = [1, 2, -3, 0, -2, 0, 0, 0];
const VOLUME: Dimension = [0, 3, 0, 0, 0, 0, 0, 0];

/// Factors are exact by definition (SI brochure, 9th edition; NIST SP 811, Appendix B), but those of psi and
/// torr, which are the ratios that define them to double precision.
const KNOWN: [Known; 37] = [
    unit("1", "", 1.0, NUMBER),
    unit("%", "", 1e-2, NUMBER),
    unit("ppm", "", 1e-6, NUMBER),
    unit("m", "numck", 1.0, LENGTH),
    also(&["inch", "\""], unit("in", "", 0.0254, LENGTH)),
    unit("ft", "", 0.3048, LENGTH),
    also(&["l"], unit("L", "um", 1e-3, VOLUME)),
    also(&["sec"], unit("s", "pnum", 1.0, TIME)),
    unit("min", "", 60.0, TIME),
    also(&["hr"], unit("h", "", 3600.0, TIME)),
    unit("Hz", "mkMG", 1.0, FREQUENCY),
    unit("rpm", "", 1.0 / 60.0, FREQUENCY),
    also(&["cycle", "cycles", "turn"], unit("rev", "", 1.0, CYCLES)),
    unit("rad", "m", 1.0, ANGLE),
    also(&["°"], unit("deg", "", std::f64::consts::PI / 180.0, ANGLE)),
    unit("g", "umk", 1e-3, MASS),
    unit("lb", "", 0.453_592_37, MASS),
    unit("mol", "mk", 1.0, AMOUNT),
    unit("K", "m", 1.0, TEMPERATURE),
    Known { also: &["°C", "℃", "C", "deg C"], offset: 273.15, ..unit("degC", "", 1.0, TEMPERATURE) },
    Known { also: &["°F", "℉"], offset: 459.67 * 5.0 / 9.0, ..unit("degF", "", 5.0 / 9.0, TEMPERATURE) },
    unit("N", "umkM", 1.0, FORCE),
    unit("Pa", "umhkMG", 1.0, PRESSURE),
    unit("bar", "um", 1e5, PRESSURE),
    unit("atm", "", 101_325.0, PRESSURE),
    unit("psi", "", 6_894.757_293_168_361, PRESSURE),
    also(&["Torr"], unit("torr", "", 101_325.0 / 760.0, PRESSURE)),
    unit("mmHg", "", 133.322_387_415, PRESSURE),
    unit("inH2O", "", 249.088_91, PRESSURE),
    unit("mmH2O", "", 9.806_65, PRESSURE),
    unit("J", "mkM", 1.0, ENERGY),
    unit("cal", "k", 4.184, ENERGY),
    unit("W", "umkM", 1.0, POWER),
    also(&["Volt", "Volts"], unit("V", "num", 1.0, VOLTAGE)),
    unit("A", "numk", 1.0, CURRENT),
    also(&["Ω", "ohm"], unit("Ohm", "mkM", 1.0, RESISTANCE)),
    also(&["rayl"], unit("Rayl", "k", 1.0, [1, -2, -1, 0, 0, 0, 0, 0])),
];

/// Factor before the table's, and the unit that a word names.
pub(super) fn find(word: &str) -> Option<(f64, &'static Known)> {
    let named = |word: &str| KNOWN.iter().find(|k| k.name == word || k.also.contains(&word));
    if let Some(known) = named(word) {
        return Some((1.0, known));
    }
    let first = word.chars().next()?;
    let rest = &word[first.len_utf8()..];
    // The micro sign and the Greek letter are different characters that look alike.
    let prefix = if matches!(first, 'µ' | 'μ') { 'u' } else { first };
    let (_, factor) = PREFIXES.iter().find(|(p, _)| *p == prefix)?;
    named(rest).filter(|known| known.prefixes.contains(prefix)).map(|known| (*factor, known))
}

/// `m (n u m c k), in, ft, ...`.
pub(super) fn listed() -> String {
    let shown = |known: &Known| {
        let with = |prefix: char| format!("{prefix}{}", known.name);
        let all: Vec<String> =
            [known.name.to_owned()].into_iter().chain(known.prefixes.chars().map(with)).collect();
        all.join(" ")
    };
    KNOWN.iter().map(shown).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn exact_no_word_names_two_units() {
        let mut seen: BTreeMap<String, &str> = BTreeMap::new();
        for known in &KNOWN {
            let names = || [known.name].into_iter().chain(known.also.iter().copied());
            let prefixed = names().flat_map(|n| known.prefixes.chars().map(move |p| format!("{p}{n}")));
            for name in names().map(str::to_owned).chain(prefixed) {
                assert!(find(&name).is_some_and(|f| f.1.name == known.name), "{name}");
                assert_eq!(seen.insert(name.clone(), known.name), None, "{name} is named twice");
            }
        }
    }
}
