//! `manifest.toml` as it is written.

use crate::apparatus::way::Way;
use crate::formats::text::TextForm;
use crate::records::reading::{Arrays, Column};
use crate::records::set::{DataKind, Day, RecordTiming};
use crate::units::{Given, Unit};
use serde::de::value::{F64Deserializer, I64Deserializer, StrDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Manifest {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) rig: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) campaign: Option<String>,
    pub(super) kind: DataKind,
    pub(super) source: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) full_scale_pa: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) full_scale: Option<Given>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) unit: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) dead: Vec<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) band_hz: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) mains_hz: Option<f64>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) may_be_silent: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) time: Option<Column>,
    pub(super) channels: Listed,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) text: TextForm,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) arrays: Arrays,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) ping: Option<RecordTiming>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) click: Option<RecordTiming>,
    #[serde(default, skip_serializing_if = "is_default")]
    pub(super) microphones: MicrophoneKeys,
    pub(super) day: Vec<Day>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) exception: Vec<ExceptionEntry>,
    #[serde(default)]
    pub(super) calibration: Vec<CalibrationEntry>,
    pub(super) point: Vec<PointEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CalibrationEntry {
    pub(super) day: String,
    pub(super) rate_hz: f64,
    pub(super) quiet_samples: usize,
    pub(super) clicks: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PointEntry {
    pub(super) id: String,
    pub(super) day: String,
    #[serde(default)]
    pub(super) pings: Vec<String>,
    #[serde(default)]
    pub(super) clicks: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) way: Option<Way>,
}

/// What is otherwise on some days or in some files; what is not given is as in the rest.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExceptionEntry {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) days: Vec<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) files: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) unit: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) dead: Vec<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) time: Option<Column>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) channels: Option<Listed>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) text: Option<TextForm>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) rate_hz: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) quiet_samples: Option<usize>,
}

/// `[microphones]`: what is known of them without clicks. Each value is one for all, or a list with one for
/// each.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MicrophoneKeys {
    /// A table of the same, one row per microphone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) table: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) sensitivity: Option<Each>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) sensitivity_sd: Option<Each>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) gain: Option<Each>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) gain_sd: Option<Each>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) delay: Option<Each>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) delay_sd: Option<Each>,
}

/// Columns with the microphones that they record, -1 for none.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Listed {
    ByPlace(Vec<i64>),
    ByName(BTreeMap<String, i64>),
}

/// One value for all microphones, or one for each.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(super) enum Each {
    All(Given),
    List(Vec<Given>),
}

/// Opening words of a manifest.
pub(super) const HEADER: &str = "\
# A set of records. Paths are relative to this file. Each file (WAV, CSV, MATLAB, HDF5) holds all microphones of one record.
# channels: for every channel of a file, the microphone it records, counted from 0 along the tube; -1 for none.
# full_scale_pa: pressure of the largest integer of an integer WAV file (a float file and a CSV file are in Pa).
# quiet_samples: samples taken before the loudspeaker acts; the trigger of a click is at that sample.

";

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

impl<'de> Deserialize<'de> for Listed {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Columns;
        impl<'de> Visitor<'de> for Columns {
            type Value = Listed;
            fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                out.write_str("a list such as [0, 1, -1], or names such as { p1 = 0, p2 = 1, drive = -1 }")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Listed, A::Error> {
                let mut all = Vec::new();
                while let Some(microphone) = seq.next_element()? {
                    all.push(microphone_or_none(microphone)?);
                }
                Ok(Listed::ByPlace(all))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Listed, A::Error> {
                let mut all = BTreeMap::new();
                while let Some((name, microphone)) = map.next_entry()? {
                    all.insert(name, microphone_or_none(microphone)?);
                }
                Ok(Listed::ByName(all))
            }
        }
        from.deserialize_any(Columns)
    }
}

fn microphone_or_none<E: Error>(microphone: i64) -> Result<i64, E> {
    match microphone {
        -1.. => Ok(microphone),
        _ => Err(E::custom(format_args!(
            "{microphone} is no microphone: count from 0, and write -1 for a channel that is none"
        ))),
    }
}

impl<'de> Deserialize<'de> for Each {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Values;
        impl<'de> Visitor<'de> for Values {
            type Value = Each;
            fn expecting(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                out.write_str("a number in SI units, a text with a unit such as \"50 mV/Pa\", or a list of them, one for each microphone")
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Each, E> {
                Given::deserialize(F64Deserializer::new(value)).map(Each::All)
            }
            fn visit_i64<E: Error>(self, value: i64) -> Result<Each, E> {
                Given::deserialize(I64Deserializer::new(value)).map(Each::All)
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Each, E> {
                Given::deserialize(StrDeserializer::new(text)).map(Each::All)
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Each, A::Error> {
                let mut all = Vec::new();
                while let Some(value) = seq.next_element()? {
                    all.push(value);
                }
                Ok(Each::List(all))
            }
        }
        from.deserialize_any(Values)
    }
}

/// A unit under a key of the manifest.
pub(super) fn unit(key: &str, text: Option<&str>) -> Result<Option<Unit>, (String, crate::problem::Problem)> {
    text.map(Unit::parse).transpose().map_err(|error| (key.to_owned(), crate::problem::Problem::Unit(error)))
}
