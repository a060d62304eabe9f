//! The gas: a march through the cells from the inflow end, quasi-steady.

use super::parameters::TubeParameters;
use super::pipe::{Cell, Pipe};
use crate::number::{Number, Single};

/// Gas temperatures along the tube for one wall, one released power and one mass flow.
#[derive(Clone, Debug, Default)]
pub struct March<N> {
    /// At the faces, K.
    pub face: Vec<N>,
    /// Mean over each cell, K.
    pub mean: Vec<N>,
    /// Heat from the gas to the wall in each cell, W.
    pub to_wall: Vec<N>,
}

impl<N: Copy> March<N> {
    /// Room for `cells` cells.
    pub(crate) fn resize(&mut self, cells: usize, blank: N) {
        self.face.resize(cells + 1, blank);
        self.mean.resize(cells, blank);
        self.to_wall.resize(cells, blank);
    }
}

/// What drives the march, besides the wall.
#[derive(Clone, Copy, Debug)]
pub struct Drive<N> {
    /// Power released by the heater, W.
    pub released: N,
    /// Ambient temperature, K.
    pub ambient: N,
}

/// (1 - e^{-z})/z and (z - 1 + e^{-z})/z^2 for z >= 0, without cancellation.
///
/// With chi = (1/2 - z + ... )/z = sum (-z)^k/(k + 3)!, psi = 1/2 - z chi and phi = 1 - z psi; the
/// derivatives are phi' = psi - phi and psi' = 2 chi - psi.
pub(crate) fn relaxation<N: Number>(z: N) -> (N, N) {
    z.map2(|v| {
        let chi = if v < 0.6 {
            // Eleven terms: the next is below 1e-14 of the first.
            const FACTORIALS: [f64; 11] = [
                6.0,
                24.0,
                120.0,
                720.0,
                5040.0,
                40_320.0,
                362_880.0,
                3_628_800.0,
                39_916_800.0,
                479_001_600.0,
                6_227_020_800.0,
            ];
            FACTORIALS.iter().rev().fold(0.0, |sum, f| 1.0 / f - v * sum)
        } else {
            (0.5 - (v - 1.0 + (-v).exp()) / (v * v)) / v
        };
        let psi = 0.5 - v * chi;
        let phi = 1.0 - v * psi;
        [(phi, psi - phi), (psi, 2.0 * chi - psi)]
    })
}

/// A temperature inside the range of the heat capacity. Only trial flows that almost stand still leave it, on
/// the way to a mass flow that does not.
fn limited<N: Number>(t: N) -> N {
    t.map(|t| {
        let inside = t.clamp(150.0, 2000.0);
        (inside, if inside == t { 1.0 } else { 0.0 })
    })
}

/// A mass flow with what the cells need of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow<N> {
    /// Its size, kg/s.
    size: N,
    inverse: N,
    /// 0.04 (4 m/pi)^{2/3}.
    thirds: N,
    down: bool,
}

impl<N: Number> Flow<N> {
    /// Of a positive size, up or down the tube.
    pub(crate) fn along(size: N, down: bool) -> Self {
        let thirds = (size * (4.0 / std::f64::consts::PI)).two_thirds() * 0.04;
        Self { size, inverse: size.recip(), thirds, down }
    }

    /// Whether it goes down the tube.
    pub(crate) fn is_down(&self) -> bool {
        self.down
    }

    /// Positive upward, kg/s.
    pub(crate) fn signed(&self) -> N {
        if self.down { -self.size } else { self.size }
    }
}

impl<N: Single> Flow<N> {
    /// Of a mass flow positive upward, not zero.
    pub(crate) fn new(signed: N) -> Self {
        let down = signed.value() < 0.0;
        Self::along(if down { -signed } else { signed }, down)
    }
}

impl Pipe {
    /// Heat that reaches the gas directly in a cell, W.
    pub(crate) fn source<N: Number>(&self, cell: &Cell, released: N, wall_share: N) -> N {
        let c = &self.closures;
        let direct = -wall_share + (1.0 - c.wire_share - c.radiated_share);
        released * (direct * cell.heater + c.wire_share * cell.wire)
    }

    /// One cell in the direction of the flow: outflow temperature, mean temperature, heat to the wall. Exact
    /// for a uniform wall, a uniform source and properties frozen at the mean temperature; second order in
    /// the cell.
    pub(crate) fn cell<N: Number>(
        &self,
        cell: &Cell,
        flow: Flow<N>,
        inflow: N,
        wall: N,
        source: N,
        p: &TubeParameters<N>,
    ) -> (N, N, N) {
        let (air, down) = (&self.air, usize::from(flow.down));
        // (3) with Hausen's mean Nusselt number: xi Nu_m = 3.66 xi + 0.0668 a/(1 + 0.04 (a/xi)^{2/3}),
        // a = 4 m c_p/(pi k); its difference over the cell is exact on any grid. Number of transfer units
        // pi k Nu dx/(m c_p) = (4/a) [xi Nu].
        let (low, high) = (cell.entry[down].low, cell.entry[down].high);
        let enhanced = p.inner_nusselt * (p.jet_enhancement * cell.jet[down] + 1.0);
        let units = |t: N| {
            let (ratio, thirds) = air.diffusion(t);
            let a23 = flow.thirds * thirds;
            let entry = a23.map(|v| {
                let developing = v * (high - low) / ((v + high) * (v + low));
                let slope = (low * high - v * v) * (high - low) / ((v + high) * (v + low)).powi(2);
                (4.0 * 0.0668 * developing, 4.0 * 0.0668 * slope)
            });
            enhanced * (flow.inverse * ratio * (std::f64::consts::PI * 3.66 * cell.length) + entry)
        };
        let heated = cell.heater > 0.0 || cell.wire > 0.0;
        let rise = |t: N| {
            if heated { source * flow.inverse / air.specific_heat(limited(t)) } else { N::constant(0.0) }
        };
        // Predict the mean from the properties at the inflow (Pade form), then take the properties there.
        let z = units(inflow);
        let mean = inflow + ((wall - inflow) * z + rise(inflow)) / (z + 2.0);
        let (z, rise) = (units(mean), rise(mean));
        let (phi, psi) = relaxation(z);
        let outflow = inflow + ((wall - inflow) * z + rise) * phi;
        let mean = inflow + ((wall - inflow) * z + rise) * psi;
        let to_wall = flow.size * (air.enthalpy(inflow) - air.enthalpy(outflow)) + source;
        (outflow, mean, to_wall)
    }

    /// Marches the gas through all cells.
    pub(crate) fn march<N: Number>(
        &self,
        wall: &[N],
        drive: Drive<N>,
        flow: Flow<N>,
        p: &TubeParameters<N>,
        out: &mut March<N>,
    ) {
        let n = self.cells.len();
        out.resize(n, N::constant(0.0));
        let mut t = drive.ambient;
        out.face[if flow.down { n } else { 0 }] = t;
        for step in 0..n {
            let i = if flow.down { n - 1 - step } else { step };
            let cell = &self.cells[i];
            let source = self.source(cell, drive.released, p.wall_share);
            let (outflow, mean, to_wall) = self.cell(cell, flow, t, wall[i], source, p);
            out.mean[i] = mean;
            out.to_wall[i] = to_wall;
            t = outflow;
            out.face[if flow.down { i } else { i + 1 }] = t;
        }
    }
}
