//! Coefficients from a closure, and the rig tube of the reference file.

use rijke_network::wall::Wall;
use rijke_network::{At, Coefficients, Laws, Network, Newton, Root, Segment, Slot, Workspace};
use rijke_numerics::C64;

pub(crate) struct Given<F> {
    pub(crate) parameters: usize,
    pub(crate) laws: usize,
    pub(crate) fill: F,
}

impl<F: Fn(&At, &mut Laws)> Coefficients for Given<F> {
    fn parameters(&self) -> usize {
        self.parameters
    }
    fn laws(&self) -> usize {
        self.laws
    }
    fn fill(&self, at: &At, laws: &mut Laws) {
        (self.fill)(at, laws);
    }
}

pub(crate) fn given<F: Fn(&At, &mut Laws)>(parameters: usize, laws: usize, fill: F) -> Given<F> {
    Given { parameters, laws, fill }
}

pub(crate) fn c(re: f64, im: f64) -> C64 {
    C64::new(re, im)
}

pub(crate) fn root<K: Coefficients>(net: &Network, k: &K, guess: C64) -> Root {
    net.solve(k, guess, &Newton::default(), &mut Workspace::default()).unwrap()
}

pub(crate) const RIG: Wall = Wall {
    density: 1.2041,
    sound_speed: 343.2,
    viscosity: 1.8134e-5,
    prandtl: 0.71,
    gamma: 1.4,
    diameter: 0.0474,
};

pub(crate) fn rig_segment() -> Segment {
    Segment::new(1.0, 1.765e-3, RIG.sound_speed, RIG.density)
}

/// Both ends constant, 0.9975 exp(3.0550 i).
pub(crate) fn close_with_paper_ends(net: &mut Network) {
    let r = C64::from_polar(0.9975, 3.0550);
    net.set(Slot::Upstream, r).unwrap();
    net.set(Slot::Downstream, r).unwrap();
}

/// The paper's wall law as laws 0 (viscous) and 1 (thermal).
pub(crate) fn paper_wall(at: &At, laws: &mut Laws) {
    let loss = RIG.paper(at.s());
    laws.set_analytic(0, loss.viscous);
    laws.set_analytic(1, loss.thermal);
}
