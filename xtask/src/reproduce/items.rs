//! A stage, a question or a map of the study, and what it rests on.

use crate::workspace::root;
use toml::{Table, Value};

/// The study of the paper.
pub(super) const STUDY: &str = "examples/juniper-yoko-2022";

/// What a run goes as far as.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Item {
    /// As given to `--only`.
    pub(super) name: String,
    /// The last stage of the study that is needed.
    pub(super) until: String,
    /// Rows of the campaign that are measured where no inferred flow is needed: those that have none.
    pub(super) cold: Option<Vec<String>>,
}

/// The item of a name in study.toml.
pub(super) fn parse(name: &str) -> Result<Item, String> {
    let read =
        |file| std::fs::read_to_string(root().join(STUDY).join(file)).map_err(|e| format!("{file}: {e}"));
    let study: Table = read("study.toml")?.parse().map_err(|e| format!("study.toml: {e}"))?;
    let list = |key: &str| study.get(key).and_then(Value::as_array).into_iter().flatten();
    let text = |table: &Value, key: &str| table.get(key)?.as_str().map(str::to_owned);
    let ids = |key, of| list(key).filter_map(move |t| text(t, "id").zip(text(t, of)));
    let all: Vec<_> = ids("stage", "id").chain(ids("ask", "stage")).chain(ids("map", "stage")).collect();
    let Some((_, until)) = all.iter().find(|(id, _)| id == name) else {
        return Err(format!("not one of {}", all.into_iter().map(|a| a.0).collect::<Vec<_>>().join(", ")));
    };
    // The flow is inferred where factors are above limits.
    let wanted = |table: &Value| table.get("points")?.get("where").cloned();
    let number = |v: &Value| v.as_float().or(v.as_integer().map(|i| i as f64));
    let hot = study.get("base").and_then(|base| wanted(base.get("states")?));
    let limit = |(factor, range): (&String, &Value)| Some((factor.clone(), number(range.get("above")?)?));
    let limits: Vec<_> = hot.iter().filter_map(Value::as_table).flatten().filter_map(limit).collect();
    let is_cold = |value: &dyn Fn(&str) -> Option<f64>| {
        limits.iter().any(|(factor, above)| value(factor).is_some_and(|v| v <= *above))
    };
    // A run answers all questions of the stages that it trains.
    let needed = 1 + list("stage").position(|s| text(s, "id").as_ref() == Some(until)).unwrap_or(0);
    let stages: Vec<&Value> = list("stage").take(needed).collect();
    let trained = |ask: &Value| stages.iter().any(|s| text(s, "id") == text(ask, "stage"));
    let asked = list("ask").filter(|ask| trained(ask) && wanted(ask).is_some());
    let cold = stages
        .iter()
        .copied()
        .chain(asked)
        .all(|t| is_cold(&|factor| wanted(t)?.get(factor).and_then(number)));
    let campaign = read("campaign.csv")?;
    let mut lines =
        campaign.lines().filter(|l| !l.starts_with('#')).map(|l| l.split(',').collect::<Vec<_>>());
    let head = lines.next().unwrap_or_default();
    let place = |name: &str| head.iter().position(|column| column.split(" [").next() == Some(name));
    let lines = lines.filter(|line| is_cold(&|factor| line.get(place(factor)?)?.parse().ok()));
    let mut rows: Vec<String> = lines.filter_map(|l| Some((*l.get(place("row")?)?).to_owned())).collect();
    rows.dedup();
    Ok(Item { name: name.to_owned(), until: until.clone(), cold: cold.then_some(rows) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_an_item_needs_its_stage_and_a_wrong_one_is_named() {
        let of = |name: &str| parse(name).map(|item| (item.until, item.cold));
        let cold = ["C1", "C2", "C3", "H0"].map(str::to_owned).to_vec();
        assert_eq!(of("prongs"), Ok(("prongs".to_owned(), Some(cold))));
        // Its stage is answered with Figs. 6 and 7, which are about hot points.
        assert_eq!(of("figure-5"), Ok(("thermocouples".to_owned(), None)));
        assert_eq!(of("figure-10"), Ok(("heat-release".to_owned(), None)));
        assert_eq!(of("stability"), of("heat-release"));
        assert!(of("figure-13").unwrap_err().contains("undamped-wall, figure-3"));
    }
}
