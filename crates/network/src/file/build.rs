//! From the tables of a file to a network and its laws.

use super::assembly::{Assembly, Attached, Redraw};
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
use toml::Spanned;

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
    let mut assembly = Assembly::new(gas, file.flow.as_ref(), region.omega[1], reading.finer);
    assembly.redraw = reading.redraw;
    assembly.warnings.extend(sizes.doubtful(&head, gas, &placed));
    assembly.warnings.extend(twins(&placed[ducts..], length));
    assembly.warnings.extend(overlapping(&placed[ducts..]));
    let along = assembly.cut(&placed, length)?;
    let (plane_below_hz, wide_or_narrow) = assembly.ducts_in_range(&sizes, &placed);
    assembly.warnings.extend(wide_or_narrow);
    assembly.act(&placed, &along, length)?;
    let flow = assembly.in_flow(text, file, &placed, &sizes)?;
    let ends = assembly.ends(text, file, flow.as_ref(), &region)?;
    let tables = assembly.fitted(&region);
    let flow = flow.map(|chain| {
        assembly.passive = false;
        let closed = ends.map(|(law, choked)| {
            if choked { FlowEnd::Choked } else { FlowEnd::Reflection(assembly.laws.laws[law].1.clone()) }
        });
        chain.with_ends(closed)
    });
    let network = assembly.network(ends)?;
    Ok(Built {
        name: file.name.clone(),
        network,
        flow,
        region,
        actors: assembly.actors(),
        laws: assembly.laws,
        places: assembly.places,
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
    /// Cuts the ducts into segments where devices are, and gives the flames that are spread along them.
    fn cut(&mut self, placed: &[Placed], length: f64) -> Result<Vec<Option<Along>>, FileError> {
        let spread = |p: &Placed| match &p.element {
            Element::Flame(flame) => Spread::of(&p.item, flame, p.x, length, self.finer),
            _ => Ok(None),
        };
        let spreads: Vec<Option<Spread>> = placed.iter().map(spread).collect::<Result<_, _>>()?;
        let mut cuts: Vec<f64> = placed.iter().filter(|p| !p.is_duct()).map(|p| p.x).collect();
        for flame in spreads.iter().flatten() {
            self.in_pieces = true;
            cuts.extend(flame.sources.iter().map(|source| source[0]).chain([flame.end]));
        }
        for (owner, duct) in placed.iter().enumerate().filter(|(_, p)| p.is_duct()) {
            self.duct(owner, duct, &cuts, SAME * length)?;
        }
        self.of_walls = (0..self.laws.laws()).collect();
        let along = |spread| Along::of(spread, |x| self.place_at(x, length));
        Ok(spreads.into_iter().map(|spread| spread.map(along)).collect())
    }

    /// Lets the devices act.
    fn act(&mut self, placed: &[Placed], along: &[Option<Along>], length: f64) -> Result<(), FileError> {
        let at = |p: &Placed| self.place_at(p.x, length);
        let devices: Vec<(&Placed, usize, Option<&Along>)> = placed
            .iter()
            .zip(along)
            .filter(|(p, _)| !p.is_duct())
            .map(|(p, along)| (p, at(p), along.as_ref()))
            .collect();
        for (device, place, _) in &devices {
            self.places.push((*place, device.called.clone()));
            self.devices.push((*place, device.item.place.clone()));
        }
        for (device, place, along) in devices {
            self.compact(&device.item, place, &device.element, along)?;
            // In a flow every piece of a flame acts where it is.
            if let Some(along) = along.filter(|_| self.flows) {
                self.places.extend(along.places.iter().map(|place| (*place, device.called.clone())));
            }
        }
        Ok(())
    }

    /// The chain with mean flow, if the file has one, with choked ends for the time being.
    fn in_flow(
        &mut self,
        text: &str,
        file: &File,
        placed: &[Placed],
        sizes: &Sizes,
    ) -> Result<Option<FlowChain>, FileError> {
        let Some(flow) = &file.flow else {
            self.warnings.extend(at_rest(placed));
            return Ok(None);
        };
        let chain = self.flow(line_of_table(text, "flow"), flow, placed)?;
        let doubtful = self.flow_in_range(&chain, sizes, placed);
        self.warnings.extend(doubtful);
        Ok(Some(chain))
    }

    /// The laws of both ends, and whether they are choked.
    fn ends(
        &mut self,
        text: &str,
        file: &File,
        flow: Option<&FlowChain>,
        region: &Region,
    ) -> Result<[(usize, bool); 2], FileError> {
        let mach = |of_flow: &FlowChain, k: usize| {
            let i = if k == 0 { 0 } else { of_flow.states().len() - 1 };
            of_flow.states()[i].mach(of_flow.gammas()[i])
        };
        let mut of = |k: usize, place: &str, table: &Spanned<toml::Table>| {
            let item = Item { line: line_of(text, table.span().start), place: place.to_owned() };
            self.end(item, table.get_ref().clone(), k, flow.map(|flow| mach(flow, k)), region)
        };
        Ok([of(0, "[upstream]", &file.upstream)?, of(1, "[downstream]", &file.downstream)?])
    }

    /// The chain with its gas at rest.
    fn network(&mut self, ends: [(usize, bool); 2]) -> Result<Network, FileError> {
        let mut network = Network::new(std::mem::take(&mut self.segments))?;
        for Attached { slot, law, weight, .. } in std::mem::take(&mut self.attach) {
            network.attach(slot, law, weight)?;
        }
        network.attach(Slot::Upstream, ends[0].0, 1.0)?;
        network.attach(Slot::Downstream, ends[1].0, 1.0)?;
        self.listen(&mut network)?;
        Ok(network)
    }

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
