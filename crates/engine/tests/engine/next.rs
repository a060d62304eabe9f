//! What further measurements would tell, on a tube whose modes have a closed form.

use crate::common::folder::Folder;
use crate::common::tube::{TUBE, speed};
use rand_distr::{Distribution, StandardNormal};
use rijke_engine::EngineError;
use rijke_engine::run::{Aim, Next, Run, Trusted, Wish, forecast, next, with_points};
use rijke_numerics::Streams;
use rijke_study::Study;
use std::collections::BTreeMap;

const PLAN: &str = "name = \"t\"\n[cost]\npoint = \"30 min\"\ninstallation = \"1 h\"\n[[stage]]\nid = \"s\"\npoints = {}\n[stage.noise]\n\
                    growth_rate = 0.0\nangular_frequency = 0.0\n";
/// Standard deviation of a measured growth rate, 1/s.
const SD: f64 = 40.0;

/// Two lengths are measured, a third is not.
fn folder(name: &str) -> Folder {
    let row = |id: &str, length: f64| {
        let c = speed();
        format!("{id},{:.12},{SD},{:.12},0.05\n", c * 0.85_f64.ln() / length, 0.5 * c / length)
    };
    let head = "point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    let modes = format!("{head}{}{}", row("a", 1.0), row("b", 0.8));
    Folder::new(
        &format!("next-{name}"),
        &[
            ("rig.toml", TUBE),
            ("campaign.csv", "point,x [cm],T_amb [degC]\na,100,20\nb,80,20\nc,50,20\n"),
            ("study.toml", PLAN),
            ("observations/observations.toml", "kind = \"virtual\"\nsource = \"closed form\"\n"),
            ("observations/modes.csv", &modes),
        ],
    )
}

fn modes(rows: &[(&str, f64, f64)]) -> String {
    let row = |(id, length, growth): &(&str, f64, f64)| {
        let c = speed();
        format!("{id},{:.12},0.4,{:.12},0.05\n", c * 0.85_f64.ln() / length + growth, 0.5 * c / length)
    };
    let rows: String = rows.iter().map(row).collect();
    format!("point,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n{rows}")
}

/// What is measured after a training, at a point that trained and at a new one, moves model and evidence as a
/// new training does. Errors of 0.4 1/s know r to 1e-3, over which the closed form bends by as much.
#[test]
fn exact_what_is_measured_after_a_training_moves_the_model_as_a_new_one() {
    let folder = folder("sequence");
    let write = |rows: &[(&str, f64, f64)]| {
        std::fs::write(folder.0.join("observations/modes.csv"), modes(rows)).unwrap();
    };
    write(&[("a", 1.0, 0.0), ("b", 0.8, 0.3)]);
    let before = ranked(&folder);
    let sequence = before.run.sequences(5).remove(0);
    write(&[("a", 1.0, 0.5), ("b", 0.8, 0.3), ("c", 0.5, -0.6)]);
    let after = ranked(&folder);
    let leads = sequence.with(&before.study, &before.study.observations().unwrap()).unwrap();
    assert_eq!(leads.new, ["c"]);
    let found = &leads.models[0];
    let [r, sd] = [found.parameters[0].value, found.parameters[0].sd];
    assert!((r - before.r[0]).abs() > 0.1 * sd, "nothing moved");
    assert!((r - after.r[0]).abs() < 1e-3 * sd, "{r} {}", after.r[0]);
    assert!((sd / after.r[1] - 1.0).abs() < 2e-3, "{sd} {}", after.r[1]);
    let (ln, then) = (after.ln_evidence, before.ln_evidence);
    assert!((found.ln_evidence - ln).abs() < 1e-3 && (ln - then).abs() > 1.0, "{} {ln}", found.ln_evidence);
}

struct Ranked {
    study: Study,
    run: Run,
    r: [f64; 2],
    ln_evidence: f64,
}

