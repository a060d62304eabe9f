//! Values of forced responses without derivatives: what `forced` computes with jets, of plain numbers, and
//! the segments of a block side by side.

use super::response::area_laws;
use crate::chain::block::{LANES, Row, add};
use crate::chain::coefficients::{At, Coefficients, Laws};
use crate::chain::line::{COSH, MEDIUM, SINH, line, terms};
use crate::chain::network::{Attachment, DENSITY, Network, SOUND_SPEED};
use crate::chain::sweep::take;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use pulp::Simd;
use rijke_numerics::C64;

/// A network and its laws at one s.
#[derive(Clone, Copy)]
pub(super) struct Values<'a> {
    network: &'a Network,
    laws: &'a Laws,
    s: C64,
}

/// (p, u) of two solutions.
pub(super) type Columns = [[C64; 2]; 2];

impl<'a> Values<'a> {
    pub(super) fn new<K: Coefficients + ?Sized>(
        network: &'a Network,
        laws: &K,
        s: C64,
        work: &'a mut Workspace,
    ) -> Result<Self, NetworkError> {
        network.check_numbers(laws)?;
        let at = At::values(s);
        work.laws.reset(laws.laws(), &at);
        laws.fill(&at, &mut work.laws);
        network.check_properties(&work.laws)?;
        Ok(Self { network, laws: &work.laws, s })
    }

    /// rho c of segment `i`.
    pub(super) fn impedance(&self, i: usize) -> C64 {
        let [density, speed] =
            [DENSITY, SOUND_SPEED].map(|kind| self.network.property(i, kind, self.laws).value);
        density * speed
    }

    /// The matrix of (p, u) from just upstream of place `from` to just downstream of place `to`, by rows.
    pub(super) fn matrix(&self, range: [usize; 2]) -> [[C64; 2]; 2] {
        let unit = [[C64::ONE, C64::ZERO], [C64::ZERO, C64::ONE]];
        let [[a, c], [b, d]] = self.pass(range, unit, |_, _, _| ());
        [[a, b], [c, d]]
    }

    /// (p, u) before a place, up to a common factor, as the downstream end wants it.
    pub(super) fn seen_from(&self, place: usize) -> [C64; 2] {
        let n = self.network.segments.len();
        let r = self.reflection(1);
        let [[a, b], [c, d]] = self.matrix([place, n]);
        let (row_p, row_u) = (1.0 - r, -(1.0 + r) * self.impedance(n - 1));
        [-(row_p * b + row_u * d), row_p * a + row_u * c]
    }

    /// (p, u) before and behind every place where `jump` is added to (p, u) behind `place`, and waves of the
    /// given pressures enter upstream and downstream.
    pub(super) fn forced(&self, place: usize, jump: [f64; 2], waves: [f64; 2]) -> [Vec<[C64; 2]>; 2] {
        let n = self.network.segments.len();
        let [up, down] = [0, 1].map(|end| self.reflection(end));
        let (z_up, z_down) = (self.impedance(0), self.impedance(n - 1));
        let own = [C64::new(waves[0], 0.0), waves[0] / z_up];
        let mut sides = [Vec::with_capacity(n + 1), Vec::with_capacity(n + 1)];
        let columns = self.pass([0, n], [[up + 1.0, (up - 1.0) / z_up], own], |j, side, columns| {
            if side == BEHIND && j == place {
                columns[1] = [columns[1][0] + jump[0], columns[1][1] + jump[1]];
            }
            sides[side].push(*columns);
        });
        // g - R f = what enters downstream.
        let [free, own] = columns.map(|[p, u]| 0.5 * ((p - z_down * u) - down * (p + z_down * u)));
        let amplitude = (waves[1] - own) / free;
        sides.map(|all| {
            let whole = |[free, own]: Columns| [0, 1].map(|k| own[k] + amplitude * free[k]);
            all.into_iter().map(whole).collect()
        })
    }

    /// R at the upstream end (0) or the downstream end (1).
    fn reflection(&self, end: usize) -> C64 {
        let key = if end == 0 { 0 } else { 2 + 2 * self.network.segments.len() };
        self.sum(self.network.ends[end], self.network.attached(key))
    }

    fn sum(&self, base: C64, here: &[Attachment]) -> C64 {
        here.iter().fold(base, |sum, a| sum + a.weight * self.laws.value(a.law))
    }

    /// Carries (p, u) of two solutions from just upstream of place `from` to just downstream of place `to`;
    /// `visit` sees them upstream and downstream of every place.
    fn pass(
        &self,
        range: [usize; 2],
        columns: Columns,
        visit: impl FnMut(usize, usize, &mut Columns),
    ) -> Columns {
        pulp::Arch::new().dispatch(Pass { values: *self, range, columns, visit })
    }

