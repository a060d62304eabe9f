//! Complex numbers over frequency from columns: of a text without headings, or by name from a table or from
//! arrays.

use super::doubts::{self, Angle, Rows};
use crate::{StudyError, StudyProblem};
use rijke_numerics::C64;
use rijke_rig::{Columns, Heading, NumberColumns, RigError, Unit, number_columns};
use std::path::Path;
use toml::Value as Toml;

/// What a column is, its unit, and its name in the file (none: by its place).
pub(super) struct Column {
    role: Role,
    unit: Option<Unit>,
    name: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Frequency,
    Real,
    Imaginary,
    Modulus,
    /// A modulus in decibels.
    Level,
    Phase,
    Sd,
    Ignored,
}

impl Role {
    /// The SI unit of its numbers.
    fn unit(self) -> &'static str {
        match self {
            Self::Frequency => "Hz",
            Self::Phase => "rad",
            _ => "1",
        }
    }
}

const ROLES: [(&str, Role); 7] = [
    ("f", Role::Frequency),
    ("re", Role::Real),
    ("im", Role::Imaginary),
    ("abs", Role::Modulus),
    ("arg", Role::Phase),
    ("sd", Role::Sd),
    ("-", Role::Ignored),
];

/// Reads the key `columns`: a list of headings of a text without any, or a table of heading and name in the
/// file.
pub(super) fn declared(value: &Toml) -> Result<Vec<Column>, StudyProblem> {
    let need =
        "a list as [\"f [Hz]\", \"re [1]\", \"im [1]\"], or a table as { \"f [Hz]\" = \"name in the file\" }";
    let wrong = |value: String| StudyProblem::Value { key: "columns".into(), value, need };
    let columns = match value {
        Toml::Array(list) => list
            .iter()
            .map(|v| v.as_str().ok_or_else(|| wrong(v.to_string())).and_then(|text| column(text, None)))
            .collect::<Result<Vec<_>, _>>()?,
        Toml::Table(table) => table
            .iter()
            .map(|(text, v)| {
                let name = v.as_str().ok_or_else(|| wrong(v.to_string()))?;
                column(text, Some(name.to_owned()))
            })
            .collect::<Result<Vec<_>, _>>()?,
        other => return Err(wrong(other.to_string())),
    };
    let has = |role: Role| columns.iter().filter(|c| c.role == role).count();
    let size = has(Role::Modulus) + has(Role::Level);
    let complex = [has(Role::Real), has(Role::Imaginary), size, has(Role::Phase)];
    if has(Role::Frequency) != 1 || !matches!(complex, [1, 1, 0, 0] | [0, 0, 1, 1]) || has(Role::Sd) > 1 {
        return Err(wrong(value.to_string()));
    }
    Ok(columns)
}

fn column(text: &str, name: Option<String>) -> Result<Column, StudyProblem> {
    if text.trim() == "-" {
        return Ok(Column { role: Role::Ignored, unit: None, name });
    }
    let (bare, unit_text) =
        text.split_once('[').map_or((text, None), |(a, b)| (a.trim(), b.strip_suffix(']')));
    let found = ROLES.iter().find(|(known, _)| *known == bare.trim()).map(|(_, role)| *role);
    let role = found.ok_or_else(|| StudyProblem::Unknown {
        what: "column of a response",
        name: text.to_owned(),
        known: ROLES.map(|r| r.0).join(", "),
    })?;
    if role == Role::Modulus && unit_text.map(str::trim) == Some("dB") {
        return Ok(Column { role: Role::Level, unit: None, name });
    }
    let need = "write it in brackets behind the name: f [Hz], re [1], abs [dB], arg [deg]";
    let unit = unit_of(text, role.unit(), Some(need))?;
    Ok(Column { role, unit, name })
}

/// The unit that a heading of `columns` states, which is one of what the SI unit `wanted` is; where `need`
/// says what to write, it must state one.
pub(super) fn unit_of(
    text: &str,
    wanted: &str,
    need: Option<&'static str>,
) -> Result<Option<Unit>, StudyProblem> {
    let fail = |source| StudyProblem::Unit { key: text.to_owned(), source };
    match (Heading::parse(text).map_err(fail)?.unit, need) {
        (Some(unit), _) => unit.of(wanted).map(Some).map_err(fail),
        (None, Some(need)) => Err(StudyProblem::Missing { key: format!("unit of {text}"), need }),
        (None, None) => Ok(None),
    }
}

impl Column {
    /// Refuses a heading in the file that states another unit than is declared.
    fn agrees(&self, heading: &str) -> Result<(), StudyProblem> {
        let stated = heading.trim().strip_suffix([']', ')']).and_then(|text| text.rsplit_once(['[', '(']));
        let decibels = stated.is_some_and(|(_, unit)| unit.trim().eq_ignore_ascii_case("dB"));
        let other = match (self.role, &self.unit) {
            (Role::Ignored, _) => false,
            (Role::Level, _) => !decibels && Heading::parse(heading).is_ok_and(|h| h.unit.is_some()),
            _ if decibels => true,
            (_, Some(declared)) => {
                let unit = Heading::parse(heading).ok().and_then(|h| h.unit);
                let same =
                    |unit: Unit| unit.of(self.role.unit()).is_ok_and(|u| u.factor() == declared.factor());
                unit.is_some_and(|unit| !same(unit))
            }
            _ => false,
        };
        let need = "the columns of the file in their order, with the units that the file states; see `columns` of this response";
        let (key, value) = ("heading".to_owned(), format!("`{heading}`"));
        if other { Err(StudyProblem::Value { key, value, need }) } else { Ok(()) }
    }
}

