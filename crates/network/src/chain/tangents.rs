//! The state of the chain with its tangents in all seeds, to first and second order.

use super::coefficients::Laws;
use rijke_numerics::{C64, Jet};

type Pair = [C64; 2];
type Matrix2 = [[C64; 2]; 2];

/// The state (p, u) and its derivatives with respect to all seeds, and room for one element's coefficients.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tangents {
    state: Pair,
    pub(crate) first: Vec<Pair>,
    /// Lower triangle, row by row.
    second: Vec<Pair>,
    /// Gradients of the local coefficients of an element, one block of seeds for each.
    pub(crate) gradient: Vec<C64>,
    /// Packed Hessians of the local coefficients, one block for each.
    hessian: Vec<C64>,
    /// M_theta v_b for each local coefficient theta and seed b.
    moved: Vec<Pair>,
    active: Vec<bool>,
}

/// An element of the chain at the working point: its matrix, and how it depends on its local coefficients.
pub(crate) struct Element<const M: usize> {
    pub(crate) matrix: Matrix2,
    pub(crate) first: [Matrix2; M],
    /// Second derivatives by pairs (i, j) with j <= i, packed; `None` if the matrix is linear.
    pub(crate) second: Option<[Matrix2; 3]>,
}

#[inline(always)]
fn apply(m: &Matrix2, v: &Pair) -> Pair {
    [m[0][0] * v[0] + m[0][1] * v[1], m[1][0] * v[0] + m[1][1] * v[1]]
}

/// As [`apply`], for a tangent: zero upstream of the first law that its seeds enter.
#[inline(always)]
fn push(m: &Matrix2, v: &Pair) -> Pair {
    if *v == [C64::ZERO; 2] { *v } else { apply(m, v) }
}

#[inline(always)]
fn add(to: &mut Pair, factor: C64, v: &Pair) {
    to[0] += factor * v[0];
    to[1] += factor * v[1];
}

impl Tangents {
    pub(crate) fn start(&mut self, p: &Jet, u: &Jet) {
        let zip = |a: &[C64], b: &[C64]| a.iter().zip(b).map(|(&p, &u)| [p, u]).collect();
        self.state = [p.value(), u.value()];
        self.first = zip(p.gradient(), u.gradient());
        self.second = zip(p.hessian_packed(), u.hessian_packed());
    }

    pub(crate) fn jet(&self, component: usize) -> Jet {
        Jet::from_parts(
            self.state[component],
            self.first.iter().map(|v| v[component]).collect(),
            self.second.iter().map(|v| v[component]).collect(),
        )
    }

    /// Clears the local coefficients of an element that has `m` of them.
    pub(crate) fn clear(&mut self, m: usize) {
        self.gradient.clear();
        self.gradient.resize(m * self.first.len(), C64::ZERO);
        self.hessian.clear();
        self.hessian.resize(m * self.second.len(), C64::ZERO);
    }

    /// Adds `factor` times a law to the derivatives of local coefficient `local`.
    pub(crate) fn add_law(&mut self, local: usize, factor: f64, law: usize, laws: &Laws) {
        let (n, m) = (self.first.len(), self.second.len());
        for (to, from) in self.gradient[local * n..(local + 1) * n].iter_mut().zip(laws.gradient(law)) {
            *to += factor * from;
        }
        for (to, from) in self.hessian[local * m..(local + 1) * m].iter_mut().zip(laws.hessian(law)) {
            *to += factor * from;
        }
    }

    /// Sets the derivatives of local coefficient `local` from a jet.
    pub(crate) fn add_jet(&mut self, local: usize, jet: &Jet) {
        let (n, m) = (self.first.len(), self.second.len());
        for (to, from) in self.gradient[local * n..].iter_mut().zip(jet.gradient()) {
            *to += from;
        }
        for (to, from) in self.hessian[local * m..].iter_mut().zip(jet.hessian_packed()) {
            *to += from;
        }
    }

    /// v' = M v, v_a' = M v_a + M_a v, v_ab' = M v_ab + M_a v_b + M_b v_a + M_ab v.
    pub(crate) fn advance<const M: usize>(&mut self, element: &Element<M>) {
        let n = self.first.len();
        let v = self.state;
        let pushed: [Pair; M] = std::array::from_fn(|t| apply(&element.first[t], &v));
        if !self.second.is_empty() {
            self.moved.clear();
            for m in &element.first {
                self.moved.extend(self.first.iter().map(|v| apply(m, v)));
            }
            let bent = element.second.map(|second| second.map(|m| apply(&m, &v)));
            self.active.clear();
            let gradient = &self.gradient;
            self.active.extend((0..n).map(|a| (0..M).any(|t| gradient[t * n + a] != C64::ZERO)));
            let mut k = 0;
            let packed = self.second.len();
            for a in 0..n {
                for b in 0..=a {
                    let mut next = push(&element.matrix, &self.second[k]);
                    if self.active[a] || self.active[b] {
                        for t in 0..M {
                            let (ta, tb) = (gradient[t * n + a], gradient[t * n + b]);
                            add(&mut next, ta, &self.moved[t * n + b]);
                            add(&mut next, tb, &self.moved[t * n + a]);
                            add(&mut next, self.hessian[t * packed + k], &pushed[t]);
                        }
                        if let Some(bent) = &bent {
                            let (pa, pb, qa, qb) =
                                (gradient[a], gradient[b], gradient[n + a], gradient[n + b]);
                            add(&mut next, pa * pb, &bent[0]);
                            add(&mut next, pa * qb + qa * pb, &bent[1]);
                            add(&mut next, qa * qb, &bent[2]);
                        }
                    }
                    self.second[k] = next;
                    k += 1;
                }
            }
        }
        for a in 0..n {
            let mut next = push(&element.matrix, &self.first[a]);
            for t in 0..M {
                add(&mut next, self.gradient[t * n + a], &pushed[t]);
            }
            self.first[a] = next;
        }
        self.state = apply(&element.matrix, &v);
    }
}
