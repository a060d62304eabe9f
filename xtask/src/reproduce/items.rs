//! The tables and figures of the paper, and the rows of Table 1 that each rests on.

/// A table or figure.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Item {
    /// As given to `--only`.
    pub(crate) name: &'static str,
    /// Rows of the campaign that must be measured; all if none is named.
    pub(super) rows: &'static [&'static str],
    /// The last stage of the study that is needed; all for hot points, whose base flow is inferred too.
    pub(super) until: Option<&'static str>,
}

const fn cold(name: &'static str, rows: &'static [&'static str], until: &'static str) -> Item {
    Item { name, rows, until: Some(until) }
}

const fn hot(name: &'static str) -> Item {
    Item { name, rows: &[], until: None }
}

/// Every table and figure that is computed. Fig. 1 is a drawing of the heater.
const ITEMS: [Item; 15] = [
    cold("table-1", &[], "empty-tube"),
    hot("figure-2"),
    cold("figure-3", &["C3"], "ends-and-wall"),
    cold("table-2", &["C3"], "prongs"),
    cold("figure-4", &["C3"], "prongs"),
    cold("table-3", &["C1", "C2", "C3"], "heater"),
    cold("figure-5", &["C1", "C2", "C3", "H0"], "thermocouples"),
    hot("figure-6"),
    hot("figure-7"),
    hot("table-4"),
    hot("figure-8"),
    hot("figure-9"),
    hot("figure-10"),
    hot("figure-11"),
    cold("figure-12", &["C3"], "ends-and-wall"),
];

/// The item of a name.
pub(super) fn parse(name: &str) -> Result<&'static Item, String> {
    let known = || ITEMS.map(|item| item.name).join(", ");
    ITEMS.iter().find(|item| item.name == name).ok_or_else(|| format!("not one of {}", known()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_an_item_needs_its_rows_and_a_wrong_one_is_named() {
        assert_eq!(parse("table-3").unwrap().rows, ["C1", "C2", "C3"]);
        assert_eq!(parse("table-4").unwrap().until, None);
        assert!(parse("table-9").unwrap_err().contains("table-4, figure-8"));
    }
}
