//! The gas as the kernels need it: the rig's formulas, for any [`Number`].

use crate::error::FlowError;
use crate::number::Number;
use rijke_rig::Gas;

/// A gas at the ambient pressure, with its constants ready for the kernels.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Air {
    pub(crate) pressure: f64,
    pub(crate) constant: f64,
    heat: [f64; 4],
    viscosity: [f64; 2],
    conductivity: [f64; 2],
    /// k/c_p and (c_p/k)^{2/3} with their slopes, every [`SPACING`] kelvin from [`COLDEST`].
    table: Vec<[f64; 4]>,
}

/// Temperatures at which the properties of air hold, K: White's transport properties within 2 % from 210 to
/// 1900 K, Cengel & Boles's heat capacity up to 1800 K. Below its 273 K the latter is 1 % small at 250 K and
/// 1.2 % at 210 K.
const HOLDS: [f64; 2] = [210.0, 1800.0];

/// Range and spacing of the table, K. Cubic Hermite interpolation at this spacing errs by 1e-10 relative, and
/// saves the march a cube root, a square root and several divisions per cell: more than half of its time.
const COLDEST: f64 = 150.0;
const HOTTEST: f64 = 2000.0;
const SPACING: f64 = 2.0;

/// Refuses a temperature outside the range of the properties, in any lane; `what` names it.
///
/// # Errors
/// [`FlowError::Range`].
pub(crate) fn in_range<N: Number>(what: &str, kelvin: N) -> Result<(), FlowError> {
    let [low, high] = HOLDS;
    let outside = kelvin.map(|t| (if (low..=high).contains(&t) { 0.0 } else { 1.0 }, 0.0));
    if outside.total() == 0.0 {
        return Ok(());
    }
    Err(FlowError::Range { what: what.to_string(), kelvin: kelvin.total(), low, high })
}

impl Air {
    pub(crate) fn new(gas: &Gas, pressure: f64) -> Self {
        // Sutherland: reference (T/T0)^1.5 (T0 + S)/(T + S) = factor T sqrt(T)/(T + S).
        let factor = |[reference, s]: [f64; 2]| [reference * (273.15 + s) / 273.15_f64.powf(1.5), s];
        let mut air = Self {
            pressure,
            constant: gas.constant(),
            heat: gas.heat_capacity.map(|c| c / gas.molar_mass),
            viscosity: factor(gas.viscosity),
            conductivity: factor(gas.conductivity),
            table: Vec::new(),
        };
        let nodes = ((HOTTEST - COLDEST) / SPACING) as usize;
        air.table = (0..=nodes)
            .map(|i| {
                let t = crate::number::Dual::<1>::variable(COLDEST + SPACING * i as f64, 0);
                let ratio = air.conductivity(t) / air.specific_heat(t);
                let thirds = ratio.recip().two_thirds();
                [ratio.value, SPACING * ratio.slopes[0], thirds.value, SPACING * thirds.slopes[0]]
            })
            .collect();
        air
    }

    /// k/c_p (kg/(m s)) and (c_p/k)^{2/3}; outside 150 to 2000 K, which only trial flows that almost stand
    /// still reach, those at the end of the range.
    #[inline]
    pub(crate) fn diffusion<N: Number>(&self, t: N) -> (N, N) {
        t.map2(|t| {
            let inside = t.clamp(COLDEST, HOTTEST);
            let place = (inside - COLDEST) / SPACING;
            let node = (place as usize).min(self.table.len() - 2);
            let (x, a, b) = (place - node as f64, &self.table[node], &self.table[node + 1]);
            let slope = if inside == t { 1.0 / SPACING } else { 0.0 };
            let cubic = |k: usize| {
                let (p, dp, dq) = (a[k], a[k + 1], b[k + 1]);
                let rise = b[k] - p;
                let (c2, c3) = (3.0 * rise - 2.0 * dp - dq, dp + dq - 2.0 * rise);
                (p + x * (dp + x * (c2 + x * c3)), dp + x * (2.0 * c2 + 3.0 * x * c3))
            };
            let ((r, dr), (g, dg)) = (cubic(0), cubic(2));
            [(r, dr * slope), (g, dg * slope)]
        })
    }

    /// Specific heat at constant pressure, J/(kg K).
    pub(crate) fn specific_heat<N: Number>(&self, t: N) -> N {
        let [a, b, c, d] = self.heat;
        ((t * d + c) * t + b) * t + a
    }

    /// Enthalpy, J/kg: the integral of the specific heat from 0 K, of which only differences mean anything.
    pub(crate) fn enthalpy<N: Number>(&self, t: N) -> N {
        let [a, b, c, d] = self.heat;
        (((t * (d / 4.0) + c / 3.0) * t + b / 2.0) * t + a) * t
    }

    /// Dynamic viscosity, Pa s.
    pub(crate) fn viscosity<N: Number>(&self, t: N) -> N {
        let [factor, s] = self.viscosity;
        t * t.sqrt() / (t + s) * factor
    }

    /// Thermal conductivity, W/(m K).
    pub(crate) fn conductivity<N: Number>(&self, t: N) -> N {
        let [factor, s] = self.conductivity;
        t * t.sqrt() / (t + s) * factor
    }

    /// Specific volume, m^3/kg.
    pub(crate) fn volume<N: Number>(&self, t: N) -> N {
        t * (self.constant / self.pressure)
    }

    /// Speed of sound, m/s.
    pub(crate) fn sound_speed<N: Number>(&self, t: N) -> N {
        let cp = self.specific_heat(t);
        (t * cp / (cp - self.constant) * self.constant).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn oracle_kernels_agree_with_the_rig() {
        let (gas, p) = (Gas::air(), 101_325.0);
        let air = Air::new(&gas, p);
        for t in [250.0, 293.15, 480.0, 900.0] {
            let state = gas.at(t, p);
            assert_relative_eq!(air.specific_heat(t), state.specific_heat, max_relative = 1e-14);
            assert_relative_eq!(air.viscosity(t), state.viscosity, max_relative = 1e-13);
            assert_relative_eq!(air.conductivity(t), state.conductivity, max_relative = 1e-13);
            assert_relative_eq!(air.volume(t), 1.0 / state.density, max_relative = 1e-14);
            assert_relative_eq!(air.sound_speed(t), state.sound_speed, max_relative = 1e-14);
            let (ratio, thirds) = air.diffusion(t);
            assert_relative_eq!(ratio, state.conductivity / state.specific_heat, max_relative = 1e-9);
            assert_relative_eq!(thirds, ratio.powf(-2.0 / 3.0), max_relative = 1e-9);
            let slope = (air.enthalpy(t + 0.1) - air.enthalpy(t - 0.1)) / 0.2;
            assert_relative_eq!(slope, state.specific_heat, max_relative = 1e-8);
        }
    }
}
