//! What can be wrong with a formula or a name, and where; the limits of what is read.

/// Why a text is not a formula, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("in the {} `{source_text}`, at character {}: {problem}", self.what(), self.character())]
pub struct FormulaError {
    /// The formula, or the definition that is at fault.
    pub source_text: String,
    /// The name of the definition, if `source_text` is one.
    pub definition: Option<String>,
    /// Offset in bytes from the start of `source_text`.
    pub at: usize,
    /// What is wrong there.
    pub problem: Box<FormulaProblem>,
}

impl FormulaError {
    fn what(&self) -> String {
        self.definition.as_ref().map_or("formula".to_owned(), |name| format!("definition of `{name}`,"))
    }

    /// The place of the fault, counted from 1.
    fn character(&self) -> usize {
        self.source_text.get(..self.at).map_or(self.at, |before| before.chars().count()) + 1
    }
}

/// What is wrong with a formula.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FormulaProblem {
    /// A character that no formula contains.
    #[error("{} has no place in formulas: known are + - * / ^, brackets, commas, numbers and names", shown(*.0))]
    Character(char),
    /// A number that breaks off.
    #[error("this number is not complete: write it as 2, 2.5 or 2.5e-3")]
    BrokenNumber,
    /// A function without its argument.
    #[error("`{name}` is a function: give its argument in parentheses, as in {name}(s)")]
    FunctionAlone {
        /// Its name.
        name: String,
    },
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
    /// A name that has a value elsewhere, but not where this formula acts.
    #[error("`{name}` ({meaning}) does not exist where this formula acts")]
    NotHere {
        /// The name.
        name: String,
        /// What it means.
        meaning: String,
    },
    /// A function that is not analytic is applied to something that depends on s.
    #[error(
        "`{function}` is not analytic, and its argument depends on s through `{through}`; continue the law analytically instead \
         (a phase lag Im(s)*tau is exp(-s*tau))"
    )]
    NotAnalytic {
        /// The function.
        function: &'static str,
        /// The name that brings s in.
        through: String,
    },
    /// Something may not be called as a definition is.
    #[error("a definition cannot have this name: {0}")]
    DefinitionName(NameError),
    /// A definition that uses itself or one after it, so that a circle cannot arise.
    #[error("`{name}` is defined only here or later; a definition may use only those before it")]
    DefinedLater {
        /// What is used.
        name: String,
    },
    /// A definition that does not enter the formula.
    #[error("`{name}` is defined but never used; use it or remove it")]
    UnusedDefinition {
        /// The definition.
        name: String,
    },
    /// Deeper than the parser allows.
    #[error("the formula is nested more than {DEEPEST} deep")]
    TooDeep,
    /// Longer than the parser allows.
    #[error("the formula has more than {LONGEST} words, those of its definitions counted at every use")]
    TooLong,
}

/// Why something may not be called so.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NameError {
    /// No formula could contain it as one name.
    #[error(
        "`{0}` is not a name: write a letter or _, then letters, digits and _; two such words may stand with a point between \
         them, as in `gauze.length`"
    )]
    NotAName(String),
    /// The name of a function or a constant.
    #[error("`{0}` is a function or a constant in every formula; choose another name")]
    Reserved(String),
    /// Something is called so already.
    #[error("`{name}` is there already ({meaning}); choose another name")]
    Double {
        /// The name.
        name: String,
        /// What it stands for.
        meaning: String,
    },
}

/// Nesting beyond which a formula is refused rather than risk the stack.
pub(crate) const DEEPEST: usize = 100;

/// Tokens beyond which a formula with its definitions is refused: a chain of sums makes a tree as deep as
/// it is long.
pub(crate) const LONGEST: usize = 2000;

/// What was read, or the place and the kind of the fault.
pub(crate) type Outcome<T> = Result<T, (usize, FormulaProblem)>;

fn hint(suggestion: Option<&str>) -> String {
    suggestion.map(|s| format!("did you mean `{s}`? ")).unwrap_or_default()
}

/// A character as people see it, or its number if they do not.
fn shown(c: char) -> String {
    if c.is_whitespace() || c.is_control() {
        format!("the invisible character U+{:04X}", u32::from(c))
    } else {
        format!("`{c}`")
    }
}
