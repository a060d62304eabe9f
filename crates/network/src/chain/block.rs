//! Segments computed side by side. What a segment does to a state does not depend on its neighbours: only the
//! state itself has to pass one segment after the other.

use super::line::{Line, SHORT, line, short_line};
use pulp::Simd;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;
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
    pub(crate) c: ComplexDual,
    pub(crate) b: ComplexDual,
    pub(crate) e: ComplexDual,
}

impl Passage {
    #[inline(always)]
    fn new(p: ComplexDual, q: ComplexDual, at: &Line) -> Self {
        let slope = p.slope * q.value + p.value * q.slope;
        let ds = at.s1 * slope;
        Self {
            c: ComplexDual { value: at.c, slope: 0.5 * at.s * slope },
            b: ComplexDual { value: p.value * at.s, slope: p.slope * at.s + p.value * ds },
            e: ComplexDual { value: q.value * at.s, slope: q.slope * at.s + q.value * ds },
        }
    }

    /// The state behind the segment; `FUSED` where the machine multiplies and adds in one instruction.
    #[inline(always)]
    pub(crate) fn apply<const FUSED: bool>(&self, [p, u]: [ComplexDual; 2]) -> [ComplexDual; 2] {
        let Self { c, b, e } = self;
        let less = |z: C64| -z;
        let pair = |c: C64, x: C64, b: C64, y: C64| add::<FUSED>(c, x, add::<FUSED>(less(b), y, C64::ZERO));
        [
            ComplexDual {
                value: pair(c.value, p.value, b.value, u.value),
                slope: pair(c.value, p.slope, b.value, u.slope) + pair(c.slope, p.value, b.slope, u.value),
            },
            ComplexDual {
                value: pair(c.value, u.value, e.value, p.value),
                slope: pair(c.value, u.slope, e.value, p.slope) + pair(c.slope, u.value, e.slope, p.value),
            },
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
fn get(from: &[Row; 2], i: usize) -> ComplexDual {
    ComplexDual { value: from[0].get(i), slope: from[1].get(i) }
}

#[inline(always)]
fn set(to: &mut [Row; 2], i: usize, z: ComplexDual) {
    to[0].set(i, z.value);
    to[1].set(i, z.slope);
}

impl Lines {
    pub(crate) const ZERO: Self = Self { p: [Row::ZERO; 2], q: [Row::ZERO; 2] };

    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, [p, q]: [ComplexDual; 2]) {
        set(&mut self.p, i, p);
        set(&mut self.q, i, q);
    }

    #[inline(always)]
    pub(crate) fn get(&self, i: usize) -> [ComplexDual; 2] {
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
            let product = p.value * q.value;
            self.size[i] = product.re.abs() + product.im.abs();
            self.set(i, p, q, &short_line(product));
        }
        for i in 0..count {
            if self.size[i] >= SHORT {
                let [p, q] = lines.get(i);
                self.set(i, p, q, &line(p.value * q.value));
            }
        }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, p: ComplexDual, q: ComplexDual, at: &Line) {
        let Passage { c, b, e } = Passage::new(p, q, at);
        set(&mut self.c, i, c);
        set(&mut self.b, i, b);
        set(&mut self.e, i, e);
        set(&mut self.s, i, ComplexDual { value: at.s, slope: at.s1 });
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
            [ComplexDual { value: rate * s, slope: rate }, ComplexDual { value: turn * s, slope: turn }]
        };
        let s = C64::new(0.1, 1.0);
        let (mut lines, mut passages) = (Lines::ZERO, Passages::ZERO);
        for i in 0..LANES {
            lines.set(i, segment(i, s));
        }
        passages.compute(&lines, LANES);
        for i in 0..LANES {
            let closed = |s: C64| {
                let [p, q] = segment(i, s).map(|z| z.value);
                let w = p.sqrt() * q.sqrt();
                [w.cosh(), p * w.sinh() / w, q * w.sinh() / w]
            };
            let h = 1e-4;
            let [up, down] = [closed(s + h), closed(s - h)];
            let Passage { c, b, e } = passages.get(i);
            for (k, (got, exact)) in [c, b, e].into_iter().zip(closed(s)).enumerate() {
                assert!((got.value - exact).norm() < 1e-14 * exact.norm(), "segment {i}, entry {k}");
                let slope = (up[k] - down[k]) / (2.0 * h);
                assert!((got.slope - slope).norm() < 1e-7 * (slope.norm() + 1e-3), "segment {i}, entry {k}");
            }
            let state = [c, b].map(|z| ComplexDual { value: z.value + 1.0, slope: z.slope - C64::I });
            let (fused, plain) =
                (passages.get(i).apply::<true>(state), passages.get(i).apply::<false>(state));
            for (one, two) in fused.iter().zip(&plain) {
                let size = one.value.norm() + one.slope.norm();
                assert!((one.value - two.value).norm() + (one.slope - two.slope).norm() < 1e-14 * size);
            }
        }
    }
}
