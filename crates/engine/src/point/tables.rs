//! Where the laws of a model rest on tables that were not measured so far.

use super::model::{LawAt, PointModel};
use rijke_formula::Here;
use rijke_numerics::{C64, ComplexDual, JetSpace, Order};
use rijke_study::names::S;
use rijke_study::{Effect, TableUse};
use std::f64::consts::TAU;

/// Share of a limit by which a frequency may lie beyond it.
const ROUNDING: f64 = 1e-9;

/// A table of which a law asks more than was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct BeyondTable {
    /// What the file calls the table; empty for that of an element.
    pub name: String,
    /// Where the law acts.
    pub place: String,
    /// The frequency that is asked for, Hz: that of the mode times what scales it.
    pub asked_hz: f64,
    /// Frequencies from and to at which it was measured, Hz.
    pub band_hz: [f64; 2],
}

impl std::fmt::Display for BeyondTable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, place, asked_hz, band_hz: [low, high] } = self;
        let table = if name.is_empty() { "the table".to_owned() } else { format!("the table `{name}`") };
        write!(
            f,
            "{table} of `{place}` is asked at {asked_hz:.1} Hz, and was measured from {low} to {high} Hz"
        )
    }
}

impl PointModel<'_> {
    /// The first table that is asked beyond its frequencies by the mode `s`, at these parameters.
    pub(crate) fn beyond_a_table(&self, values: &[f64], s: C64) -> Option<BeyondTable> {
        let numbers = self.assembly.numbers(values);
        let dual = ComplexDual { value: s, slope: C64::ONE };
        let mut analytic = [None; S + 1];
        analytic[S] = Some(&dual);
        let asked = |law: &LawAt, table: &TableUse| {
            let here = Here {
                space: JetSpace::new(1, Order::First),
                numbers: &self.surroundings[law.around],
                analytic: &analytic,
            };
            table.argument.evaluate_in_s(&here, &numbers[law.candidate]).value.im.abs() / TAU
        };
        let beyond = |law: &LawAt, effect: &Effect, table: &TableUse| {
            let ([low, high], asked_hz) = (table.band_hz, asked(law, table));
            let outside = asked_hz < low * (1.0 - ROUNDING) || asked_hz > high * (1.0 + ROUNDING);
            let (name, place) = (table.name.clone(), effect.place_text.clone());
            outside.then_some(BeyondTable { name, place, asked_hz, band_hz: table.band_hz })
        };
        self.laws.iter().find_map(|law| {
            let effect = self.effect(law);
            effect.tables.iter().find_map(|table| beyond(law, effect, table))
        })
    }
}
