//! What each law of a rig has of the growth rate of a mode.

use super::{CLOSED, LOSSY, assembly, conditions, network, study};
use rijke_engine::PointModel;

/// Flames that answer to velocities elsewhere, two at places and one that is spread: each acts by several
/// coefficients, whose parts are those of one law.
#[test]
fn exact_parts_of_the_growth_rate_bear_the_names_of_their_laws() {
    let flame = |name: &str, more: &str| {
        format!("[[element]]\nname = '{name}'\ntype = 'flame'\ngain = 0.2\ndelay = 1e-3\n{more}\n")
    };
    let duct = "[[element]]\ntype = 'duct'\nlength = 0.1\ndiameter = 0.03\n";
    let flames = [
        flame("first", "reference = 0.1"),
        flame("second", "reference = 0.05"),
        flame("third", "length = 0.2\npieces = 4"),
    ];
    let study = study("accounts", &network(&flames.join(duct), [CLOSED, LOSSY])).unwrap();
    let (assembly, conditions) = (assembly(&study), conditions(&study));
    let model = PointModel::new(&assembly, &conditions, &[]).unwrap();
    let (_, spectrum) = model.spectrum(&[], [None, None]).unwrap();
    assert!(spectrum.modes.modes.len() >= 3);
    for mode in &spectrum.modes.modes {
        let details = spectrum.of(mode).unwrap();
        for name in ["first", "second", "third"] {
            let all = details.laws.iter().filter(|(law, _)| law.ends_with(&format!(" at {name}")));
            assert_eq!(all.count(), 1, "{:?}", details.laws);
        }
        assert!(!details.laws.iter().any(|(law, _)| law.starts_with("law ")), "{:?}", details.laws);
        // The account is that of this mode: its powers over its energy are twice its growth rate.
        let growth = details.budget.growth;
        assert!((growth - 2.0 * mode.s.re).abs() < 1e-9 * mode.s.norm(), "{growth} {}", mode.s);
    }
}
