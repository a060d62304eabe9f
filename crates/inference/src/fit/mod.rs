//! One maximum of a posterior: the cost J of a model with its data (`posterior`), and the search for its minimum (`map`).
//!
//! Knows no evidence, and does not ask whether there are other maxima.

pub(crate) mod approach;
pub(crate) mod held;
pub(crate) mod map;
pub(crate) mod memory;
pub(crate) mod posterior;
pub(crate) mod settle;
