//! One sweep of the state (p, u) through the chain: the characteristic function F(s) and its derivative.

use super::block::{LANES, Lines, Passages};
use super::coefficients::{At, Coefficients, Laws};
use super::line::Line;
use super::network::{AREA, Attachment, DENSITY, LENGTH, Network, SOUND_SPEED, THERMAL, VISCOUS};
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// What a sweep passes, with the state just before it.
pub(crate) enum Step<'a> {
    /// Feedback k_mu, k_mp, k_eu, k_ep and the ratio of areas at place `j`; also visited where nothing jumps.
    Joint { j: usize, p: ComplexDual, u: ComplexDual, jump: Option<&'a ([ComplexDual; 4], ComplexDual)> },
    /// The next segment: P, Q, the line functions at PQ, and its length, density and compressibility 1/(rho
    /// c^2).
    Segment { line: &'a Line, coefficients: [ComplexDual; 2], bare: [C64; 3] },
    /// The end, with impedances and reflections of both ends.
    End { p: ComplexDual, u: ComplexDual, impedances: [ComplexDual; 2], reflections: [ComplexDual; 2] },
}

/// Splits off the attachments of `key` from the front of a sorted list.
#[inline]
pub(crate) fn take<'a>(rest: &mut &'a [Attachment], key: usize) -> &'a [Attachment] {
    let count = rest.iter().take_while(|a| a.key == key).count();
    let (here, later) = rest.split_at(count);
    *rest = later;
    here
}

#[inline]
fn sum(base: C64, here: &[Attachment], kind: usize, laws: &Laws) -> ComplexDual {
    let mut total = ComplexDual::constant(base);
    for a in here.iter().filter(|a| a.kind == kind) {
        total.value += a.weight * laws.value(a.law);
        total.slope += a.weight * laws.slope(a.law);
    }
    total
}

impl Network {
    /// Everything attached to one key, for the few places that look out of order.
    pub(crate) fn attached(&self, key: usize) -> &[Attachment] {
        let start = self.attachments.partition_point(|a| a.key < key);
        let end = self.attachments.partition_point(|a| a.key <= key);
        &self.attachments[start..end]
    }

    /// One of the four properties of segment `i`.
    pub(crate) fn property(&self, i: usize, kind: usize, laws: &Laws) -> ComplexDual {
        sum(C64::new(self.constant_property(i, kind), 0.0), self.attached(2 + 2 * i), kind, laws)
    }

    pub(crate) fn constant_property(&self, i: usize, kind: usize) -> f64 {
        let s = &self.segments[i];
        match kind {
            LENGTH => s.length,
            AREA => s.area,
            SOUND_SPEED => s.sound_speed,
            _ => s.density,
        }
    }

    /// The area before place `j` over that behind it, which a jump of areas multiplies the velocity with.
    pub(crate) fn area_ratio(&self, j: usize, laws: &Laws) -> C64 {
        if j == 0 || j == self.segments.len() {
            return C64::ONE;
        }
        self.property(j - 1, AREA, laws).value / self.property(j, AREA, laws).value
    }

    /// P = l (s rho + kappa_mu) and Q = l (s/(rho c^2) + kappa_ep) of segment `i`, and l, rho, 1/(rho c^2).
    #[inline(always)]
    pub(crate) fn line_coefficients(
        &self,
        i: usize,
        s: C64,
        here: &[Attachment],
        laws: &Laws,
    ) -> ([ComplexDual; 2], [C64; 3]) {
        let segment = &self.segments[i];
        let [mut mu, mut ep] = self.losses[i].map(ComplexDual::constant);
        for a in here {
            if a.kind < VISCOUS {
                return self.varied_coefficients(i, s, here, laws);
            }
            // Both sums stay in registers, which an index would not let them.
            let more =
                ComplexDual { value: a.weight * laws.value(a.law), slope: a.weight * laws.slope(a.law) };
            if a.kind == VISCOUS {
                mu = mu + more;
            } else {
                ep = ep + more;
            }
        }
        let (l, inertia) = (segment.length, segment.density);
        let compliance = 1.0 / (segment.density * segment.sound_speed * segment.sound_speed);
        let p = ComplexDual { value: (s * inertia + mu.value) * l, slope: (mu.slope + inertia) * l };
        let q = ComplexDual { value: (s * compliance + ep.value) * l, slope: (ep.slope + compliance) * l };
        let real = |v| C64::new(v, 0.0);
        ([p, q], [real(l), real(inertia), real(compliance)])
    }

    /// The same where laws act on length, speed or density.
    #[cold]
    fn varied_coefficients(
        &self,
        i: usize,
        s: C64,
        here: &[Attachment],
        laws: &Laws,
    ) -> ([ComplexDual; 2], [C64; 3]) {
        let s = ComplexDual { value: s, slope: C64::ONE };
        let [mu, ep] = self.losses[i];
        let (mu, ep) = (sum(mu, here, VISCOUS, laws), sum(ep, here, THERMAL, laws));
        let l = self.property(i, LENGTH, laws);
        let (c, rho) = (self.property(i, SOUND_SPEED, laws), self.property(i, DENSITY, laws));
        let compliance = (rho * c * c).recip();
        ([l * (s * rho + mu), l * (s * compliance + ep)], [l.value, rho.value, compliance.value])
    }

    /// Whether the state jumps at place `j` by constants alone.
    #[inline(always)]
    pub(crate) fn jumps(&self, j: usize) -> bool {
        let n = self.segments.len();
        self.feedback[j].iter().any(|k| *k != C64::ZERO)
            || (j > 0 && j < n && self.segments[j - 1].area != self.segments[j].area)
    }