/// No ratio of pressures is this level, dB.
const LOUDEST: f64 = 300.0;

/// Reads a file by its declared columns.
pub(super) fn read(path: &Path, columns: &[Column]) -> Result<Rows, StudyError> {
    let fail = |line: Option<usize>, problem: StudyProblem| StudyError {
        file: path.display().to_string(),
        line,
        problem: Box::new(problem),
    };
    // A text without headings has none to be compared.
    let headings = Columns::read(path).map(|table| table.headings().to_vec()).unwrap_or_default();
    let named = columns.iter().any(|c| c.name.is_some());
    for (k, column) in columns.iter().enumerate() {
        let own = |h: &&String| column.name.as_ref().is_some_and(|name| *h == name);
        let heading = if named { headings.iter().find(own) } else { headings.get(k) };
        heading.map_or(Ok(()), |heading| column.agrees(heading)).map_err(|problem| fail(None, problem))?;
    }
    let (numbers, lines) = if named {
        let table = Columns::read(path).map_err(|e| fail(None, StudyProblem::Csv(without_path(&e, path))))?;
        let read = |c: &Column| match &c.name {
            Some(name) if c.role != Role::Ignored => {
                // The unit is the declared one: what stands behind a name in the file must not contradict it.
                let wanted =
                    if c.role == Role::Level { "1" } else { c.unit.as_ref().map_or("1", Unit::text) };
                table.numbers(name, wanted).map_err(|e| fail(None, StudyProblem::Csv(without_path(&e, path))))
            }
            _ => Ok(Vec::new()),
        };
        let numbers = columns.iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let longest = numbers.iter().map(Vec::len).max().unwrap_or(0);
        (numbers, (0..longest).map(|row| table.line(row)).collect())
    } else {
        text(path, columns.len()).map_err(|(line, problem)| fail(line, problem))?
    };
    let of = |role: Role| {
        let found = columns.iter().zip(&numbers).find(|(c, _)| c.role == role);
        found.map(|(c, v)| -> Vec<f64> {
            v.iter().map(|v| c.unit.as_ref().map_or(*v, |unit| unit.to_si(*v))).collect()
        })
    };
    // Hz is a cycle per second: the unit's SI value is that of the number in Hz.
    let frequency_hz = of(Role::Frequency).unwrap_or_default();
    let n = frequency_hz.len();
    if let Some((k, v)) = of(Role::Level).iter().flatten().enumerate().find(|(_, v)| v.abs() > LOUDEST) {
        let problem = StudyProblem::Value {
            key: "abs".into(),
            value: format!("{v} dB"),
            need: "a level between -300 and 300 dB",
        };
        return Err(fail(lines.get(k).copied(), problem));
    }
    let modulus = of(Role::Modulus).or_else(|| {
        Some(of(Role::Level)?.into_iter().map(|level| 10_f64.powf(level / 20.0)).collect::<Vec<_>>())
    });
    if let Some((k, v)) = modulus.iter().flatten().enumerate().find(|(_, v)| **v < 0.0) {
        let need = "zero or more; if it is a level, write abs [dB] in `columns`";
        let problem = StudyProblem::Value { key: "abs".into(), value: v.to_string(), need };
        return Err(fail(lines.get(k).copied(), problem));
    }
    let values: Vec<C64> = match (modulus, of(Role::Phase), of(Role::Real), of(Role::Imaginary)) {
        (Some(size), Some(phase), _, _) => {
            size.iter().zip(&phase).map(|(r, a)| C64::from_polar(*r, *a)).collect()
        }
        (_, _, Some(re), Some(im)) => re.iter().zip(&im).map(|(re, im)| C64::new(*re, *im)).collect(),
        _ => Vec::new(),
    };
    if values.len() != n {
        let problem = StudyProblem::Value {
            key: "columns".into(),
            value: format!("{n} frequencies and {} numbers", values.len()),
            need: "columns of one length",
        };
        return Err(fail(None, problem));
    }
    let sd = of(Role::Sd).unwrap_or_default();
    let phase = columns.iter().find(|c| c.role == Role::Phase);
    let phases = phase.map(|c| c.unit.as_ref().map_or(Angle::Degrees, |unit| Angle::of(unit.to_si(1.0))));
    let rows = Rows { frequency_hz, values, sd, lines, phases };
    doubts::refuse(&rows).map_err(|(line, problem)| fail(Some(line), problem))?;
    Ok(rows)
}

/// What is wrong with a file, whose name stands in front of it elsewhere.
pub(super) fn without_path(error: &RigError, path: &Path) -> String {
    let (all, path) = (error.to_string(), format!("{}: ", path.display()));
    all.trim_start_matches(path.as_str()).to_owned()
}

/// Columns of a text of numbers alone, and the line of each row, as text records are read.
fn text(path: &Path, width: usize) -> Result<NumberColumns, (Option<usize>, StudyProblem)> {
    let text = rijke_numerics::read_text(path)
        .map_err(|error| (None, StudyProblem::Unreadable(std::io::Error::other(error.to_string()))))?;
    let (columns, lines) =
        number_columns(&text).map_err(|(line, said)| (Some(line), StudyProblem::Csv(said)))?;
    let Some(first) = lines.first() else {
        let need = "a row for every frequency; the file has none";
        return Err((None, StudyProblem::Empty { what: "row of numbers", need }));
    };
    if columns.len() != width {
        let said = format!(
            "the row has {} numbers, and `columns` in observations.toml lists {width}",
            columns.len()
        );
        return Err((Some(*first), StudyProblem::Csv(said)));
    }
    Ok((columns, lines))
}
