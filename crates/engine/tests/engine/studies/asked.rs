//! Conditions that were not measured: what is known of their surroundings, and what stands beside them.

use super::{PLAN, closed_form, two_points};
use crate::common::folder::Folder;
use rijke_engine::SavedModel;
use rijke_engine::run::{AskedPoint, Forecast, Run, Trusted, forecast, modes_at, over_map, with_points};
use rijke_study::plan::{MapGrid, Selection};
use rijke_study::{ObservedModes, Study};

fn asked(values: &[(&str, f64)], day: Option<&str>) -> AskedPoint {
    let values = values.iter().map(|(name, v)| ((*name).to_owned(), *v)).collect();
    AskedPoint::new(values, day.map(str::to_owned))
}

/// Two points of one day whose thermometer is said to err by 4 K and showed 5 K too little.
fn cold_day(name: &str) -> Folder {
    let campaign = "point,x [cm],day,T_amb [K],T_amb_sd [K]\na,100,one,288.15,4\nb,80,one,288.15,4\n";
    // The errors of base states that installations share are inferred.
    let plan = PLAN.replace("points = {}\n", "points = {}\nbase_errors = true\n");
    two_points(name, &[("campaign.csv", campaign), ("study.toml", &plan)])
}

struct Trained {
    study: Study,
    observations: ObservedModes,
    model: SavedModel,
}

impl Trained {
    fn of(folder: &Folder) -> Self {
        let study = Study::open(&folder.0).unwrap();
        let observations = study.observations().unwrap();
        let mut run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
        run.next_stage().unwrap();
        let model = run.saved("s").unwrap();
        Self { study, observations, model }
    }

    fn ask(&self, asked: &[AskedPoint]) -> Vec<Forecast> {
        let (wider, places) = with_points(&self.study, &Selection::default(), asked).unwrap();
        let (found, lost) = forecast(&wider, &self.observations, &self.model, &[], &places).unwrap();
        assert!(lost.is_empty(), "{lost:?}");
        found
    }
}

/// What sound told of one day's thermometer is not said of another temperature, whose error is the one that
/// is stated; of that day it is.
#[test]
fn exact_another_temperature_has_an_error_of_its_own() {
    let trained = Trained::of(&cold_day("another-temperature"));
    let omega = |t: f64| std::f64::consts::PI * (1.4_f64 * 287.05 * t).sqrt() / 0.9;
    let of = |values: &[(&str, f64)], day| trained.ask(&[asked(values, day)]).remove(0).angular_frequency;
    let [value, _, sd] = of(&[("x", 0.9), ("T_amb", 310.0), ("T_amb_sd", 2.0)], None);
    let expected = omega(310.0) * 0.5 * 2.0 / 310.0;
    assert!((value / omega(310.0) - 1.0).abs() < 1e-6, "{value} {}", omega(310.0));
    assert!((sd / expected - 1.0).abs() < 1e-2, "{sd} {expected}");
    // Without a word it is the campaign's.
    let [value, _, wide] = of(&[("x", 0.9), ("T_amb", 310.0)], None);
    assert!((value / omega(310.0) - 1.0).abs() < 1e-6 && (wide / sd - 2.0).abs() < 1e-2, "{wide} {sd}");
    // Of the day whose thermometer sound has judged: 4 K of 4.
    let [value, _, sure] = of(&[("x", 0.9), ("T_amb", 305.0)], Some("one"));
    assert!(
        (value / omega(310.0) - 1.0).abs() < 1e-3 && sure < 0.1 * wide,
        "{value} {} {sure}",
        omega(310.0)
    );
    let [value, _, _] = of(&[("x", 0.9)], Some("one"));
    assert!((value / omega(293.15) - 1.0).abs() < 1e-3, "{value}");
    let [value, _, open] = of(&[("x", 0.9)], None);
    assert!((value / omega(288.15) - 1.0).abs() < 1e-6 && open > 10.0 * sure, "{value} {open}");
}

#[test]
fn message_of_a_day_or_a_deviation_that_cannot_be() {
    let study = Study::open(&cold_day("another-day").0).unwrap();
    let refused =
        |asked: AskedPoint| with_points(&study, &Selection::default(), &[asked]).unwrap_err().to_string();
    let said = refused(asked(&[("x", 0.9)], Some("two")));
    assert!(said.contains("the campaign has no day `two` (one)"), "{said}");
    let said = refused(asked(&[("x", 0.9), ("T_amb_sd", -1.0)], None));
    assert!(said.contains("T_amb_sd = -1: a standard deviation lies from 0 to 50 K"), "{said}");
    let said = refused(asked(&[("x", 0.9), ("x_sd", -1e-9)], None));
    assert!(said.contains("x_sd = -0.000000001: a standard deviation is zero or more"), "{said}");
    let exact = asked(&[("x", 0.9), ("x_sd", 0.0)], None);
    assert!(with_points(&study, &Selection::default(), &[exact]).is_ok());
}

