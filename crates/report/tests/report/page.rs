//! The page of a study, from records made by hand.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::figures::answer;
use rijke_engine::run::{
    Asked, CarriedOn, CarriedStage, Checks, EvidenceRecord, Family, Judgement, LayerLook, MeasuredRecord,
    Missing, ModelRecord, PointCheck, StageRecord, SumCheck, TrainedParameter,
};
use rijke_report::{StudyHead, StudyPage};
use rijke_rig::DataKind;
use rijke_study::{Claims, Factor};

fn model(id: &str, ln_marginal: f64) -> ModelRecord {
    ModelRecord {
        id: id.into(),
        label: format!("law <{id}>"),
        candidates: std::iter::once(("role".to_owned(), id.to_owned())).collect(),
        laws: vec![("eu at gauze".into(), "-k*exp(-s*tau)".into())],
        parameters: vec![TrainedParameter {
            name: "k".into(),
            symbol: "k".into(),
            unit: "1".into(),
            value: 1.01093,
            sd: 0.0018,
            interval: None,
            prior_sds: Some(5.2),
            narrowed: Some(0.2),
            averaged: Some([1.0234, 0.0061]),
            tied: Some(("tau".into(), -0.953)),
        }],
        misfit: [0.1, 0.2, 0.0],
        evidence: Some(EvidenceRecord {
            ln_best_fit: ln_marginal + 3.0,
            ln_occam: -3.0,
            ln_marginal,
            observations: 2,
        }),
        predicted: vec![[-5.0, 600.0], [-6.0, 610.0]],
        fitted: Vec::new(),
        remark: None,
    }
}

fn stage() -> StageRecord {
    let measured = |k: usize| MeasuredRecord {
        point: format!("p{k}"),
        mode: String::new(),
        factors: vec![Some(0.1 * k as f64)],
        growth_rate: Some([-5.0 - k as f64, 0.1]),
        angular_frequency: Some([600.0 + 10.0 * k as f64, 0.5]),
    };
    StageRecord {
        id: "heat".into(),
        title: "Heat release".into(),
        measured: vec![measured(0), measured(1)],
        models: vec![model("a", -3.0), model("b", -20.0)],
        winner: "a".into(),
        chosen: "a".into(),
        decides: 3.0,
        assumes: vec!["Cold tube: x is taken, though y is only 0.4 nats behind".into()],
        one_start: false,
        missed: Some("frequencies are missed by 1.7 %".into()),
        undescribed: vec!["this stage stands on \"ftf\"".into()],
        carried: vec![carried("a", Some(-30.0)), carried("b", Some(-31.25)), carried("c", None)],
        missing: Some(missing()),
        moved_since: Some("what is missing may have moved eta".into()),
        lengths: None,
        checks: Some(Checks {
            rival: Some("b".into()),
            points: vec![check("p0", false), check("p1", true)],
            residuals: vec![[Some(0.25), Some(-1.5)], [Some(0.5), None]],
            sums: vec![SumCheck {
                what: "growth rates".into(),
                count: 2,
                chi_squared: 3.25,
                probability: Some(0.197),
                law: None,
                of_noise: None,
            }],
        }),
    }
}

fn carried(id: &str, ln_evidence: Option<f64>) -> CarriedOn {
    let later = CarriedStage { stage: "hot".into(), model: "hot.law".into(), parameters: Vec::new() };
    CarriedOn { id: id.into(), ln_evidence, later: vec![later] }
}

fn check(point: &str, doubtful: bool) -> PointCheck {
    PointCheck {
        point: point.into(),
        ln_left_out: Some(-2.5),
        ahead: Some(1.25),
        shift: if doubtful { 1.5 } else { 0.5 },
        doubtful,
    }
}

fn missing() -> Missing {
    let first = Asked {
        effect: "leak".into(),
        place: "x = 0.300 m".into(),
        x: Some(0.3),
        times: "Q/(50 W)".into(),
        strength: [0.0021, 0.0004],
        unit: "1".into(),
        prior_sd: 0.004,
        gain: 12.34,
        probability: 0.001,
        moves: [0.4, 0.02],
    };
    let like = vec!["compliance at x = 0.250 m".to_owned()];
    let family = Family {
        first: first.clone(),
        also: Vec::new(),
        beyond: (11.5, 0.001),
        like,
        between: Some([0.25, 0.35]),
    };
    let other = Asked { x: Some(0.5), gain: -0.5, ..first.clone() };
    Missing { tried: 700, by_chance: 3.4, families: vec![family], best: vec![first, other], laws: Vec::new() }
}

/// A factor that its campaign has in mm.
fn millimetres() -> Factor {
    let shown = rijke_rig::Unit::parse("mm").unwrap();
    Factor { name: "x".into(), unit: "m".into(), shown, stated: true }
}

