//! Where a small device or change would stabilise a mode most.

use crate::ui::Ui;
use rijke_network::{BestPlace, Device, SmallChange};
use rijke_report::ModeCurves;
use serde::Serialize;

/// What a curve of the figure shows, and the name of its column of numbers.
pub(super) fn names(change: SmallChange) -> [&'static str; 2] {
    match change {
        SmallChange::Device(Device::Drag) => {
            ["screen *e* \u{3c1}*c u*: d\u{3c3}/d*e* / s^{-1}", "by_screen [1/s]"]
        }
        SmallChange::Device(Device::Heat) => ["heat *e u*: d\u{3c3}/d*e* / s^{-1}", "by_heat [1/s]"],
        SmallChange::Device(Device::Leak) => {
            ["leak *e p*/\u{3c1}*c*: d\u{3c3}/d*e* / s^{-1}", "by_leak [1/s]"]
        }
        SmallChange::Area => ["wider by 100 %: d\u{3c3}/d*x* / s^{-1} m^{-1}", "by_area [1/(s m)]"],
        SmallChange::Temperature => {
            ["warmer by 100 %: d\u{3c3}/d*x* / s^{-1} m^{-1}", "by_temperature [1/(s m)]"]
        }
    }
}

/// The best place for one change of a mode.
#[derive(Serialize)]
pub(crate) struct Advice {
    frequency_hz: f64,
    #[serde(flatten)]
    best: BestPlace,
}

/// The best place of every change, mode by mode.
pub(crate) fn of(modes: &[ModeCurves]) -> Vec<Advice> {
    let of_mode = |mode: &ModeCurves| -> Vec<Advice> {
        let best = SmallChange::ALL.iter().zip(&mode.changes);
        let best = best.filter_map(|(change, (_, curve))| change.best(&mode.x, curve));
        best.map(|best| Advice { frequency_hz: mode.frequency_hz, best }).collect()
    };
    modes.iter().flat_map(of_mode).collect()
}

pub(crate) fn print(modes: &[ModeCurves], advice: &[Advice], ui: &Ui) {
    if advice.is_empty() {
        return;
    }
    let head = ["mode\nHz", "small change", "best place\nm", "growth rate\nchanges by, 1/s"];
    let row = |Advice { frequency_hz, best }: &Advice| {
        let effect = if best.growth_rate_change < 0.0 {
            format!("{:.4}", best.growth_rate_change)
        } else {
            "nowhere less".to_owned()
        };
        [format!("{frequency_hz:.2}"), best.proposal.to_owned(), format!("{:.3}", best.at), effect]
    };
    ui.table(head, advice.iter().map(row));
    let modes = crate::number::counted(modes.len(), "mode");
    ui.say(format!("To first order, each change alone, for {modes}. Curves along x: --plot, --along."));
}