/// The modes of a point are those that are predicted of it: of gas with the inferred error.
#[test]
fn exact_modes_at_a_point_are_those_that_are_predicted() {
    let trained = Trained::of(&cold_day("modes-as-predicted"));
    let (wider, places) =
        with_points(&trained.study, &Selection::default(), &[asked(&[("x", 1.0)], None)]).unwrap();
    assert_eq!(places, [0]);
    let found = forecast(&wider, &trained.observations, &trained.model, &[], &places).unwrap().0;
    let (_, spectrum, _, [stated, counts]) =
        modes_at(&trained.study, Some(&trained.observations), Some(&trained.model), 0, [None, Some(250.0)])
            .unwrap();
    let s = spectrum.modes.modes[0].s;
    assert!((stated - 288.15).abs() < 1e-9 && (counts - 293.15).abs() < 0.1, "{stated} {counts}");
    let [sigma, hertz] = closed_form(1.0);
    assert!((s.im / std::f64::consts::TAU - hertz).abs() < 0.05 && (s.re - sigma).abs() < 0.2, "{s}");
    // The prediction is linear in the error.
    assert!(
        (s.im / found[0].angular_frequency[0] - 1.0).abs() < 1e-4,
        "{s} {:?}",
        found[0].angular_frequency
    );
}

/// Two families of modes whose labels say which is which at two lengths; between them the nearest point
/// tells, whatever else is asked.
#[test]
fn exact_the_answer_for_a_point_is_the_same_in_any_company() {
    let campaign = "point,x [cm],y,T_amb [degC]\na,100,1,20\nb,80,2,20\n";
    let row = |id: &str, mode: &str, length: f64, number: f64| {
        let [sigma, hertz] = closed_form(length);
        format!("{id},{mode},{sigma:.9},0.1,{:.9},0.05\n", number * hertz)
    };
    let head = "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n";
    // At `b` the labels go the other way round.
    let rows =
        [row("a", "p", 1.0, 1.0), row("a", "q", 1.0, 2.0), row("b", "q", 0.8, 1.0), row("b", "p", 0.8, 2.0)];
    let modes = format!("{head}{}", rows.concat());
    let files = [("campaign.csv", campaign), ("observations/modes.csv", modes.as_str())];
    let trained = Trained::of(&two_points("company", &files));
    // Nearer to `a` in x, nearer to `b` in y; far points would change what near means.
    let point = || asked(&[("x", 0.93), ("y", 1.55)], None);
    let alone = trained.ask(&[point()]);
    for other in [asked(&[("x", 1.0), ("y", 9.0)], None), asked(&[("x", 5.0), ("y", 1.0)], None)] {
        let both = trained.ask(&[point(), other]);
        assert_eq!(alone[..], both[..alone.len()], "{both:?}");
    }
    // Asked twice it is answered once.
    assert_eq!(trained.ask(&[point(), point()]), alone);
}

/// What is not on an axis is the same at all nodes, also of a factor that some points do not have.
#[test]
fn exact_nodes_of_a_map_differ_in_its_factors_alone() {
    let campaign = "point,x [cm],y,z,day,T_amb [K],T_amb_sd [K]\na,100,1,3,one,290,1\nb,80,2,,two,295,2\nc,60,3,7,two,300,3\n";
    let study = Study::open(&two_points("map-company", &[("campaign.csv", campaign)]).0).unwrap();
    let grid = MapGrid::new(&study.campaign, [0, 1], [None, None]).unwrap();
    let every = Selection::default();
    let others = |at: &AskedPoint| {
        let nodes = over_map(&study, &every, &grid, at).unwrap();
        let (wider, places) = with_points(&study, &every, &nodes).unwrap();
        assert_eq!(places.len(), 225);
        let of = |k: &usize| {
            let p = &wider.campaign.points[*k];
            (p.factors[2].to_string(), p.ambient.unwrap(), p.day.clone())
        };
        let all: Vec<_> = places.iter().map(of).collect();
        assert!(all.iter().all(|one| *one == all[0]), "{all:?}");
        all[0].clone()
    };
    assert_eq!(others(&AskedPoint::default()), ("NaN".to_owned(), [295.0, 2.0], String::new()));
    let held = others(&asked(&[("z", 6.5), ("T_amb", 310.0)], None));
    assert_eq!(held, ("6.5".to_owned(), [310.0, 3.0], String::new()));
    // Of points beside the middle of the map, 0.8 m and 2, the nearest gives what is not on an axis.
    let beside = "point,x [cm],y,z,T_amb [K]\na,100,1,1,290\nb,60,3,2,290\nc,78,2,3,290\nd,86,2,4,290\n";
    let modes = "point,frequency [Hz],frequency_sd [Hz]\na,171.6,0.05\n";
    let files = [("campaign.csv", beside), ("observations/modes.csv", modes)];
    let near = Study::open(&two_points("map-middle", &files).0).unwrap();
    let nodes = MapGrid::new(&near.campaign, [0, 1], [None, None]).unwrap();
    let nodes = over_map(&near, &every, &nodes, &AskedPoint::default()).unwrap();
    let (wider, places) = with_points(&near, &every, &nodes[..1]).unwrap();
    assert_eq!(wider.campaign.points[places[0]].factors[2], 3.0);
    let refused = over_map(&study, &every, &grid, &asked(&[("x", 0.7)], None)).unwrap_err().to_string();
    assert!(refused.contains("`x` is on an axis of the map"), "{refused}");
}
