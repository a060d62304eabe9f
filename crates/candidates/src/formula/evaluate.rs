//! A tree as a list of operations on a stack, run on jets.

use super::parser::{Binary, Function, Tree};
use crate::{Here, Symbol};
use rijke_numerics::{C64, Jet};

/// One step of the stack machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operation {
    Number(C64),
    Symbol(Symbol),
    Parameter(usize),
    Negate,
    Binary(Binary),
    Call(Function),
}

/// An operand: most of them carry no derivative, and are cheaper as plain numbers.
enum Operand {
    Number(C64),
    Jet(Jet),
}

use Operand::{Jet as J, Number as N};

pub(super) fn compile(tree: &Tree, program: &mut Vec<Operation>) {
    match tree {
        Tree::Number(z) => program.push(Operation::Number(*z)),
        Tree::Symbol(symbol) => program.push(Operation::Symbol(*symbol)),
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

pub(super) fn run(program: &[Operation], here: &Here<'_>, parameters: &[Jet]) -> Jet {
    let nothing = || N(C64::new(f64::NAN, f64::NAN));
    let mut stack: Vec<Operand> = Vec::with_capacity(8);
    for operation in program {
        let result = match *operation {
            Operation::Number(z) => N(z),
            Operation::Symbol(symbol) => match here.surroundings.get(symbol) {
                Some(real) => N(C64::new(real, 0.0)),
                None => here.jet(symbol).map_or_else(nothing, J),
            },
            Operation::Parameter(index) => parameters.get(index).cloned().map_or_else(nothing, J),
            Operation::Negate => match stack.pop().unwrap_or_else(nothing) {
                N(z) => N(-z),
                J(x) => J(-&x),
            },
            Operation::Binary(operator) => {
                let right = stack.pop().unwrap_or_else(nothing);
                let left = stack.pop().unwrap_or_else(nothing);
                binary(operator, left, right)
            }
            Operation::Call(function) => {
                // A number becomes a jet here: functions of numbers are rare, and one code path is enough.
                let argument = stack.pop().unwrap_or_else(nothing);
                J(call(function, &into_jet(argument, here)))
            }
        };
        stack.push(result);
    }
    into_jet(stack.pop().unwrap_or_else(nothing), here)
}

fn into_jet(operand: Operand, here: &Here<'_>) -> Jet {
    match operand {
        N(z) => here.space.constant(z),
        J(x) => x,
    }
}

fn binary(operator: Binary, left: Operand, right: Operand) -> Operand {
    match (operator, left, right) {
        (Binary::Add, N(a), N(b)) => N(a + b),
        (Binary::Add, N(a), J(b)) | (Binary::Add, J(b), N(a)) => J(b.shift(a)),
        (Binary::Add, J(a), J(b)) => J(&a + &b),
        (Binary::Subtract, N(a), N(b)) => N(a - b),
        (Binary::Subtract, N(a), J(b)) => J((-&b).shift(a)),
        (Binary::Subtract, J(a), N(b)) => J(a.shift(-b)),
        (Binary::Subtract, J(a), J(b)) => J(&a - &b),
        (Binary::Multiply, N(a), N(b)) => N(a * b),
        (Binary::Multiply, N(a), J(b)) | (Binary::Multiply, J(b), N(a)) => J(b.scale(a)),
        (Binary::Multiply, J(a), J(b)) => J(&a * &b),
        (Binary::Divide, N(a), N(b)) => N(a / b),
        (Binary::Divide, N(a), J(b)) => J(b.recip().scale(a)),
        (Binary::Divide, J(a), N(b)) => J(a.scale(b.inv())),
        (Binary::Divide, J(a), J(b)) => J(&a / &b),
        (Binary::Power, N(a), N(b)) => N(number_power(a, b)),
        (Binary::Power, J(a), N(b)) => J(jet_power(&a, b)),
        // 0^k with Re k > 0 is 0 with all its derivatives, where exp(k ln 0) is NaN: no power law of the heater's
        // power would survive the cold rig.
        (Binary::Power, N(a), J(b)) if a == C64::ZERO && b.value().re > 0.0 => J(b.scale(C64::ZERO)),
        (Binary::Power, N(a), J(b)) => J(b.scale(a.ln()).exp()),
        (Binary::Power, J(a), J(b)) => J((&b * &a.ln()).exp()),
    }
}

/// The integer that `z` is, if it is a small one.
fn small_integer(z: C64) -> Option<i32> {
    let whole = z.im == 0.0 && z.re.fract() == 0.0 && z.re.abs() <= 64.0;
    #[allow(clippy::cast_possible_truncation, reason = "an integer of at most 64 in modulus")]
    whole.then_some(z.re as i32)
}

fn number_power(a: C64, b: C64) -> C64 {
    match small_integer(b) {
        Some(n) => a.powi(n),
        None if b.im == 0.0 && a.im == 0.0 && a.re >= 0.0 => C64::new(a.re.powf(b.re), 0.0),
        None => a.powc(b),
    }
}

fn jet_power(a: &Jet, b: C64) -> Jet {
    match small_integer(b) {
        Some(n) => a.powi(n),
        None if b.im == 0.0 => a.powf(b.re),
        None => a.ln().scale(b).exp(),
    }
}

fn call(function: Function, x: &Jet) -> Jet {
    let half = C64::new(0.5, 0.0);
    match function {
        Function::Sqrt => x.sqrt(),
        Function::Exp => x.exp(),
        Function::Ln => x.ln(),
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
        Function::Tan => &x.sin() / &x.cos(),
        Function::Sinh => (&x.exp() - &(-x).exp()).scale(half),
        Function::Cosh => (&x.exp() + &(-x).exp()).scale(half),
        Function::Tanh => x.tanh(),
        Function::Re => x.re(),
        Function::Im => x.im(),
        Function::Abs => x.abs(),
        Function::Arg => x.ln().im(),
        Function::Conj => x.conj(),
    }
}
