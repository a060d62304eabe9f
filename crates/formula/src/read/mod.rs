//! Text to a tree: names that a formula may use (`scope`), words (`lexer`), precedence (`parser`), named
//! parts (`definitions`), and what can be wrong (`problem`).
//!
//! Knows no values: what a tree is worth is for `run`.

pub(crate) mod definitions;
mod function;
mod lexer;
mod nearest;
mod parser;
mod problem;
mod scope;
mod tree;

pub use problem::{FormulaError, FormulaProblem, NameError};
pub use scope::{Context, Kind, Name, Scope};

pub(crate) use function::Function;
pub(crate) use tree::{Binary, Tree};
