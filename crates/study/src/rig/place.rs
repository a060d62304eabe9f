//! Where a law acts.

use super::{Part, Shape};
use crate::Problem;
use crate::source::listed;

/// A kind of place of the rig; the operating point says where it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Along a duct, or along all of them.
    Duct(Option<usize>),
    /// Along an insert; the law is a coefficient per metre.
    Along(usize),
    /// Where an insert or a duct begins.
    Start(usize),
    /// Where an insert or a duct ends.
    End(usize),
    /// Every place of a device, with the whole law at each.
    Each(usize),
    /// Every place of a device, with an equal share of the law at each.
    Shared(usize),
    /// The mean of the places of a device, all of the law at once.
    Middle(usize),
    /// The upstream end.
    Upstream,
    /// The downstream end.
    Downstream,
    /// Both ends alike.
    Ends,
}

impl Place {
    /// Reads `gauze`, `gauze.middle`, `rods.end`, `ducts`, `upstream`, `ends`.
    pub(crate) fn parse(text: &str, parts: &[Part]) -> Result<Self, Problem> {
        match text {
            "upstream" => return Ok(Self::Upstream),
            "downstream" => return Ok(Self::Downstream),
            "ends" => return Ok(Self::Ends),
            "ducts" => return Ok(Self::Duct(None)),
            _ => {}
        }
        let (name, side) = text.split_once('.').unwrap_or((text, ""));
        let found = parts.iter().position(|p| p.name == name);
        let place = found.and_then(|k| match (&parts[k].shape, side) {
            (Shape::Duct(_), "") => Some(Self::Duct(Some(k))),
            (Shape::Device(_), "") => Some(Self::Each(k)),
            (Shape::Device(_), "shared") => Some(Self::Shared(k)),
            (Shape::Device(_), "middle") => Some(Self::Middle(k)),
            (Shape::Insert(..), "") => Some(Self::Along(k)),
            (Shape::Insert(..) | Shape::Duct(_), "start") => Some(Self::Start(k)),
            (Shape::Insert(..) | Shape::Duct(_), "end") => Some(Self::End(k)),
            _ => None,
        });
        place.ok_or_else(|| {
            let of = |p: &Part| match p.shape {
                Shape::Device(_) => ["", ".shared", ".middle"].map(|s| format!("{}{s}", p.name)).to_vec(),
                Shape::Insert(..) | Shape::Duct(_) => {
                    ["", ".start", ".end"].map(|s| format!("{}{s}", p.name)).to_vec()
                }
            };
            let all: Vec<String> = parts
                .iter()
                .flat_map(of)
                .chain(["ducts", "upstream", "downstream", "ends"].map(str::to_owned))
                .collect();
            let known = listed(all.iter().map(String::as_str));
            Problem::Unknown { what: "place", name: text.to_owned(), known }
        })
    }

    /// Whether the law is a coefficient per metre.
    #[must_use]
    pub fn is_along(&self) -> bool {
        matches!(self, Self::Duct(_) | Self::Along(_))
    }

    /// Whether it is an end of the rig.
    #[must_use]
    pub fn is_end(&self) -> bool {
        matches!(self, Self::Upstream | Self::Downstream | Self::Ends)
    }

    /// Whether it is along ducts themselves, so that the law is that of their wall.
    #[must_use]
    pub fn is_duct(&self) -> bool {
        matches!(self, Self::Duct(_))
    }

    /// The part, if it is one.
    #[must_use]
    pub fn part(&self) -> Option<usize> {
        match *self {
            Self::Duct(part) => part,
            Self::Along(k)
            | Self::Start(k)
            | Self::End(k)
            | Self::Each(k)
            | Self::Shared(k)
            | Self::Middle(k) => Some(k),
            Self::Upstream | Self::Downstream | Self::Ends => None,
        }
    }
}
