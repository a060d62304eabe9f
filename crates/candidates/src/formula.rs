//! Formulas: text to a program, evaluated on jets.
//!
//! Grammar: numbers (`1.5e-3`, imaginary `2i`), names, functions, `+ - * / ^`, parentheses. Precedence is that of
//! MATLAB and Python: `^` (or `**`) binds tighter than the minus before it, so `-2^2` is -4, and `2^-1` is 0.5. A
//! chain `a^b^c` is refused, because MATLAB reads it from the left and Python from the right.

mod analytic;
mod evaluate;
mod lexer;
mod parser;
mod share;
#[cfg(test)]
mod tests;
mod units;

use crate::{Coefficient, Dual, Here, Place, Surroundings, Symbol};
use evaluate::{Operand, Operation};
pub(crate) use parser::is_reserved;
use rijke_numerics::{C64, Jet};
pub use units::unit_fault;

/// A formula in the symbols of [`crate::SYMBOLS`] and named parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    source: String,
    program: Vec<Operation>,
}

/// Which names a formula may use, and where its value will act.
#[derive(Clone, Copy, Debug)]
pub struct Scope<'a> {
    /// Names of the parameters, in order.
    pub parameters: &'a [String],
    /// Where the value acts: decides whether `wall_mu`, `wall_ep` and `R_LS` exist.
    pub place: Place,
    /// What it acts on.
    pub coefficient: Coefficient,
}

/// Why a text is not a formula, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("in the formula `{source_text}`, at character {at}: {problem}", at = at + 1)]
pub struct FormulaError {
    /// The formula.
    pub source_text: String,
    /// Offset in bytes from its start.
    pub at: usize,
    /// What is wrong there.
    pub problem: Problem,
}

/// What is wrong with a formula.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A character that no formula contains.
    #[error("`{0}` does not belong into a formula")]
    Character(char),
    /// An operand is missing.
    #[error("a number, a name or an opening parenthesis is missing here")]
    MissingOperand,
    /// Something follows a complete expression.
    #[error("an operator (+ - * / ^) is missing here")]
    MissingOperator,
    /// A parenthesis is not closed.
    #[error("this parenthesis is never closed")]
    Unclosed,
    /// `a^b^c`.
    #[error("write (a^b)^c or a^(b^c): MATLAB and Python read a chain of powers differently")]
    ChainedPower,
    /// A name that nobody knows.
    #[error("`{name}` is not known; {}the names known here are: {known}", hint(suggestion.as_deref()))]
    UnknownName {
        /// The name.
        name: String,
        /// The nearest known name, if one is near.
        suggestion: Option<String>,
        /// All names that could stand here, separated by commas.
        known: String,
    },
    /// A symbol that exists elsewhere, but not where this formula acts.
    #[error("`{name}` ({meaning}) does not exist where this formula acts")]
    NotHere {
        /// The symbol.
        name: &'static str,
        /// What it means.
        meaning: &'static str,
    },
    /// A function that is not analytic is applied to something that depends on s.
    #[error(
        "`{function}` is not analytic, and its argument depends on s through `{through}`; continue the law analytically instead \
         (a phase lag Im(s)*tau is exp(-s*tau))"
    )]
    NotAnalytic {
        /// The function.
        function: &'static str,
        /// The symbol that brings s in.
        through: &'static str,
    },
    /// Deeper than the parser allows.
    #[error("the formula is nested more than {} deep", parser::DEEPEST)]
    TooDeep,
    /// Longer than the parser allows.
    #[error("the formula has more than {} words", parser::LONGEST)]
    TooLong,
}

fn hint(suggestion: Option<&str>) -> String {
    suggestion.map(|s| format!("did you mean `{s}`? ")).unwrap_or_default()
}

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// [`FormulaError`], with the offset of the first thing that is wrong.
    pub fn parse(source: &str, scope: &Scope<'_>) -> Result<Self, FormulaError> {
        let at_source = |(at, problem)| FormulaError { source_text: source.to_owned(), at, problem };
        let tokens = lexer::tokens(source).map_err(at_source)?;
        let tree = parser::parse(&tokens, source.len(), scope).map_err(at_source)?;
        let mut program = Vec::new();
        evaluate::compile(&tree, &mut program);
        Ok(Self { source: source.to_owned(), program })
    }

    /// The formula as it was written.
    #[must_use]
    pub fn source(&self) -> &str {
        &self.source
    }

    /// Its value, with derivatives. A symbol that does not exist `here` (excluded when the formula was parsed with
    /// the right scope) or a missing parameter gives NaN, never a panic.
    #[must_use]
    pub fn evaluate(&self, here: &Here<'_>, parameters: &[Jet]) -> Jet {
        let parameter = |index: usize| parameters.get(index).cloned().map(Operand::Full);
        evaluate::run(&self.program, here, parameter, |z| here.space.constant(z))
    }

    /// As [`Formula::evaluate`], with the derivative with respect to s alone: without parameters as seeds it needs no
    /// jets.
    #[must_use]
    pub fn evaluate_in_s(&self, here: &Here<'_, Dual>, parameters: &[f64]) -> Dual {
        let number = |value: &f64| Operand::Number(C64::new(*value, 0.0));
        let parameter = |index: usize| parameters.get(index).map(number);
        evaluate::run(&self.program, here, parameter, |value| Dual { value, slope: C64::ZERO })
    }

    /// The same formula for these surroundings alone, with all arithmetic done that neither s nor a parameter enters.
    #[must_use]
    pub fn at(&self, surroundings: &Surroundings) -> Self {
        Self { source: self.source.clone(), program: evaluate::folded(&self.program, surroundings) }
    }

    /// g such that the value is g times something that is the same wherever the gas differs, if the form of the formula
    /// shows that; `wall` holds g of `wall_mu` and of `wall_ep`.
    #[must_use]
    pub fn scale(&self, surroundings: &Surroundings, wall: [Option<f64>; 2]) -> Option<f64> {
        share::scale(&self.program, surroundings, wall)
    }

    /// Whether it contains `symbol`.
    #[must_use]
    pub fn uses(&self, symbol: Symbol) -> bool {
        self.program.contains(&Operation::Symbol(symbol))
    }

    /// Whether it contains parameter number `index`.
    #[must_use]
    pub fn uses_parameter(&self, index: usize) -> bool {
        self.program.contains(&Operation::Parameter(index))
    }
}

impl Scope<'_> {
    /// Whether `symbol` has a value where the formula acts.
    fn has(&self, symbol: Symbol) -> bool {
        match symbol {
            Symbol::WallMu | Symbol::WallEp => self.place != Place::Tube,
            Symbol::LevineSchwinger => self.place.is_end(),
            _ => true,
        }
    }
}