    /// The state behind place `j`, where often the area changes alone.
    #[inline(always)]
    fn enter<const FUSED: bool>(
        &self,
        j: usize,
        here: &[Attachment],
        area_laws: bool,
        mut columns: Columns,
        visit: &mut impl FnMut(usize, usize, &mut Columns),
    ) -> Columns {
        let Network { segments, feedback, .. } = self.network;
        visit(j, BEFORE, &mut columns);
        if here.is_empty() && !area_laws && feedback[j] == [C64::ZERO; 4] {
            if j > 0 && j < segments.len() {
                let ratio = segments[j - 1].area / segments[j].area;
                columns[0][1] *= ratio;
                columns[1][1] *= ratio;
            }
        } else {
            columns = apply::<FUSED>(self.jump(j, here), columns);
        }
        visit(j, BEHIND, &mut columns);
        columns
    }

    #[cold]
    fn jump(&self, j: usize, here: &[Attachment]) -> [[C64; 2]; 2] {
        let [mu, mp, eu, ep] = here.iter().fold(self.network.feedback[j], |mut k, a| {
            k[a.kind] += a.weight * self.laws.value(a.law);
            k
        });
        [[1.0 - mp, -mu], [-ep, self.network.area_ratio(j, self.laws) - eu]]
    }
}

/// The two sides of a place.
const BEFORE: usize = 0;
const BEHIND: usize = 1;

struct Pass<'a, V> {
    values: Values<'a>,
    range: [usize; 2],
    columns: Columns,
    visit: V,
}

impl<V: FnMut(usize, usize, &mut Columns)> pulp::WithSimd for Pass<'_, V> {
    type Output = Columns;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Columns {
        if S::IS_SCALAR { self.run::<S, false>(simd) } else { self.run::<S, true>(simd) }
    }
}

impl<V: FnMut(usize, usize, &mut Columns)> Pass<'_, V> {
    #[inline(always)]
    fn run<S: Simd, const FUSED: bool>(self, simd: S) -> Columns {
        let Self { values, range: [from, to], mut columns, mut visit } = self;
        let network = values.network;
        let area_laws = area_laws(network);
        let first = network.attachments.partition_point(|a| a.key < 1 + 2 * from);
        let mut rest = &network.attachments[first..];
        let mut lines = Lines { p: Row::ZERO, q: Row::ZERO, c: Row::ZERO, b: Row::ZERO, e: Row::ZERO };
        for block in (from..to).step_by(LANES) {
            let count = LANES.min(to - block);
            let mut attached: [&[Attachment]; LANES] = [&[]; LANES];
            for i in 0..count {
                let j = block + i;
                attached[i] = take(&mut rest, 1 + 2 * j);
                let here = take(&mut rest, 2 + 2 * j);
                let ([p, q], _) = network.line_coefficients(j, values.s, here, values.laws);
                lines.p.set(i, p.value);
                lines.q.set(i, q.value);
            }
            lines.compute(simd, count);
            for i in 0..count {
                columns = values.enter::<FUSED>(block + i, attached[i], area_laws, columns, &mut visit);
                let (c, b, e) = (lines.c.get(i), lines.b.get(i), lines.e.get(i));
                columns = apply::<FUSED>([[c, -b], [-e, c]], columns);
            }
        }
        values.enter::<FUSED>(to, take(&mut rest, 1 + 2 * to), area_laws, columns, &mut visit)
    }
}

// No closures here: a closure has not the instructions of the machine until it is inlined.
#[inline(always)]
fn apply<const FUSED: bool>(matrix: [[C64; 2]; 2], [one, two]: Columns) -> Columns {
    [turned::<FUSED>(matrix, one), turned::<FUSED>(matrix, two)]
}

#[inline(always)]
fn turned<const FUSED: bool>([[a, b], [c, d]]: [[C64; 2]; 2], [p, u]: [C64; 2]) -> [C64; 2] {
    [add::<FUSED>(a, p, add::<FUSED>(b, u, C64::ZERO)), add::<FUSED>(c, p, add::<FUSED>(d, u, C64::ZERO))]
}

/// P and Q of the segments of a block; C, P S and Q S at PQ.
struct Lines {
    p: Row,
    q: Row,
    c: Row,
    b: Row,
    e: Row,
}

impl Lines {
    #[inline(always)]
    fn compute<S: Simd>(&mut self, simd: S, count: usize) {
        for v in 0..count.div_ceil(S::F64_LANES) {
            let (p, q) = (self.p.load(simd, v), self.q.load(simd, v));
            let product = p * q;
            let sizes = simd.add_f64s(simd.abs_f64s(product.re), simd.abs_f64s(product.im));
            let size = simd.reduce_max_f64s(sizes);
            let terms = terms(size);
            let (c, s) = (product.polynomial(&COSH[..terms]), product.polynomial(&SINH[..terms]));
            self.c.store(v, c);
            self.b.store(v, p * s);
            self.e.store(v, q * s);
            if size >= MEDIUM {
                (v * S::F64_LANES..(v + 1) * S::F64_LANES).for_each(|i| self.long(i));
            }
        }
    }

    /// A segment that is long against the wavelength, alone.
    #[inline(never)]
    fn long(&mut self, i: usize) {
        let (p, q) = (self.p.get(i), self.q.get(i));
        let at = line(p * q);
        self.c.set(i, at.c);
        self.b.set(i, p * at.s);
        self.e.set(i, q * at.s);
    }
}