    /// F(s) and F'(s), where F = g - R_d f at the downstream end for a wave g = 1 at the upstream end.
    ///
    /// F is an entire function of s if all laws are; its zeros are the eigenvalues. Cost: one pass over the
    /// chain, about fifty complex products per segment. Allocates nothing once `laws` has grown.
    pub(crate) fn characteristic<K: Coefficients + ?Sized>(
        &self,
        k: &K,
        s: C64,
        laws: &mut Laws,
    ) -> ComplexDual {
        self.sweep(k, s, laws, |_| ())
    }

    /// [`Network::characteristic`], telling `visit` of every step.
    #[inline]
    pub(crate) fn sweep<K: Coefficients + ?Sized>(
        &self,
        k: &K,
        s: C64,
        laws: &mut Laws,
        visit: impl FnMut(Step<'_>),
    ) -> ComplexDual {
        let at = At::search(s);
        laws.reset(k.laws(), &at);
        k.fill(&at, laws);
        pulp::Arch::new().dispatch(Sweep { network: self, s, laws, visit })
    }

    /// k_mu, k_mp, k_eu, k_ep and the ratio of areas at place `j`.
    #[cold]
    fn jump(
        &self,
        j: usize,
        here: &[Attachment],
        area_laws: bool,
        laws: &Laws,
    ) -> ([ComplexDual; 4], ComplexDual) {
        let [mu, mp, eu, ep] = self.feedback[j];
        let inside = j > 0 && j < self.segments.len();
        let ratio = if area_laws && inside {
            self.property(j - 1, AREA, laws) * self.property(j, AREA, laws).recip()
        } else if inside {
            ComplexDual::real(self.segments[j - 1].area / self.segments[j].area)
        } else {
            ComplexDual::real(1.0)
        };
        let (mu, mp) = (sum(mu, here, 0, laws), sum(mp, here, 1, laws));
        let (eu, ep) = (sum(eu, here, 2, laws), sum(ep, here, 3, laws));
        ([mu, mp, eu, ep], ratio)
    }
}

struct Sweep<'a, V> {
    network: &'a Network,
    s: C64,
    laws: &'a Laws,
    visit: V,
}

impl<V: FnMut(Step<'_>)> pulp::WithSimd for Sweep<'_, V> {
    type Output = ComplexDual;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> ComplexDual {
        if S::IS_SCALAR { self.run::<false>() } else { self.run::<true>() }
    }
}

impl<V: FnMut(Step<'_>)> Sweep<'_, V> {
    #[inline(always)]
    fn run<const FUSED: bool>(self) -> ComplexDual {
        let Self { network, s, laws, mut visit } = self;
        let n = network.segments.len();
        let one = ComplexDual::real(1.0);
        let area_laws = network.attachments.iter().any(|a| a.kind == AREA && a.key % 2 == 0 && a.key > 0);
        let mut rest = network.attachments.as_slice();
        let upstream = sum(network.ends[0], take(&mut rest, 0), 0, laws);
        let impedance =
            |i: usize| network.property(i, DENSITY, laws) * network.property(i, SOUND_SPEED, laws);
        let z_upstream = impedance(0);
        let joints = Joints { network, laws, area_laws };
        let (mut p, mut u) = (one + upstream, (upstream - one) * z_upstream.recip());
        let (mut lines, mut passages) = (Lines::ZERO, Passages::ZERO);
        for first in (0..n).step_by(LANES) {
            let count = LANES.min(n - first);
            let mut attached: [&[Attachment]; LANES] = [&[]; LANES];
            let mut bare = [[C64::ZERO; 3]; LANES];
            for i in 0..count {
                let j = first + i;
                attached[i] = take(&mut rest, 1 + 2 * j);
                let here = take(&mut rest, 2 + 2 * j);
                let (coefficients, properties) = network.line_coefficients(j, s, here, laws);
                lines.set(i, coefficients);
                bare[i] = properties;
            }
            passages.compute(&lines, count);
            for i in 0..count {
                if let Some(jumped) = joints.enter(first + i, attached[i], [p, u], &mut visit) {
                    [p, u] = jumped;
                }
                visit(Step::Segment { line: &passages.line(i), coefficients: lines.get(i), bare: bare[i] });
                [p, u] = passages.get(i).apply::<FUSED>([p, u]);
            }
        }
        if let Some(jumped) = joints.enter(n, take(&mut rest, 1 + 2 * n), [p, u], &mut visit) {
            [p, u] = jumped;
        }
        let downstream = sum(network.ends[1], take(&mut rest, 2 + 2 * n), 0, laws);
        let z = impedance(n - 1);
        visit(Step::End { p, u, impedances: [z_upstream, z], reflections: [upstream, downstream] });
        let f = (one - downstream) * p - (one + downstream) * z * u;
        ComplexDual { value: 0.5 * f.value, slope: 0.5 * f.slope }
    }
}

/// The places between segments, as a sweep meets them.
struct Joints<'a> {
    network: &'a Network,
    laws: &'a Laws,
    area_laws: bool,
}

impl Joints<'_> {
    /// The state behind place `j`, if it jumps there.
    #[inline(always)]
    fn enter(
        &self,
        j: usize,
        here: &[Attachment],
        [p, u]: [ComplexDual; 2],
        visit: &mut impl FnMut(Step<'_>),
    ) -> Option<[ComplexDual; 2]> {
        if here.is_empty() && !self.area_laws && !self.network.jumps(j) {
            visit(Step::Joint { j, p, u, jump: None });
            return None;
        }
        let jump = self.network.jump(j, here, self.area_laws, self.laws);
        visit(Step::Joint { j, p, u, jump: Some(&jump) });
        let ([mu, mp, eu, ep], ratio) = jump;
        Some([p - mu * u - mp * p, ratio * u - eu * u - ep * p])
    }
}
