//! Numbers and small algebra that every other crate of the workspace stands on; knows no physics.
//!
//! * [`Jet`]: a complex number that carries its gradient and Hessian.
//! * [`Matrix`], [`Cholesky`], [`lu_solve`] and friends: small dense algebra behind two files, so that the
//!   linear-algebra library never appears in a public signature.
//! * [`Streams`]: named random streams from one seed, the same for any number of threads.
//! * [`special`]: special functions of a complex variable, and Legendre's polynomials.
//! * [`read_text`], [`open_file`]: files of others, which may be pipes, devices, or too large.
//! * [`check`]: Taylor slopes and orders of convergence, for tests.
//!
//! # Conventions
//!
//! Complex numbers are [`C64`]. Matrices are real, row-major, indexed `m[(row, column)]`.
//! Nothing here prints, reads a clock, or keeps global state.
//!
//! # Example
//!
//! ```
//! use rijke_numerics::{C64, JetSpace, Order};
//! let space = JetSpace::new(2, Order::Second);
//! let (a, b) = (space.seed(0, C64::new(2.0, 0.0)), space.seed(1, C64::new(3.0, 0.0)));
//! let f = &(&a * &a) * &b; // a^2 b
//! assert_eq!(f.value().re, 12.0);
//! assert_eq!(f.gradient()[0].re, 12.0); // 2ab
//! assert_eq!(f.hessian(0, 1).re, 4.0); // 2a
//! ```

pub mod check;
mod cholesky;
mod dense;
mod files;
mod jet;
mod product;
pub mod special;
mod streams;

pub use cholesky::Cholesky;
pub use dense::{
    DenseError, Matrix, complex_eigenvalues, complex_lu_solve, dot, least_direction, least_squares_sd,
    lu_solve, symmetric_eigen,
};
pub use files::{LARGEST_TEXT, Unreadable, open_file, read_bytes, read_text};
pub use jet::{Jet, JetSpace, Order};
pub use streams::{Stream, Streams};

/// A complex number in double precision.
pub type C64 = num_complex::Complex<f64>;
