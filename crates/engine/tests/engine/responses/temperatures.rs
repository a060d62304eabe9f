//! Ducts of different temperatures.

use super::bench::{folder, model, normal, reflection, rig, trained};
use rijke_numerics::{C64, Streams};

#[test]
fn oracle_every_duct_has_the_gas_of_its_temperature() {
    let frequency_hz: Vec<f64> = (0..60).map(|k| 100.0 + 48.0 * f64::from(k)).collect();
    let truth = [0.102, 5.1e-3, 0.93];
    // The wide duct has the temperature of the gas, as the file of the rig has it.
    for temperatures in [[None, Some(400.0)], [Some(350.0), Some(600.0)]] {
        let rig = rig(temperatures);
        let folder = folder("hot", &rig, "rig", "[]", "noise = 1e-4");
        let mut stream = Streams::new(3).stream("responses/hot");
        let known = temperatures.map(|t| t.unwrap_or(293.15));
        let values: Vec<C64> = frequency_hz
            .iter()
            .map(|f| {
                reflection(*f, truth, 0.0, known) + 1e-4 * C64::new(normal(&mut stream), normal(&mut stream))
            })
            .collect();
        let stage = trained(&folder, &frequency_hz, &values).unwrap();
        let found = model(&stage, "end.constant");
        for (name, truth) in ["l2", "b2", "eta"].iter().zip(truth) {
            let p = found.parameters.iter().find(|p| p.name == *name).unwrap();
            assert!((p.value - truth).abs() < 4.0 * p.sd && p.sd < 1e-3 * truth, "{name}: {p:?}");
        }
        assert!(found.residual < 2e-4, "{}", found.residual);
        assert_eq!(stage.winner, "end.constant");
    }
}
