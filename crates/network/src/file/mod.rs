//! Networks in a TOML file.
//!
//! `schema` is what a file may hold; `item` and `layout` find its elements and their lines; `row` puts
//! devices at one place one behind the other; `assembly` gathers segments and laws, which `duct`, `compact`,
//! `devices`, `ends`, `flow` and `hear` add; `build` makes the network.
//! Knows every room of the crate; none knows it.

mod account;
mod assembly;
mod build;
mod compact;
mod course;
mod devices;
mod driven;
mod duct;
mod ends;
mod error;
mod flow;
mod hear;
mod item;
mod layout;
mod named;
mod odd;
mod oscilos;
mod oscilos_doubt;
mod oscilos_rule;
mod problem;
mod ranges;
mod read;
mod redrawn;
mod row;
mod schema;
mod sizes;
mod spread;
mod warning;

pub use account::{Account, Actors, samples_of_each};
pub use build::Built;
pub use driven::{DrivenError, DrivenQuantity};
pub use error::FileError;
pub use named::{NamedNumbers, NumberError};
pub use oscilos::{OscilosError, OscilosTexts, read_oscilos};
pub use oscilos_doubt::doubts_of_oscilos;
pub use oscilos_rule::by_the_rule_of_oscilos;
pub use problem::ElementProblem;
pub use read::read;
pub use redrawn::{Scatter, moved_by_pieces, scatter};
pub use warning::Warning;
