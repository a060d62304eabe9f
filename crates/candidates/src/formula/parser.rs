//! Tokens to a tree, by precedence climbing; names resolved and analyticity checked on the way.

use super::lexer::{Kind, Token};
use super::{Problem, Scope};
use crate::{SYMBOLS, Symbol};
use rijke_numerics::C64;

/// Nesting beyond which a formula is refused rather than risk the stack.
pub(super) const DEEPEST: usize = 100;

/// Tokens beyond which a formula is refused: a chain of sums makes a tree as deep as it is long.
pub(super) const LONGEST: usize = 1000;

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Tree {
    Number(C64),
    Symbol(Symbol),
    Parameter(usize),
    Negate(Box<Tree>),
    Binary(Binary, Box<Tree>, Box<Tree>),
    Call(Function, Box<Tree>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Sqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Sinh,
    Cosh,
    Tanh,
    BesselRatio,
    Re,
    Im,
    Abs,
    Arg,
    Conj,
}

/// Names of the functions; `log` is the natural logarithm, as in MATLAB and Python; `bessel_ratio` is I1/I0 for Re z >= 0.
const FUNCTIONS: [(&str, Function); 16] = [
    ("sqrt", Function::Sqrt),
    ("exp", Function::Exp),
    ("ln", Function::Ln),
    ("log", Function::Ln),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("bessel_ratio", Function::BesselRatio),
    ("re", Function::Re),
    ("im", Function::Im),
    ("abs", Function::Abs),
    ("arg", Function::Arg),
    ("conj", Function::Conj),
];

impl Function {
    /// Its name, if it is not analytic.
    fn not_analytic(self) -> Option<&'static str> {
        let (name, _) = FUNCTIONS.iter().find(|(_, f)| *f == self)?;
        matches!(self, Self::Re | Self::Im | Self::Abs | Self::Arg | Self::Conj).then_some(name)
    }
}

type Outcome<T> = Result<T, (usize, Problem)>;

struct Parser<'a> {
    tokens: &'a [Token<'a>],
    next: usize,
    end: usize,
    depth: usize,
    scope: &'a Scope<'a>,
}

/// Binding powers: sum, product, sign, power.
const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const SIGN: u8 = 3;
const POWER: u8 = 4;

