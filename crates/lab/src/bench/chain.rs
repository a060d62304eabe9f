//! One operating point as a chain of stretches, and the march through it.

use super::base::{Base, within};
use super::campaign::Point;
use super::ends::End;
use super::error::BenchError;
use super::parts::Branch;
use super::response::{Response, wire_sensitivity};
use super::truth::BenchTruth;
use super::value::is_present;
use crate::acoustics::duct::Stretch;
use crate::acoustics::obstacle::{Obstacle, end_correction};
use crate::acoustics::walls::{Line, Section};
use rijke_numerics::C64;
use rijke_rig::GasState;
use std::f64::consts::PI;

/// A chain from upstream to downstream.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pieces: Vec<Piece>,
    ends: [End; 2],
    sources: Vec<Source>,
    microphones: usize,
}

#[derive(Clone, Debug)]
enum Piece {
    /// A stretch of duct: length, its medium at the two Gauss points, and u/c^2 in its middle.
    Line { length: f64, media: Box<[Medium; 2]>, drift: f64 },
    /// A change of area: inertia, kg/m^4, and what the mean flow takes, Pa s/m^3.
    Step { inertance: f64, flow: f64 },
    /// Wires, a grid.
    Obstacle(Box<Obstacle>),
    /// A side branch.
    Branch(Box<Branch>),
    /// Here is the velocity that this source answers to.
    Reference(usize),
    /// Here this source begins.
    Begin(usize),
    /// A share of this source: the volume velocity that its heat adds per reference velocity; the momentum
    /// that takes per volume velocity, Pa s/m^3; and what the mean acceleration takes per volume velocity at
    /// the source's beginning.
    Heat { source: usize, factor: f64, momentum: f64, acceleration: f64 },
    /// A microphone.
    Microphone(usize),
}

/// What a stretch is filled with.
#[derive(Clone, Debug)]
struct Medium {
    section: Section,
    gas: GasState,
    /// Density times the slope of the mean velocity, kg/(m^3 s); 0 in a source, whose share is in its heat.
    momentum: f64,
    /// Slope of the mean velocity, 1/s.
    stretching: f64,
}

/// A source at one operating point.
#[derive(Clone, Debug)]
struct Source {
    response: Response,
    /// The sum of its shares at low frequency: relative change of velocity behind it per relative change
    /// before it.
    gain: f64,
}

/// One march for unit incident pressure at the upstream end.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    /// Pressure at the microphones, Pa.
    pub(crate) pressures: Vec<C64>,
    /// What is missing at the downstream end, times a factor that is analytic and has no zero there; zero at
    /// an eigenvalue.
    pub(crate) drive: C64,
}

/// Longest step where the gas is not uniform, m.
const STEP: f64 = 0.01;
/// Slices of a source.
const SLICES: usize = 16;

