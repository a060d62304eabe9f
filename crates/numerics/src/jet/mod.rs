//! Complex numbers that carry their first and second derivatives.

mod operators;
mod order;
mod space;
#[cfg(test)]
mod tests;
mod values;

pub use order::{Order, packed};
pub use space::JetSpace;
pub use values::Jet;
