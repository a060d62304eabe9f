//! The derivatives at strength zero against those of models that have the effects.

use super::library::{self, Library};
use crate::observed::Used;
use crate::point::given;
use crate::predictor::Predictor;
use crate::run::{Run, Trusted};
use crate::{Assembly, Observed, PointModel};
use rijke_inference::Forward;
use rijke_network::Workspace;
use rijke_numerics::{C64, Order};
use rijke_study::Study;
use rijke_study::names::{AREA, DENSITY, DIAMETER, GAMMA, PERIMETER, PRANDTL, SOUND_SPEED, VISCOSITY};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

/// The derivatives of a model that has the effect, at strength zero, against those that the model without it
/// foresees.
#[test]
fn exact_effects_that_a_model_lacks_move_it_as_if_it_had_them() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/quarter-wave");
    let study = Study::open(&folder).unwrap();
    let observations = study.observations().unwrap();
    let run = Run::new(study.clone(), &observations, Trusted::Laplace).unwrap();
    let observed = run.observed.iter().find(|o| o.conditions.point.row == "hot").unwrap();
    let model = |ids: &[&str]| {
        let candidates = ids.iter().map(|id| study.catalogue.get(id).unwrap().clone()).collect();
        Assembly::new(Arc::new(study.rig.clone()), candidates, &BTreeMap::new()).unwrap()
    };
    let microphones = [0, 1, 2];
    let x = observed.conditions.layout.parts.iter().find_map(|p| match p {
        rijke_study::PartAt::Places(list) => Some(list[0]),
        _ => None,
    });
    let x = x.unwrap();
    let values = |assembly: &Assembly, given: &[(&str, f64)]| -> Vec<f64> {
        let of = |name: &str| given.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
        assembly.parameters().iter().map(|p| of(&p.name).unwrap_or_else(|| p.prior.quantile(0.5))).collect()
    };
    let bare = model(&["wall.kirchhoff", "inlet.rigid", "mouth.thick"]);
    let point = PointModel::with_cuts(&bare, &observed.conditions, &microphones, &[x]).unwrap();
    let point = point.starting_from(observed.near);
    let found = point.probe(&values(&bare, &[]), &observed.conditions, &mut Workspace::default()).unwrap();
    // The slope in a parameter of a model with more.
    let slope = |ids: &[&str], name: &str, given: &[(&str, f64)], observed: &Observed| -> Vec<C64> {
        let assembly = model(ids);
        let model = PointModel::with_cuts(&assembly, &observed.conditions, &microphones, &[x]).unwrap();
        let model = model.starting_from(observed.near);
        let response =
            model.respond(&values(&assembly, given), Order::First, &mut Workspace::default()).unwrap();
        let k = assembly.parameters().iter().position(|p| p.name == name).unwrap();
        model.numbers(&response).map(|z| z.gradient()[k]).collect()
    };
    let near = |tolerance: f64, found: &[C64], scale: C64, expected: &[C64]| {
        assert_eq!(found.len(), 3);
        for (a, b) in found.iter().zip(expected) {
            assert!((a * scale - b).norm() < tolerance * b.norm(), "{} {b}", a * scale);
        }
    };
    let same = |found: &[C64], scale: C64, expected: &[C64]| near(1e-9, found, scale, expected);
    let around = observed.conditions.around(x);
    let [bore, area, perimeter] = [DIAMETER, AREA, PERIMETER].map(|k| around[k]);
    assert!((area - 0.25 * PI * bore * bore).abs() < 1e-12 && (perimeter - PI * bore).abs() < 1e-12);
    let cold = ["wall.kirchhoff", "inlet.rigid", "mouth.thick", "gauze.resistance"];
    let drag = slope(&cold, "drag", &[("drag", 0.0)], observed);
    let [mu, _, eu, _] = &found.places[0];
    same(mu.as_ref().unwrap(), C64::from(around[DENSITY] * around[SOUND_SPEED]), &drag);
    let hot = ["wall.kirchhoff", "inlet.rigid", "mouth.thick", "heat.constant"];
    let heat = slope(&hot, "k1", &[("k1", 0.0), ("k2", 0.0)], observed);
    let q = study.campaign.factor("Q").unwrap();
    same(eu.as_ref().unwrap(), C64::from(-observed.conditions.point.factors[q]), &heat);
    let blown = slope(&["wall.kirchhoff", "inlet.loss", "mouth.thick"], "y", &[("y", 0.0)], observed);
    same(found.ends[0].as_ref().unwrap(), C64::from(-2.0), &blown);
    // The wall's two laws are in proportion to eta.
    let walls: Vec<C64> =
        (0..3).map(|i| found.laws.iter().filter(|l| l.0[0] == 0).map(|l| l.1[i]).sum()).collect();
    let eta = slope(&["wall.kirchhoff", "inlet.rigid", "mouth.thick"], "eta", &[], observed);
    same(&walls, C64::from(1.0 / values(&bare, &[])[0]), &eta);
    // The boundary layers of the library are those of Kirchhoff's candidate. It takes the mean gas of an
    // element, the library that in the middle of either half: of second order in its length.
    let layers: Vec<C64> = found.layers.as_ref().unwrap().iter().map(|z| z * found.s.sqrt()).collect();
    near(3e-4, &layers, C64::ONE, &eta);
}

