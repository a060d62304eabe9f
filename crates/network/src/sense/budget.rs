//! Where the energy of a mode comes from and where it goes.
//!
//! With p, u the amplitudes of a mode and I = Re(p u*)/2 its intensity, the equations of a segment give
//! exactly d(A I)/dx = -A [sigma (rho |u|^2 + |p|^2/(rho c^2))/2 + Re(kappa_mu) |u|^2/2 + Re(kappa_ep)
//! |p|^2/2], so that 2 sigma E is what crosses the ends and the places minus what the losses take.

use crate::chain::coefficients::Coefficients;
use crate::chain::network::Network;
use crate::chain::sweep::Step;
use crate::chain::workspace::Workspace;
use crate::plane::newton::Root;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// Mean power by mechanism over the energy of a mode, 1/s; positive feeds the mode. Half of each is its share
/// of the growth rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Budget {
    /// 2 sigma, what the others add up to.
    pub growth: f64,
    /// Through the upstream end (radiation: negative), convection included.
    pub upstream: f64,
    /// Through the downstream end.
    pub downstream: f64,
    /// Viscous losses of the ducts.
    pub viscous: f64,
    /// Thermal losses of the ducts.
    pub thermal: f64,
    /// What the mean flow takes where nothing acts, at changes of area, by vortices and entropy waves; 0 at
    /// rest.
    pub mean_flow: f64,
    /// At places where something acts or is heated.
    pub places: Vec<Power>,
}

/// Mean power over energy at one place, 1/s.
#[derive(Clone, Debug, PartialEq)]
pub struct Power {
    /// The place.
    pub place: usize,
    /// All of it.
    pub power: f64,
    /// The parts that laws of the caller have in it; the rest is constant feedback, actions and mean heat of
    /// the chain itself. With mean flow, products of two laws are halved between them.
    pub laws: Vec<(usize, f64)>,
}

impl Budget {
    /// Sum of all entries minus 2 sigma, relative to the sum of their moduli: zero but for rounding if s is
    /// an eigenvalue, and only then, as the power that leaves at the downstream end is what its reflection
    /// coefficient lets pass of the wave that arrives there.
    #[must_use]
    pub fn mismatch(&self) -> f64 {
        let parts = [self.upstream, self.downstream, self.viscous, self.thermal, self.mean_flow];
        let all = parts.into_iter().chain(self.places.iter().map(|p| p.power));
        let (sum, size) = all.fold((0.0, 0.0), |(sum, size), x| (sum + x, size + f64::abs(x)));
        let scale = size.max(self.growth.abs());
        if scale > 0.0 { (sum - self.growth).abs() / scale } else { 0.0 }
    }

    /// Divides every power by the energy of the mode.
    pub(crate) fn per_energy(&mut self, energy: f64) {
        let own = [&mut self.upstream, &mut self.downstream, &mut self.viscous, &mut self.thermal];
        let places = self.places.iter_mut();
        let at_places =
            places.flat_map(|p| std::iter::once(&mut p.power).chain(p.laws.iter_mut().map(|l| &mut l.1)));
        own.into_iter().chain([&mut self.mean_flow]).chain(at_places).for_each(|power| *power /= energy);
    }
}

