//! How a caller hands over coefficients that depend on s and on parameters the network knows nothing about.

use crate::error::NetworkError;
use crate::plane::region::Region;
use rijke_numerics::{C64, Jet, JetSpace, Order};

/// Coefficients as numbered laws: complex numbers that depend on s and on real parameters a_1 .. a_p.
///
/// The network asks for all laws at one s; slots of the network take weighted sums of them
/// ([`crate::Network::attach`]), so that fifty segments can share one wall law.
///
/// Every law must be **analytic in s** (no Re s, |s| or conjugates): Newton, the derivatives and the contour
/// count are exact only then. It may depend on the parameters in any smooth way, because they are real.
///
/// ```
/// use rijke_network::{At, Coefficients, Laws, Network, Newton, Places, Segment, Slot, Workspace};
/// use rijke_numerics::{C64, Order};
/// /// A gauze k_eu = -K e^{-s tau}; parameters K and tau.
/// struct Gauze([f64; 2]);
/// impl Coefficients for Gauze {
///     fn parameters(&self) -> usize { 2 }
///     fn laws(&self) -> usize { 1 }
///     fn fill(&self, at: &At, laws: &mut Laws) {
///         let (k, tau) = (at.parameter(0, self.0[0]), at.parameter(1, self.0[1]));
///         laws.set(0, &-&(&k * &(-&(&at.s_jet() * &tau)).exp()));
///     }
/// }
/// let mut tube = Network::cut_tube(Segment::new(1.0, 1.8e-3, 343.2, 1.2041), &[0.25])?;
/// tube.set(Slot::Upstream, C64::new(-0.99, 0.0))?;
/// tube.set(Slot::Downstream, C64::new(-0.99, 0.0))?;
/// tube.attach(Slot::Eu(1), 0, 1.0)?; // law 0 at the place between the two segments
/// let (gauze, mut work) = (Gauze([0.05, 1.5e-3]), Workspace::default());
/// let root = tube.solve(&gauze, C64::new(0.0, 1080.0), &Newton::default(), &mut work)?;
/// let places = Places { at: vec![1], reference: 1 };
/// let s = tube.respond(&gauze, &root, &places, Order::Second, &mut work)?.s;
/// assert!(s.gradient()[0].re > 0.0); // more heat drives this mode
/// assert!(s.hessian(0, 1).norm() > 0.0);
/// # Ok::<(), rijke_network::NetworkError>(())
/// ```
pub trait Coefficients {
    /// Number of real parameters p.
    fn parameters(&self) -> usize;
    /// Number of laws.
    fn laws(&self) -> usize;
    /// Writes every law at `at` into `laws`. Laws that are not written are zero.
    fn fill(&self, at: &At, laws: &mut Laws);
    /// Name of a law in messages.
    fn name(&self, law: usize) -> String {
        format!("law {law}")
    }
    /// For a k_eu or k_ep that stands for the velocity at another place, with nothing but ducts between: how
    /// far downstream that lies, m, negative upstream. [`crate::Network::along`] needs to know; `None` unless
    /// overridden.
    fn reference_at(&self, _law: usize) -> Option<f64> {
        None
    }
    /// Every pole of every law, so that a count of modes can tell poles from zeros; none unless overridden.
    ///
    /// A law with a pole must name it. A weak resonance that is left out hides the mode beside it: the two
    /// cancel in the count, which then certifies the others. [`NetworkError::UndeclaredPole`] tells of strong
    /// ones alone.
    fn poles(&self) -> Vec<Pole> {
        Vec::new()
    }
    /// Every pole of every law in `region`, others may be among them; [`Coefficients::poles`] unless
    /// overridden, for laws whose poles must be searched for.
    ///
    /// # Errors
    /// As [`crate::Network::modes`], if the search fails.
    fn poles_in(&self, _region: &Region) -> Result<Vec<Pole>, NetworkError> {
        Ok(self.poles())
    }
}

/// A pole of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// Number of the law.
    pub law: usize,
    /// Where, 1/s and rad/s.
    pub at: C64,
    /// Its order.
    pub order: usize,
}

/// What is asked for: the place s and the derivatives that are needed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct At {
    s: C64,
    parameters: usize,
    order: Order,
    search: bool,
}

impl At {
    /// The request of a root search: values and the derivative with respect to s alone.
    #[must_use]
    pub fn search(s: C64) -> Self {
        Self { s, parameters: 0, order: Order::First, search: true }
    }

    /// The request of a forced response without derivatives: values alone. Derivatives may be written, but
    /// nobody reads them.
    #[must_use]
    pub fn values(s: C64) -> Self {
        Self { s, parameters: 0, order: Order::Value, search: true }
    }

