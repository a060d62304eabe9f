//! Tokens to a tree, by precedence climbing; names resolved and analyticity checked on the way.

use super::function::{CONSTANTS, FUNCTIONS};
use super::lexer::{Kind, Token};
use super::nearest::unknown;
use super::problem::{DEEPEST, FormulaProblem, LONGEST, Outcome};
use super::scope::Context;
use super::tree::{Binary, Tree};
use rijke_numerics::C64;

/// A definition that has been read.
pub(crate) struct Definition<'a> {
    pub(crate) name: &'a str,
    pub(crate) tree: Tree,
    /// How many words it has, with those of the definitions that it uses.
    pub(crate) words: usize,
    /// Whether anything after it uses it.
    pub(crate) used: bool,
}

struct Parser<'a, 'd> {
    tokens: &'a [Token<'a>],
    next: usize,
    end: usize,
    depth: usize,
    /// Tokens, with those of the definitions put in so far.
    words: usize,
    context: &'a Context<'a>,
    before: &'a mut [Definition<'d>],
}

/// Binding powers: sum, product, sign, power.
const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const SIGN: u8 = 3;
const POWER: u8 = 4;

/// The tree of a whole formula with the number of its words; `end` is the length of its text, where an
/// error at the end points, and `before` holds the definitions that it may use.
pub(crate) fn parse(
    tokens: &[Token<'_>],
    end: usize,
    context: &Context<'_>,
    before: &mut [Definition<'_>],
) -> Outcome<(Tree, usize)> {
    if let Some(token) = tokens.get(LONGEST) {
        return Err((token.at, FormulaProblem::TooLong));
    }
    let mut parser = Parser { tokens, next: 0, end, depth: 0, words: tokens.len(), context, before };
    let tree = parser.expression(SUM)?;
    match parser.peek() {
        None => Ok((tree, parser.words)),
        Some(_) => Err((parser.at(), FormulaProblem::MissingOperator)),
    }
}

impl<'a> Parser<'a, '_> {
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
            return Err((self.at(), FormulaProblem::TooDeep));
        }
        let mut left = self.operand(weakest)?;
        while let Some((operator, power)) = self.operator().filter(|(_, power)| *power >= weakest) {
            self.next += 1;
            // The exponent may carry its own sign, as in 2^-1; every other right operand must bind tighter.
            let right = self.expression(if power == POWER { POWER + 1 } else { power + 1 })?;
            if operator == Binary::Power && matches!(self.operator(), Some((Binary::Power, _))) {
                return Err((self.at(), FormulaProblem::ChainedPower));
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

    /// A number, name, call, parenthesis or signed operand. A sign inside an exponent binds as the exponent
    /// does, so that `2^-1^2` is seen to be a chain.
    fn operand(&mut self, weakest: u8) -> Outcome<Tree> {
        let sign = weakest.max(SIGN);
        let at = self.at();
        let kind = self.peek().ok_or((at, FormulaProblem::MissingOperand))?;
        self.next += 1;
        match *kind {
            Kind::Number(x) => Ok(Tree::Number(C64::new(x, 0.0))),
            Kind::Imaginary(x) => Ok(Tree::Number(C64::new(0.0, x))),
            Kind::Sign('-') => Ok(Tree::Negate(Box::new(self.expression(sign)?))),
            Kind::Sign('+') => self.expression(sign),
            Kind::Sign('(') => self.closed(at),
            Kind::Sign(_) => Err((at, FormulaProblem::MissingOperand)),
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
            Some(_) => Err((self.at(), FormulaProblem::MissingOperator)),
            None => Err((open, FormulaProblem::Unclosed)),
        }
    }

    fn call(&mut self, at: usize, name: &str) -> Outcome<Tree> {
        let Some((_, function)) = FUNCTIONS.iter().find(|(n, _)| *n == name) else {
            return Err((at, unknown(name, FUNCTIONS.iter().map(|(n, _)| *n))));
        };
        let open = self.at();
        self.next += 1;
        let argument = self.closed(open)?;
        match argument.brings_s(self.context.scope) {
            Some(through) if !function.is_analytic() => {
                let (function, through) = (function.name(), through.to_owned());
                Err((at, FormulaProblem::NotAnalytic { function, through }))
            }
            _ => Ok(Tree::Call(*function, Box::new(argument))),
        }
    }

    fn name(&mut self, at: usize, name: &str) -> Outcome<Tree> {
        let Context { scope, here, parameters, definitions } = *self.context;
        if let Some(index) = parameters.iter().position(|p| p == name) {
            return Ok(Tree::Parameter(index));
        }
        if let Some(definition) = self.before.iter_mut().find(|d| d.name == name) {
            definition.used = true;
            self.words += definition.words;
            return if self.words > LONGEST {
                Err((at, FormulaProblem::TooLong))
            } else {
                Ok(definition.tree.clone())
            };
        }
        if definitions.iter().any(|(later, _)| later == name) {
            return Err((at, FormulaProblem::DefinedLater { name: name.to_owned() }));
        }
        if let Some((index, found)) = scope.names().iter().enumerate().find(|(_, n)| n.name == name) {
            let missing =
                || FormulaProblem::NotHere { name: found.name.clone(), meaning: found.meaning.clone() };
            return if here(index) { Ok(Tree::Name(index, found.kind)) } else { Err((at, missing())) };
        }
        if let Some((_, constant)) = CONSTANTS.iter().find(|(n, _)| *n == name) {
            return Ok(Tree::Number(*constant));
        }
        if FUNCTIONS.iter().any(|(n, _)| *n == name) {
            return Err((at, FormulaProblem::FunctionAlone { name: name.to_owned() }));
        }
        let known = parameters.iter().map(String::as_str);
        let known = known.chain(self.before.iter().map(|d| d.name));
        let here = scope.names().iter().enumerate().filter(|(index, _)| here(*index));
        let known = known.chain(here.map(|(_, n)| n.name.as_str())).chain(CONSTANTS.iter().map(|(n, _)| *n));
        Err((at, unknown(name, known)))
    }
}
