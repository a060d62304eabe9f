//! The draught: buoyancy against losses gives the mass flow.
//!
//! Knows a tube, its gas and its walls at one moment. Knows neither readings nor what is uncertain.

mod lanes;

use super::march::{Drive, Flow, March};
use super::parameters::TubeParameters;
use super::pipe::Pipe;
use crate::error::FlowError;
use crate::number::{Number, Single};

pub(crate) const GRAVITY: f64 = 9.81;
/// Mass flow below which the gas counts as still, kg/s: half a micrometre per second.
pub(crate) const STILL: f64 = 1e-9;

/// Buoyancy and losses in Pa, of a march with mass flow m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Balance<N> {
    pub(crate) buoyancy: N,
    /// Signed as the flow.
    pub(crate) losses: N,
}

/// A march with the mass flow that balances it, kg/s.
#[derive(Clone, Debug)]
pub struct Draught<N> {
    /// Mass flow, kg/s; zero if still.
    pub mass_flow: N,
    /// The gas at that flow.
    pub march: March<N>,
    plain: March<f64>,
    walls: Vec<f64>,
    /// Last slope of ln(buoyancy/losses) against ln m.
    slope: N,
    marches: usize,
}

impl<N: Number> Draught<N> {
    /// Still gas, not yet marched.
    pub(crate) fn empty() -> Self {
        Self {
            mass_flow: N::constant(0.0),
            march: March { face: Vec::new(), mean: Vec::new(), to_wall: Vec::new() },
            plain: March::default(),
            walls: Vec::new(),
            slope: N::constant(-2.5),
            marches: 0,
        }
    }

    /// A march with the mass flow (kg/s) that balances it.
    pub(crate) fn at(mass_flow: N, march: March<N>) -> Self {
        Self { mass_flow, march, ..Self::empty() }
    }

    /// Gas marches used so far: the unit of cost. Lanes count one by one.
    #[must_use]
    pub fn marches(&self) -> usize {
        self.marches
    }

    /// Where the next search starts: a mass flow and a slope.
    pub(crate) fn guess(&self) -> (N, N) {
        (self.mass_flow, self.slope)
    }

    /// Lets the next search start from `guess`.
    pub(crate) fn start_from(&mut self, guess: (N, N)) {
        (self.mass_flow, self.slope) = guess;
    }
}

impl Pipe {
    /// g int (rho_a - rho) dx and
    /// beta G^2 (v_out - v_in) + (1 + K_e + K_H) G^2 v_in/2 + C_d G^2 <v>_h/2 + (32 G/D^2) int f_p mu v dx.
    pub(crate) fn balance<N: Number>(
        &self,
        march: &March<N>,
        flow: Flow<N>,
        ambient: N,
        p: &TubeParameters<N>,
    ) -> Balance<N> {
        let (air, c) = (&self.air, &self.closures);
        let ambient_density = air.volume(ambient).recip();
        let zero = N::constant(0.0);
        let (mut buoyancy, mut friction, mut heater) = (zero, zero, zero);
        for (cell, &t) in self.cells.iter().zip(&march.mean) {
            let volume = air.volume(t);
            buoyancy = buoyancy + (ambient_density - volume.recip()) * cell.length;
            friction = friction + air.viscosity(t) * volume * (cell.friction * cell.length);
            if cell.heater > 0.0 {
                heater = heater + volume * cell.heater;
            }
        }
        let n = self.cells.len();
        let (down, flow) = (flow.is_down(), flow.signed());
        let (inflow, outflow) = if down { (n, 0) } else { (0, n) };
        let (v_in, v_out) = (air.volume(march.face[inflow]), air.volume(march.face[outflow]));
        let flux = flow * (1.0 / self.area);
        let square = flux * if down { -flux } else { flux };
        let entrance = 0.5 * (1.0 + c.entrance_loss + c.development_loss);
        let inertial = (v_out - v_in) * c.profile_factor + v_in * entrance + p.heater_drag * heater * 0.5;
        let friction = flux * friction * (32.0 / (self.diameter * self.diameter));
        Balance { buoyancy: buoyancy * GRAVITY, losses: square * inertial + friction }
    }

    /// Finds the mass flow, starting from `out.mass_flow`, to `tolerance` in ln(buoyancy/losses), and leaves
    /// the gas at that flow in `out`.
    ///
    /// Secant on ln(buoyancy/losses) against ln m, which is nearly a straight line of slope -2.5; where the
    /// two differ in sign (still gas, or cold walls) a bisection in sinh^{-1}(m).
    ///
    /// # Errors
    /// [`FlowError::NoFlow`] if no flow up to 0.1 kg/s balances.
    pub(crate) fn draught<N: Balanced>(
        &self,
        wall: &[N],
        drive: Drive<N>,
        p: &TubeParameters<N>,
        tolerance: f64,
        out: &mut Draught<N>,
    ) -> Result<(), FlowError> {
        N::draught(self, wall, drive, p, tolerance, out)
    }
}

/// A number for which the mass flow can be found: one at a time, or the lanes together.
pub trait Balanced: Number {
    /// Finds the mass flow through `pipe` with this wall, starting from that in `out`, and leaves the gas at
    /// that flow there: to `tolerance` in the logarithm of buoyancy over losses.
    ///
    /// # Errors
    /// [`FlowError::NoFlow`] if no flow up to 0.1 kg/s balances.
    fn draught(
        pipe: &Pipe,
        wall: &[Self],
        drive: Drive<Self>,
        p: &TubeParameters<Self>,
        tolerance: f64,
        out: &mut Draught<Self>,
    ) -> Result<(), FlowError>;
}