impl Chain {
    /// The chain of `truth` at `point` with the mean state `base`.
    pub(crate) fn new(truth: &BenchTruth, point: &Point, base: &Base) -> Result<Self, BenchError> {
        let section = |k: usize| Section {
            radius: 0.5 * base.ducts[k][1],
            roughness: truth.duct[k].layers,
            rods: vec![],
        };
        let velocity = |x: f64| base.mass_flow / (base.gas(x).density * section(base.duct(x)).open_area());
        let length = base.length();
        let mut marks: Vec<(f64, Piece)> = Vec::new();
        for (m, x) in truth.microphones.at.iter().enumerate() {
            marks.push((*x, Piece::Microphone(m)));
        }
        for (k, x) in base.boundaries().into_iter().enumerate() {
            let gas = base.gas(x);
            marks.push((x, step(base, &gas, [section(k), section(k + 1)], truth.added_mass)));
        }
        for obstacle in truth.obstacle.iter().filter(|o| is_present(o.present.as_ref(), point)) {
            let x = obstacle.at.at(point)?;
            let area = section(base.duct(x)).open_area();
            let piece = obstacle.obstacle(base.gas(x), area, base.mass_flow / area);
            marks.push((x, Piece::Obstacle(Box::new(piece))));
        }
        for branch in truth.branch.iter().filter(|b| is_present(b.present.as_ref(), point)) {
            let x = branch.at.at(point)?;
            let gas = branch.temperature.map_or_else(|| base.gas(x), |t| base.gas_at(t));
            let piece = branch.branch(
                gas,
                section(base.duct(x)).radius,
                branch.cavity_depth.at(point)?,
                truth.added_mass,
            );
            marks.push((x, Piece::Branch(Box::new(piece))));
        }
        let mut sources = Vec::new();
        for (source, place) in truth.source.iter().zip(&base.sources) {
            let Some([begin, thickness, heat]) = *place else { continue };
            let reference = begin - source.reference;
            let area = section(base.duct(reference)).open_area();
            let speed = velocity(reference);
            let sensitivity = match (&source.sensitivity, source.wire) {
                (Some(value), _) => value.at(point)?,
                (None, Some(wire)) => wire_sensitivity(wire, base.law(), &base.gas(begin), speed, heat),
                (None, None) => 0.0,
            };
            let number = sources.len();
            marks.push((reference, Piece::Reference(number)));
            let mut gain = 0.0;
            let local = section(base.duct(begin)).open_area();
            for k in 0..SLICES {
                let x = begin + thickness * (k as f64 + 0.5) / SLICES as f64;
                let gas = base.gas(x);
                let expansion = (gas.gamma - 1.0) / (gas.gamma * gas.pressure) * heat * sensitivity;
                let factor = expansion / (area * speed) / SLICES as f64;
                gain += factor;
                let momentum = base.mass_flow / local.powi(2);
                let half = 0.5 * thickness / SLICES as f64;
                // The fluctuating mass flux through a source is that before it: spots of entropy are taken to
                // be longer.
                let acceleration =
                    base.gas(begin).density * (velocity(x + half) - velocity(x - half)) / local;
                marks.push((x, Piece::Heat { source: number, factor, momentum, acceleration }));
            }
            // Edges, so that every step lies within the source or outside.
            let edge = Piece::Step { inertance: 0.0, flow: 0.0 };
            marks.extend([(begin, Piece::Begin(number)), (begin + thickness, edge)]);
            sources.push(Source { response: source.response(speed), gain });
        }
        let mut pieces = Vec::new();
        let mut x = 0.0;
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (x, _) in &marks {
            within(point, "a place, m from the upstream end,", *x, 0.0, length)?;
        }
        let last = (length, Piece::Step { inertance: 0.0, flow: 0.0 });
        for (mark, piece) in marks.into_iter().chain([last]) {
            if mark > x {
                let duct = section(base.duct(0.5 * (x + mark)));
                lines(base, &duct, [x, mark], &mut pieces);
                x = mark;
            }
            pieces.push(piece);
        }
        let end = |k: usize, x: f64| (base.gas(x), 0.5 * base.ducts[k][1], velocity(x));
        let (up, down) = (end(0, 0.0), end(base.ducts.len() - 1, length));
        let ends = [truth.upstream.end(up.0, up.1, up.2), truth.downstream.end(down.0, down.1, down.2)];
        Ok(Self { pieces, ends, sources, microphones: truth.microphones.at.len() })
    }