/// Losses per metre of viscosity and of conduction, in rho c and 1/(rho c), move a mode as Kirchhoff's two
/// laws do, divided by what these are there: in gas that is the same everywhere.
#[test]
fn exact_losses_per_metre_move_a_mode_as_those_of_a_wall() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/quarter-wave");
    let study = Study::open(&folder).unwrap();
    let run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    let observed = run.observed.iter().find(|o| o.conditions.base.is_uniform()).unwrap();
    let ids = ["wall.kirchhoff", "inlet.rigid", "mouth.thick"];
    let candidates = ids.iter().map(|id| study.catalogue.get(id).unwrap().clone()).collect();
    let assembly = Assembly::new(Arc::new(study.rig.clone()), candidates, &BTreeMap::new()).unwrap();
    let values: Vec<f64> = assembly.parameters().iter().map(|p| p.prior.quantile(0.5)).collect();
    let eta = values[assembly.parameters().iter().position(|p| p.name == "eta").unwrap()];
    let point = PointModel::with_cuts(&assembly, &observed.conditions, &[0, 1, 2], &[]).unwrap();
    let found = point
        .starting_from(observed.near)
        .probe(&values, &observed.conditions, &mut Workspace::default())
        .unwrap();
    let around = observed.conditions.around(0.1);
    let (rho, c) = (around[DENSITY], around[SOUND_SPEED]);
    // Kirchhoff's laws as the candidate writes them.
    let viscous = eta * 4.0 / around[DIAMETER] * (found.s * rho * around[VISCOSITY]).sqrt();
    let thermal = viscous * (around[GAMMA] - 1.0) / (rho * c).powi(2) / around[PRANDTL].sqrt();
    let strengths = [viscous / (rho * c), thermal * rho * c];
    for (k, (loss, strength)) in found.walls.iter().zip(strengths).enumerate() {
        let (_, law) = found.laws.iter().find(|(owner, _)| *owner == [0, k]).unwrap();
        for (moved, expected) in loss.as_ref().unwrap().iter().zip(law) {
            assert!((moved * strength - expected).norm() < 1e-9 * expected.norm(), "{k}: {moved} {expected}");
        }
    }
}

