//! From the tables of a file to a network and its laws.

use super::compact::Flame;
use super::layout::{self, SAME};
use super::schema::{File, Gas};
use super::{FileError, Problem, REGION};
use crate::chain::{Network, Segment, Slot};
use crate::contour::Region;
use crate::flow_chain::{FlowChain, FlowEnd, FlowWall};
use crate::laws::LawSet;
use serde::Deserialize;
use std::f64::consts::PI;

/// A network with its laws, and where to look for modes.
#[derive(Clone, Debug, PartialEq)]
pub struct Built {
    /// What the file calls it.
    pub name: Option<String>,
    /// The chain.
    pub network: Network,
    /// Its laws.
    pub laws: LawSet,
    /// The same with mean flow, if the file has `[flow]`; `network` then is the chain with the gas at rest.
    pub flow: Option<FlowChain>,
    /// Where to look for modes.
    pub region: Region,
    /// What each place is, for tables and figures: its number and the name of the element that acts there.
    pub places: Vec<(usize, String)>,
    /// By law: the name of the element whose it is, or what it is.
    pub actors: Vec<String>,
    /// Whether nothing in it can feed energy to a mode.
    pub passive: bool,
    /// What is doubtful but possible.
    pub warnings: Vec<Warning>,
}

/// What is doubtful about a network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Warning {
    /// Density and sound speed do not belong to the pressure.
    #[error("line {line}: {place}: rho c^2/gamma is {found:.0} Pa, but the pressure is {expected:.0} Pa")]
    Pressure {
        /// Line in the file.
        line: usize,
        /// Which element.
        place: String,
        /// rho c^2/gamma, Pa.
        found: f64,
        /// The pressure of the gas, Pa.
        expected: f64,
    },
    /// A reflection coefficient above one feeds energy.
    #[error(
        "line {line}: {place}: |R| = {modulus} at {frequency_hz} Hz is above 1: this end feeds the modes"
    )]
    Reflection {
        /// Line in the file.
        line: usize,
        /// Which end.
        place: String,
        /// The largest |R| at the frequencies searched.
        modulus: f64,
        /// Where, Hz.
        frequency_hz: f64,
    },
    /// The search goes beyond a table.
    #[error(
        "line {line}: {place}: the table ends at {low_hz} and {high_hz} Hz, but the search does not: modes beyond rest \
         on extrapolation"
    )]
    Extrapolation {
        /// Line in the file.
        line: usize,
        /// Which element or end.
        place: String,
        /// Limits of the table, Hz.
        low_hz: f64,
        /// Upper limit.
        high_hz: f64,
    },
}

#[derive(Clone)]
pub(super) struct Item {
    pub(super) line: usize,
    pub(super) place: String,
}

impl Item {
    pub(super) fn fail(&self, problem: Problem) -> FileError {
        FileError::Element { line: self.line, place: self.place.clone(), problem }
    }

    pub(super) fn positive(&self, key: &'static str, value: f64) -> Result<f64, FileError> {
        if value.is_finite() && value > 0.0 {
            Ok(value)
        } else {
            Err(self.fail(Problem::NotPositive { key, value }))
        }
    }

    pub(super) fn not_negative(&self, key: &'static str, value: f64) -> Result<f64, FileError> {
        if value.is_finite() && value >= 0.0 {
            Ok(value)
        } else {
            Err(self.fail(Problem::Negative { key, value }))
        }
    }

    pub(super) fn polynomial(&self, key: &'static str, value: &[f64]) -> Result<Vec<f64>, FileError> {
        if value.iter().any(|k| *k != 0.0) && value.iter().all(|k| k.is_finite()) {
            Ok(value.to_vec())
        } else {
            Err(self.fail(Problem::Polynomial { key }))
        }
    }

    pub(super) fn parse<'de, T: Deserialize<'de>>(&self, table: toml::Table) -> Result<T, FileError> {
        T::deserialize(toml::Value::Table(table)).map_err(|error| {
            let mut message = error.message().to_owned();
            if message.starts_with("invalid type: string") && message.contains("f64") {
                message += "; this reader takes plain numbers in SI units";
            }
            self.fail(Problem::Keys { message })
        })
    }
}

/// What an attached law is for a chain with flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Force or heat, by its slot.
    Plain,
    /// Mass taken by a side branch.
    Branch,
    /// Stands in the list of flames too, in another form.
    Flame,
}

/// A law in a slot.
pub(super) struct Attached {
    pub(super) slot: Slot,
    pub(super) law: usize,
    pub(super) weight: f64,
    pub(super) role: Role,
}

/// Segments so far, and what acts on them.
pub(super) struct Assembly<'a> {
    pub(super) gas: &'a Gas,
    pub(super) segments: Vec<Segment>,
    pub(super) temperatures: Vec<f64>,
    pub(super) walls: Vec<Option<FlowWall>>,
    /// Element of each segment, by its index in the list of elements.
    pub(super) owners: Vec<usize>,
    pub(super) laws: LawSet,
    pub(super) attach: Vec<Attached>,
    pub(super) flames: Vec<Flame>,
    /// Place and loss coefficient of screens.
    pub(super) screens: Vec<(usize, f64)>,
    pub(super) places: Vec<(usize, String)>,
    /// Place of each device, and what it is called in messages.
    pub(super) devices: Vec<(usize, String)>,
    pub(super) tables: Vec<(Item, [f64; 2])>,
    pub(super) passive: bool,
    pub(super) warnings: Vec<Warning>,
}

