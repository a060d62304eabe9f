//! Poles of laws that act at places of a chain.

use rijke_numerics::C64;

/// Poles of laws, each with the place P at which the law acts.
///
/// F is linear in what acts at one place together, so a pole that several laws have there is one of F, of the
/// highest of their orders.
pub(crate) struct PolesByPlace<P> {
    found: Vec<Found<P>>,
}

struct Found<P> {
    at: C64,
    order: usize,
    /// The law that has it in this order.
    law: usize,
    place: P,
}

impl<P> Default for PolesByPlace<P> {
    fn default() -> Self {
        Self { found: Vec::new() }
    }
}

impl<P> PolesByPlace<P> {
    /// Distance of two poles that are one, relative to |s|.
    const SAME: f64 = 1e-8;

    /// Adds a pole of the law of this number at `place`; `is_here` tells of other places whether they are the
    /// same.
    pub(crate) fn add(
        &mut self,
        (at, order): (C64, usize),
        law: usize,
        is_here: impl Fn(&P) -> bool,
        place: P,
    ) {
        let same = |f: &&mut Found<P>| (f.at - at).norm() <= Self::SAME * at.norm() && is_here(&f.place);
        match self.found.iter_mut().find(same) {
            // A law that names a pole twice has it in this order.
            Some(known) if known.law == law => known.order += order,
            Some(known) if known.order < order => (known.order, known.law) = (order, law),
            Some(_) => {}
            None => self.found.push(Found { at, order, law, place }),
        }
    }

    /// All with their orders.
    pub(crate) fn all(self) -> Vec<(C64, usize)> {
        self.found.into_iter().map(|f| (f.at, f.order)).collect()
    }
}
