//! The gas of a duct as a function of its temperature, with derivatives.

use rijke_numerics::{C64, Jet};
use rijke_rig::Gas;
use rijke_study::GasModel;
use rijke_study::names::{DENSITY, PRANDTL, SOUND_SPEED};

/// Properties of a gas in the order of the names of laws, from density to Prandtl number.
pub(crate) type Properties = [Jet; PRANDTL - DENSITY + 1];

/// The speed of sound among them, m/s.
pub(crate) const SPEED: usize = SOUND_SPEED - DENSITY;

/// All properties at temperature `t` (K) and `pressure` (Pa): those of [`GasModel::at`], of the gas with
/// `own` ratio of specific heats and gas constant, as by [`GasModel::with`].
pub(crate) fn properties(model: &GasModel, own: [Option<Jet>; 2], t: &Jet, pressure: f64) -> Properties {
    let constant = |value: f64| t.scale(C64::ZERO).shift(C64::new(value, 0.0));
    let real = |jet: &Jet, factor: f64| jet.scale(C64::new(factor, 0.0));
    let [own_gamma, own_constant] = own;
    let r = own_constant.unwrap_or_else(|| constant(model.constant()));
    let (gamma, viscosity, conductivity, specific_heat, prandtl) = match model {
        GasModel::Real(gas) => {
            let Gas { molar_mass, heat_capacity: [c0, c1, c2, c3], .. } = *gas;
            let rise = |higher: &Jet, c: f64| (t * higher).shift(C64::new(c, 0.0));
            let capacity = rise(&rise(&rise(&constant(c3), c2), c1), c0);
            let specific_heat = real(&capacity, 1.0 / molar_mass);
            let gamma = &specific_heat * &(&specific_heat - &r).recip();
            let [mu, k] = [gas.viscosity, gas.conductivity].map(|law| sutherland(law, t));
            let prandtl = &(&mu * &specific_heat) * &k.recip();
            (gamma, mu, k, specific_heat, prandtl)
        }
        GasModel::Perfect { gamma, viscosity: [viscosity, reference], prandtl, .. } => {
            let mu = real(&real(t, 1.0 / reference).powf(0.7), *viscosity);
            let gamma = own_gamma.unwrap_or_else(|| constant(*gamma));
            let specific_heat = &(&gamma * &r) * &gamma.shift(-C64::ONE).recip();
            let k = real(&(&mu * &specific_heat), 1.0 / prandtl);
            (gamma, mu, k, specific_heat, constant(*prandtl))
        }
    };
    let heat = t * &r;
    let density = real(&heat.recip(), pressure);
    let sound_speed = (&gamma * &heat).sqrt();
    [
        density,
        sound_speed,
        t.clone(),
        constant(pressure),
        viscosity,
        conductivity,
        specific_heat,
        gamma,
        prandtl,
    ]
}

/// Sutherland's law: `[value at 273.15 K, constant in K]`.
fn sutherland([reference, constant]: [f64; 2], t: &Jet) -> Jet {
    let growth = t.scale(C64::new(1.0 / 273.15, 0.0)).powf(1.5);
    let shifted = t.shift(C64::new(constant, 0.0)).recip();
    (&growth * &shifted).scale(C64::new(reference * (273.15 + constant), 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::{JetSpace, Order};

    #[test]
    fn oracle_properties_are_those_of_the_gas_with_their_derivatives() {
        let perfect =
            GasModel::Perfect { gamma: 1.32, constant: 291.0, viscosity: [1.9e-5, 300.0], prandtl: 0.7 };
        for model in [perfect, GasModel::Real(Gas::air())] {
            for temperature in [250.0, 293.15, 900.0] {
                let at = |t: f64| {
                    let gas = model.at(t, 9.5e4);
                    [
                        gas.density,
                        gas.sound_speed,
                        gas.temperature,
                        gas.pressure,
                        gas.viscosity,
                        gas.conductivity,
                        gas.specific_heat,
                        gas.gamma,
                        gas.prandtl,
                    ]
                };
                let t = JetSpace::new(1, Order::Second).seed(0, C64::new(temperature, 0.0));
                let h = 1e-3 * temperature;
                let (here, up, down) = (at(temperature), at(temperature + h), at(temperature - h));
                for (k, jet) in properties(&model, [None, None], &t, 9.5e4).iter().enumerate() {
                    let size = here[k].abs();
                    assert!((jet.value().re - here[k]).abs() < 1e-14 * size, "{k} at {temperature} K");
                    let slope = (up[k] - down[k]) / (2.0 * h);
                    let bend = (up[k] - 2.0 * here[k] + down[k]) / (h * h);
                    let per = size / temperature;
                    assert!((jet.gradient()[0].re - slope).abs() < 1e-5 * per, "slope of {k}");
                    assert!((jet.hessian(0, 0).re - bend).abs() < 1e-4 * per / temperature, "bend of {k}");
                }
            }
        }
    }
}
