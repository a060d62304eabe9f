#![doc = include_str!("../README.md")]

mod beyond;
pub mod check;
mod cholesky;
mod complex_dual;
mod dense;
mod empty_ends;
mod failure;
mod field;
mod files;
mod howe;
mod in_order;
mod jet;
mod median;
mod output;
mod product;
mod range;
pub mod rational;
mod routh;
pub mod slips;
mod solvers;
pub mod special;
mod streams;
pub mod tails;
mod tell;
mod two_part;
mod whole;
pub mod wide;
pub mod words;

pub use beyond::scatter_beyond;
pub use cholesky::{Cholesky, forward};
pub use complex_dual::ComplexDual;
pub use dense::{DenseError, Matrix, dot, interpolate};
pub use empty_ends::{BehindHeadings, csv_without_empty_ends, without_empty_ends};
pub use failure::{Blame, Classify, Failed};
pub use field::{GridField, Lines, Zero};
pub use files::{LARGEST_TEXT, Unreadable, open_file, read_bytes, read_text};
pub use howe::{howe, howe_parts};
pub use in_order::InOrder;
pub use jet::{Jet, JetSpace, Order, packed};
pub use median::median;
pub use output::{Lock, StagedFolder, keep_others, write_output, write_within};
pub use range::range;
pub use routh::has_growing_root;
pub use streams::{Stream, Streams};
pub use tell::Tell;
pub use two_part::{Grows, TwoPart};
pub use whole::{write_through, write_whole};

/// A complex number in double precision.
pub type C64 = num_complex::Complex<f64>;
pub use solvers::{
    complex_eigenvalues, complex_lu_solve, least_direction, least_squares_sd, lu_solve, principal_directions,
    symmetric_eigen,
};