    /// Marches from the upstream to the downstream end at complex frequency `s`.
    pub(crate) fn march(&self, s: C64) -> Shot {
        let [up, down] = &self.ends;
        let r = up.reflection(s);
        // f = R g with g = 1.
        let (mut p, mut u) = (r + 1.0, (r - 1.0) / up.wave_impedance());
        // What side branches would add as poles, taken out at the end.
        let mut poles = C64::ONE;
        let mut pressures = vec![C64::ZERO; self.microphones];
        let mut heard = vec![C64::ZERO; self.sources.len()];
        let mut begun = heard.clone();
        let responses: Vec<C64> = self.sources.iter().map(|source| source.response.at(s)).collect();
        for piece in &self.pieces {
            match piece {
                Piece::Line { length, media, drift } => {
                    let [lower, upper] = [media[0].line(s), media[1].line(s)];
                    let carried = (s * *drift * *length).exp();
                    (p, u) = Stretch::new(&lower, &upper, *length).ascend((p * carried, u * carried));
                }
                Piece::Step { inertance, flow } => p += (*flow - s * *inertance) * u,
                Piece::Obstacle(obstacle) => {
                    p -= obstacle.impedance(s) * u;
                    u -= obstacle.admittance(s) * p;
                }
                Piece::Branch(branch) => {
                    let (taken, driving) = branch.opening(s);
                    u -= taken / driving * p;
                    poles *= driving;
                }
                Piece::Reference(source) => heard[*source] = u,
                Piece::Begin(source) => begun[*source] = u,
                Piece::Heat { source, factor, momentum, acceleration } => {
                    let added = *factor * responses[*source] * heard[*source];
                    u += added;
                    p -= *momentum * added + *acceleration * begun[*source];
                }
                Piece::Microphone(m) => pressures[*m] = p,
            }
        }
        let r = down.reflection(s);
        let missing = 0.5 * ((1.0 - r) * p - (1.0 + r) * down.wave_impedance() * u);
        Shot { pressures, drive: missing * poles }
    }

    /// The k_eu of every source at complex frequency `s`: -(u2' - u1')/u1'.
    pub(crate) fn feedback(&self, s: C64) -> Vec<C64> {
        self.sources.iter().map(|source| -source.gain * source.response.at(s)).collect()
    }
}

impl Medium {
    fn line(&self, s: C64) -> Line {
        let line = self.section.line(&self.gas, s);
        let area = self.section.open_area();
        Line {
            impedance: line.impedance + self.momentum / area,
            admittance: line.admittance + self.stretching * area / self.gas.pressure,
        }
    }
}

/// Pushes the stretches from `from` to `to`.
fn lines(base: &Base, section: &Section, [from, to]: [f64; 2], pieces: &mut Vec<Piece>) {
    let uniform = base.is_uniform(from, to);
    let cells = if uniform { 1.0 } else { ((to - from) / STEP).ceil().max(1.0) };
    let h = (to - from) / cells;
    let is_source = base.sources.iter().flatten().any(|s| from >= s[0] - 1e-12 && to <= s[0] + s[1] + 1e-12);
    let area = section.open_area();
    let medium = |x: f64| {
        let (gas, slope) = (base.gas(x), base.temperature(x)[1]);
        let stretching = base.mass_flow / (gas.density * area) * slope / gas.temperature;
        let momentum = if is_source { 0.0 } else { gas.density * stretching };
        Medium { section: section.clone(), gas, momentum, stretching }
    };
    for k in 0..cells as usize {
        let middle = from + (k as f64 + 0.5) * h;
        let offset = h / 12.0_f64.sqrt();
        let gas = base.gas(middle);
        let drift = base.mass_flow / (gas.density * area) / gas.sound_speed.powi(2);
        let media = Box::new([medium(middle - offset), medium(middle + offset)]);
        pieces.push(Piece::Line { length: h, media, drift });
    }
}

/// A change from one section to another in uniform gas.
fn step(base: &Base, gas: &GasState, [before, after]: [Section; 2], added_mass: bool) -> Piece {
    let (r1, r2) = (before.radius, after.radius);
    let (a1, a2) = (before.open_area(), after.open_area());
    let (small, large) = (r1.min(r2), r1.max(r2));
    let inertance = if r1 == r2 || !added_mass {
        0.0
    } else {
        gas.density * end_correction(small, large) / (PI * small.powi(2))
    };
    // To first order in the mean flow: a contraction keeps p + rho u^2/2, an expansion p A2 + rho u^2 A.
    let flow = if a2 < a1 { 1.0 / a1.powi(2) - 1.0 / a2.powi(2) } else { 2.0 / (a1 * a2) - 2.0 / a2.powi(2) };
    Piece::Step { inertance, flow: base.mass_flow * flow }
}