fn page(kind: DataKind, verdicts: &[Judgement]) -> (String, std::path::PathBuf) {
    let head = StudyHead {
        beside: None,
        found_beside: vec!["Flame: <b>a delay</b>, 5.0 nats ahead of none.".into()],
        name: "A rig".into(),
        question: "Which law?".into(),
        kind,
        source: "a test".into(),
        factors: vec![millimetres()],
        claims: Claims { source: "Somebody 2022".into(), ..Claims::default() },
    };
    let folder = std::env::temp_dir().join(format!("rijke-page-{kind:?}-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    StudyPage::new(&head, &[stage()], &[answer(LayerLook::Dots)], verdicts, None)
        .unwrap()
        .write(&folder)
        .unwrap();
    (std::fs::read_to_string(folder.join("index.html")).unwrap(), folder)
}

#[test]
fn behaviour_the_page_says_what_was_found_and_whose_data_it_is() {
    let (text, folder) = page(DataKind::Measured, &[]);
    for part in [
        "Measured data. Source: a test.",
        // What was found on the page of responses stands before what is found here.
        "<p class=\"answer\">Flame: <b>a delay</b>, 5.0 nats ahead of none.</p>\n<p class=\"answer\">Heat release",
        // By itself the stage is 17 nats ahead; later stages take that back.
        "Heat release: not decided between <b>law &lt;a&gt;</b> and law &lt;b&gt;, which is 1.2 nats behind by this and later stages: odds of 3.5 to 1.",
        "1.0109(18)",
        "1.0234(61)",
        "averaged over the models that earlier stages leave open",
        "<td class=n>1.2<td><code>hot.law</code>",
        "cannot be fitted",
        "lies 5.2 standard deviations of its prior",
        "<h2 id=\"question\">What &amp; how</h2>",
        // One model of two, by 17 nats.
        "<td class=n>1.000<",
        "growth rates 3.2 of 2 (p = 0.197)",
        "Together the points are +2.5 nats ahead",
        "<td>p1*<",
        "leak at x = 0.300 m, times Q/(50 W)<br><small>between 0.250 m and 0.350 m</small>",
        "It is no cause",
        "assume a complete model; what is missing may have moved eta.",
        "<title>p1: ",
        // Of the point under the pointer.
        "[-6.0,0.1,-6.0,0.5]",
    ] {
        assert!(text.contains(part), "no `{part}` in\n{text}");
    }
    assert!(!text.to_lowercase().contains("virtual"), "nothing of a laboratory on measured data");
    assert!(!text.contains("statements of"), "no verdict from nothing");
    let table = std::fs::read_to_string(folder.join("tables/question.csv")).unwrap();
    assert!(
        table.starts_with("name,series,x [1],y [1],y_sd [1]\np0,Q = 7 W,0,0,0.1\np1,Q = 7 W,1,2,\n"),
        "{table}"
    );
    assert!(folder.join("figures/question.svg").is_file() && folder.join("tables/heat.csv").is_file());
    let points = std::fs::read_to_string(folder.join("tables/heat-points.csv")).unwrap();
    assert!(points.contains("p1,doubtful,-2.5,1.25,1.5"), "{points}");
    assert!(
        folder.join("figures/heat-missing.svg").is_file()
            && folder.join("tables/heat-residuals.csv").is_file()
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn message_a_page_that_cannot_solve_its_model_says_why() {
    let head = StudyHead {
        beside: None,
        found_beside: Vec::new(),
        name: "t".into(),
        question: "q".into(),
        kind: DataKind::Virtual,
        source: "a test".into(),
        factors: vec![millimetres()],
        claims: Claims::default(),
    };
    let folder = std::env::temp_dir().join(format!("rijke-page-no-sliders-{}", std::process::id()));
    let why = ("heat".to_owned(), Err("its waves are those of a mean flow".to_owned()));
    StudyPage::new(&head, &[stage()], &[], &[], Some(&why)).unwrap().write(&folder).unwrap();
    let text = std::fs::read_to_string(folder.join("index.html")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(text.contains("no sliders for Heat release: its waves are those of a mean flow."), "{text}");
    assert!(!text.contains("id=\"model\"") && !text.contains("#sliders"), "{text}");
}

#[test]
fn behaviour_statements_stand_beside_their_numbers() {
    let verdict = |holds: bool| Judgement {
        of: "heat".into(),
        statement: "a beats b".into(),
        holds,
        figure: "a = 1".into(),
        explanation: (!holds).then(|| "because".into()),
    };
    let (text, folder) = page(DataKind::Virtual, &[verdict(true), verdict(false)]);
    assert!(text.contains("1 of 2 statements of Somebody 2022 hold here"), "{text}");
    assert!(text.contains("<b>does not hold:</b> a beats b <small>a = 1</small><br>because"), "{text}");
    std::fs::remove_dir_all(folder).unwrap();
}
