//! From the tables of a file to a network and its laws.

use super::assembly::{Assembly, Attached, Carried, Redraw};
use super::error::FileError;
use super::item::{Item, line_of_table};
use super::layout::{Placed, SAME, place};
use super::odd::{at_rest, overlapping, twins};
use super::problem::ElementProblem;
use super::row::in_a_row;
use super::schema::{Element, File, Gas};
use super::sizes::Sizes;
use super::spread::{Along, Spread};
use super::warning::Warning;
use crate::chain::coefficients::Coefficients;
use crate::chain::network::Network;
use crate::flow_chain::{FlowChain, FlowEnd};
use crate::laws::{LawSet, Table};
use crate::plane::region::Region;
use crate::slot::Slot;
use rijke_numerics::words::line_of;
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
    /// The frequency from which on a higher mode is cut on in one of its ducts, Hz: above, the sound is not
    /// in plane waves alone.
    pub plane_below_hz: f64,
    /// Whether pieces stand for a slope, a cone or a spread flame: its modes are as good as these are fine
    /// ([`super::moved_by_pieces`]).
    pub in_pieces: bool,
    /// The tables as they were fitted, in the order in which they were met.
    pub(super) tables: Vec<Table>,
    /// What is doubtful but possible.
    pub warnings: Vec<Warning>,
}

/// How a file is read: [`Default`] is as it says.
pub(super) struct Reading<'a> {
    /// Draws every table anew within its noise.
    pub(super) redraw: Option<Redraw<'a>>,
    /// How many times more pieces than the file says ducts and flames are cut into.
    pub(super) finer: usize,
}

impl Default for Reading<'_> {
    fn default() -> Self {
        Self { redraw: None, finer: 1 }
    }
}

/// The network of a file.
pub(super) fn build(text: &str, file: &File, reading: Reading<'_>) -> Result<Built, FileError> {
    let gas = &file.gas;
    let head = Item { line: line_of_table(text, "gas"), place: "[gas]".to_owned() };
    check(gas, &head)?;
    let region = region(text, file)?;
    let (mut placed, length) = place(text, &file.element)?;
    let ducts = placed.iter().take_while(|p| p.is_duct()).count();
    in_a_row(&mut placed[ducts..], length);
    let sizes = Sizes::of(gas, &region);
    let carrying = file.flow.as_ref().filter(|flow| flow.entropy_waves);
    let carried = carrying.map(|flow| Carried { flow: [flow.mach, flow.velocity], omega: region.omega[1] });
    let mut warnings = sizes.doubtful(&head, gas, &placed);
    warnings.extend(twins(&placed[ducts..], length));
    warnings.extend(overlapping(&placed[ducts..]));
    let mut assembly = Assembly {
        gas,
        segments: Vec::new(),
        gases: Vec::new(),
        walls: Vec::new(),
        owners: Vec::new(),
        laws: LawSet::default(),
        attach: Vec::new(),
        of_walls: Vec::new(),
        flames: Vec::new(),
        listeners: Vec::new(),
        screens: Vec::new(),
        places: Vec::new(),
        devices: Vec::new(),
        tables: Vec::new(),
        redraw: reading.redraw,
        flows: file.flow.is_some(),
        finer: reading.finer,
        carried,
        passive: true,
        in_pieces: false,
        warnings,
    };
    let spread = |p: &Placed| match &p.element {
        Element::Flame(flame) => Spread::of(&p.item, flame, p.x, length, reading.finer),
        _ => Ok(None),
    };
    let spreads: Vec<Option<Spread>> = placed.iter().map(spread).collect::<Result<_, _>>()?;
    let mut cuts: Vec<f64> = placed.iter().filter(|p| !p.is_duct()).map(|p| p.x).collect();
    for flame in spreads.iter().flatten() {
        assembly.in_pieces = true;
        cuts.extend(flame.sources.iter().map(|source| source[0]).chain([flame.end]));
    }
    for (owner, duct) in placed.iter().enumerate().filter(|(_, p)| p.is_duct()) {
        assembly.duct(owner, duct, &cuts, SAME * length)?;
    }
    assembly.of_walls = (0..assembly.laws.laws()).collect();
    let (plane_below_hz, wide_or_narrow) = assembly.ducts_in_range(&sizes, &placed);
    assembly.warnings.extend(wide_or_narrow);
    let place_of = |x: f64| {
        let mut end = 0.0;
        let ends = assembly.segments.iter().map(|s| {
            end += s.length;
            end
        });
        1 + ends.take_while(|end| *end < x + SAME * length).count()
    };
    let place_at = |x: f64| if x <= SAME * length { 0 } else { place_of(x) - 1 };
    let at: Vec<usize> = placed.iter().map(|p| place_at(p.x)).collect();
    let along: Vec<Option<Along>> = spreads.into_iter().map(|s| s.map(|s| Along::of(s, place_at))).collect();
    for (device, &place) in placed.iter().zip(&at).filter(|(p, _)| !p.is_duct()) {
        assembly.places.push((place, device.called.clone()));
        assembly.devices.push((place, device.item.place.clone()));
    }
    for ((device, &place), along) in placed.iter().zip(&at).zip(&along).filter(|((p, _), _)| !p.is_duct()) {
        assembly.compact(&device.item, place, &device.element, along.as_ref())?;
        // In a flow every piece of a flame acts where it is.
        for along in along.iter().filter(|_| file.flow.is_some()) {
            assembly.places.extend(along.places.iter().map(|place| (*place, device.called.clone())));
        }
    }
    if file.flow.is_none() {
        assembly.warnings.extend(at_rest(&placed));
    }
    let line = line_of_table(text, "flow");
    let flow = file.flow.as_ref().map(|flow| assembly.flow(line, flow, &placed)).transpose()?;
    if let Some(chain) = &flow {
        let doubtful = assembly.flow_in_range(chain, &sizes, &placed);
        assembly.warnings.extend(doubtful);
    }
    let machs = flow.as_ref().map(|f| [0, f.states().len() - 1].map(|i| f.states()[i].mach(f.gammas()[i])));
    let mut ends = Vec::new();
    for (k, (place, table)) in
        [("[upstream]", &file.upstream), ("[downstream]", &file.downstream)].into_iter().enumerate()
    {
        let item = Item { line: line_of(text, table.span().start), place: place.to_owned() };
        ends.push(assembly.end(item, table.get_ref().clone(), k, machs.map(|m| m[k]), &region)?);
    }
    let tables = assembly.fitted(&region);
    let flow = flow.map(|chain| {
        assembly.passive = false;
        let closed = ends.iter().map(|(law, choked)| {
            if *choked { FlowEnd::Choked } else { FlowEnd::Reflection(assembly.laws.laws[*law].1.clone()) }
        });
        chain.with_ends(closed.collect::<Vec<_>>().try_into().unwrap_or([FlowEnd::Choked, FlowEnd::Choked]))
    });
    let mut network = Network::new(std::mem::take(&mut assembly.segments))?;
    for Attached { slot, law, weight, .. } in std::mem::take(&mut assembly.attach) {
        network.attach(slot, law, weight)?;
    }
    network.attach(Slot::Upstream, ends[0].0, 1.0)?;
    network.attach(Slot::Downstream, ends[1].0, 1.0)?;
    assembly.listen(&mut network)?;
    let actor = |law: usize| {
        let name = assembly.laws.name(law);
        let device =
            assembly.devices.iter().position(|d| name.strip_prefix(&d.1).is_some_and(|r| r.starts_with(':')));
        device.map_or_else(|| "lumped wall losses".to_owned(), |k| assembly.places[k].1.clone())
    };
    let actors = (0..assembly.laws.laws()).map(actor).collect();
    Ok(Built {
        name: file.name.clone(),
        network,
        laws: assembly.laws,
        flow,
        region,
        places: assembly.places,
        actors,
        passive: assembly.passive,
        plane_below_hz,
        in_pieces: assembly.in_pieces,
        tables,
        warnings: assembly.warnings,
    })
}

