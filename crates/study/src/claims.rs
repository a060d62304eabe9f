//! `paper.toml`: published numbers and statements, each held against the tables of a study.

use crate::plan::{Condition, Plan};
use crate::source::{Source, listed};
use crate::{Catalogue, StudyError, StudyProblem};
use rijke_formula::{Context, Formula, Kind, Name, Scope};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// What somebody published of a rig.
#[derive(Clone, Debug, Default)]
pub struct Claims {
    /// Where it was published.
    pub source: String,
    /// By stage: ln of best fit, Occam factor and evidence of a candidate, per operating point.
    pub published: BTreeMap<String, BTreeMap<String, [f64; 3]>>,
    /// The statements.
    pub statements: Vec<Statement>,
}

/// A statement that numbers decide.
#[derive(Clone, Debug)]
pub struct Statement {
    /// The stage or question whose table it is about.
    pub of: String,
    /// In words.
    pub text: String,
    /// Names of numbers.
    pub quantities: Vec<(String, ClaimNumber)>,
    /// It holds where each of these is less than the next.
    pub ascending: Vec<Vec<Formula>>,
    /// What is known of the reason where it fails.
    pub explanation: Option<String>,
}

/// A number from a table.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClaimNumber {
    /// The column.
    pub column: String,
    /// What is made of its numbers.
    #[serde(default)]
    pub take: Take,
    /// Labels of rows; all if empty.
    #[serde(default)]
    pub rows: Vec<String>,
    /// Labels of rows that are left out.
    #[serde(default)]
    pub except: Vec<String>,
    /// Conditions on other columns.
    #[serde(default, rename = "where")]
    pub conditions: BTreeMap<String, Condition>,
    /// Another table than that of the statement.
    pub of: Option<String>,
}

/// What is made of several numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Take {
    /// Their mean; the number itself if it is one.
    #[default]
    Mean,
    /// Their root mean square.
    Rms,
    /// Their standard deviation.
    Spread,
    /// The smallest.
    Least,
    /// The largest.
    Most,
    /// The largest minus the smallest.
    Range,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    source: String,
    #[serde(default)]
    published: BTreeMap<String, BTreeMap<String, [f64; 3]>>,
    #[serde(default)]
    claim: Vec<Spanned<ClaimFile>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ClaimFile {
    of: String,
    statement: String,
    #[serde(rename = "let")]
    quantities: BTreeMap<String, ClaimNumber>,
    holds: String,
    explanation: Option<String>,
}

impl Claims {
    /// Reads `paper.toml`; no claims where there is no such file.
    ///
    /// # Errors
    /// File, line and remedy; stages, questions and candidates must be those of the study.
    pub fn read(path: &Path, plan: &Plan, catalogue: &Catalogue) -> Result<Self, StudyError> {
        if path.exists() { Self::parse(&Source::read(path)?, plan, catalogue) } else { Ok(Self::default()) }
    }

    fn parse(source: &Source, plan: &Plan, catalogue: &Catalogue) -> Result<Self, StudyError> {
        let file: File = source.toml()?;
        let tables = || plan.answers().map(String::as_str);
        let known = |id: &str| {
            let unknown = || StudyProblem::Unknown {
                what: "stage, question or map",
                name: id.to_owned(),
                known: listed(tables()),
            };
            tables().any(|t| t == id).then_some(()).ok_or_else(unknown)
        };
        for (stage, rows) in &file.published {
            known(stage).map_err(|p| source.fail(0, p))?;
            if let Some(id) = rows.keys().find(|id| catalogue.get(id).is_none()) {
                let known = listed(catalogue.candidates().iter().map(|c| c.id.as_str()));
                return Err(
                    source.fail(0, StudyProblem::Unknown { what: "candidate", name: id.clone(), known })
                );
            }
        }
        let mut statements = Vec::new();
        for claim in file.claim {
            let at = claim.span().start;
            let claim = claim.into_inner();
            let fail = |problem| source.fail(at, problem);
            known(&claim.of).map_err(fail)?;
            claim.quantities.values().filter_map(|q| q.of.as_deref()).try_for_each(known).map_err(fail)?;
            let ascending = ascending(&claim.holds, &claim.quantities).map_err(fail)?;
            statements.push(Statement {
                of: claim.of,
                text: claim.statement,
                quantities: claim.quantities.into_iter().collect(),
                ascending,
                explanation: claim.explanation,
            });
        }
        Ok(Self { source: file.source, published: file.published, statements })
    }
}

/// `a < b < c and d > e`: lists of formulas, each less than the next.
fn ascending(
    text: &str,
    quantities: &BTreeMap<String, ClaimNumber>,
) -> Result<Vec<Vec<Formula>>, StudyProblem> {
    let mut scope = Scope::new();
    for name in quantities.keys() {
        let meaning = "a number of this claim".to_owned();
        let new = Name { name: name.clone(), unit: "1".into(), meaning, kind: Kind::Global };
        let why = "formulas name it: write a letter, then letters, digits and _, and no name of a function";
        scope.add(new).map_err(|_| StudyProblem::Name { what: "number", name: name.clone(), why })?;
    }
    let everywhere = |_: usize| true;
    let context = Context { scope: &scope, here: &everywhere, parameters: &[], definitions: &[] };
    let formula = |text: &str| {
        Formula::parse(text.trim(), &context)
            .map_err(|source| StudyProblem::Formula { key: "holds".into(), source })
    };
    let chain = |text: &str| {
        let (sign, other) = if text.contains('<') { ('<', '>') } else { ('>', '<') };
        let mut chain = text.split(sign).map(formula).collect::<Result<Vec<_>, _>>()?;
        if chain.len() < 2 || text.contains(other) {
            let (key, value) = ("holds".to_owned(), text.to_owned());
            return Err(StudyProblem::Value {
                key,
                value,
                need: "formulas joined by < or by >, as in `a < b < 2*c`",
            });
        }
        if sign == '>' {
            chain.reverse();
        }
        Ok(chain)
    };
    text.split(" and ").map(chain).collect()
}
