//! The compiled part of the Python package `rijke`: thin classes about what the crates offer. Must not do
//! science of its own.
//!
//! What needs pandas, ArviZ or matplotlib is Python, in `python/rijke`, on top of these classes;
//! `rijke/_native.pyi` says what they take and return.
//!
//! # Conventions
//!
//! SI units; s = growth rate + i angular frequency, as Python's `complex`. Arrays are NumPy's, made once and
//! handed over. The interpreter lock is released while a solver works. Every error is an instance of
//! `rijke.RijkeError`.

mod convert;
mod fault;
mod forced;
mod forward;
mod model;
mod network;
mod posterior;
mod signals;
mod study;

/// The module as Python sees it.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::forward::rank;
    #[pymodule_export]
    use super::model::Model;
    #[pymodule_export]
    use super::network::Network;
    #[pymodule_export]
    use super::posterior::Posterior;
    #[pymodule_export]
    use super::study::{Run, Study, merge_searches};
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
