//! Segments computed side by side. What a segment does to a state does not depend on its neighbours: only the
//! state itself has to pass one segment after the other.

use super::line::{Line, SHORT, line, short_line};
use crate::plane::dual::Dual;
use pulp::Simd;
use rijke_numerics::C64;
use rijke_numerics::wide::Wide;

/// Segments in a block: four vectors of four doubles, few enough for short chains not to wait for idle lanes.
pub(crate) const LANES: usize = 16;

/// Complex numbers side by side.
#[derive(Clone, Copy)]
pub(crate) struct Row {
    re: [f64; LANES],
    im: [f64; LANES],
}

impl Row {
    pub(crate) const ZERO: Self = Self { re: [0.0; LANES], im: [0.0; LANES] };

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> C64 {
        C64::new(self.re[i], self.im[i])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, z: C64) {
        self.re[i] = z.re;
        self.im[i] = z.im;
    }

    /// Vector number `v` of the machine.
    #[inline(always)]
    pub(crate) fn load<S: Simd>(&self, simd: S, v: usize) -> Wide<S> {
        Wide::new(simd, S::as_simd_f64s(&self.re).0[v], S::as_simd_f64s(&self.im).0[v])
    }

    #[inline(always)]
    pub(crate) fn store<S: Simd>(&mut self, v: usize, z: Wide<S>) {
        S::as_mut_simd_f64s(&mut self.re).0[v] = z.re;
        S::as_mut_simd_f64s(&mut self.im).0[v] = z.im;
    }
}

/// P and Q of the segments of a block, with their derivatives in s.
pub(crate) struct Lines {
    p: [Row; 2],
    q: [Row; 2],
}

/// M = [[C, -P S], [-Q S, C]] and dM/ds of the segments of a block.
pub(crate) struct Passages {
    /// C and its derivative.
    c: [Row; 2],
    /// P S and its derivative.
    b: [Row; 2],
    /// Q S and its derivative.
    e: [Row; 2],
    /// S and S'.
    s: [Row; 2],
    /// |Re PQ| + |Im PQ|.
    size: [f64; LANES],
}

/// M and dM/ds of one segment.
pub(crate) struct Passage {
    pub(crate) c: Dual,
    pub(crate) b: Dual,
    pub(crate) e: Dual,
}

impl Passage {
    #[inline(always)]
    fn new(p: Dual, q: Dual, at: &Line) -> Self {
        let slope = p.d * q.v + p.v * q.d;
        let ds = at.s1 * slope;
        Self {
            c: Dual { v: at.c, d: 0.5 * at.s * slope },
            b: Dual { v: p.v * at.s, d: p.d * at.s + p.v * ds },
            e: Dual { v: q.v * at.s, d: q.d * at.s + q.v * ds },
        }
    }

    /// The state behind the segment; `FUSED` where the machine multiplies and adds in one instruction.
    #[inline(always)]
    pub(crate) fn apply<const FUSED: bool>(&self, [p, u]: [Dual; 2]) -> [Dual; 2] {
        let Self { c, b, e } = self;
        let less = |z: C64| -z;
        let pair = |c: C64, x: C64, b: C64, y: C64| add::<FUSED>(c, x, add::<FUSED>(less(b), y, C64::ZERO));
        [
            Dual { v: pair(c.v, p.v, b.v, u.v), d: pair(c.v, p.d, b.v, u.d) + pair(c.d, p.v, b.d, u.v) },
            Dual { v: pair(c.v, u.v, e.v, p.v), d: pair(c.v, u.d, e.v, p.d) + pair(c.d, u.v, e.d, p.v) },
        ]
    }
}

/// a b + c.
#[inline(always)]
pub(crate) fn add<const FUSED: bool>(a: C64, b: C64, c: C64) -> C64 {
    if FUSED {
        C64::new(
            (-a.im).mul_add(b.im, a.re.mul_add(b.re, c.re)),
            a.im.mul_add(b.re, a.re.mul_add(b.im, c.im)),
        )
    } else {
        a * b + c
    }
}

#[inline(always)]
fn get(from: &[Row; 2], i: usize) -> Dual {
    Dual { v: from[0].get(i), d: from[1].get(i) }
}

