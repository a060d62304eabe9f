//! How files are written, as the manifest says: which column or array is which microphone, in which unit, and
//! which is time.

use crate::formats::text::TextForm;
use crate::units::Unit;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What the manifest says of the files beyond the order of their channels. The default is a file of numbers
/// in Pa whose columns are all listed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// For every column by its name the microphone that it records; none for one that is unused. Empty if
    /// columns are listed by their place.
    pub names: BTreeMap<String, Option<usize>>,
    /// Names of the microphones in the rig, for columns that are listed by their place; empty if not known.
    pub microphones: Vec<String>,
    /// The column of time; if none is declared, the one whose name or unit says so.
    pub time: Option<Column>,
    /// How text files are written.
    pub text: TextForm,
    /// Unit of the numbers where the file does not say, of pressure or voltage; Pa if none.
    pub unit: Option<Unit>,
    /// Whether the largest integer of an integer file is in V; else in Pa.
    pub full_scale_in_volts: bool,
    /// Sensitivity of each microphone, V/Pa; empty if they are not stated.
    pub sensitivities: Vec<f64>,
    /// Whether numbers in V stay what they are where no sensitivity is stated here: it is among the gains.
    pub volts_stay: bool,
    /// Microphones that recorded nothing of use. A record has no samples of them.
    pub dead: Vec<usize>,
}

/// A column of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Column {
    /// By its place, from 1.
    Number(usize),
    /// By its name, with or without the unit behind it.
    Name(String),
}

/// Which arrays of a MATLAB or HDF5 file hold the record.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arrays {
    /// Names of the arrays, `p` or `run/p` or `data.p`. Their channels are counted through in this order.
    /// Empty: the file has one array that is longer than one sample, and it holds all channels.
    #[serde(default)]
    pub names: Vec<String>,
    /// Name of the array that holds the sampling rate in Hz, to be compared with the manifest's; none if the
    /// file has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<String>,
}
