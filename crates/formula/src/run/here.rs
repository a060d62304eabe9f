//! The values that the names of a formula have at one place.

use rijke_numerics::JetSpace;

/// The values of all names at one place. `T` is a [`rijke_numerics::Jet`] where derivatives in the
/// parameters are carried, and a [`rijke_numerics::ComplexDual`] in a search for a root.
#[derive(Debug)]
pub struct Here<'a, T> {
    /// Number and order of the derivatives that jets carry.
    pub space: JetSpace,
    /// Values of the real names by index, in the units of the scope; NaN for those that have none here or
    /// depend on s.
    pub numbers: &'a [f64],
    /// Values of the names that carry derivatives by index, `s` itself first: those that depend on s, and
    /// real ones that depend on parameters, which count before `numbers`; none for all others.
    pub analytic: &'a [Option<&'a T>],
}

// By hand, because the derived ones would ask for `T: Copy`, and jets are not.
impl<T> Clone for Here<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Here<'_, T> {}
