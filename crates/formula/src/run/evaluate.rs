//! A tree as a list of operations in postfix order, folded and run.

use super::analytic::{Analytic, Operand};
use super::calculus::{binary, call, number_binary, number_call};
use super::here::Here;
use crate::read::{Binary, Function, Kind, Tree};
use Operand::{Full as J, Number as N};
use rijke_numerics::C64;

/// One step; its operands come before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operation {
    Number(C64),
    /// A name of the scope by its index, by its kind.
    Global(usize),
    Local(usize),
    Analytic(usize),
    Parameter(usize),
    Negate,
    Binary(Binary),
    Call(Function),
}

pub(crate) fn compile(tree: &Tree, program: &mut Vec<Operation>) {
    match tree {
        Tree::Number(z) => program.push(Operation::Number(*z)),
        Tree::Name(index, kind) => program.push(match kind {
            Kind::Global => Operation::Global(*index),
            Kind::Local => Operation::Local(*index),
            Kind::Analytic => Operation::Analytic(*index),
        }),
        Tree::Parameter(index) => program.push(Operation::Parameter(*index)),
        Tree::Negate(inner) => {
            compile(inner, program);
            program.push(Operation::Negate);
        }
        Tree::Binary(operator, left, right) => {
            compile(left, program);
            compile(right, program);
            program.push(Operation::Binary(*operator));
        }
        Tree::Call(function, argument) => {
            compile(argument, program);
            program.push(Operation::Call(*function));
        }
    }
}

/// `program` where the real names and the first parameters have these values: what neither s nor another
/// parameter enters is a number. Its value is the same to the last bit, because the operations and their
/// order are.
pub(crate) fn folded(program: &[Operation], numbers: &[f64], parameters: &[f64]) -> Vec<Operation> {
    let mut short: Vec<Operation> = Vec::with_capacity(program.len());
    for &operation in program {
        let known = match (operation, short.as_slice()) {
            (Operation::Global(index) | Operation::Local(index), _) => {
                numbers.get(index).filter(|x| !x.is_nan()).map(|&x| (0, C64::new(x, 0.0)))
            }
            (Operation::Parameter(index), _) => parameters.get(index).map(|&x| (0, C64::new(x, 0.0))),
            (Operation::Negate, [.., Operation::Number(z)]) => Some((1, -z)),
            (Operation::Binary(operator), [.., Operation::Number(a), Operation::Number(b)]) => {
                Some((2, number_binary(operator, *a, *b)))
            }
            (Operation::Call(function), [.., Operation::Number(z)]) => Some((1, number_call(function, *z))),
            _ => None,
        };
        match known {
            Some((operands, z)) => {
                short.truncate(short.len() - operands);
                short.push(Operation::Number(z));
            }
            None => short.push(operation),
        }
    }
    short
}

/// Where the operand begins whose last operation is just before `end`.
pub(crate) fn start(program: &[Operation], end: usize) -> usize {
    let (mut at, mut missing) = (end, 1_usize);
    while missing > 0 && at > 0 {
        at -= 1;
        missing -= 1;
        missing += match program[at] {
            Operation::Binary(_) => 2,
            Operation::Negate | Operation::Call(_) => 1,
            _ => 0,
        };
    }
    at
}

/// Runs `program`; `parameter` gives a parameter by its number, `constant` a number as a `T`.
pub(crate) fn run<T: Analytic>(
    program: &[Operation],
    here: &Here<'_, T>,
    parameter: impl Fn(usize) -> Option<Operand<T>>,
    constant: impl Fn(C64) -> T,
) -> T {
    let mut end = program.len();
    match operand(program, &mut end, here, &parameter) {
        N(z) => constant(z),
        J(x) => x,
    }
}

/// The operand whose last operation is just before `end`, which moves to its first: the program read
/// backwards needs no stack, and its depth is that of the tree, which the parser limits.
fn operand<T: Analytic>(
    program: &[Operation],
    end: &mut usize,
    here: &Here<'_, T>,
    parameter: &impl Fn(usize) -> Option<Operand<T>>,
) -> Operand<T> {
    let nothing = || N(C64::new(f64::NAN, f64::NAN));
    let Some(operation) = end.checked_sub(1).and_then(|k| program.get(k)) else { return nothing() };
    *end -= 1;
    match *operation {
        Operation::Number(z) => N(z),
        Operation::Global(index) | Operation::Local(index) => match here.analytic.get(index) {
            Some(Some(x)) => J((*x).clone()),
            _ => N(C64::new(here.numbers.get(index).copied().unwrap_or(f64::NAN), 0.0)),
        },
        Operation::Analytic(index) => match here.analytic.get(index) {
            Some(Some(x)) => J((*x).clone()),
            _ => nothing(),
        },
        Operation::Parameter(index) => parameter(index).unwrap_or_else(nothing),
        Operation::Negate => match operand(program, end, here, parameter) {
            N(z) => N(-z),
            J(x) => J(x.scale(-C64::ONE)),
        },
        Operation::Binary(operator) => {
            let right = operand(program, end, here, parameter);
            let left = operand(program, end, here, parameter);
            binary(operator, left, right)
        }
        Operation::Call(function) => match operand(program, end, here, parameter) {
            N(z) => N(number_call(function, z)),
            J(x) => J(call(function, &x)),
        },
    }
}
