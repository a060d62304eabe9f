//! Published statements, held against the tables of a study. Every threshold is in the statement, and is
//! judged here.

use super::answers::Answer;
use super::frame::{Frame, FrameColumn, FrameRow, finite};
use super::record::{ModelRecord, StageRecord};
use rijke_numerics::range;
use rijke_rig::DataKind;
use rijke_study::{ClaimNumber, Claims, Statement, Take};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A statement that was judged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Judgement {
    /// The stage or question that it is about.
    pub of: String,
    /// In words.
    pub statement: String,
    /// Whether it holds here.
    pub holds: bool,
    /// The numbers that decide it.
    pub figure: String,
    /// What is known of the reason where it fails on virtual data.
    pub explanation: Option<String>,
}

/// Judges every statement whose numbers are all there; of what was not measured nothing is said. Reasons are
/// known of virtual data alone.
#[must_use]
pub fn verdicts(
    claims: &Claims,
    kind: DataKind,
    stages: &[StageRecord],
    answers: &[Answer],
) -> Vec<Judgement> {
    let of_stages = stages.iter().map(|s| (s.id.as_str(), models(s)));
    let others = answers.iter().filter(|a| stages.iter().all(|s| s.id != a.id));
    let of_answers = others.filter_map(|a| Some((a.id.as_str(), a.frames.first()?.clone())));
    let tables: BTreeMap<&str, Frame> = of_stages.chain(of_answers).collect();
    let known = |mut judged: Judgement| {
        judged.explanation = judged.explanation.filter(|_| kind == DataKind::Virtual);
        judged
    };
    claims.statements.iter().filter_map(|s| verdict(s, &tables)).map(known).collect()
}

/// Kendall's tau between the order of a stage's models and the published one: 1 for the same order, -1 for
/// the opposite; none where fewer than two models were published.
#[must_use]
pub fn agreement(claims: &Claims, stage: &StageRecord) -> Option<f64> {
    let published = claims.published.get(&stage.id)?;
    let both = |m: &ModelRecord| Some([m.evidence?.ln_marginal, published.get(&m.id)?[2]]);
    let both: Vec<[f64; 2]> = stage.models.iter().filter_map(both).collect();
    let order = |a: f64, b: f64| f64::from(a.total_cmp(&b) as i8);
    let signs: Vec<f64> = (0..both.len())
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .map(|(i, j)| order(both[i][0], both[j][0]) * order(both[i][1], both[j][1]))
        .collect();
    (!signs.is_empty()).then(|| signs.iter().sum::<f64>() / signs.len() as f64)
}

/// The models of a stage as a table: evidences per observation, misfits, parameters with their standard
/// deviations.
#[must_use]
pub fn models(stage: &StageRecord) -> Frame {
    let mut columns: Vec<FrameColumn> = [
        ("ln_best_fit", "ln best fit per observation", "1"),
        ("ln_occam", "ln Occam factor per observation", "1"),
        ("ln_marginal", "ln evidence per observation", "1"),
        ("total", "ln evidence", "1"),
        ("probability", "Probability, all models equally probable before", "1"),
        ("growth_rate_misfit", "Misfit of the growth rate", "1/s"),
        ("angular_frequency_misfit", "Misfit of the angular frequency", "rad/s"),
        ("pressure_misfit", "Misfit of relative pressures", "1"),
    ]
    .into_iter()
    .map(|(name, label, unit)| FrameColumn::new(name, label, unit))
    .collect();
    let first = columns.len();
    // Candidates may use one name for parameters of different units.
    let mut names: Vec<[&str; 2]> = Vec::new();
    for p in stage.models.iter().flat_map(|m| &m.parameters) {
        if !names.contains(&[p.name.as_str(), p.unit.as_str()]) {
            names.push([&p.name, &p.unit]);
            columns.push(FrameColumn::new(&p.name, &p.symbol, &p.unit));
            columns.push(FrameColumn::new(&format!("{}_sd", p.name), &format!("{}, sd", p.symbol), &p.unit));
        }
    }
    let row = |(m, probability): (&ModelRecord, f64)| {
        let mut values = vec![None; columns.len()];
        if let Some(e) = m.evidence {
            let all = e.per_observation().into_iter().chain([e.ln_marginal, probability]).chain(m.misfit);
            values[..first].iter_mut().zip(all).for_each(|(to, from)| *to = finite(from));
        }
        for p in &m.parameters {
            if let Some(k) = names.iter().position(|n| *n == [&p.name, &p.unit]) {
                (values[first + 2 * k], values[first + 2 * k + 1]) = (finite(p.value), finite(p.sd));
            }
        }
        FrameRow { label: m.id.clone(), series: stage.id.clone(), values, ..FrameRow::default() }
    };
    let rows = stage.models.iter().zip(stage.probabilities()).map(row).collect();
    Frame { columns, rows }
}

