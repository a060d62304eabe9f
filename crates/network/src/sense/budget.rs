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

/// Mean power by mechanism over the energy of the mode, 1/s; positive feeds the mode. Half of each is its
/// share of the growth rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Budget {
    /// 2 sigma, what the others must add up to.
    pub growth: f64,
    /// Through the upstream end (radiation: negative).
    pub upstream: f64,
    /// Through the downstream end.
    pub downstream: f64,
    /// Viscous losses in the segments.
    pub viscous: f64,
    /// Thermal losses in the segments.
    pub thermal: f64,
    /// At places with feedback.
    pub places: Vec<Exchange>,
}

/// Mean power over energy at one place, 1/s, by feedback coefficient.
#[derive(Clone, Debug, PartialEq)]
pub struct Exchange {
    /// The place.
    pub place: usize,
    /// By k_mu, k_mp, k_eu (an area change, which carries no power, excluded) and k_ep.
    pub power: [f64; 4],
    /// The same by law that acts there: number of the law, power. Constant feedback of the network itself is
    /// not among them.
    pub laws: Vec<(usize, f64)>,
}

impl Budget {
    /// Sum of all entries minus 2 sigma, relative to the sum of their moduli: zero but for rounding if s is
    /// an eigenvalue, and only then, as the power that leaves at the downstream end is what its reflection
    /// coefficient lets pass of the wave that arrives there.
    #[must_use]
    pub fn mismatch(&self) -> f64 {
        let places = self.places.iter().flat_map(|e| e.power);
        let all = [self.upstream, self.downstream, self.viscous, self.thermal].into_iter().chain(places);
        let (sum, size) = all.fold((0.0, 0.0), |(sum, size), x| (sum + x, size + f64::abs(x)));
        let scale = size.max(self.growth.abs());
        if scale > 0.0 { (sum - self.growth).abs() / scale } else { 0.0 }
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
                        budget.places.push(Exchange { place: j, power, laws: Vec::new() });
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
        let per_energy = energy.recip();
        for entry in [&mut budget.upstream, &mut budget.downstream, &mut budget.viscous, &mut budget.thermal]
        {
            *entry *= per_energy;
        }
        for (exchange, ([p1, u1, p2], [before, after])) in budget.places.iter_mut().zip(joints) {
            exchange.power = exchange.power.map(|w| w * per_energy);
            for a in self.attached(1 + 2 * exchange.place) {
                let k = a.weight * work.laws.value(a.law);
                let power = match a.kind {
                    0 => before * (k * u1 * u1.conj()).re,
                    1 => before * (k * p1 * u1.conj()).re,
                    2 => after * (p2 * (k * u1).conj()).re,
                    _ => after * (p2 * (k * p1).conj()).re,
                };
                exchange.laws.push((a.law, -0.5 * per_energy * power));
            }
        }
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
