//! An end of the rig.

use super::element::{free_numbers, in_any_order};
use super::owner::Owner;
use super::{Reading, complex};
use crate::StudyProblem;
use crate::rig::elements::{CHOKED, ENDS, FUNCTION};
use crate::source::{Outcome, listed};
use std::ops::Range;
use toml::{Spanned, Table, Value as Toml};

impl Reading<'_> {
    pub(super) fn end(&mut self, place: &'static str, table: Spanned<Table>) -> Outcome<()> {
        let at = table.span();
        let mut table = table.into_inner();
        let kind = table.remove("type");
        let kind = kind.as_ref().and_then(Toml::as_str).unwrap_or("?");
        let found = ENDS.iter().find(|k| k.name == kind).ok_or_else(|| {
            let known = listed(ENDS.iter().map(|k| k.name));
            (at.clone(), StudyProblem::Unknown { what: "type of end", name: kind.to_owned(), known })
        })?;
        // `calibration` = [modulus, angle], as network files have it.
        if kind == "unflanged"
            && let Some(calibration) = table.remove("calibration")
        {
            let pair = calibration.as_array().filter(|list| list.len() == 2).cloned();
            let beside = table.contains_key("modulus") || table.contains_key("angle");
            let Some([modulus, angle]) =
                pair.filter(|_| !beside).and_then(|list| <[Toml; 2]>::try_from(list).ok())
            else {
                let need = "[modulus, angle in rad], without `modulus` and `angle` beside it";
                let value = calibration.to_string();
                return Err((at, StudyProblem::Value { key: "calibration".into(), value, need }));
            };
            table.extend([("modulus".to_owned(), modulus), ("angle".to_owned(), angle)]);
        }
        let owner = Owner::Other { name: place, prefix: "end_", part: None };
        in_any_order(&free_numbers(&mut table, &at)?, |key, value| {
            let own = self.own_of(owner);
            let named = self.named(place, &own, key, (value, ""), &at)?;
            self.of_ends.push(named);
            Ok(())
        })?;
        let mut definitions = Vec::new();
        let function = FUNCTION.iter().find(|(name, _)| *name == kind).map(|(_, keys)| *keys);
        if let Some(keys) = function.filter(|_| !table.contains_key("impedance")) {
            definitions.extend(self.function_of(owner, kind, keys, &mut table, &at)?);
        } else {
            for key in found.keys {
                let (value, unit) = match (table.remove(key.name), key.default) {
                    // A pair is a formula of plain numbers, which has any unit.
                    (Some(value @ Toml::Array(_)), _) => (complex(value), ""),
                    (Some(value), _) => (value, key.unit),
                    (None, Some(default)) => (Toml::String(default.to_owned()), key.unit),
                    (None, None) => {
                        let need = "a number, a quantity, a formula, or \"$unknown\"";
                        return Err((at.clone(), StudyProblem::Missing { key: key.name.into(), need }));
                    }
                };
                definitions.extend(self.defined(owner, key.name, unit, &value, &at)?);
            }
        }
        if kind == "choked" {
            self.is_choked = true;
            let law = CHOKED[usize::from(place == "downstream")];
            definitions.push(("end_m".into(), law.into()));
        }
        self.finished(&table, kind, &at)?;
        for (coefficient, law) in found.laws {
            self.wait(&at, place.to_owned(), *coefficient, (*law).to_owned(), &definitions, None);
        }
        Ok(())
    }

    /// An end that is a function of s, or a table of it.
    fn function_of(
        &mut self,
        owner: Owner<'_>,
        kind: &str,
        keys: &[&str],
        table: &mut Table,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        let needed: &[&'static str] = match kind {
            "rational" => &["numerator", "denominator"],
            "table" => &["table"],
            _ => &[],
        };
        if let Some(key) = needed.iter().find(|key| !table.contains_key(**key)) {
            let need = if *key == "table" {
                "rows of [frequency in Hz, gain, phase in rad], or the name of a file with them"
            } else {
                "a list of coefficients, ascending powers of s"
            };
            return Err((at.clone(), StudyProblem::Missing { key: (*key).into(), need }));
        }
        if kind == "impedance"
            && !["numerator", "denominator", "table"].iter().any(|k| table.contains_key(*k))
        {
            let need = "a number, a formula or \"$unknown\"; or give numerator and denominator, or table";
            return Err((at.clone(), StudyProblem::Missing { key: "impedance".into(), need }));
        }
        let mut all = self.transfer(owner, table, keys, at)?;
        if kind == "impedance" {
            all.push(("end_impedance".into(), "end_transfer".into()));
        }
        Ok(all)
    }
}
