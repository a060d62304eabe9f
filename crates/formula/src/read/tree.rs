//! A formula as a tree, and its operators.

use super::function::Function;
use super::scope::{Kind, Scope};
use rijke_numerics::C64;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Tree {
    Number(C64),
    /// A name of the scope, by its index.
    Name(usize, Kind),
    Parameter(usize),
    Negate(Box<Tree>),
    Binary(Binary, Box<Tree>, Box<Tree>),
    Call(Function, Box<Tree>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

impl Binary {
    /// As formulas write it.
    pub(crate) fn sign(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Subtract => "-",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Power => "^",
        }
    }
}

impl Tree {
    /// The first name in the tree that depends on s.
    pub(crate) fn brings_s<'a>(&self, scope: &'a Scope) -> Option<&'a str> {
        match self {
            Self::Name(index, Kind::Analytic) => scope.names().get(*index).map(|n| n.name.as_str()),
            Self::Name(..) | Self::Number(_) | Self::Parameter(_) => None,
            Self::Negate(inner) | Self::Call(_, inner) => inner.brings_s(scope),
            Self::Binary(_, left, right) => left.brings_s(scope).or_else(|| right.brings_s(scope)),
        }
    }
}