/// The tree of a whole formula; `end` is the length of its text, where an error at the end points.
pub(super) fn parse(tokens: &[Token<'_>], end: usize, scope: &Scope<'_>) -> Outcome<Tree> {
    if let Some(token) = tokens.get(LONGEST) {
        return Err((token.at, Problem::TooLong));
    }
    let mut parser = Parser { tokens, next: 0, end, depth: 0, scope };
    let tree = parser.expression(SUM)?;
    match parser.peek() {
        None => Ok(tree),
        Some(_) => Err((parser.at(), Problem::MissingOperator)),
    }
}

impl<'a> Parser<'a> {
    fn peek(&self) -> Option<&'a Kind<'a>> {
        self.tokens.get(self.next).map(|t| &t.kind)
    }

    fn at(&self) -> usize {
        self.tokens.get(self.next).map_or(self.end, |t| t.at)
    }

    /// An operand and every operator after it that binds at least as tightly as `weakest`.
    fn expression(&mut self, weakest: u8) -> Outcome<Tree> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err((self.at(), Problem::TooDeep));
        }
        let mut left = self.operand(weakest)?;
        while let Some((operator, power)) = self.operator().filter(|(_, power)| *power >= weakest) {
            self.next += 1;
            // The exponent may carry its own sign, as in 2^-1; every other right operand must bind tighter.
            let right = self.expression(if power == POWER { POWER + 1 } else { power + 1 })?;
            if operator == Binary::Power && matches!(self.operator(), Some((Binary::Power, _))) {
                return Err((self.at(), Problem::ChainedPower));
            }
            left = Tree::Binary(operator, Box::new(left), Box::new(right));
        }
        self.depth -= 1;
        Ok(left)
    }

    fn operator(&self) -> Option<(Binary, u8)> {
        match self.peek()? {
            Kind::Sign('+') => Some((Binary::Add, SUM)),
            Kind::Sign('-') => Some((Binary::Subtract, SUM)),
            Kind::Sign('*') => Some((Binary::Multiply, PRODUCT)),
            Kind::Sign('/') => Some((Binary::Divide, PRODUCT)),
            Kind::Sign('^') => Some((Binary::Power, POWER)),
            _ => None,
        }
    }

    /// A number, name, call, parenthesis or signed operand. A sign inside an exponent binds as the exponent does, so
    /// that `2^-1^2` is seen to be a chain.
    fn operand(&mut self, weakest: u8) -> Outcome<Tree> {
        let sign = weakest.max(SIGN);
        let at = self.at();
        let kind = self.peek().ok_or((at, Problem::MissingOperand))?;
        self.next += 1;
        match *kind {
            Kind::Number(x) => Ok(Tree::Number(C64::new(x, 0.0))),
            Kind::Imaginary(x) => Ok(Tree::Number(C64::new(0.0, x))),
            Kind::Sign('-') => Ok(Tree::Negate(Box::new(self.expression(sign)?))),
            Kind::Sign('+') => self.expression(sign),
            Kind::Sign('(') => self.closed(at),
            Kind::Sign(_) => Err((at, Problem::MissingOperand)),
            Kind::Name(name) if self.peek() == Some(&Kind::Sign('(')) => self.call(at, name),
            Kind::Name(name) => self.name(at, name),
        }
    }

    /// What stands between an opening parenthesis at `open`, already read, and its closing one.
    fn closed(&mut self, open: usize) -> Outcome<Tree> {
        let inner = self.expression(SUM)?;
        match self.peek() {
            Some(Kind::Sign(')')) => {
                self.next += 1;
                Ok(inner)
            }
            Some(_) => Err((self.at(), Problem::MissingOperator)),
            None => Err((open, Problem::Unclosed)),
        }
    }

    fn call(&mut self, at: usize, name: &str) -> Outcome<Tree> {
        let Some((_, function)) = FUNCTIONS.iter().find(|(n, _)| *n == name) else {
            return Err((at, unknown(name, FUNCTIONS.iter().map(|(n, _)| (*n).to_owned()))));
        };
        let open = self.at();
        self.next += 1;
        let argument = self.closed(open)?;
        if let (Some(function), Some(symbol)) = (function.not_analytic(), argument.brings_s()) {
            return Err((at, Problem::NotAnalytic { function, through: symbol.meaning().name }));
        }
        Ok(Tree::Call(*function, Box::new(argument)))
    }

    fn name(&self, at: usize, name: &str) -> Outcome<Tree> {
        if let Some(index) = self.scope.parameters.iter().position(|p| p == name) {
            return Ok(Tree::Parameter(index));
        }
        if let Some(symbol) = Symbol::named(name) {
            let meaning = symbol.meaning();
            let missing = Problem::NotHere { name: meaning.name, meaning: meaning.text };
            return if self.scope.has(symbol) { Ok(Tree::Symbol(symbol)) } else { Err((at, missing)) };
        }
        match name {
            "i" | "j" => Ok(Tree::Number(C64::I)),
            "pi" => Ok(Tree::Number(C64::new(std::f64::consts::PI, 0.0))),
            _ => {
                let symbols = SYMBOLS.iter().filter(|m| self.scope.has(m.symbol)).map(|m| m.name.to_owned());
                let constants = ["i", "j", "pi"].map(str::to_owned);
                Err((
                    at,
                    unknown(name, self.scope.parameters.iter().cloned().chain(symbols).chain(constants)),
                ))
            }
        }
    }
}

impl Tree {
    /// The first symbol in the tree that depends on s.
    fn brings_s(&self) -> Option<Symbol> {
        match self {
            Self::Symbol(symbol) => Some(*symbol).filter(|s| s.meaning().depends_on_s),
            Self::Number(_) | Self::Parameter(_) => None,
            Self::Negate(inner) | Self::Call(_, inner) => inner.brings_s(),
            Self::Binary(_, left, right) => left.brings_s().or_else(|| right.brings_s()),
        }
    }
}

/// Whether `name` means something already, so that no parameter may be called so.
pub(crate) fn is_reserved(name: &str) -> bool {
    Symbol::named(name).is_some()
        || FUNCTIONS.iter().any(|(n, _)| *n == name)
        || ["i", "j", "pi"].contains(&name)
}

fn unknown(name: &str, known: impl Iterator<Item = String>) -> Problem {
    let known: Vec<String> = known.collect();
    let suggestion = nearest(name, &known);
    Problem::UnknownName { name: name.to_owned(), suggestion, known: known.join(", ") }
}

/// The known word within two edits of `name` (one for short names), if any.
fn nearest(name: &str, known: &[String]) -> Option<String> {
    let allowed = if name.chars().count() > 3 { 2 } else { 1 };
    let best = known.iter().map(|k| (edits(name, k), k)).min_by_key(|(d, _)| *d)?;
    (best.0 <= allowed).then(|| best.1.clone())
}

/// Levenshtein distance, upper and lower case alike.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
