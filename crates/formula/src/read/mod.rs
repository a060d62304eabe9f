//! Text to a tree: names that a formula may use (`scope`), words (`lexer`), precedence (`parser`), named parts (`definitions`),
//! and what can be wrong (`problem`).
//!
//! Knows no values: what a tree is worth is for `run`.

pub(crate) mod definitions;
pub(crate) mod function;
pub(crate) mod lexer;
pub(crate) mod nearest;
pub(crate) mod parser;
pub(crate) mod problem;
pub(crate) mod scope;
pub(crate) mod tree;