fn ranked(folder: &Folder) -> Ranked {
    let study = Study::open(&folder.0).unwrap();
    let mut run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    let stage = run.next_stage().unwrap().unwrap();
    let r = &stage.models[0].parameters[0];
    let r = [r.value, r.sd];
    let ln_evidence = stage.models[0].ln_evidence();
    Ranked { study, run, r, ln_evidence }
}

impl Ranked {
    fn ask(&self, study: &Study, wish: &Wish) -> Result<Next, EngineError> {
        let saved = self.run.saved("s")?;
        next(study, &study.observations()?, &saved, &self.run.rivals("s")?, wish)
    }
}

/// Nested Monte Carlo with the closed form: no derivative, no Gaussian predictive.
fn sampled(length: f64, [mean, sd]: [f64; 2], error: f64) -> f64 {
    let (outer, inner) = (6000, 3000);
    let mut stream = Streams::new(5).stream("next/closed form");
    let growth = |r: f64| speed() * r.ln() / length;
    let mut draw = || -> f64 { StandardNormal.sample(&mut stream) };
    let cloud: Vec<f64> = (0..inner).map(|_| growth(mean + sd * draw())).collect();
    let mut sum = 0.0;
    for _ in 0..outer {
        let (theta, noise) = (growth(mean + sd * draw()), draw());
        let y = theta + error * noise;
        let density = cloud.iter().map(|m| (-0.5 * ((y - m) / error).powi(2)).exp()).sum::<f64>();
        sum += -0.5 * noise * noise - (density / f64::from(inner)).ln();
    }
    sum / f64::from(outer)
}

#[test]
fn oracle_information_against_nested_monte_carlo() {
    let folder = folder("oracle");
    let ranked = ranked(&folder);
    let wish = Wish { candidates: vec![0, 1, 2], points: 2, ..Wish::default() };
    let found = ranked.ask(&ranked.study, &wish).unwrap();
    for s in &found.points {
        let length = s.factors[0].unwrap();
        let oracle = sampled(length, ranked.r, SD);
        assert!((s.parameters / oracle - 1.0).abs() < 0.1, "{} m: {} {oracle}", length, s.parameters);
        assert_eq!((s.repeat, s.models, s.quantity), (length > 0.6, None, None));
        assert_eq!(s.hours, Some(1.5));
    }
    assert_eq!(found.points[0].point, "c", "a short tube loses most at its ends");
    // One installation is mounted once, and its points cost half an hour each.
    assert_eq!(found.plan.iter().map(|s| s.hours.unwrap()).collect::<Vec<_>>(), [1.5, 0.5]);
    let sum: f64 = found.plan.iter().map(|s| s.adds).sum();
    assert!((sum - found.total[0]).abs() < 1e-12 && found.total[0] >= found.total[1]);
    assert!(found.further.unwrap().1 < found.plan[1].adds);
}

/// A visit counts all modes, in whatever order they are written. Both modes of the tube lose as much, so that
/// two are one with errors smaller by the root of two.
#[test]
fn oracle_a_visit_counts_all_modes_that_were_measured() {
    let folder = folder("two-modes");
    let rows = |id: &str, length: f64| -> [String; 2] {
        [1, 2].map(|n| {
            let (growth, hertz) = (speed() * 0.85_f64.ln() / length, f64::from(n) * 0.5 * speed() / length);
            format!("{id},{n},{growth:.12},{SD},{hertz:.12},0.05\n")
        })
    };
    let told = |order: [usize; 2]| {
        let head = "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
        let rows = [rows("a", 1.0), rows("b", 0.8)].map(|both| order.map(|k| both[k].clone()).concat());
        std::fs::write(folder.0.join("observations/modes.csv"), [head, &rows[0], &rows[1]].concat()).unwrap();
        let ranked = ranked(&folder);
        let wish = Wish { candidates: vec![0, 1, 2], points: 1, ..Wish::default() };
        (ranked.ask(&ranked.study, &wish).unwrap(), ranked.r)
    };
    let ((found, r), (other, _)) = (told([0, 1]), told([1, 0]));
    for (s, t) in found.points.iter().zip(&other.points) {
        let oracle = sampled(s.factors[0].unwrap(), r, SD / 2.0_f64.sqrt());
        assert!((s.parameters / oracle - 1.0).abs() < 0.1, "{}: {} {oracle}", s.point, s.parameters);
        assert!(s.point == t.point && (s.parameters / t.parameters - 1.0).abs() < 1e-6);
    }
}

