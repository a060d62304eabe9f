//! Where the elements of a file lie: ducts follow each other, devices stand where the file puts them.

use super::error::FileError;
use super::item::Item;
use super::problem::ElementProblem;
use super::schema::Element;
use rijke_numerics::words::line_of;
use serde::Deserialize;
use toml::Spanned;

/// An element with its place.
pub(super) struct Placed {
    pub(super) item: Item,
    /// Its name, or else its type.
    pub(super) called: String,
    pub(super) element: Element,
    /// Where it begins, m from the upstream end.
    pub(super) x: f64,
}

impl Placed {
    pub(super) fn is_duct(&self) -> bool {
        matches!(self.element, Element::Duct(_))
    }
}

/// Positions closer than this part of the length are the same.
pub(super) const SAME: f64 = 1e-9;

/// Reads the tables of all elements and places them; the devices come behind the ducts, in order of place,
/// then of file.
pub(super) fn place(text: &str, tables: &[Spanned<toml::Table>]) -> Result<(Vec<Placed>, f64), FileError> {
    let (mut all, mut end) = (Vec::new(), 0.0);
    let mut last = String::new();
    let names: Vec<_> = tables.iter().map(|table| table.get_ref().get("name")).collect();
    for (index, table) in tables.iter().enumerate() {
        let (item, called, at, element) = parse(text, index, table)?;
        if let Some(other) = names[..index].iter().position(|name| name.is_some() && *name == names[index]) {
            return Err(item.fail(ElementProblem::SameName { other: other + 1 }));
        }
        let x = if let Element::Duct(duct) = &element {
            let length = item.positive("length", duct.length)?;
            if let Some(at) = at {
                let by = end - at;
                let slack = SAME * (end + length);
                if by > slack {
                    return Err(item.fail(ElementProblem::Overlap { at, other: last, by }));
                }
                if by < -slack {
                    return Err(item.fail(ElementProblem::Gap { at, by: -by }));
                }
            }
            last.clone_from(&item.place);
            let start = end;
            end += length;
            start
        } else {
            at.unwrap_or(end)
        };
        all.push(Placed { item, called, element, x });
    }
    if !all.iter().any(Placed::is_duct) {
        return Err(FileError::NoDuct);
    }
    let slack = SAME * end;
    for placed in &all {
        if let Element::Duct(duct) = &placed.element
            && duct.length <= slack
        {
            let problem = ElementProblem::TooShort { length: duct.length, tube: end };
            return Err(placed.item.fail(problem));
        }
    }
    if let Some(out) = all.iter().find(|p| !p.is_duct() && !(-slack..=end + slack).contains(&p.x)) {
        return Err(out.item.fail(ElementProblem::OutsideTube { at: out.x, length: end }));
    }
    all.sort_by(|a, b| b.is_duct().cmp(&a.is_duct()).then(a.x.total_cmp(&b.x)));
    Ok((all, end))
}

fn parse(
    text: &str,
    index: usize,
    table: &Spanned<toml::Table>,
) -> Result<(Item, String, Option<f64>, Element), FileError> {
    let line = line_of(text, table.span().start);
    let mut table: toml::Table = table.get_ref().clone();
    let kind = table.get("type").and_then(toml::Value::as_str).unwrap_or("?").to_owned();
    let name = table.remove("name");
    let called = name.as_ref().and_then(toml::Value::as_str);
    let shown = called.map_or(String::new(), |n| format!(" `{n}`"));
    let item = Item { line, place: format!("element {}{shown} ({kind})", index + 1) };
    if name.is_some() && called.is_none() {
        return Err(item.fail(ElementProblem::Keys { message: "name must be text".to_owned() }));
    }
    let at = match table.remove("at") {
        None => None,
        Some(value) => match f64::deserialize(value) {
            Ok(at) if at.is_finite() => Some(at),
            _ => {
                let message = "at must be a number, m from the upstream end".to_owned();
                return Err(item.fail(ElementProblem::Keys { message }));
            }
        },
    };
    let called = called.map_or(kind, str::to_owned);
    let element = item.parse(table)?;
    Ok((item, called, at, element))
}
