//! Points that stand at one place of the axis and differ by other factors: which symbol each has.

use rijke_draw::Symbol;
use rijke_engine::run::{Answer, Frame, FrameRow, LayerLook, symbol};
use std::collections::{BTreeMap, BTreeSet};

/// The groups of the points of a figure; without any where points need no telling apart.
pub(super) struct Groups {
    /// What the points of each group have in common.
    pub(super) names: Vec<String>,
    /// The group of each point, by the name of the point.
    of: BTreeMap<String, usize>,
}

/// Values of a row, as they are compared.
type Values = Vec<Option<u64>>;

impl Groups {
    /// Of the measured points of an answer, whose table begins with the factors. `by_series` says whether
    /// series have colours, so that only points of one series need telling apart.
    pub(super) fn of(answer: &Answer, by_series: bool) -> Self {
        Self::found(answer, by_series).unwrap_or(Self { names: Vec::new(), of: BTreeMap::new() })
    }

    fn found(answer: &Answer, by_series: bool) -> Option<Self> {
        let frame = answer.frames.first()?;
        let factors = frame.column("growth_rate")?;
        let layers = || answer.panels.iter().flat_map(|p| &p.layers);
        let axis = layers().find(|l| l.frame == 0 && l.look == LayerLook::Dots).map(|l| l.x)?;
        let others = others(frame, factors, axis);
        let key = |row: &FrameRow, columns: &[usize]| -> Values {
            columns.iter().map(|k| row.number(*k).map(f64::to_bits)).collect()
        };
        let count =
            |columns: &[usize]| frame.rows.iter().map(|r| key(r, columns)).collect::<BTreeSet<_>>().len();
        // Those of the fewest values first, as long as there are symbols for them.
        let mut telling: Vec<usize> = Vec::new();
        for k in others {
            telling.push(k);
            if count(&telling) > Symbol::COUNT {
                telling.pop();
            }
        }
        telling.sort_unstable();
        let mut together: BTreeMap<_, BTreeSet<Values>> = BTreeMap::new();
        for row in &frame.rows {
            let series = if by_series { row.series.as_str() } else { "" };
            let place = (key(row, &[axis]), row.mode.as_str(), series);
            together.entry(place).or_default().insert(key(row, &telling));
        }
        if together.values().all(|of| of.len() < 2) {
            return None;
        }
        let mut rows: Vec<&FrameRow> = frame.rows.iter().collect();
        let value = |row: &FrameRow, k: usize| row.number(k).unwrap_or(f64::NEG_INFINITY);
        rows.sort_by(|a, b| {
            let compared = telling.iter().map(|&k| value(a, k).total_cmp(&value(b, k)));
            compared.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        });
        let mut keys: Vec<Values> = Vec::new();
        let (mut names, mut of) = (Vec::new(), BTreeMap::new());
        for row in rows {
            let own = key(row, &telling);
            let group = keys.iter().position(|k| *k == own).unwrap_or_else(|| {
                keys.push(own);
                names.push(factors_of(frame, row, &telling));
                keys.len() - 1
            });
            of.insert(row.label.clone(), group);
        }
        Some(Self { names, of })
    }

    /// Whether points need telling apart.
    pub(super) fn any(&self) -> bool {
        !self.names.is_empty()
    }

    /// The group of the point with this name; the first if it has none.
    pub(super) fn of_point(&self, label: &str) -> usize {
        self.of.get(label).copied().unwrap_or(0)
    }

    /// The symbol of the point with this name.
    pub(super) fn symbol(&self, label: &str) -> Symbol {
        Symbol::of(self.of_point(label))
    }
}

/// The factors with several values but that of the axis, those of the fewest first.
fn others(frame: &Frame, factors: usize, axis: usize) -> Vec<usize> {
    let values = |k: usize| {
        let all = frame.numbers(k).into_iter().map(|v| v.map(f64::to_bits));
        all.collect::<BTreeSet<_>>().len()
    };
    let mut varying: Vec<(usize, usize)> =
        (0..factors).filter(|k| *k != axis).map(|k| (values(k), k)).filter(|(n, _)| *n > 1).collect();
    varying.sort_unstable();
    varying.into_iter().map(|(_, k)| k).collect()
}

/// Factors of a row with their values, in the markup of labels.
pub(super) fn factors_of(frame: &Frame, row: &FrameRow, columns: &[usize]) -> String {
    let part = |&k: &usize| {
        let column = &frame.columns[k];
        let unit = if column.unit == "1" { String::new() } else { format!(" {}", column.unit) };
        let called = symbol(&column.name);
        row.number(k).map_or(format!("no {called}"), |v| format!("{called} = {v}{unit}"))
    };
    columns.iter().map(part).collect::<Vec<_>>().join(", ")
}
