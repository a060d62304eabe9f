//! Measured functions of frequency as texts of formulas. Must not know where they act.

use crate::StudyProblem;
use crate::rig::number;
use rijke_numerics::rational::{Doubt, Table, TableRow, doubt};
use rijke_rig::Columns;
use std::path::Path;
use toml::Value as Toml;

/// Deviation from a table that is allowed, over its largest gain, where the file does not say another.
const TOLERANCE: f64 = 1e-6;

/// Pairs of poles that a formula can hold.
const MOST_PAIRS: usize = 30;

/// One second, as a number with its unit: formulas whose units are judged take a table of s times this.
pub(crate) const SECOND: &str = "table.second";

/// A table that was read and fitted.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Measured {
    /// The fit as a formula of s.
    pub(crate) text: String,
    /// Its first and last frequency, Hz.
    pub(crate) band: [f64; 2],
    /// What is doubtful about it.
    pub(crate) doubt: Option<String>,
    /// The stated error of the measurement, over the largest gain; none if nothing is stated.
    pub(crate) stated: Option<f64>,
}

impl Measured {
    /// Reads a list of rows of frequency, gain and phase, or the name of a table in `folder`, and fits it;
    /// `of` is the formula that stands in the place of s.
    ///
    /// # Errors
    /// [`StudyProblem::Value`], [`StudyProblem::Csv`], [`StudyProblem::Table`].
    pub(crate) fn read(
        value: &Toml,
        tolerance: Option<&Toml>,
        of: &str,
        folder: &Path,
    ) -> Result<Self, StudyProblem> {
        let key = "table".to_owned();
        let need = "a list of [frequency in Hz, gain, phase in rad], or the name of a file with the columns frequency [Hz], gain and \
                    phase [rad]";
        let wrong = |value: String| StudyProblem::Value { key: key.clone(), value, need };
        let rows = match value {
            Toml::Array(list) => {
                let row = |row: &Toml| -> Option<TableRow> {
                    let numbers: Option<Vec<f64>> = row.as_array()?.iter().map(number).collect();
                    <[f64; 3]>::try_from(numbers?).ok().map(TableRow::from)
                };
                list.iter()
                    .map(|v| row(v).ok_or_else(|| wrong(v.to_string())))
                    .collect::<Result<Vec<_>, _>>()?
            }
            Toml::String(name) => from_file(&folder.join(name))?,
            other => return Err(wrong(other.to_string())),
        };
        let stated = |value: &Toml| {
            number(value).ok_or_else(|| StudyProblem::Value {
                key: "tolerance".into(),
                value: value.to_string(),
                need: "a number: the deviation that is allowed, over the largest gain",
            })
        };
        let stated = tolerance.map(stated).transpose()?;
        let table = Table::fit(&rows, stated.unwrap_or(TOLERANCE))
            .map_err(|source| StudyProblem::Table { key: key.clone(), source })?;
        if table.terms.len() > 2 * MOST_PAIRS {
            let need =
                "met by a function of at most 60 poles: raise `tolerance` to the error of the measurement";
            return Err(StudyProblem::Value {
                key,
                value: format!("a table of {} poles", table.terms.len()),
                need,
            });
        }
        let band = [rows[0].frequency, rows[rows.len() - 1].frequency];
        Ok(Self { text: text(&table, of), band, doubt: doubt(&rows).map(said), stated })
    }

    /// The warning that a search goes beyond the table, if it does.
    pub(crate) fn beyond(&self, [low, high]: [f64; 2]) -> Option<String> {
        let [first, last] = self.band;
        let beyond = low < first * (1.0 - 1e-9) || high > last * (1.0 + 1e-9);
        beyond.then(|| {
            format!("the search from {low} to {high} Hz leaves its table, from {first} to {last} Hz: there its fit extrapolates")
        })
    }
}

/// The heading of gains in decibels, 20 log10 of the gain.
const LEVEL: &str = "gain [dB]";

