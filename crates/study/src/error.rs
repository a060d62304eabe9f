//! What can be wrong with a file of a study: which file, which line, what, and the remedy.

use rijke_formula::FormulaError;
use rijke_numerics::rational::TableError;
use rijke_rig::UnitError;

/// What a stage is called on which another one can stand: it comes before.
pub(crate) const EARLIER: &str = "earlier stage";

/// Why a study cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{file}{}: {problem}", line.map(|l| format!(", line {l}")).unwrap_or_default())]
pub struct StudyError {
    /// Name of the file.
    pub file: String,
    /// Line, from 1; none if the file could not be read at all.
    pub line: Option<usize>,
    /// What is wrong there.
    pub problem: Box<StudyProblem>,
}

/// What is wrong in a file of a study.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyProblem {
    /// The file is not there.
    #[error(
        "there is no such file{}",
        if *of_every_study { "; `rijke new DIR --template NAME` writes every file of a study to fill in" } else { "" }
    )]
    Absent {
        /// Whether every study has it.
        of_every_study: bool,
    },
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(std::io::Error),
    /// Not TOML, or a key or type that does not belong there; names the known ones.
    #[error("{0}")]
    Toml(String),
    /// Not a table of comma-separated values.
    #[error("{0}")]
    Csv(String),
    /// A mode that two tables have.
    #[error(
        "operating point `{point}`{} stands in modes.csv, too; delete one of the two rows, or give that of modes.csv another label in its column `mode`",
        if mode.is_empty() { String::new() } else { format!(", mode {mode},") }
    )]
    InBoth {
        /// The operating point.
        point: String,
        /// The label; empty without one.
        mode: String,
    },
    /// A formula that cannot be used.
    #[error("`{key}`: {source}")]
    Formula {
        /// The key that holds it.
        key: String,
        /// What is wrong with it.
        source: FormulaError,
    },
    /// A formula whose units do not agree.
    #[error(
        "`{key}` at {place}: {fault}; correct the formula, the unit of a parameter or of a factor of the campaign, or a number in rig.toml that was written without its unit. A plain \
         number that multiplies has no unit: one that should have, as a time, is better a number of a part, numbers = {{ lag = \"1 ms\" }}"
    )]
    UnitOfLaw {
        /// The coefficient or key.
        key: String,
        /// Where it acts.
        place: String,
        /// What does not agree.
        fault: String,
    },
    /// A measured table that no rational function meets.
    #[error("`{key}`: {source}")]
    Table {
        /// The key that holds it.
        key: String,
        /// What is wrong with it.
        source: TableError,
    },
    /// A temperature of a duct that the base state does not use.
    #[error(
        "rig.toml gives `{part}` a temperature, which only base = \"rig\" uses; say so, or take the temperature out of rig.toml"
    )]
    UnusedTemperature {
        /// The duct.
        part: String,
    },
    /// A stage whose models do not say what an end reflects.
    #[error(
        "stage `{stage}`: the {end} end is \"free\" in rig.toml, and no candidate of this stage says what it reflects: {remedy}"
    )]
    FreeEnd {
        /// The stage.
        stage: String,
        /// `upstream` or `downstream`.
        end: &'static str,
        /// What to write.
        remedy: String,
    },
    /// A duct of another gas where the flow of one gas is inferred.
    #[error(
        "rig.toml gives `{part}` a gas of its own, and this base state is inferred for one gas; write base = \"rig\" or \"ambient\", or take gamma \
         and gas_constant out of `{part}`"
    )]
    OtherGas {
        /// The duct.
        part: String,
    },
    /// What is impossible at an operating point.
    #[error(
        "at operating point {point}: {source}; correct it in rig.toml, or the factors of this point in the campaign"
    )]
    AtPoint {
        /// The operating point.
        point: String,
        /// What is wrong there.
        source: Box<StudyProblem>,
    },
    /// A quantity whose unit is unknown or of another dimension.
    #[error("`{key}`: {source}")]
    Unit {
        /// The key or column.
        key: String,
        /// What is wrong with it.
        source: UnitError,
    },
    /// A standard deviation in a unit of another quantity than its factor.
    #[error(
        "`{factor}_sd` is in {other} and `{factor}` in {unit}: a standard deviation has a unit of the same quantity"
    )]
    SdOfFactor {
        /// The factor.
        factor: String,
        /// Its unit.
        unit: String,
        /// That of the standard deviation.
        other: String,
    },
    /// An unknown that has the name of another number of the same element.
    #[error(
        "the unknown `${name}` has the name of the key `{name}` of this element, so formulas could not distinguish the two: call the unknown \
         {name}_1, for example, here and in [unknown.{name}]"
    )]
    Clash {
        /// The name.
        name: String,
    },
    /// A name that nothing has.
    #[error("there is no {what} called `{name}`; {}", meant(name, known))]
    Unknown {
        /// What kind of thing.
        what: &'static str,
        /// The name.
        name: String,
        /// All names that could stand here.
        known: String,
    },
    /// A stage that stands further down in the file, where only an earlier one can be named.
    #[error("stage `{name}` does not come before this one: move it up, or name an earlier stage: {known}")]
    Later {
        /// The stage.
        name: String,
        /// All stages that could be named.
        known: String,
    },
    /// Data of other people that are not here.
    #[error(
        "the data are not part of this folder: set the variable {variable} to a folder that holds `{folder}`; get them from {obtain}"
    )]
    Elsewhere {
        /// The environment variable.
        variable: String,
        /// The folder within.
        folder: String,
        /// The public source.
        obtain: String,
    },
    /// A mode of a point in two rows.
    #[error(
        "`{name}` has a second row: of repeats give one row with their mean and its standard deviation, or make each a point of the campaign \
         with the same factors; delete a copy"
    )]
    SecondRow {
        /// The operating point and the label of the mode.
        name: String,
    },
    /// Two things of one name.
    #[error("a second {what} is called `{name}`; every name must be different")]
    Duplicate {
        /// What kind of thing.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// Something that must be there.
    #[error("`{key}` is missing; {need}")]
    Missing {
        /// The key or column.
        key: String,
        /// What is needed.
        need: &'static str,
    },
    /// A value that is no number, or not in its range.
    #[error("`{key}` is `{value}`, but must be {need}")]
    Value {
        /// The key or column.
        key: String,
        /// What stands there.
        value: String,
        /// What must stand there.
        need: &'static str,
    },
    /// A name that cannot be one.
    #[error("`{name}` cannot be the name of a {what}: {why}")]
    Name {
        /// What kind of thing.
        what: &'static str,
        /// The name.
        name: String,
        /// Why.
        why: &'static str,
    },
    /// A name that formulas know as something else.
    #[error(
        "`{name}` cannot be the name of a {what}: formulas already know it as {meaning}; choose another, such as {name}_1"
    )]
    Known {
        /// What kind of thing.
        what: &'static str,
        /// The name.
        name: String,
        /// What it is already.
        meaning: String,
    },
    /// A parameter or number that nothing uses.
    #[error("`{name}` is used nowhere in {place}; use it or remove it")]
    Unused {
        /// The name.
        name: String,
        /// Where it is declared.
        place: String,
    },
    /// A coefficient where it cannot act.
    #[error(
        "`{coefficient}` cannot act at `{place}`: ends take `reflection`, ducts also `forward` and `backward`, all other places mu, mp, eu and ep"
    )]
    WrongPlace {
        /// The coefficient.
        coefficient: &'static str,
        /// The place.
        place: String,
    },
    /// A prior that is no probability density.
    #[error(
        "{reason}{}",
        if *exact { format!("; a number that is known exactly is no parameter: `hold = {{ {parameter} = 1.5 }}` of a stage fixes one") } else { String::new() }
    )]
    Prior {
        /// The parameter.
        parameter: String,
        /// Why.
        reason: String,
        /// Whether its standard deviation is zero.
        exact: bool,
    },
    /// Readings that no heat and no flow have.
    #[error(
        "no heat and no flow explain the readings of the thermometers: a reading, a power, a flow or an ambient temperature may be in another unit than \
         its heading says, or of another point"
    )]
    Unexplained,
    /// A covariance that is none.
    #[error("the covariance of {of} is not positive definite; check the sizes and signs of its numbers")]
    Covariance {
        /// Of what.
        of: String,
    },
    /// Two errors of one number.
    #[error("`{first}` and `{second}` both state the error of one number of {of}; keep one of the two")]
    TwoErrors {
        /// The operating point.
        of: String,
        /// The column of the standard deviation.
        first: String,
        /// That of the variance.
        second: String,
    },
    /// A covariance of a number that has no column, or that its column calls otherwise.
    #[error(
        "`{column}` speaks of `{name}`, which no column is called; its names must be those of columns with numbers, whose units it has: {known}"
    )]
    Covaries {
        /// The column.
        column: String,
        /// The name in it.
        name: String,
        /// The columns that there are.
        known: String,
    },
    /// Errors of pressures that are smaller than those of the channels alone.
    #[error(
        "the stated errors of the pressures of {of} are smaller than those of the channels alone in channels.toml ({what}), which they must contain at \
         the measured pressures, as those that `rijke process` writes do. If X_sd only states how measurements repeat, write `contained = false` in \
         channels.toml, which adds the errors of the channels"
    )]
    ChannelsAlone {
        /// The operating point.
        of: String,
        /// Which number shows it.
        what: String,
    },
    /// A number that was declared as data twice.
    #[error(
        "`{file}` is declared for operating point {point} where the same number at {frequency_hz} Hz is declared already: data count once; remove one"
    )]
    Twice {
        /// The file.
        file: String,
        /// The operating point.
        point: String,
        /// The first frequency that is there twice, Hz.
        frequency_hz: f64,
    },
    /// Something on which nothing could be based.
    #[error("there is no {what}; {need}")]
    Empty {
        /// What is missing.
        what: &'static str,
        /// What to give.
        need: &'static str,
    },
}

/// The known name nearest to one that is not, and all known ones.
fn meant(name: &str, known: &str) -> String {
    let all: Vec<&str> = known.split(", ").collect();
    // Of numbered things the nearest is any other one.
    let is_numbered = name.contains(|c: char| c.is_ascii_digit());
    match rijke_numerics::words::nearest(name, &all).filter(|_| !is_numbered) {
        Some(nearest) => format!("did you mean `{nearest}`? Known: {known}"),
        None => format!("known: {known}"),
    }
}
