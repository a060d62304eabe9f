//! In a heated tube, laws that are evaluated once against the same laws evaluated segment by segment.

use super::{ALL, assembly};
use rijke_candidates::{Effect, Here, Law};
use rijke_flow::{Closures, Parameters, Pipe};
use rijke_model::{Assembly, Conditions, PointModel};
use rijke_network::Workspace;
use rijke_numerics::{C64, Jet, Order};
use rijke_rig::Campaign;
use std::sync::Arc;

/// A law that hides its short cuts: no scale, no evaluation in s alone.
#[derive(Debug)]
struct Slow(Arc<dyn Law>);

impl Law for Slow {
    fn evaluate(&self, here: &Here<'_>, parameters: &[Jet]) -> Jet {
        self.0.evaluate(here, parameters)
    }
    fn text(&self) -> String {
        self.0.text()
    }
}

#[test]
fn oracle_shared_laws_are_the_laws_of_every_segment() {
    let fast = assembly(&[
        "wall.rayleigh",
        "ends.calibrated",
        "prongs.4",
        "heater.3",
        "thermocouples.paper",
        "heat-release.5",
    ]);
    let slow = fast.candidates().iter().cloned().map(|mut candidate| {
        let hide = |e: &Effect| Effect { law: Arc::new(Slow(e.law.clone())), ..e.clone() };
        candidate.effects = candidate.effects.iter().map(hide).collect();
        candidate
    });
    let slow = Assembly::new(fast.rig.clone(), slow.collect()).unwrap();
    let rig = &fast.rig;
    let pipe = Pipe::new(rig, &Closures::default(), 0.25, 1).unwrap();
    let base = pipe.steady(&Parameters::default(), 130.0, 293.15).unwrap().base_state(&pipe);
    let point = Campaign::juniper_yoko_2022().points.into_iter().find(|p| p.id == "H130-25").unwrap();
    let conditions = Conditions { point, base, ambient: 293.15 };
    let values: Vec<f64> = fast.parameters().iter().map(|p| p.prior.quantile(0.6)).collect();
    let respond = |assembly: &Assembly, order: Order| {
        let model = PointModel::new(assembly, &conditions, &ALL).unwrap();
        model.respond(&values, order, &mut Workspace::default()).unwrap()
    };
    let (one, all) = (respond(&fast, Order::Second), respond(&slow, Order::Second));
    let plain = respond(&fast, Order::Value);
    for ((a, b), v) in one
        .pressures
        .iter()
        .chain([&one.s])
        .zip(all.pressures.iter().chain([&all.s]))
        .zip(plain.pressures.iter().chain([&plain.s]))
    {
        assert!((a.value() - b.value()).norm() < 1e-11 * b.value().norm());
        assert!((v.value() - b.value()).norm() < 1e-11 * b.value().norm());
        // The reference pressure is 1, its derivatives rounding: the floor is set by the derivatives of all pressures.
        let near = |x: &[C64], y: &[C64]| {
            let biggest = |z: &[C64]| z.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let everywhere = all.pressures.iter().map(|p| biggest(p.hessian_packed())).fold(0.0, f64::max);
            let largest = biggest(y);
            for (k, (x, y)) in x.iter().zip(y).enumerate() {
                assert!(
                    (x - y).norm() <= 1e-9 * largest + 1e-12 * everywhere,
                    "{k}: {x} {y}, largest {largest}"
                );
            }
        };
        near(a.gradient(), b.gradient());
        near(a.hessian_packed(), b.hessian_packed());
    }
}