    /// The request after convergence: derivatives up to `order` with respect to p parameters and s.
    #[must_use]
    pub fn full(s: C64, parameters: usize, order: Order) -> Self {
        Self { s, parameters, order: order.max(Order::First), search: false }
    }

    /// s = sigma + i omega.
    #[must_use]
    pub fn s(&self) -> C64 {
        self.s
    }

    /// The space of the jets: seeds a_1 .. a_p, then s. During a root search, and where values alone are
    /// wanted, it has the single seed s.
    #[must_use]
    pub fn space(&self) -> JetSpace {
        JetSpace::new(self.parameters + 1, self.order.max(Order::First))
    }

    /// Highest derivative asked for.
    #[must_use]
    pub fn order(&self) -> Order {
        self.order
    }

    /// s as a jet.
    #[must_use]
    pub fn s_jet(&self) -> Jet {
        self.space().seed(self.parameters, self.s)
    }

    /// Parameter number `index` (from 0), whose value is `value`, as a jet; a constant during a root search.
    #[must_use]
    pub fn parameter(&self, index: usize, value: f64) -> Jet {
        let value = C64::new(value, 0.0);
        if self.search { self.space().constant(value) } else { self.space().seed(index, value) }
    }
}

/// Values and derivatives of all laws, in one flat allocation that is reused.
#[derive(Clone, Debug, Default)]
pub struct Laws {
    seeds: usize,
    packed: usize,
    value: Vec<C64>,
    gradient: Vec<C64>,
    hessian: Vec<C64>,
}

impl Laws {
    /// Makes room for `count` laws in the space of `at` and sets them to zero.
    pub fn reset(&mut self, count: usize, at: &At) {
        self.seeds = at.space().seeds();
        self.packed = if at.order() == Order::Second { self.seeds * (self.seeds + 1) / 2 } else { 0 };
        for (field, length) in
            [(&mut self.value, 1), (&mut self.gradient, self.seeds), (&mut self.hessian, self.packed)]
        {
            field.clear();
            field.resize(count * length, C64::ZERO);
        }
    }

    /// Writes law number `law` from a jet of [`At::space`]. Later writes replace earlier ones.
    pub fn set(&mut self, law: usize, jet: &Jet) {
        let (n, m) = (self.seeds, self.packed);
        self.value[law] = jet.value();
        copy(&mut self.gradient[law * n..(law + 1) * n], jet.gradient());
        copy(&mut self.hessian[law * m..(law + 1) * m], jet.hessian_packed());
    }

    /// Writes law number `law` from a jet whose seeds are the parameters `seeds` (ascending) and, last, s.
    pub fn set_among(&mut self, law: usize, jet: &Jet, seeds: &[usize]) {
        let last = self.seeds - 1;
        let space = JetSpace::new(self.seeds, jet.order());
        self.set(law, &space.take(jet, |i| Some(seeds.get(i).copied().unwrap_or(last))));
    }

    /// Writes law number `law` that depends on s alone, from value, first and second derivative; allocates
    /// nothing.
    #[inline]
    pub fn set_analytic(&mut self, law: usize, [value, slope, curvature]: [C64; 3]) {
        let (n, m) = (self.seeds, self.packed);
        self.value[law] = value;
        self.gradient[law * n + n - 1] = slope;
        if m > 0 {
            self.hessian[law * m + m - 1] = curvature;
        }
    }

    /// Value of a law.
    #[must_use]
    pub fn value(&self, law: usize) -> C64 {
        self.value[law]
    }

    /// Derivatives of a law with respect to a_1 .. a_p and s.
    #[must_use]
    pub fn gradient(&self, law: usize) -> &[C64] {
        &self.gradient[law * self.seeds..(law + 1) * self.seeds]
    }

    /// Derivative of a law with respect to s.
    #[must_use]
    pub(crate) fn slope(&self, law: usize) -> C64 {
        self.gradient[(law + 1) * self.seeds - 1]
    }

    /// Second derivatives of a law, the lower triangle row by row; empty below second order.
    #[must_use]
    pub fn hessian(&self, law: usize) -> &[C64] {
        &self.hessian[law * self.packed..(law + 1) * self.packed]
    }

    /// A law with its derivatives.
    pub(crate) fn jet(&self, law: usize) -> Jet {
        Jet::from_parts(self.value(law), self.gradient(law).to_vec(), self.hessian(law).to_vec())
    }
}

fn copy(to: &mut [C64], from: &[C64]) {
    for (to, from) in to.iter_mut().zip(from) {
        *to = *from;
    }
}

/// No law and no parameter: every coefficient of the network is the constant in it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Constant;

impl Coefficients for Constant {
    fn parameters(&self) -> usize {
        0
    }
    fn laws(&self) -> usize {
        0
    }
    fn fill(&self, _at: &At, _laws: &mut Laws) {}
}