/// Refuses numbers that no gas has.
fn check(gas: &Gas, head: &Item) -> Result<(), FileError> {
    for (key, value) in gas.numbers() {
        head.positive(key, value)?;
    }
    if gas.gamma > 1.0 { Ok(()) } else { Err(head.fail(ElementProblem::Gamma { value: gas.gamma })) }
}

impl Assembly<'_> {
    /// The tables as they were fitted, and a warning of each that does not reach as far as the search.
    fn fitted(&mut self, region: &Region) -> Vec<Table> {
        let mut tables = Vec::new();
        for (Item { line, place }, table) in std::mem::take(&mut self.tables) {
            let [low, high] = table.range;
            tables.push(table);
            if region.omega[0] < low * (1.0 - 1e-9) || region.omega[1] > high * (1.0 + 1e-9) {
                let [low_hz, high_hz] = [low, high].map(|w| w / (2.0 * PI));
                let beyond = Warning::Extrapolation { line, place, low_hz, high_hz };
                // A flame that hears elsewhere has its table in two laws.
                if !self.warnings.contains(&beyond) {
                    self.warnings.push(beyond);
                }
            }
        }
        tables
    }
}

fn region(text: &str, file: &File) -> Result<Region, FileError> {
    let mut region = REGION;
    let increasing = |limits: [f64; 2], key| {
        if limits[0] < limits[1] && limits.iter().all(|v| v.is_finite()) {
            Ok(limits)
        } else {
            Err(FileError::Search { line: line_of_table(text, "search"), key })
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

/// The default region of a search: growth rates from -500 to 500 1/s, frequencies from 10 Hz to 1 kHz.
const REGION: Region = Region { sigma: [-500.0, 500.0], omega: [2.0 * PI * 10.0, 2.0 * PI * 1000.0] };