pub(super) fn build(text: &str, file: &File) -> Result<Built, FileError> {
    let gas = &file.gas;
    let head = Item { line: layout::line_of_table(text, "gas"), place: "[gas]".to_owned() };
    for (key, value) in [
        ("temperature", gas.temperature),
        ("pressure", gas.pressure),
        ("gamma", gas.gamma),
        ("gas_constant", gas.gas_constant),
        ("viscosity", gas.viscosity),
        ("prandtl", gas.prandtl),
    ] {
        head.positive(key, value)?;
    }
    if gas.gamma <= 1.0 {
        return Err(head.fail(Problem::Gamma { value: gas.gamma }));
    }
    let region = region(text, file)?;
    let (placed, length) = layout::place(text, &file.element)?;
    let mut assembly = Assembly {
        gas,
        segments: Vec::new(),
        temperatures: Vec::new(),
        walls: Vec::new(),
        owners: Vec::new(),
        laws: LawSet::default(),
        attach: Vec::new(),
        flames: Vec::new(),
        screens: Vec::new(),
        places: Vec::new(),
        devices: Vec::new(),
        tables: Vec::new(),
        passive: true,
        warnings: Vec::new(),
    };
    let cuts: Vec<f64> = placed.iter().filter(|p| !p.is_duct()).map(|p| p.x).collect();
    for (owner, duct) in placed.iter().enumerate().filter(|(_, p)| p.is_duct()) {
        assembly.duct(owner, duct, &cuts, SAME * length)?;
    }
    let place_of = |x: f64| {
        let mut end = 0.0;
        let ends = assembly.segments.iter().map(|s| {
            end += s.length;
            end
        });
        1 + ends.take_while(|end| *end < x + SAME * length).count()
    };
    let at: Vec<usize> =
        placed.iter().map(|p| if p.x <= SAME * length { 0 } else { place_of(p.x) - 1 }).collect();
    for (device, &place) in placed.iter().zip(&at).filter(|(p, _)| !p.is_duct()) {
        assembly.places.push((place, device.called.clone()));
        assembly.devices.push((place, device.item.place.clone()));
    }
    for (device, &place) in placed.iter().zip(&at).filter(|(p, _)| !p.is_duct()) {
        assembly.compact(&device.item, place, &device.element)?;
    }
    let line = layout::line_of_table(text, "flow");
    let flow = file.flow.as_ref().map(|flow| assembly.flow(line, flow, &placed)).transpose()?;
    let machs = flow.as_ref().map(|f| [0, f.states().len() - 1].map(|i| f.states()[i].mach(gas.gamma)));
    let mut ends = Vec::new();
    for (k, (place, table)) in
        [("[upstream]", &file.upstream), ("[downstream]", &file.downstream)].into_iter().enumerate()
    {
        let item = Item { line: layout::line_of(text, table.span().start), place: place.to_owned() };
        ends.push(assembly.end(item, table.get_ref().clone(), k, machs.map(|m| m[k]), &region)?);
    }
    for (item, [low, high]) in std::mem::take(&mut assembly.tables) {
        if region.omega[0] < low * (1.0 - 1e-9) || region.omega[1] > high * (1.0 + 1e-9) {
            let [low_hz, high_hz] = [low, high].map(|w| w / (2.0 * PI));
            let Item { line, place } = item;
            assembly.warnings.push(Warning::Extrapolation { line, place, low_hz, high_hz });
        }
    }
    let flow = flow.map(|chain| {
        assembly.passive = false;
        let closed = ends.iter().map(|(law, choked)| {
            if *choked { FlowEnd::Choked } else { FlowEnd::Reflection(assembly.laws.laws[*law].1.clone()) }
        });
        chain.with_ends(closed.collect::<Vec<_>>().try_into().unwrap_or([FlowEnd::Choked, FlowEnd::Choked]))
    });
    let actor = |(name, _): &(String, _)| {
        let device =
            assembly.devices.iter().position(|d| name.strip_prefix(&d.1).is_some_and(|r| r.starts_with(':')));
        device.map_or_else(|| "lumped wall losses".to_owned(), |k| assembly.places[k].1.clone())
    };
    let actors = assembly.laws.laws.iter().map(actor).collect();
    let mut network = Network::new(assembly.segments)?;
    for Attached { slot, law, weight, .. } in assembly.attach {
        network.attach(slot, law, weight)?;
    }
    network.attach(Slot::Upstream, ends[0].0, 1.0)?;
    network.attach(Slot::Downstream, ends[1].0, 1.0)?;
    Ok(Built {
        name: file.name.clone(),
        network,
        laws: assembly.laws,
        flow,
        region,
        places: assembly.places,
        actors,
        passive: assembly.passive,
        warnings: assembly.warnings,
    })
}

fn region(text: &str, file: &File) -> Result<Region, FileError> {
    let mut region = REGION;
    let increasing = |limits: [f64; 2], key| {
        if limits[0] < limits[1] && limits.iter().all(|v| v.is_finite()) {
            Ok(limits)
        } else {
            Err(FileError::Search { line: layout::line_of_table(text, "search"), key })
        }
    };
    if let Some(limits) = file.search.growth_rate {
        region.sigma = increasing(limits, "growth_rate")?;
    }
    if let Some(limits) = file.search.frequency_hz {
        region.omega = increasing(limits, "frequency_hz")?.map(|f| 2.0 * PI * f);
    }
    Ok(region)
}
