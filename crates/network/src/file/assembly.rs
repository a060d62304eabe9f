//! A network in the making.

use super::item::Item;
use super::layout::SAME;
use super::schema::{Flow, Gas};
use super::warning::Warning;
use crate::chain::coefficients::Coefficients;
use crate::chain::network::Segment;
use crate::flow_chain::{ActionKind, FlowWall};
use crate::laws::{Law, LawSet, Likely, SpreadPiece, Table, TableError, TableRow};
use crate::slot::Slot;
use rijke_numerics::Stream;

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

/// The gas of a segment.
#[derive(Clone, Copy)]
pub(super) struct LocalGas {
    /// K.
    pub(super) temperature: f64,
    pub(super) gamma: f64,
    /// Gas constant times temperature, J/kg.
    pub(super) heat: f64,
}

/// Puts another function that its rows allow ([`Likely`]) in the place of every table.
pub(super) struct Redraw<'a> {
    pub(super) stream: Stream,
    /// The tables as they are, in the order in which they are met.
    pub(super) known: std::slice::Iter<'a, Table>,
    /// What the rows of each allow, from the second drawing on.
    pub(super) likely: &'a mut Vec<Likely>,
    /// How many tables were met.
    pub(super) met: usize,
}

/// Segments so far, and what acts on them.
pub(super) struct Assembly<'a> {
    pub(super) gas: &'a Gas,
    pub(super) segments: Vec<Segment>,
    pub(super) gases: Vec<LocalGas>,
    pub(super) walls: Vec<Option<FlowWall>>,
    /// Element of each segment, by its index in the list of elements.
    pub(super) owners: Vec<usize>,
    pub(super) laws: LawSet,
    pub(super) attach: Vec<Attached>,
    /// Numbers of laws of wall losses.
    pub(super) of_walls: Vec<usize>,
    pub(super) flames: Vec<Flame>,
    pub(super) listeners: Vec<Listener>,
    /// Place and loss coefficient of screens.
    pub(super) screens: Vec<(usize, f64)>,
    pub(super) places: Vec<(usize, String)>,
    /// Place of each device, and what it is called in messages.
    pub(super) devices: Vec<(usize, String)>,
    pub(super) tables: Vec<(Item, Table)>,
    pub(super) redraw: Option<Redraw<'a>>,
    /// Whether the file has a mean flow.
    pub(super) flows: bool,
    /// How many times more pieces than the file says its ducts have.
    pub(super) finer: usize,
    /// Of a file whose flow carries entropy waves: what carries them.
    pub(super) carried: Option<Carried>,
    pub(super) passive: bool,
    /// Whether pieces stand for what varies along a duct.
    pub(super) in_pieces: bool,
    pub(super) warnings: Vec<Warning>,
}

impl<'a> Assembly<'a> {
    /// Of nothing yet, for a file with this gas and flow, in so many times more pieces than it says.
    pub(super) fn new(gas: &'a Gas, flow: Option<&Flow>, omega: f64, finer: usize) -> Self {
        let carrying = flow.filter(|flow| flow.entropy_waves);
        Self {
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
            redraw: None,
            flows: flow.is_some(),
            finer,
            carried: carrying.map(|flow| Carried { flow: [flow.mach, flow.velocity], omega }),
            passive: true,
            in_pieces: false,
            warnings: Vec::new(),
        }
    }

    /// The place at `x` (m) of a tube of this length (m), when its ducts are there.
    pub(super) fn place_at(&self, x: f64, length: f64) -> usize {
        if x <= SAME * length {
            return 0;
        }
        let mut end = 0.0;
        let ends = self.segments.iter().map(|s| {
            end += s.length;
            end
        });
        ends.take_while(|end| *end < x + SAME * length).count()
    }

    /// By law: the name of the element whose it is, or what it is.
    pub(super) fn actors(&self) -> Vec<String> {
        let actor = |law: usize| {
            let name = self.laws.name(law);
            let of =
                |(_, device): &(usize, String)| name.strip_prefix(device).is_some_and(|r| r.starts_with(':'));
            let device = self.devices.iter().position(of);
            device.map_or_else(|| "lumped wall losses".to_owned(), |k| self.places[k].1.clone())
        };
        (0..self.laws.laws()).map(actor).collect()
    }
}

/// The mean flow that carries entropy waves, as far as the file says it before the chain is built.
#[derive(Clone, Copy)]
pub(super) struct Carried {
    /// Mach number or velocity (m/s) in the first duct.
    pub(super) flow: [Option<f64>; 2],
    /// Highest frequency of the search, rad/s.
    pub(super) omega: f64,
}

impl Carried {
    /// Change of ln T times the square of omega h/U that pieces of length h leave: the growth rates of a tube
    /// with a choked outlet are right to some 0.1 1/s.
    const RESOLVED: f64 = 0.25;

    /// How many pieces resolve the entropy waves that a temperature between `coldest` and `hottest` (K) makes
    /// along a `length` (m) of the largest area `area` (m^2), where `first` has temperature (K), area and
    /// sound speed of the first duct. Where the phase of a wave turns far from one step to the next, what the
    /// steps radiate together is not what the slope does.
    pub(super) fn pieces(
        &self,
        length: f64,
        [coldest, hottest]: [f64; 2],
        area: f64,
        [temperature, first_area, sound_speed]: [f64; 3],
    ) -> usize {
        let inlet = match self.flow {
            [Some(mach), _] => mach * sound_speed,
            [_, velocity] => velocity.unwrap_or(f64::INFINITY),
        };
        let velocity = inlet * first_area / area * coldest / temperature;
        let turns = self.omega * length / velocity;
        (turns * ((hottest / coldest).ln() / Self::RESOLVED).sqrt()).ceil().clamp(1.0, 1e9) as usize
    }
}

/// A flame as a chain with flow takes it.
pub(super) struct Flame {
    pub(super) place: usize,
    /// k_eu from the velocity at the reference, or Q'/Q from it over its mean.
    pub(super) law: Law,
    pub(super) effect: ActionKind,
    /// Distance of the reference, m, and whether it lies downstream.
    pub(super) reference: f64,
    pub(super) downstream: bool,
}

/// A flame that answers to a velocity elsewhere, in a chain at rest.
pub(super) struct Listener {
    pub(super) item: Item,
    pub(super) place: usize,
    /// Number of the law that is T.
    pub(super) law: usize,
    /// How far away the velocity is, m, and whether it lies downstream.
    pub(super) distance: f64,
    pub(super) downstream: bool,
    /// Of a spread flame: the place of its end, and its pieces.
    pub(super) spread: Option<(usize, Vec<SpreadPiece>)>,
}

impl Redraw<'_> {
    /// Another function in the place of the next table; as it is fitted where none is left.
    pub(super) fn table(&mut self, rows: &[TableRow], tolerance: f64) -> Result<Table, TableError> {
        let Some(table) = self.known.next() else { return Table::fit(rows, tolerance) };
        if self.likely.len() == self.met {
            self.likely.push(Likely::of(rows, table));
        }
        self.met += 1;
        Ok(self.likely[self.met - 1].draw(&mut self.stream).unwrap_or_else(|| table.clone()))
    }
}