#[inline(always)]
fn set(to: &mut [Row; 2], i: usize, z: Dual) {
    to[0].set(i, z.v);
    to[1].set(i, z.d);
}

impl Lines {
    pub(crate) const ZERO: Self = Self { p: [Row::ZERO; 2], q: [Row::ZERO; 2] };

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, [p, q]: [Dual; 2]) {
        set(&mut self.p, i, p);
        set(&mut self.q, i, q);
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> [Dual; 2] {
        [get(&self.p, i), get(&self.q, i)]
    }
}

impl Passages {
    pub(crate) const ZERO: Self = Self {
        c: [Row::ZERO; 2],
        b: [Row::ZERO; 2],
        e: [Row::ZERO; 2],
        s: [Row::ZERO; 2],
        size: [0.0; LANES],
    };

    /// All segments of a block. Inside `pulp`'s dispatch the first loop, without branch or call, becomes
    /// vector instructions.
    #[inline(always)]
    pub(crate) fn compute(&mut self, lines: &Lines, count: usize) {
        for i in 0..LANES {
            let [p, q] = lines.get(i);
            let product = p.v * q.v;
            self.size[i] = product.re.abs() + product.im.abs();
            self.set(i, p, q, &short_line(product));
        }
        for i in 0..count {
            if self.size[i] >= SHORT {
                let [p, q] = lines.get(i);
                self.set(i, p, q, &line(p.v * q.v));
            }
        }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, p: Dual, q: Dual, at: &Line) {
        let Passage { c, b, e } = Passage::new(p, q, at);
        set(&mut self.c, i, c);
        set(&mut self.b, i, b);
        set(&mut self.e, i, e);
        set(&mut self.s, i, Dual { v: at.s, d: at.s1 });
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> Passage {
        Passage { c: get(&self.c, i), b: get(&self.b, i), e: get(&self.e, i) }
    }

    /// C, S and S' of a segment.
    #[inline(always)]
    pub(crate) fn line(&self, i: usize) -> Line {
        Line { c: self.c[0].get(i), s: self.s[0].get(i), s1: self.s[1].get(i) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_block_is_its_segments_one_by_one() {
        // Short and long segments in turn, on both sides of the limit; P and Q are linear in s.
        let segment = |i: usize, s: C64| {
            let size = [1e-4, 0.02, 0.06, 0.1, 0.5, 3.0][i % 6];
            let (rate, turn) =
                (C64::from_polar(size, 0.3 + 0.2 * i as f64), C64::from_polar(1.1 * size, 0.9));
            [Dual { v: rate * s, d: rate }, Dual { v: turn * s, d: turn }]
        };
        let s = C64::new(0.1, 1.0);
        let (mut lines, mut passages) = (Lines::ZERO, Passages::ZERO);
        for i in 0..LANES {
            lines.set(i, segment(i, s));
        }
        passages.compute(&lines, LANES);
        for i in 0..LANES {
            let closed = |s: C64| {
                let [p, q] = segment(i, s).map(|z| z.v);
                let w = p.sqrt() * q.sqrt();
                [w.cosh(), p * w.sinh() / w, q * w.sinh() / w]
            };
            let h = 1e-4;
            let [up, down] = [closed(s + h), closed(s - h)];
            let Passage { c, b, e } = passages.get(i);
            for (k, (got, exact)) in [c, b, e].into_iter().zip(closed(s)).enumerate() {
                assert!((got.v - exact).norm() < 1e-14 * exact.norm(), "segment {i}, entry {k}");
                let slope = (up[k] - down[k]) / (2.0 * h);
                assert!((got.d - slope).norm() < 1e-7 * (slope.norm() + 1e-3), "segment {i}, entry {k}");
            }
            let state = [c, b].map(|z| Dual { v: z.v + 1.0, d: z.d - C64::I });
            let (fused, plain) =
                (passages.get(i).apply::<true>(state), passages.get(i).apply::<false>(state));
            for (one, two) in fused.iter().zip(&plain) {
                let size = one.v.norm() + one.d.norm();
                assert!((one.v - two.v).norm() + (one.d - two.d).norm() < 1e-14 * size);
            }
        }
    }
}