fn verdict(statement: &Statement, tables: &BTreeMap<&str, Frame>) -> Option<Judgement> {
    let mut numbers: Vec<(&str, f64)> = Vec::new();
    for (name, q) in &statement.quantities {
        let table = tables.get(q.of.as_deref().unwrap_or(&statement.of))?;
        numbers.push((name, taken(q, table)?));
    }
    // The scope of a formula begins with s.
    let values: Vec<f64> = std::iter::once(f64::NAN).chain(numbers.iter().map(|(_, v)| *v)).collect();
    let holds = statement.ascending.iter().all(|chain| {
        let sides: Vec<f64> = chain.iter().map(|f| f.real(&values)).collect();
        sides.windows(2).all(|w| w[0] < w[1])
    });
    let figure =
        numbers.iter().map(|(name, v)| format!("{name} = {}", short(*v))).collect::<Vec<_>>().join(", ");
    Some(Judgement {
        of: statement.of.clone(),
        statement: statement.text.clone(),
        holds,
        figure,
        explanation: statement.explanation.clone().filter(|_| !holds),
    })
}

/// Four digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e5).contains(&size) {
        let digits = if size >= 1000.0 {
            1
        } else if size >= 10.0 {
            2
        } else {
            4
        };
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

fn taken(q: &ClaimNumber, table: &Frame) -> Option<f64> {
    let known = |name: &str| table.column(name).is_some();
    if !known(&q.column) || !q.conditions.keys().all(|name| known(name)) {
        return None;
    }
    // Parameters of one name and different units have a column each.
    let number = |row: &FrameRow, name: &str| {
        let mut cells = table.columns.iter().zip(&row.values).filter(|(column, _)| column.name == name);
        cells.find_map(|(_, value)| *value).unwrap_or(f64::NAN)
    };
    let meant = |row: &&FrameRow| {
        (q.rows.is_empty() || q.rows.contains(&row.label))
            && !q.except.contains(&row.label)
            && q.conditions.iter().all(|(name, c)| c.holds(number(row, name)))
    };
    let rows: Vec<&FrameRow> = table.rows.iter().filter(meant).collect();
    // A row that was asked for by name must be there.
    if q.rows.iter().any(|label| rows.iter().all(|r| r.label != *label)) {
        return None;
    }
    let all: Vec<f64> = rows.iter().map(|r| number(r, &q.column)).filter(|v| v.is_finite()).collect();
    if all.is_empty() {
        return None;
    }
    let mean = |f: &dyn Fn(f64) -> f64| all.iter().map(|v| f(*v)).sum::<f64>() / all.len() as f64;
    let centre = mean(&|v| v);
    let [least, most] = range(all.iter().copied());
    Some(match q.take {
        Take::Mean => centre,
        Take::Rms => mean(&|v| v * v).sqrt(),
        Take::Spread => mean(&|v| (v - centre).powi(2)).sqrt(),
        Take::Least => least,
        Take::Most => most,
        Take::Range => most - least,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Frame {
        let columns = vec![FrameColumn::new("x", "x", "m"), FrameColumn::new("y", "y", "1")];
        let row = |(label, x, y): (&str, f64, f64)| FrameRow {
            label: label.into(),
            series: String::new(),
            values: vec![Some(x), finite(y)],
            ..FrameRow::default()
        };
        let rows =
            [("a", 0.0, 1.0), ("b", 1.0, 3.0), ("c", 2.0, 8.0), ("d", 2.0, f64::NAN)].map(row).to_vec();
        Frame { columns, rows }
    }

    fn quantity(text: &str) -> Option<f64> {
        taken(&toml::from_str(text).unwrap(), &table())
    }

    #[test]
    fn exact_numbers_of_a_table() {
        assert_eq!(quantity("column = 'y'"), Some(4.0));
        assert_eq!(quantity("column = 'y'\nrows = ['b']"), Some(3.0));
        assert_eq!(quantity("column = 'y'\nexcept = ['c']\ntake = 'range'"), Some(2.0));
        assert_eq!(quantity("column = 'y'\nwhere = { x = { above = 0.5 } }\ntake = 'spread'"), Some(2.5));
        assert_eq!(quantity("column = 'y'\nrows = ['nobody']"), None);
        assert_eq!(quantity("column = 'z'"), None, "no verdict from nothing");
    }
}
