//! What the data still ask for, on examples whose truth is known and on data of the model itself.

mod channels;
mod left_out;
mod record;
mod right;
mod seeds;
mod variants;

use rijke_engine::run::Asked;
use variants::{QUARTER_WAVE, Variant};

/// Whether a term is one of these effects within 5 cm of a place.
fn is(asked: &Asked, effects: &[&str], x: f64) -> bool {
    effects.iter().any(|e| asked.effect.starts_with(e))
        && asked.x.is_some_and(|found| (found - x).abs() <= 0.05)
}

#[test]
fn lab_a_gauze_that_the_model_lacks_is_asked_for_at_its_place() {
    let with = "with = { heat-release = \"heat.king-lighthill\" }\nwithout = [\"gauze\"]\n";
    let heat = Variant::new("without-gauze", &QUARTER_WAVE).stage(with).run().pop().unwrap();
    let missing = heat.missing.unwrap();
    let first = &missing.families[0];
    assert_eq!(
        (first.first.place.as_str(), first.first.effect.as_str()),
        ("gauze", "resistance"),
        "{first:?}"
    );
    assert!(first.first.gain > 50.0 && first.first.probability < 2e-3 && first.first.strength[0] > 0.0);
    assert!(missing.by_chance > 1.0 && missing.by_chance < 8.0 && missing.tried > 300);
}

/// The slow route: the same terms as candidates that compete, trained in the model's own nonlinear way.
#[test]
fn oracle_terms_gain_what_trainings_with_them_gain() {
    let with = "with = { heat-release = \"heat.king-lighthill\" }\n";
    let found = Variant::new("oracle", &QUARTER_WAVE).stage(with).run().pop().unwrap().missing.unwrap();
    let chosen: Vec<&Asked> =
        found.best.iter().filter(|a| variants::has_formula(a)).step_by(12).take(6).collect();
    let refits = Variant::new("oracle-refits", &QUARTER_WAVE).refits(with, &chosen);
    for (asked, gain) in chosen.iter().zip(&refits) {
        assert!((asked.gain - gain).abs() < 0.15 + 0.1 * gain.abs(), "{asked:?}: {gain}");
    }
    assert!(chosen.len() == 6 && refits.len() == 6);
}
