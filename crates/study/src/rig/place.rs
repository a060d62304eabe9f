//! Places by the names of a rig's parts.

use super::part::{Part, Shape};
use crate::StudyProblem;
use crate::law::Place;
use crate::source::listed;

impl Place {
    /// Reads `gauze`, `gauze.middle`, `rods.end`, `ducts`, `upstream`, `ends`.
    pub(crate) fn parse(text: &str, parts: &[Part]) -> Result<Self, StudyProblem> {
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
            StudyProblem::Unknown { what: "place", name: text.to_owned(), known }
        })
    }
}
