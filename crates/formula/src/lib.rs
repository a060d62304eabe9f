//! Formulas: text to a program in names that the caller gives, evaluated with exact derivatives. Does not
//! know what the names mean.
//!
//! A [`Scope`] lists the names with their units, a [`Context`] says which of them have a value where a
//! formula acts, and [`Formula::parse`] reads the text. The program then runs on jets
//! ([`Formula::evaluate`]), on a value with its slope in s ([`Formula::evaluate_in_s`]) or on plain numbers
//! ([`Formula::real`]).
//!
//! # Conventions
//!
//! * Numbers (`1.5e-3`, imaginary `2i`), names, `+ - * / ^`, parentheses, the constants `i`, `j` and `pi`,
//!   and the functions `sqrt exp ln log sin cos tan sinh cosh tanh bessel_ratio re im abs arg conj`. `log`
//!   is the natural logarithm, `bessel_ratio` is I1/I0. Names may be dotted, as `gauze.length`.
//! * Precedence is that of MATLAB and Python: `^` (or `**`) binds tighter than the minus before it, so
//!   `-2^2` is -4, and `2^-1` is 0.5. A chain `a^b^c` is refused, because MATLAB reads it from the left and
//!   Python from the right.
//! * Index 0 of every scope is `s` = sigma + i omega, time dependence e^{st}. Everything is analytic in s:
//!   `re`, `im`, `abs`, `arg` and `conj` of anything that depends on s are refused when the formula is
//!   read.
//! * Roots, logarithms and powers take their principal branches. 0^k is 0 with all its derivatives where the
//!   real part of k is positive.
//! * Parameters are real. A complex coefficient is written `alpha_r + i*alpha_i`.
//! * Values are in the units that the scope states; nothing is converted.
//! * No text makes the reader panic, and no value makes a formula panic: what has no value is NaN.
//!
//! # Folders
//!
//! `read` makes a tree of a text, `run` a program of the tree, `inspect` judges the program unrun. Each knows only those before it.
//!
//! # Example
//!
//! ```
//! use rijke_formula::{Context, Formula, Here, Kind, Name, Scope};
//! use rijke_numerics::{C64, Jet, JetSpace, Order};
//!
//! let mut scope = Scope::new();
//! let power = scope.add(Name {
//!     name: "gauze.power".into(),
//!     unit: "W".into(),
//!     meaning: "electrical power of the gauze".into(),
//!     kind: Kind::Global,
//! })?;
//! let parameters = ["k".to_owned(), "tau".to_owned()];
//! let definitions = [("lag".to_owned(), "exp(-s*tau)".to_owned())];
//! let (parameters, definitions) = (&parameters[..], &definitions[..]);
//! let context = Context { scope: &scope, here: &|_| true, parameters, definitions };
//!
//! let law = Formula::parse("-k*gauze.power*lag", &context)?;
//! assert_eq!(law.names_used(), [0, power]);
//! assert_eq!(law.unit_fault(&scope, &["1/W", "s"], "1"), None);
//! assert!(law.unit_fault(&scope, &["1/W", "1"], "1").unwrap().contains("exp is applied to"));
//!
//! // The value with its derivatives in k, tau and s.
//! let space = JetSpace::new(3, Order::First);
//! let [k, tau] = [1e-3, 2e-3].map(|x| C64::new(x, 0.0));
//! let (s, numbers) = (space.seed(2, C64::new(-10.0, 1000.0)), [f64::NAN, 150.0]);
//! let here = Here { space, numbers: &numbers, analytic: &[Some(&s), None] };
//! let value: Jet = law.evaluate(&here, &[space.seed(0, k), space.seed(1, tau)]);
//! let expected = -k * 150.0 * (-s.value() * tau).exp();
//! assert!((value.value() - expected).norm() < 1e-15);
//! assert!((value.gradient()[2] + tau * expected).norm() < 1e-15);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod formula;
mod inspect;
mod read;
mod run;
#[cfg(test)]
mod tests;

pub use formula::Formula;
pub use inspect::is_unit;
pub use read::{Context, FormulaError, Kind, Name, NameError, Problem, Scope};
pub use run::{Dual, Here};