impl<N: Single> Balanced for N {
    fn draught(
        pipe: &Pipe,
        wall: &[N],
        drive: Drive<N>,
        p: &TubeParameters<N>,
        tolerance: f64,
        out: &mut Draught<N>,
    ) -> Result<(), FlowError> {
        let mut plain = std::mem::take(&mut out.plain);
        let mut walls = std::mem::take(&mut out.walls);
        walls.clear();
        walls.extend(wall.iter().map(|w| w.value()));
        let drive_plain = Drive { released: drive.released.value(), ambient: drive.ambient.value() };
        let p_plain = p.plain();
        let mut marches = 0;
        let mut at = |m: f64, plain: &mut March<f64>| {
            marches += 1;
            let flow = Flow::new(m);
            pipe.march(&walls, drive_plain, flow, &p_plain, plain);
            pipe.balance(plain, flow, drive_plain.ambient, &p_plain)
        };
        let mut search = Search::new(out.mass_flow.value(), out.slope.value());
        let found = search
            .run(tolerance, |m| at(m, &mut plain))
            .or_else(|| bisection(tolerance, |m| at(m, &mut plain)));
        out.slope = N::constant(search.slope);
        out.marches += marches;
        let result = match found {
            Some(m) if !N::DERIVATIVES => {
                let copy = |from: &[f64], to: &mut Vec<N>| {
                    to.clear();
                    to.extend(from.iter().map(|&v| N::constant(v)));
                };
                copy(&plain.face, &mut out.march.face);
                copy(&plain.mean, &mut out.march.mean);
                copy(&plain.to_wall, &mut out.march.to_wall);
                out.mass_flow = N::constant(m);
                Ok(())
            }
            Some(m) => {
                let root = N::unknown(m);
                let flow = Flow::new(root);
                pipe.march(wall, drive, flow, p, &mut out.march);
                out.marches += 1;
                let balance = pipe.balance(&out.march, flow, drive.ambient, p);
                let slope = N::slope(balance.buoyancy - balance.losses);
                let settle = |values: &mut Vec<N>| values.iter_mut().for_each(|v| *v = v.settle(&slope));
                settle(&mut out.march.face);
                settle(&mut out.march.mean);
                settle(&mut out.march.to_wall);
                out.mass_flow = root.settle(&slope);
                Ok(())
            }
            None => {
                let (coldest, hottest) =
                    walls.iter().fold((f64::NAN, f64::NAN), |(a, b), &w| (a.min(w), b.max(w)));
                Err(FlowError::NoFlow { coldest, hottest })
            }
        };
        out.plain = plain;
        out.walls = walls;
        result
    }
}

/// Marches that the secant may take.
const TRIES: usize = 25;

/// What a march told the secant.
#[derive(Clone, Copy)]
enum Step {
    /// March at this flow.
    Next(f64),
    /// The gas is left at this flow, which balances.
    Found(f64),
    /// No root on this side.
    Lost,
}

/// The secant for one mass flow.
struct Search {
    sign: f64,
    /// ln |m|.
    y: f64,
    slope: f64,
    last: Option<(f64, f64)>,
}

impl Search {
    fn new(guess: f64, slope: f64) -> Self {
        let sign = if guess < 0.0 { -1.0 } else { 1.0 };
        Self { sign, y: guess.abs().clamp(1e-7, 0.05).ln(), slope, last: None }
    }

    fn is_down(&self) -> bool {
        self.sign < 0.0
    }

    fn flow(&self) -> f64 {
        self.sign * self.y.exp()
    }

    fn run(&mut self, tolerance: f64, mut at: impl FnMut(f64) -> Balance<f64>) -> Option<f64> {
        let mut flow = self.flow();
        for _ in 0..TRIES {
            let balance = at(flow);
            match self.judge(balance.buoyancy, balance.losses, tolerance) {
                Step::Next(next) => flow = next,
                Step::Found(flow) => return Some(flow),
                Step::Lost => return None,
            }
        }
        None
    }

    /// What to do after the march at the present flow.
    fn judge(&mut self, buoyancy: f64, losses: f64, tolerance: f64) -> Step {
        let ratio = buoyancy / losses;
        if ratio.is_nan() || ratio <= 0.0 || self.y < STILL.ln() {
            return Step::Lost;
        }
        let error = ratio.ln();
        if error.abs() < tolerance {
            return Step::Found(self.flow());
        }
        if let Some((y0, e0)) = self.last
            && (self.y - y0).abs() > 1e-9
        {
            self.slope = ((error - e0) / (self.y - y0)).clamp(-20.0, -0.3);
        }
        self.last = Some((self.y, error));
        self.y += (-error / self.slope).clamp(-1.5, 1.5);
        Step::Next(self.flow())
    }
}

fn bisection(tolerance: f64, mut at: impl FnMut(f64) -> Balance<f64>) -> Option<f64> {
    let flow = |u: f64| {
        let m = STILL * u.sinh();
        if m.abs() < STILL { STILL.copysign(if u < 0.0 { -1.0 } else { 1.0 }) } else { m }
    };
    let (mut low, mut high) = (-(2e8_f64.ln()), 2e8_f64.ln()); // -0.1 to 0.1 kg/s
    let mut excess = |u: f64| {
        let balance = at(flow(u));
        balance.buoyancy - balance.losses
    };
    let (bottom, top) = (excess(low), excess(high));
    if !(bottom > 0.0 && top < 0.0) {
        return None;
    }
    while high - low > tolerance.max(1e-12) {
        let middle = 0.5 * (low + high);
        let e = excess(middle);
        if e.is_nan() {
            return None;
        }
        if e > 0.0 {
            low = middle
        } else {
            high = middle
        }
        if high.abs() < 0.88 && low.abs() < 0.88 {
            break; // still gas
        }
    }
    let m = flow(0.5 * (low + high));
    at(m);
    Some(m)
}
