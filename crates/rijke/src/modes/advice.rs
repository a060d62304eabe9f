//! Where a small device or change would stabilise a mode most.

use crate::ui::Ui;
use rijke_report::ModeCurves;
use serde::Serialize;

/// A small change somewhere along the tube.
#[derive(Clone, Copy)]
pub(crate) enum Change {
    Drag,
    Heat,
    Leak,
    Area,
    Temperature,
}

/// In the order of the curves.
pub(crate) const CHANGES: [Change; 5] =
    [Change::Drag, Change::Heat, Change::Leak, Change::Area, Change::Temperature];

impl Change {
    /// What a curve of the figure shows.
    pub(super) fn label(self) -> &'static str {
        match self {
            Self::Drag => "screen *e* \u{3c1}*c u*: d\u{3c3}/d*e* / s^{-1}",
            Self::Heat => "heater *e u*: d\u{3c3}/d*e* / s^{-1}",
            Self::Leak => "leak *e p*/\u{3c1}*c*: d\u{3c3}/d*e* / s^{-1}",
            Self::Area => "wider by 100 %: d\u{3c3}/d*x* / s^{-1} m^{-1}",
            Self::Temperature => "warmer by 100 %: d\u{3c3}/d*x* / s^{-1} m^{-1}",
        }
    }

    /// Name of its column of numbers.
    pub(crate) fn column(self) -> &'static str {
        match self {
            Self::Drag => "by_screen_per_s",
            Self::Heat => "by_heat_per_s",
            Self::Leak => "by_leak_per_s",
            Self::Area => "by_area_per_s_per_m",
            Self::Temperature => "by_temperature_per_s_per_m",
        }
    }

    /// What is proposed, of which sign, and how much of a unit it is.
    fn proposal(self, sign: f64) -> (&'static str, f64) {
        match self {
            Self::Drag => ("a screen that takes 0.01 rho c u", 0.01),
            Self::Heat => ("a heater that adds 0.01 u in phase", 0.01),
            Self::Leak => ("a leak that takes 0.01 p/(rho c)", 0.01),
            Self::Area if sign > 0.0 => ("0.1 m wider by 1 %", 0.001),
            Self::Area => ("0.1 m narrower by 1 %", 0.001),
            Self::Temperature if sign > 0.0 => ("0.1 m warmer by 1 %", 0.001),
            Self::Temperature => ("0.1 m colder by 1 %", 0.001),
        }
    }
}

/// The best place for one change.
#[derive(Serialize)]
pub(crate) struct Advice {
    frequency_hz: f64,
    proposal: &'static str,
    /// m from the upstream end.
    at: f64,
    /// Change of the growth rate, 1/s.
    growth_rate_change: f64,
}

/// The best place of every change, mode by mode.
pub(crate) fn of(modes: &[ModeCurves]) -> Vec<Advice> {
    let mut all = Vec::new();
    for mode in modes {
        for (change, (_, curve)) in CHANGES.iter().zip(&mode.changes) {
            // Devices act one way; areas and temperatures can go both ways.
            let both = matches!(change, Change::Area | Change::Temperature);
            let gain = |v: f64| if both { -v.abs() } else { v };
            let best = mode.x.iter().zip(curve).min_by(|a, b| gain(*a.1).total_cmp(&gain(*b.1)));
            if let Some((&at, &value)) = best {
                let (proposal, unit) = change.proposal(-value);
                let growth_rate_change = unit * gain(value);
                all.push(Advice { frequency_hz: mode.frequency_hz, proposal, at, growth_rate_change });
            }
        }
    }
    all
}

pub(crate) fn print(modes: &[ModeCurves], advice: &[Advice], ui: &Ui) {
    if advice.is_empty() {
        return;
    }
    let head = ["mode\nHz", "small change", "best place\nm", "growth rate\nchanges by, 1/s"];
    let row = |a: &Advice| {
        let effect = if a.growth_rate_change < 0.0 {
            format!("{:.4}", a.growth_rate_change)
        } else {
            "nowhere less".to_owned()
        };
        [format!("{:.2}", a.frequency_hz), a.proposal.to_owned(), format!("{:.3}", a.at), effect]
    };
    ui.table(head, advice.iter().map(row));
    let modes = if modes.len() == 1 { "one mode".to_owned() } else { format!("{} modes", modes.len()) };
    ui.say(format!("To first order, each change alone, for {modes}. Curves along x: --plot, --along."));
}
