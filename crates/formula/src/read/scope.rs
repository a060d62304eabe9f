//! The names that a formula may use, given by the caller.

use super::function::is_reserved;
use super::lexer;
use super::problem::NameError;

/// What a name stands for, and what is told of it in messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// As written in formulas: a letter or `_`, then letters, digits and `_`; or two such words with a
    /// point between them, as `gauze.length`.
    pub name: String,
    /// Its unit, as `W/(m K)`; see [`crate::is_unit`]. A unit that is not understood is not judged.
    pub unit: String,
    /// What it is, in a few words.
    pub meaning: String,
    /// Where its value is the same.
    pub kind: Kind,
}

/// Where the value of a name is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Real; the same at all places of an operating point.
    Global,
    /// Real; differs from place to place (gas, velocity, the diameter of a duct).
    Local,
    /// Depends on s, and therefore may not pass through a function that is not analytic.
    Analytic,
}

/// What a formula may name. A name's place in it, its index, never changes; index 0 is always `s`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scope {
    names: Vec<Name>,
}

/// Where a formula is read: its names, which of them have a value there, parameters and definitions.
///
/// A name is looked up among the parameters, then the definitions, the scope and the constants `i`, `j` and
/// `pi`. Parameters are not checked here; [`Scope::check`] tells whether one hides a name of the scope.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// All names.
    pub scope: &'a Scope,
    /// Whether the name with this index has a value where the formula acts.
    pub here: &'a dyn Fn(usize) -> bool,
    /// Names of the parameters, in order.
    pub parameters: &'a [String],
    /// Parts of the formula with a name: (name, text), in order. Each may use those before it, and each
    /// must be used.
    pub definitions: &'a [(String, String)],
}

impl Scope {
    /// The scope that contains `s` alone.
    #[must_use]
    pub fn new() -> Self {
        let [name, unit, meaning] =
            ["s", "1/s", "complex angular frequency, sigma + i omega"].map(str::to_owned);
        Self { names: vec![Name { name, unit, meaning, kind: Kind::Analytic }] }
    }

    /// Adds a name and returns its index.
    ///
    /// # Errors
    /// As [`Scope::check`].
    pub fn add(&mut self, name: Name) -> Result<usize, NameError> {
        self.check(&name.name)?;
        self.names.push(name);
        Ok(self.names.len() - 1)
    }

    /// Whether something new may be called `name`.
    ///
    /// # Errors
    /// [`NameError`] if it is no name, a function or a constant, or in the scope already.
    pub fn check(&self, name: &str) -> Result<(), NameError> {
        if !lexer::is_name(name) {
            return Err(NameError::NotAName(name.to_owned()));
        }
        if is_reserved(name) {
            return Err(NameError::Reserved(name.to_owned()));
        }
        match self.find(name).and_then(|index| self.names.get(index)) {
            Some(old) => Err(NameError::Double { name: name.to_owned(), meaning: old.meaning.clone() }),
            None => Ok(()),
        }
    }

    /// The index of `name`.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n.name == name)
    }

    /// All names, by index.
    #[must_use]
    pub fn names(&self) -> &[Name] {
        &self.names
    }

    /// How many names there are: the length of the slices in [`crate::Here`].
    #[must_use]
    #[allow(clippy::len_without_is_empty, reason = "a scope is never empty, because `s` is in it")]
    pub fn len(&self) -> usize {
        self.names.len()
    }
}

impl Default for Scope {
    fn default() -> Self {
        Self::new()
    }
}