fn from_file(path: &Path) -> Result<Vec<TableRow>, StudyProblem> {
    let columns = Columns::read(path).map_err(|error| StudyProblem::Csv(error.to_string()))?;
    let column = |name: &str, unit: &str| {
        columns.numbers(name, unit).map_err(|error| StudyProblem::Csv(error.to_string()))
    };
    let level = |db: f64| 10_f64.powf(db / 20.0);
    let has = |heading: &str| columns.headings().iter().any(|h| h == heading);
    let gain = match (has(LEVEL), has("gain")) {
        (true, true) => return Err(StudyProblem::Duplicate { what: "column", name: "gain".into() }),
        (true, false) => column(LEVEL, "1")?.into_iter().map(level).collect(),
        _ => column("gain", "1")?,
    };
    for (name, need) in [
        ("frequency", "write it in brackets behind the name: frequency [Hz]"),
        ("phase", "write it in brackets behind the name: phase [rad] or phase [deg]"),
    ] {
        if let Ok(None) = columns.unit(name) {
            return Err(StudyProblem::Missing { key: format!("unit of {name}"), need });
        }
    }
    let (frequency, phase) = (column("frequency", "Hz")?, column("phase", "rad")?);
    Ok(frequency
        .into_iter()
        .zip(gain.into_iter().zip(phase))
        .map(|(f, (g, p))| TableRow::from([f, g, p]))
        .collect())
}

fn said(doubt: Doubt) -> String {
    match doubt {
        Doubt::Degrees { step } => format!(
            "half of the steps of its table's phase are larger than {step:.0} rad, so that the phases seem to be in degrees: give them in \
             rad"
        ),
        Doubt::Coarse { step, other } => format!(
            "half of the steps of its table's phase are larger than {step:.1} rad: such steps cannot distinguish a delay from one that is {:.2} ms longer or \
             shorter, nor the convention exp(i omega t), which is assumed, from exp(-i omega t); give finer frequencies",
            1e3 * other
        ),
        Doubt::Rises { rise } => format!(
            "its phase rises by {rise:.1} rad over its table, so that it answers before it is asked: an answer later by tau has the phase \
             -omega tau; if the numbers are for exp(-i omega t), turn the signs of the phases"
        ),
    }
}

/// The fit as a formula. A pole and its conjugate make r/(s - p) + r*/(s - p*) = (2 Re r s - 2 Re(r
/// p*))/(s^2 - 2 Re p s + |p|^2).
fn text(table: &Table, of: &str) -> String {
    let s = if of == "s" { "s".to_owned() } else { format!("({of})") };
    let mut sum = format!("({:e})", table.constant);
    for (pole, residue) in &table.terms {
        if pole.im.abs() <= 1e-9 * pole.norm() {
            sum += &format!(" + ({:e})/({s} - ({:e}))", residue.re, pole.re);
        } else if pole.im > 0.0 {
            let [slope, constant] = [2.0 * residue.re, -2.0 * (residue * pole.conj()).re];
            let [damping, stiffness] = [-2.0 * pole.re, pole.norm_sqr()];
            sum += &format!(
                " + (({slope:e})*{s} + ({constant:e}))/(({s} + ({damping:e}))*{s} + ({stiffness:e}))"
            );
        }
    }
    if table.delay == 0.0 { format!("({sum})") } else { format!("({sum})*exp(-{s}*({:e}))", table.delay) }
}

#[cfg(test)]
mod tests {
    use super::from_file;

    #[test]
    fn exact_gains_in_decibels_are_those_as_numbers() {
        let folder = std::env::temp_dir().join(format!("rijke-table-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let read = |text: &str| {
            let path = folder.join("flame.csv");
            std::fs::write(&path, text).unwrap();
            from_file(&path).map(|rows| rows.iter().map(|r| r.gain).collect::<Vec<_>>())
        };
        let plain = read("frequency [Hz],gain,phase [rad]\n50,1,0\n100,2,-1\n").unwrap();
        let level =
            read("frequency [Hz],gain [dB],phase [deg]\n50,0,0\n100,6.020599913279624,-57\n").unwrap();
        assert!(plain.iter().zip(&level).all(|(a, b)| (a - b).abs() < 1e-12), "{plain:?} {level:?}");
        assert!(read("frequency [Hz],gain,gain [dB],phase [rad]\n50,1,0,0\n").is_err());
        let bare = read("frequency [Hz],gain,phase\n50,1,0\n100,2,-57\n").unwrap_err().to_string();
        assert!(bare.contains("`unit of phase` is missing") && bare.contains("phase [deg]"), "{bare}");
        assert!(read("frequency [Hz],gain [Pa],phase [rad]\n50,1,0\n").is_err());
        std::fs::remove_dir_all(folder).unwrap();
    }
}
