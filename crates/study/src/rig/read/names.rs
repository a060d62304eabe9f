//! The names that values of a rig may use.

use crate::Campaign;
use crate::names::{FACTOR, add, built_in};
use crate::source::Outcome;
use rijke_formula::{Kind as NameKind, Name, Scope};
use std::collections::BTreeMap;

/// The names that values of a rig may use.
pub(super) struct Names {
    pub(super) scope: Scope,
    /// Those of the factors.
    pub(super) factors: Vec<usize>,
    /// Those of the numbers of the base state.
    pub(super) brought: Vec<usize>,
}

impl Names {
    pub(super) fn of(campaign: &Campaign, numbers: BTreeMap<String, String>) -> Outcome<Self> {
        let here = |problem| (0..0, problem);
        let global =
            |name, unit, meaning: &str| Name { name, unit, meaning: meaning.into(), kind: NameKind::Global };
        let mut scope = built_in().map_err(here)?;
        let mut factors = Vec::new();
        for factor in &campaign.factors {
            // A unit that no formula understands is right everywhere.
            let unit = if factor.stated { factor.unit_in_print() } else { "not stated".to_owned() };
            let name = global(factor.name.clone(), unit, FACTOR);
            factors.push(add(&mut scope, "factor", name).map_err(here)?);
        }
        let mut brought = Vec::new();
        for (name, unit) in numbers {
            let name = global(name, unit, "number that the base state brings");
            brought.push(add(&mut scope, "number of the base state", name).map_err(here)?);
        }
        Ok(Self { scope, factors, brought })
    }
}
