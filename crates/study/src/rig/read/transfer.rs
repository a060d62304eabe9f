//! Functions of s: gain, delay, filter, polynomials, or a measured table.

use super::Reading;
use super::owner::Owner;
use crate::StudyProblem;
use crate::law::Measured;
use crate::rig::elements::{FUNCTION, transfer};
use crate::rig::value::number;
use crate::rig::value::{Given, Value};
use crate::source::Outcome;
use rijke_numerics::has_growing_root;
use std::ops::Range;
use toml::{Table, Value as Toml};

impl Reading<'_> {
    /// `gain` from `n`, and `transfer` from what is given of delay, filter, polynomials and table.
    pub(super) fn flame(
        &mut self,
        part: usize,
        table: &mut Table,
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        let mut all = Vec::new();
        if let Some(n) = table.remove("n") {
            if table.contains_key("gain") {
                return Err((
                    at.clone(),
                    StudyProblem::Missing { key: "gain or n".into(), need: "give one of the two" },
                ));
            }
            all.extend(self.definition(part, "n", "1", &n, at)?);
            all.push(("gain".into(), "(n)*(rho/rho_2 - 1)*A/A_2".into()));
        }
        let keys = FUNCTION.iter().find(|(name, _)| *name == "flame").map_or(&[][..], |(_, keys)| *keys);
        all.extend(self.transfer(Owner::Part(part), table, keys, at)?);
        Ok(all)
    }

    /// What `transfer` is, with the owner's prefix, from those of its keys that `known` holds.
    pub(super) fn transfer(
        &mut self,
        owner: Owner<'_>,
        table: &mut Table,
        known: &[&str],
        at: &Range<usize>,
    ) -> Outcome<Vec<(String, String)>> {
        let prefix = owner.prefix();
        let mut all = Vec::new();
        let mut take = |key: &str| if known.contains(&key) { table.remove(key) } else { None };
        let [rows, tolerance] = ["table", "tolerance"].map(&mut take);
        let [gain, delay, cutoff] = ["gain", "delay", "cutoff_hz"].map(&mut take);
        let [numerator, denominator] = ["numerator", "denominator"].map(&mut take);
        let fail = |problem| Err((at.clone(), problem));
        if rows.is_some() && (cutoff.is_some() || numerator.is_some() || denominator.is_some()) {
            let key = "table, or cutoff_hz, numerator and denominator".into();
            return fail(StudyProblem::Missing {
                key,
                need: "give one of the two; `delay` may stand beside both",
            });
        }
        if rows.is_none() && tolerance.is_some() {
            return fail(StudyProblem::Missing {
                key: "table".into(),
                need: "a tolerance is that of a table",
            });
        }
        let mut factors = Vec::new();
        if let Some(rows) = rows {
            let measured = Measured::read(&rows, tolerance.as_ref(), "s", self.folder)
                .map_err(|problem| (at.clone(), problem))?;
            all.push((format!("{prefix}measured"), measured.text.clone()));
            factors.push(format!("{prefix}measured"));
            self.tables.push((format!("{prefix}measured"), at.clone(), measured));
        }
        for (key, unit, value) in [("delay", "s", &delay), ("cutoff_hz", "Hz", &cutoff)] {
            if let Some(value) = value {
                self.delays.extend(number(value).filter(|_| key == "delay").map(|delay| (at.clone(), delay)));
                all.extend(self.defined(owner, key, unit, value, at)?);
            }
        }
        if let Some(gain) = gain {
            all.extend(self.defined(owner, "gain", "1", &gain, at)?);
            factors.push(format!("({})", owner.name("gain")));
        }
        let numerator = self.polynomial(owner, "numerator", numerator, &mut all, at)?;
        let denominator = self.polynomial(owner, "denominator", denominator, &mut all, at)?;
        let [delay, cutoff] = [("delay", delay.is_some()), ("cutoff_hz", cutoff.is_some())]
            .map(|(key, there)| there.then(|| owner.name(key)));
        factors.push(transfer(delay.as_deref(), cutoff.as_deref(), &numerator, &denominator));
        all.push((format!("{prefix}transfer"), factors.join("*")));
        Ok(all)
    }

    /// The names of the coefficients.
    fn polynomial(
        &mut self,
        owner: Owner<'_>,
        key: &'static str,
        value: Option<Toml>,
        all: &mut Vec<(String, String)>,
        at: &Range<usize>,
    ) -> Outcome<Vec<String>> {
        let Some(value) = value else { return Ok(Vec::new()) };
        let list = value.as_array().cloned().unwrap_or_default();
        let (mut names, mut numbers) = (Vec::new(), Vec::new());
        for (k, value) in list.iter().enumerate() {
            let name = format!("{key}_{k}");
            let given = self.given(owner, &name, value, "", at)?;
            if let Given::Value(Value::Number(number)) = given {
                numbers.push(number);
            }
            all.extend(self.defined(owner, &name, "", value, at)?);
            names.push(owner.name(&name));
        }
        let known = numbers.len() == list.len();
        let need = if known && numbers.iter().all(|number| *number == 0.0) {
            "a list of coefficients, ascending powers of s, not all zero"
        } else if known && key == "denominator" && has_growing_root(&numbers) {
            "without roots of positive real part: with one, the answer to a short push grows for ever; turn the sign of a coefficient"
        } else {
            return Ok(names);
        };
        Err((at.clone(), StudyProblem::Value { key: key.into(), value: value.to_string(), need }))
    }
}
