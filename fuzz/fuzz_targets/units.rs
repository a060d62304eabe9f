//! Any text as a unit, a quantity and a heading.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_rig::{Heading, Quantity, Unit};

fuzz_target!(|text: &str| {
    if let Ok(unit) = Unit::parse(text) {
        assert!(unit.factor() > 0.0 && unit.factor().is_finite());
        assert_eq!(Unit::parse(unit.text()), Ok(unit));
    }
    let _ = (Quantity::parse(text), Heading::parse(text));
});
