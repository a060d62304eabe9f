//! Parameters with their priors, as files have them.

use crate::StudyProblem;
use crate::names::free;
use crate::source::Outcome;
use rijke_formula::Scope;
use rijke_inference::{Parameter, Prior};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;

/// Parameters as files have them.
pub(crate) type Parameters = BTreeMap<String, Spanned<ParameterSpec>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParameterSpec {
    symbol: Option<String>,
    #[serde(default = "one")]
    unit: String,
    prior: Prior,
}

fn one() -> String {
    "1".to_owned()
}

/// The parameters of a candidate or of a rig, in the order of the file: tables list them as their author did.
pub(crate) fn parameters(specs: Parameters, scope: &Scope) -> Outcome<Vec<(Parameter, Range<usize>)>> {
    let mut specs: Vec<_> = specs.into_iter().collect();
    specs.sort_by_key(|(_, p)| p.span().start);
    let read = |(name, spec): (String, Spanned<ParameterSpec>)| {
        let at = spec.span();
        check_name("parameter", &name, scope).map_err(|problem| (at.clone(), problem))?;
        let ParameterSpec { symbol, unit, prior } = spec.into_inner();
        let symbol = symbol.unwrap_or_else(|| name.clone());
        // The unit of a factor before a power may depend on the power: 1/W^k_3.
        let of_a_power = unit.split('^').skip(1).any(|rest| rest.starts_with(|c: char| c.is_alphabetic()));
        let parsed = match rijke_rig::Unit::parse(&unit) {
            Ok(parsed) => parsed,
            Err(_) if of_a_power => rijke_rig::Unit::one(),
            Err(source) => return Err((at, StudyProblem::Unit { key: format!("unit of {name}"), source })),
        };
        // Formulas compute with the number as it stands: 3 ms would be 3 s.
        if (parsed.to_si(0.0), parsed.to_si(1.0)) != (0.0, 1.0) {
            let si = crate::campaign::si_text(&parsed);
            let si = if si.is_empty() { String::new() } else { format!(" `{si}`") };
            let text = format!(
                "the unit of `{name}` is `{unit}`, and formulas compute with the number as it stands: write its prior in SI units, and the unit{si}"
            );
            return Err((at, StudyProblem::Toml(text)));
        }
        // `sec` is a second, by the name that formulas check.
        let si = crate::campaign::si_text(&parsed);
        let other_name = !of_a_power && !rijke_formula::is_unit(&unit) && rijke_formula::is_unit(&si);
        let parameter = Parameter::new(name, symbol, if other_name { si } else { unit }, prior);
        // The checks on priors are those of the inference, where they are used.
        match rijke_inference::Parameters::new(vec![parameter.clone()]) {
            Ok(_) => Ok((parameter, at)),
            Err(error) => {
                let reason = error.to_string();
                let exact = reason.contains("sd = 0,");
                Err((at, StudyProblem::Prior { parameter: parameter.name, reason, exact }))
            }
        }
    };
    specs.into_iter().map(read).collect()
}

pub(crate) fn check_name(what: &'static str, name: &str, scope: &Scope) -> Result<(), StudyProblem> {
    let good = name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    let why = if !good {
        "use letters, digits and _, and start with a letter"
    } else if scope.check(name).is_err() && scope.find(name).is_none() {
        "formulas know it as a function or a constant"
    } else {
        return free(scope, what, name);
    };
    Err(StudyProblem::Name { what, name: name.to_owned(), why })
}
