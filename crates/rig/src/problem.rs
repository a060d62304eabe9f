//! What can be wrong with a value in a file, and the remedy.

use crate::column_fault::ColumnFault;
use crate::units::UnitError;
use crate::words::{listed, too_short};
use std::path::PathBuf;
use thiserror::Error;

/// What is wrong with a value, and the remedy.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Problem {
    /// A number outside its range.
    #[error(
        "{value} {unit} is outside {low} to {high} {unit}; a number without a unit is in {unit}, a text has a unit of its own, as \"12 mm\""
    )]
    OutOfRange {
        /// The value found.
        value: f64,
        /// Lowest value allowed.
        low: f64,
        /// Highest value allowed.
        high: f64,
        /// Unit of all three.
        unit: &'static str,
    },
    /// A microphone or thermometer that is not in the tube.
    #[error(
        "x = {position} m is outside the tube (0 to {length} m); positions are metres from the bottom end"
    )]
    OutsideTube {
        /// Where it would be, m.
        position: f64,
        /// Length of the tube, m.
        length: f64,
    },
    /// Two things at one place, or out of order.
    #[error("{second} m follows {first} m; list positions from the bottom of the tube upward, each once")]
    NotAscending {
        /// The earlier position, m.
        first: f64,
        /// The later one, m.
        second: f64,
    },
    /// An index that points nowhere.
    #[error("{index} does not exist: there are {count}, counted from 0")]
    NoSuchIndex {
        /// The index found.
        index: usize,
        /// How many there are.
        count: usize,
    },
    /// A name that is used nowhere else, or not declared.
    #[error("`{name}` is not known; known: {}", known.join(", "))]
    UnknownName {
        /// The name found.
        name: String,
        /// The names that exist.
        known: Vec<String>,
    },
    /// The same name twice.
    #[error("`{name}` appears twice; every name must be different")]
    Duplicate {
        /// The name.
        name: String,
    },
    /// A matrix of another size.
    #[error(
        "has {rows} rows, or rows of other lengths, but needs {need} of {need} numbers, one for each microphone but the reference; process the \
         records again, or remove the file"
    )]
    WrongSize {
        /// Rows found.
        rows: usize,
        /// Rows and columns needed.
        need: usize,
    },
    /// A list without entries.
    #[error("is empty; give at least {need}")]
    Empty {
        /// What is needed.
        need: &'static str,
    },
    /// The geometry contradicts itself.
    #[error("{inner} m does not fit inside {outer} m; check both diameters")]
    DoesNotFit {
        /// The diameter that should be smaller, m.
        inner: f64,
        /// The diameter that should be larger, m.
        outer: f64,
    },
    /// A channel map that is not one microphone per channel.
    #[error(
        "microphone {microphone} is recorded by {count} channels; `channels` lists, for every channel of a file, \
         the microphone it records (or -1), each microphone once"
    )]
    ChannelMap {
        /// The microphone, counted from 0.
        microphone: usize,
        /// How many channels claim it.
        count: usize,
    },
    /// A file that a list names and that does not exist.
    #[error("there is no file {}; copy it there or take it out of the list", path.display())]
    AbsentFile {
        /// Where it should be.
        path: PathBuf,
    },
    /// Fewer channels in a file than the manifest says.
    #[error(
        "{have} channels, the manifest's `channels` lists {need}; record all channels or correct the list"
    )]
    MissingChannel {
        /// Channels in the file.
        have: usize,
        /// Channels in the manifest.
        need: usize,
    },
    /// More channels in a file than the manifest says.
    #[error(
        "{have} channels, the manifest's `channels` lists {need}; surplus: {}; list every channel with its microphone, or with -1 if it \
         is unused",
        surplus.join(", ")
    )]
    SurplusChannels {
        /// Channels in the file, without that of time.
        have: usize,
        /// Channels in the manifest.
        need: usize,
        /// Those not listed: number, from 1, and name where there is one.
        surplus: Vec<String>,
    },
    /// A column by a name that the file does not have.
    #[error("there is no column `{name}`; the file has {}; correct the name", listed(known))]
    NoSuchHeading {
        /// The name wanted.
        name: String,
        /// The headings of the file.
        known: Vec<String>,
    },
    /// A column by a number that the file does not have.
    #[error("there is no column {number}: the file has {width}, counted from 1")]
    NoSuchColumn {
        /// The number wanted.
        number: usize,
        /// Columns of the file.
        width: usize,
    },
    /// Columns that are not what the manifest says.
    #[error(transparent)]
    Columns(#[from] ColumnFault),
    /// Two columns that could be time.
    #[error("`{}` could each be time; say which, with `time`, and list the other with -1", known.join("` and `"))]
    TwoTimes {
        /// Their headings.
        known: Vec<String>,
    },
    /// A column of time that is listed as a microphone.
    #[error(
        "the column is time, and `channels` lists it as microphone {microphone}; list it with -1, or leave it out"
    )]
    TimeIsMicrophone {
        /// The microphone, counted from 0.
        microphone: usize,
    },
    /// Times that do not advance by one sample.
    #[error(
        "the time of sample {sample} is {step} s after the one before, {need} s were expected: samples are missing, or the \
         times are too coarse; export the file again, or list the column with -1"
    )]
    TimeJumps {
        /// The sample, from 0.
        sample: usize,
        /// The step found, s.
        step: f64,
        /// One over the sampling rate, s.
        need: f64,
    },
    /// Numbers in V of a microphone without sensitivity.
    #[error(
        "the numbers are volts, and microphone {microphone} has no `sensitivity`; state it under [microphones] in the \
         manifest, such as \"50 mV/Pa\""
    )]
    NoSensitivity {
        /// The microphone, counted from 0.
        microphone: usize,
    },
    /// Sensitivities of microphones whose numbers have no unit.
    #[error(
        "a `sensitivity` is stated, and nothing says whether the numbers are volts or Pa; give `unit = \"V\"` or \
         `unit = \"Pa\"` in the manifest, or a unit in the heading"
    )]
    NoUnit,
    /// Integers without a full scale.
    #[error(
        "the samples are integers, and the manifest states no full scale; give `full_scale_pa = 20.0`, or \
         `full_scale = \"10 V\"` with sensitivities"
    )]
    NoFullScale,
    /// A unit that cannot be read, or of another quantity.
    #[error(transparent)]
    Unit(#[from] UnitError),
    /// A row of another width than the others.
    #[error("{have} columns, the rows before have {need}; every row needs as many")]
    OtherWidth {
        /// Columns of this row.
        have: usize,
        /// Columns of those before.
        need: usize,
    },
    /// A text file without any row of numbers.
    #[error(
        "no row of numbers in the first {lines} lines, which begin with `{text}`; use comma, semicolon, tab or blanks between \
         columns, or say how many lines come before the names, with `header_lines`"
    )]
    NoNumbers {
        /// Beginning of the first line.
        text: String,
        /// Lines looked at.
        lines: usize,
    },
    /// A line without end.
    #[error("is longer than {most} bytes; a text of numbers has one row per line")]
    LongLine {
        /// The longest line that is read, bytes.
        most: u64,
    },
    /// A key that the table should have once.
    #[error("`{key}` stands in line {first} already; keep one of the two")]
    DuplicateKey {
        /// The key.
        key: String,
        /// Where it was first.
        first: usize,
    },
    /// Keys that do not ascend.
    #[error("{second} follows {first}; sort the rows so that the column ascends")]
    Unsorted {
        /// The key before.
        first: f64,
        /// The key found.
        second: f64,
    },
    /// A file that stands twice in the lists of records.
    #[error("is the same file as {first}; list every record once")]
    ListedTwice {
        /// Where it stands first.
        first: String,
    },
    /// A list of which each entry belongs to one microphone.
    #[error("lists {have} values for {need} microphones; give one for each, or one for all")]
    OtherCount {
        /// Values found.
        have: usize,
        /// Microphones.
        need: usize,
    },
    /// A microphone that all relative pressures need is dead.
    #[error(
        "microphone {microphone} is the rig's reference and is dead; choose another `reference` in rig.toml"
    )]
    DeadReference {
        /// The microphone, counted from 0.
        microphone: usize,
    },
    /// Two keys that exclude one another, or need one another.
    #[error("{what}")]
    Keys {
        /// Which, and what to do.
        what: &'static str,
    },
    /// The file's sampling rate is not the declared one.
    #[error(
        "sampled at {have} Hz, expected {need} Hz; correct the rate in the manifest or the list of files, or, of pings at two rates, give the rate of \
         these in an [[exception]]: files = [...], rate_hz = {have}"
    )]
    WrongRate {
        /// In the file, Hz.
        have: f64,
        /// In the manifest, Hz.
        need: f64,
    },
    /// The file ends before its header says.
    #[error("ends after sample {have} of {need}; the file is truncated: copy or record it again")]
    Truncated {
        /// Samples per channel that can be read.
        have: usize,
        /// Samples per channel announced.
        need: usize,
    },
    /// Too few samples to hold the quiet stretch and an event.
    #[error("{}", too_short(*have, *quiet))]
    TooShort {
        /// Samples per channel.
        have: usize,
        /// Declared length of the quiet stretch.
        quiet: usize,
    },
    /// A sample that is not a number, or infinite.
    #[error("sample {sample} is {value}; remove the file from the manifest or export it again")]
    NotFinite {
        /// Index of the sample, from 0.
        sample: usize,
        /// What it is.
        value: f64,
    },
    /// A file of National Instruments' TDMS.
    #[error(
        "NI TDMS, which is not read; save it as HDF5, .mat or text, which LabVIEW and the Python package npTDMS do"
    )]
    Tdms,
    /// A WAV file of a kind that is not supported.
    #[error("not a WAV file that can be read ({reason}); use 16, 24 or 32 bit integer, or 32 bit float PCM")]
    BadWav {
        /// The decoder's reason.
        reason: String,
    },
    /// A chunk of a WAV file that cannot be as long as it says.
    #[error(
        "chunk `{name}` at byte {at} should have {stated} bytes, {left} are left in the file; it is damaged or truncated: copy or \
         record it again"
    )]
    LongChunk {
        /// Name of the chunk.
        name: String,
        /// Where it begins, bytes from the start of the file.
        at: u64,
        /// Length that it says it has, bytes.
        stated: u32,
        /// Length of what follows, bytes.
        left: u64,
    },
    /// A WAV file whose recorder stopped before it wrote how long the record is.
    #[error(
        "the length of `data` at byte {at} is {stated} and {left} bytes follow: the recorder did not finish the file; have \
         the length written (`sox --ignore-length in.wav out.wav`), or record again"
    )]
    Unfinished {
        /// Where the chunk begins, bytes from the start of the file.
        at: u64,
        /// Length that it says it has, bytes.
        stated: u32,
        /// Length of what follows, bytes.
        left: u64,
    },
    /// A file of arrays that is damaged, truncated or of another format.
    #[error("not a MATLAB or HDF5 file that can be read ({reason}); save it again, or export WAV or CSV")]
    BadArrays {
        /// The reader's reason.
        reason: String,
    },
    /// An array that the manifest names and the file does not have, or not as numbers.
    #[error("there is no numeric array `{name}`; the file holds {}; correct `arrays` in the manifest", known.join(", "))]
    NoSuchArray {
        /// The name wanted.
        name: String,
        /// What the file holds.
        known: Vec<String>,
    },
    /// A file of which it is not clear what the record is.
    #[error(
        "the file holds {}; say which of them is the record, with `arrays = {{ names = [...] }}` in the manifest",
        if known.is_empty() { "nothing".to_owned() } else { known.join(", ") }
    )]
    WhichArray {
        /// What the file holds.
        known: Vec<String>,
    },
    /// Arrays of one record that differ in length.
    #[error("has {have} samples, another array of the record {need}; all must have the same length")]
    Uneven {
        /// Samples of this array.
        have: usize,
        /// Samples of the first.
        need: usize,
    },
    /// A CSV cell that is not a number.
    #[error("`{text}` is not {expected}")]
    BadCell {
        /// The text found.
        text: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A CSV header that is not the one expected.
    #[error("column {column} is `{have}`, expected `{need}`; keep the header as `rijke process` writes it")]
    BadHeader {
        /// Column, from 1.
        column: usize,
        /// Text found.
        have: String,
        /// Text expected.
        need: String,
    },
    /// A covariance that no noise can have.
    #[error(
        "the covariance is not positive definite; give variances above zero and correlations inside -1 to 1"
    )]
    NotPositiveDefinite,
}