impl Network {
    /// The energy budget of the mode at `root`, which must be an eigenvalue. Cost: one sweep.
    ///
    /// Valid for compact feedback with real areas; a complex property of a segment counts by its real part.
    ///
    /// # Panics
    /// If a law is attached that `coefficients` do not have.
    #[must_use]
    pub fn budget<K: Coefficients + ?Sized>(
        &self,
        coefficients: &K,
        root: &Root,
        work: &mut Workspace,
    ) -> Budget {
        let s = root.s;
        let mut budget = Budget { growth: 2.0 * s.re, ..Budget::default() };
        let mut energy = 0.0;
        let mut state = [C64::ZERO; 2];
        // Only ratios of areas matter: that of the first segment is 1.
        let mut area = 1.0;
        let mut joints: Vec<([C64; 3], [f64; 2])> = Vec::new();
        self.sweep(coefficients, s, &mut work.laws, |step| match step {
            Step::Joint { j, p, u, jump } => {
                let (p1, u1) = (p.value, u.value);
                if j == 0 {
                    budget.upstream = 0.5 * area * (p1 * u1.conj()).re;
                }
                state = [p1, u1];
                if let Some((k, ratio)) = jump {
                    let [mu, mp, eu, ep] = k.map(|k: ComplexDual| k.value);
                    let p2 = p1 - mu * u1 - mp * p1;
                    state = [p2, ratio.value * u1 - eu * u1 - ep * p1];
                    let before = area;
                    area /= ratio.value.re;
                    let after = area;
                    let power = [
                        -0.5 * before * (mu * u1 * u1.conj()).re,
                        -0.5 * before * (mp * p1 * u1.conj()).re,
                        -0.5 * after * (p2 * (eu * u1).conj()).re,
                        -0.5 * after * (p2 * (ep * p1).conj()).re,
                    ];
                    if power.iter().any(|w| *w != 0.0) {
                        budget.places.push(Power { place: j, power: power.iter().sum(), laws: Vec::new() });
                        joints.push(([p1, u1, p2], [before, after]));
                    }
                }
            }
            Step::Segment { coefficients: [p, q], bare, .. } => {
                let [l, density, compliance] = bare.map(|v| v.re);
                let (z, y) = (p.value / l, q.value / l);
                let [pressure, velocity] = square_integrals(z, y, l, state);
                energy += 0.25 * area * (density * velocity + compliance * pressure);
                budget.viscous -= 0.5 * area * (z - s * density).re * velocity;
                budget.thermal -= 0.5 * area * (y - s * compliance).re * pressure;
            }
            Step::End { p, u, impedances, reflections } => {
                // The sweep is past the jump at place N. Of what arrives, f, the end sends back R f, which is
                // the g of the sweep at an eigenvalue alone.
                let (z, r) = (impedances[1].value, reflections[1].value);
                let f = 0.5 * (p.value + z * u.value);
                budget.downstream = -0.5 * area * ((1.0 + r) * f * ((1.0 - r) * f / z).conj()).re;
            }
        });
        for (at, ([p1, u1, p2], [before, after])) in budget.places.iter_mut().zip(joints) {
            for a in self.attached(1 + 2 * at.place) {
                let k = a.weight * work.laws.value(a.law);
                let power = match a.kind {
                    0 => before * (k * u1 * u1.conj()).re,
                    1 => before * (k * p1 * u1.conj()).re,
                    2 => after * (p2 * (k * u1).conj()).re,
                    _ => after * (p2 * (k * p1).conj()).re,
                };
                at.laws.push((a.law, -0.5 * power));
            }
        }
        budget.per_energy(energy);
        budget
    }
}

/// Integrals of |p|^2 and |u|^2 over a segment of length `l` from the state at its upstream end, with
/// p = a e^{-g x} + b e^{g x}, g = sqrt(Z) sqrt(Y).
fn square_integrals(z: C64, y: C64, l: f64, [p, u]: [C64; 2]) -> [f64; 2] {
    let (g, zc) = (z.sqrt() * y.sqrt(), z.sqrt() / y.sqrt());
    let (a, b) = (0.5 * (p + zc * u), 0.5 * (p - zc * u));
    let forward = a.norm_sqr() * mean_exponential(C64::new(-2.0 * g.re * l, 0.0)).re;
    let backward = b.norm_sqr() * mean_exponential(C64::new(2.0 * g.re * l, 0.0)).re;
    let cross = 2.0 * (a * b.conj() * mean_exponential(C64::new(0.0, -2.0 * g.im * l))).re;
    [l * (forward + backward + cross), l * (forward + backward - cross) / zc.norm_sqr()]
}

/// (e^x - 1)/x.
fn mean_exponential(x: C64) -> C64 {
    if x.norm() < 0.05 {
        // Six terms: the next is x^6/7! < 4e-12 of the last digit kept.
        let mut sum = C64::ONE;
        for k in (2..=9).rev() {
            sum = 1.0 + x / f64::from(k) * sum;
        }
        sum
    } else {
        (x.exp() - 1.0) / x
    }
}
