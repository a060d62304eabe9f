//! Lengths, areas, temperatures and places as functions of the unknowns.

use super::gas::{Properties, properties};
use super::model::{At, ShapeModel};
use rijke_formula::Here;
use rijke_numerics::{C64, Jet, JetSpace};
use rijke_study::{Shape, Value};

/// The shape of the rig at given unknowns.
pub(crate) struct Extents {
    /// Length of every segment, m.
    pub(crate) lengths: Vec<Jet>,
    /// Area of every duct, m^2.
    pub(crate) areas: Vec<Jet>,
    /// Diameter of every duct, m.
    pub(crate) diameters: Vec<Jet>,
    /// Total length, m.
    pub(crate) length: Jet,
    /// The gas of every duct of unknown temperature or unknown gas.
    pub(crate) gas: Vec<Option<Properties>>,
}

impl ShapeModel<'_> {
    /// The shape, with derivatives; `own` are the parameters of the rig's file.
    pub(crate) fn extents(&self, space: JetSpace, own: &[Jet]) -> Extents {
        let number = |value: &Value| match value {
            Value::Unknown(formula, _) => {
                formula.evaluate(&Here { space, numbers: &self.numbers, analytic: &[] }, own)
            }
            known => space.real(known.at(&self.numbers)),
        };
        let parts = &self.assembly.rig.parts;
        let duct = |k: &usize| match &parts[*k].shape {
            Shape::Duct(duct) => [number(&duct.length), number(&duct.area[0])],
            _ => [space.real(f64::NAN), space.real(f64::NAN)],
        };
        let gas = |(k, part): (usize, &usize)| match &parts[*part].shape {
            Shape::Duct(duct) if parts[*part].is_of_unknown_gas() => {
                let known = || space.real(self.temperatures[k]);
                let unknown = duct.temperatures.first().filter(|t| t.unknown().is_some());
                let own = [0, 1].map(|i| duct.gas[i].as_ref().map(&number));
                let temperature = unknown.map_or_else(known, &number);
                Some(properties(&self.assembly.rig.gas, own, &temperature, self.pressure))
            }
            _ => None,
        };
        let ducts: Vec<[Jet; 2]> = self.ducts.iter().map(duct).collect();
        let mut ends = vec![space.real(0.0)];
        for [length, _] in &ducts {
            let next = ends.last().map_or_else(|| length.clone(), |x| x + length);
            ends.push(next);
        }
        let place = |at: &At| match at {
            At::Boundary(k) => ends[*k].clone(),
            At::Part(part, k) => match &parts[*part].shape {
                Shape::Device(list) => number(&list[*k]),
                _ => space.real(f64::NAN),
            },
            At::Microphone(k) => number(&self.assembly.rig.microphones.at[*k]),
            At::Fixed(x) => space.real(*x),
        };
        let places: Vec<Jet> = self.cuts.iter().map(place).collect();
        let areas: Vec<Jet> = ducts.iter().map(|[_, area]| area.clone()).collect();
        let wide = C64::new(4.0 / std::f64::consts::PI, 0.0);
        Extents {
            lengths: places.windows(2).map(|pair| &pair[1] - &pair[0]).collect(),
            diameters: areas.iter().map(|area| area.scale(wide).sqrt()).collect(),
            areas,
            gas: self.ducts.iter().enumerate().map(gas).collect(),
            length: ends.last().cloned().unwrap_or_else(|| space.real(0.0)),
        }
    }
}