/// A parameter that grows as a factor changes each number by its own derivative, times that factor there:
/// against differences of the model.
#[test]
fn exact_parameters_that_grow_as_a_factor_change_each_point_by_its_own() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/quarter-wave");
    let study = Study::open(&folder).unwrap();
    let run = Run::new(study.clone(), &study.observations().unwrap(), Trusted::Laplace).unwrap();
    let hot = |o: &&Observed| o.conditions.point.row == "hot";
    let observed: Vec<Observed> = run.observed.iter().filter(hot).take(5).cloned().collect();
    let used: Vec<Used> = observed.iter().map(|o| o.used(&[0, 1, 2], 0)).collect();
    let ids = ["wall.kirchhoff", "inlet.rigid", "mouth.thick", "heat.constant"];
    let candidates = ids.iter().map(|id| study.catalogue.get(id).unwrap().clone()).collect();
    let assembly = Assembly::new(Arc::new(study.rig.clone()), candidates, &BTreeMap::new()).unwrap();
    let mut values: Vec<f64> = assembly.parameters().iter().map(|p| p.prior.quantile(0.5)).collect();
    let rows: Vec<(usize, usize)> =
        used.iter().enumerate().flat_map(|(k, u)| (0..u.size()).map(move |row| (k, row))).collect();
    let library = Library::of(&assembly, &study.campaign, &observed, &used, &values, &rows).unwrap();
    let grows = |t: &library::Term| t.effect == "change of k2" && t.times.starts_with("flow/");
    let k = library.terms.iter().position(grows).unwrap();
    assert!((&*library.terms[k].place, &*library.terms[k].unit) == ("gauze", "s"), "{:?}", library.terms[k]);
    let predictor = Predictor::new(&assembly, &observed, &used).unwrap();
    let j = assembly.parameters().iter().position(|p| p.name == "k2").unwrap();
    let (at, step) = (values[j], 1e-3 * values[j]);
    let mut moved = |by: f64| {
        values[j] = at + by;
        predictor.predict(&values, Order::Value).unwrap().values
    };
    let [up, down] = [moved(step), moved(-step)];
    let flow = study.campaign.factor("flow").unwrap();
    let flows: Vec<f64> = observed.iter().map(|o| o.conditions.point.factors[flow]).collect();
    let largest = flows.iter().copied().fold(0.0, f64::max);
    assert!(flows.iter().any(|f| *f < largest));
    let expected: Vec<f64> = rows
        .iter()
        .enumerate()
        .map(|(i, (o, _))| flows[*o] / largest * (up[i] - down[i]) / (2.0 * step))
        .collect();
    let size = expected.iter().map(|e| e.abs()).fold(0.0, f64::max);
    let off = library.directions[k].iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(size > 0.0 && off < 1e-5 * size, "{off} of {size}");
    // The same at all points it is the parameter itself.
    assert!(!library.terms.iter().any(|t| t.effect == "change of k2" && t.times.is_empty()));
}

/// Laws that are in proportion to a gain move s by that gain times its derivative: of each of two flames that
/// are spread along ducts.
#[test]
fn exact_laws_of_spread_flames_are_each_of_its_own_flame() {
    let duct = "[[element]]\ntype = 'duct'\nlength = 0.4\ndiameter = 0.04\n";
    let flame = |name: &str| {
        format!(
            "[[element]]\nname = '{name}'\ntype = 'flame'\ngain = '${name}_gain'\ndelay = 1e-3\nlength = 0.2\npieces = 3\n"
        )
    };
    let unknown =
        |name: &str| format!("[unknown.{name}_gain]\nprior = {{ normal = {{ mean = 0.2, sd = 0.1 }} }}\n");
    let ends = "name = 'tube'\n[upstream]\ntype = 'closed'\n[downstream]\ntype = 'constant'\nmodulus = 0.95\nangle = 3.0\n";
    let text =
        [ends, duct, &flame("first"), duct, &flame("second"), duct, &unknown("first"), &unknown("second")];
    let (assembly, conditions) = given::at_one_point(&text.concat());
    let (values, work) = ([0.3, 0.2], &mut Workspace::default());
    let model = PointModel::with_cuts(&assembly, &conditions, &[], &[]).unwrap();
    let found = model.probe(&values, &conditions, work).unwrap();
    let slopes = model.respond(&values, Order::First, work).unwrap().s;
    for (k, p) in assembly.parameters().iter().enumerate() {
        let at = p.name.strip_suffix("_gain").unwrap();
        let effects = &assembly.candidates()[0].effects;
        let effect = effects.iter().position(|e| e.place_text == at).unwrap();
        let sum: C64 = found.laws.iter().filter(|l| l.0 == [0, effect]).map(|l| l.1[0]).sum();
        let expected = slopes.gradient()[k] * values[k];
        assert!((sum - expected).norm() < 1e-9 * expected.norm(), "{at}: {sum} {expected}");
    }
}
