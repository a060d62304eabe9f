//! What an error of the state of the gas comes from, and who shares it.

use crate::Point;
use std::fmt;

/// A cause of error, and who shares it: two equal causes are one random number.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The ambient temperature, as read at one point or on one day.
    Ambient(Sharing),
    /// The readings at a place, numbered from 1 on from upstream, or what all places read too much (0).
    Reading(usize, Sharing),
    /// The temperature that the file of the rig gives a part, at all points.
    Part(String),
    /// The mass flow.
    Flow(Sharing),
    /// A factor of the campaign, as it was set or measured: points of one installation with one value of it
    /// share the error; all points where neither is named.
    Factor {
        /// Its name.
        name: String,
        /// The installation.
        installation: String,
        /// The value, as text.
        level: String,
    },
    /// A drift of the frequency that all decays have in common, of which processing knows only how large it
    /// may be: an error of what was measured, not of the gas.
    Drift,
    /// A cause that an inference of the base states itself names.
    Inferred(String),
    /// The real (0) or imaginary (1) part of the error of the laws of a role, at one value of the factor over
    /// which it varies.
    Law {
        /// The role.
        role: String,
        /// 0 real, 1 imaginary.
        part: usize,
        /// The value of the factor, as text.
        level: String,
    },
}

impl Cause {
    /// The ambient temperature as read at `point`: one number for all points of its day, if the campaign says
    /// which day that was.
    #[must_use]
    pub fn ambient(point: &Point) -> Self {
        Self::Ambient(if point.day.is_empty() {
            Sharing::Point(point.id.clone())
        } else {
            Sharing::Day(point.day.clone())
        })
    }

    /// The error of a factor that all points share.
    #[must_use]
    pub fn of_all_points(factor: &str) -> Self {
        Self::Factor { name: factor.to_owned(), installation: String::new(), level: String::new() }
    }

    /// The factor of which it is the error, if it is one's.
    #[must_use]
    pub fn factor(&self) -> Option<&str> {
        if let Self::Factor { name, .. } = self { Some(name) } else { None }
    }

    /// Whether its error is that of all installations, wherever they are.
    #[must_use]
    pub fn is_of_many(&self) -> bool {
        matches!(self, Self::Drift)
    }
}

/// What is said of it.
impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Factor { name, level, .. } if level.is_empty() => write!(f, "{name} (all points)"),
            Self::Factor { name, installation, level } => write!(f, "{name} {level} ({installation})"),
            Self::Ambient(sharing) => write!(f, "T_amb{sharing}"),
            Self::Part(part) => write!(f, "the temperature of {part}"),
            Self::Reading(0, sharing) => write!(f, "the offset of all thermometers{sharing}"),
            Self::Reading(number, sharing) => write!(f, "thermometer {number} from upstream{sharing}"),
            Self::Flow(sharing) => write!(f, "the mass flow{sharing}"),
            Self::Drift => f.write_str("the drift that all decays have in common"),
            Self::Inferred(name) => f.write_str(name),
            Self::Law { role, part, level } => {
                let part = if *part == 0 { "real" } else { "imaginary" };
                write!(f, "the law of {role}, {part} part ({level})")
            }
        }
    }
}

/// Behind what they share, in brackets.
impl fmt::Display for Sharing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Point(id) => write!(f, " ({id})"),
            Self::Installation(id) => write!(f, " (installation {id})"),
            Self::Day(day) => write!(f, " (day {day})"),
            Self::All => Ok(()),
        }
    }
}

/// Who shares an error.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sharing {
    /// One operating point.
    Point(String),
    /// All points of one installation.
    Installation(String),
    /// All points of one day.
    Day(String),
    /// All points.
    All,
}
