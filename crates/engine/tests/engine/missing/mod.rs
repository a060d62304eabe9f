//! What the data still ask for, on examples whose truth is known and on data of the model itself.

mod channels;
mod left_out;
mod record;
mod right;
mod seeds;
mod variants;

use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rijke_engine::run::{Asked, Run, Trusted};
use rijke_study::Study;
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
    // The model without the gauze moves what the stages before it found.
    let before = heat.moved_since.unwrap();
    assert!(before.contains(": delta = 0.03") && before.ends_with(" (gauze)"), "{before}");
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

/// A frequency that is one per cent too high: whatever moves it explains it as well as all else does.
#[test]
fn exact_one_number_cannot_tell_effects_apart() {
    let folder = Folder::new(
        "missing-one",
        &[
            ("rig.toml", TUBE),
            ("campaign.csv", "point,x [cm],T_amb [degC]\na,100,20\n"),
            (
                "study.toml",
                "name = \"t\"\n[[stage]]\nid = \"s\"\npoints = {}\n[stage.noise]\ngrowth_rate = 0.0\nangular_frequency = 0.0\n",
            ),
            ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
            (
                "observations/modes.csv",
                &format!("point,frequency [Hz],frequency_sd [Hz]\na,{},0.05\n", 1.01 * 0.5 * speed()),
            ),
        ],
    );
    let study = Study::open(&folder.0).unwrap();
    let observations = study.observations().unwrap();
    let stage = Run::new(study, &observations, Trusted::Laplace).unwrap().next_stage().unwrap().unwrap();
    let missing = stage.missing.unwrap();
    let family = &missing.families[0];
    let first = format!("{} at {}", family.first.effect, family.first.place);
    for end in ["upstream", "downstream"] {
        let law = format!("reflection, in proportion to s at {end} end");
        assert!(first == law || family.like.contains(&law), "{first}: {:?}", family.like);
    }
    // But for those in the middle and real reflections, which move it by next to nothing.
    assert!(family.like.len() + 10 > missing.tried, "{} of {}", family.like.len(), missing.tried);
}