/// The sd before is that of a prediction; the sd after is that of the posterior with one more datum, which
/// has a closed form.
#[test]
fn exact_a_quantity_is_known_as_well_as_its_prediction_and_then_better() {
    let folder = folder("quantity");
    let ranked = ranked(&folder);
    let asked = [BTreeMap::from([("x".to_owned(), 0.9)])];
    let (study, places) = with_points(&ranked.study, &ranked.study.plan.stages[0].points, &asked).unwrap();
    let wish = Wish {
        aim: Aim::Quantity,
        candidates: vec![2],
        about: Some(places[0]),
        points: 1,
        without_pressures: false,
    };
    let [before, after] = ranked.ask(&study, &wish).unwrap().quantity_sd.unwrap();
    let saved = ranked.run.saved("s").unwrap();
    let predicted = &forecast(&study, &study.observations().unwrap(), &saved, &[], &places).unwrap().0[0];
    assert!((before / predicted.growth_rate[2] - 1.0).abs() < 1e-9);
    let [r, sd] = ranked.r;
    let slope = |length: f64| speed() / (r * length);
    let left = (sd.powi(-2) + (slope(0.5) / SD).powi(2)).powf(-0.5);
    assert!((after / (slope(0.9) * left) - 1.0).abs() < 1e-6, "{after}");
}

/// A reading of the temperature belongs to its point. What a visit tells of it is no knowledge of another
/// day: after the visit, the prediction of that very point has the standard deviation that was foreseen.
#[test]
fn exact_a_visit_foresees_the_prediction_of_its_own_point() {
    let folder = folder("own-point");
    let campaign = "point,x [cm],T_amb [degC],T_amb_sd [K]\na,100,20,3\nb,80,20,3\nc,50,20,3\n";
    std::fs::write(folder.0.join("campaign.csv"), campaign).unwrap();
    let write = |rows: &[(&str, f64, f64)]| {
        std::fs::write(folder.0.join("observations/modes.csv"), modes(rows)).unwrap();
    };
    write(&[("a", 1.0, 0.0), ("b", 0.8, 0.0)]);
    let before = ranked(&folder);
    let wish =
        Wish { aim: Aim::Quantity, candidates: vec![2], about: Some(2), points: 1, without_pressures: false };
    let foreseen = before.ask(&before.study, &wish).unwrap().quantity_sd.unwrap()[1];
    write(&[("a", 1.0, 0.0), ("b", 0.8, 0.0), ("c", 0.5, 0.0)]);
    let after = ranked(&folder);
    let saved = after.run.saved("s").unwrap();
    let said = forecast(&after.study, &after.study.observations().unwrap(), &saved, &[], &[2]).unwrap();
    let stated = said.0[0].growth_rate[2];
    assert!((foreseen / stated - 1.0).abs() < 0.02, "{foreseen} {stated}");
    assert!(stated > 0.5, "the temperature is uncertain");
}

#[test]
fn message_what_cannot_be_asked() {
    let folder = folder("message");
    let ranked = ranked(&folder);
    let wish = Wish { aim: Aim::Models, candidates: vec![0], points: 1, ..Wish::default() };
    let said = ranked.ask(&ranked.study, &wish).unwrap_err().to_string();
    assert!(said.contains("only one model of it could be fitted"), "{said}");
    let nothing = Wish { aim: Aim::Parameters, candidates: Vec::new(), ..wish };
    assert!(ranked.ask(&ranked.study, &nothing).unwrap_err().to_string().contains("no point is given"));
}
