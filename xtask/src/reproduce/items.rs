//! The tables and figures of the paper, and the rows of Table 1 that each rests on.

/// A table or figure.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Item {
    /// As given to `--only`.
    pub(crate) name: &'static str,
    /// Rows of the campaign that must be measured; all if none is named.
    pub(super) rows: &'static [&'static str],
    /// Whether the base flow of the hot points is needed.
    pub(super) flow: bool,
}

const fn cold(name: &'static str, rows: &'static [&'static str]) -> Item {
    Item { name, rows, flow: false }
}

const fn hot(name: &'static str) -> Item {
    Item { name, rows: &[], flow: true }
}

/// Every table and figure that is computed. Fig. 1 is a drawing of the heater.
const ITEMS: [Item; 15] = [
    cold("table-1", &[]),
    hot("figure-2"),
    cold("figure-3", &["C3"]),
    cold("table-2", &["C3"]),
    cold("figure-4", &["C3"]),
    cold("table-3", &["C1", "C2", "C3"]),
    hot("figure-5"),
    hot("figure-6"),
    hot("figure-7"),
    hot("table-4"),
    hot("figure-8"),
    hot("figure-9"),
    hot("figure-10"),
    hot("figure-11"),
    cold("figure-12", &["C3"]),
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
        assert!(parse("table-4").unwrap().flow);
        assert!(parse("table-9").unwrap_err().contains("table-4, figure-8"));
    }
}
