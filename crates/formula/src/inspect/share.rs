//! Laws that are a number of the place times something that is the same everywhere.
//!
//! The losses of fifty segments with fifty temperatures are often one function of s and the parameters,
//! times a real number of the local gas: sqrt(s rho mu) = sqrt(rho mu) sqrt(s). Then the function is
//! evaluated once.

use crate::read::{Binary, Function};
use crate::run::{Operation, number_binary, number_call};
use rijke_numerics::C64;

/// What a part of a formula is, seen from one place.
#[derive(Clone, Copy)]
enum Part {
    /// A known number, the same everywhere.
    Number(C64),
    /// A known real number of this place.
    Local(f64),
    /// This real number of the place, times an unknown that is the same everywhere.
    Scaled(f64),
}

use Part::{Local, Number, Scaled};

/// g such that the program's value is g times something that is the same at all places, if its form shows
/// that it is. `numbers` are the values of the real names here, `analytic` the g of those that depend on s.
pub(crate) fn scale(program: &[Operation], numbers: &[f64], analytic: &[Option<f64>]) -> Option<f64> {
    let known = |index: usize| numbers.get(index).copied().filter(|x| !x.is_nan());
    let mut stack: Vec<Part> = Vec::with_capacity(8);
    for operation in program {
        let part = match *operation {
            Operation::Number(z) => Number(z),
            Operation::Global(index) => Number(C64::new(known(index)?, 0.0)),
            Operation::Local(index) => Local(known(index)?),
            Operation::Analytic(index) => Scaled(*analytic.get(index)?.as_ref()?),
            Operation::Parameter(_) => Scaled(1.0),
            Operation::Negate => match stack.pop()? {
                Number(z) => Number(-z),
                Local(v) => Local(-v),
                scaled => scaled,
            },
            Operation::Binary(operator) => {
                let right = stack.pop()?;
                binary(operator, stack.pop()?, right)?
            }
            Operation::Call(function) => call(function, stack.pop()?)?,
        };
        stack.push(part);
    }
    match stack.pop()? {
        Number(_) => Some(1.0),
        Local(g) | Scaled(g) => Some(g),
    }
}

fn binary(operator: Binary, left: Part, right: Part) -> Option<Part> {
    let real = |z: C64| (z.im == 0.0).then_some(z.re);
    Some(match (operator, left, right) {
        (operator, Number(a), Number(b)) => Number(number_binary(operator, a, b)),

        (Binary::Add, Local(a), Local(b)) => Local(a + b),
        (Binary::Subtract, Local(a), Local(b)) => Local(a - b),
        (Binary::Multiply, Local(a), Local(b)) => Local(a * b),
        (Binary::Divide, Local(a), Local(b)) => Local(a / b),
        (Binary::Add, Local(a), Number(b)) | (Binary::Add, Number(b), Local(a)) => Local(a + real(b)?),
        (Binary::Subtract, Local(a), Number(b)) => Local(a - real(b)?),
        (Binary::Subtract, Number(a), Local(b)) => Local(real(a)? - b),

        // A sum has a common factor only if both parts have the same one.
        (Binary::Add | Binary::Subtract, Scaled(a), Scaled(b)) if a == b => Scaled(a),
        (Binary::Add | Binary::Subtract, Scaled(1.0), Number(_))
        | (Binary::Add | Binary::Subtract, Number(_), Scaled(1.0)) => Scaled(1.0),

        (Binary::Multiply, Scaled(a), Scaled(b)) => Scaled(a * b),
        (Binary::Divide, Scaled(a), Scaled(b)) => Scaled(a / b),
        (Binary::Multiply, Scaled(a), Number(_)) | (Binary::Multiply, Number(_), Scaled(a)) => Scaled(a),
        (Binary::Divide, Scaled(a), Number(_)) => Scaled(a),
        (Binary::Divide, Number(_), Scaled(a)) => Scaled(1.0 / a),
        (Binary::Multiply, Scaled(a), Local(b)) | (Binary::Multiply, Local(b), Scaled(a)) => Scaled(a * b),
        (Binary::Divide, Scaled(a), Local(b)) => Scaled(a / b),
        (Binary::Divide, Local(a), Scaled(b)) => Scaled(a / b),
        (Binary::Multiply, Local(a), Number(b)) | (Binary::Multiply, Number(b), Local(a)) => {
            real(b).map_or(Scaled(a), |b| Local(a * b))
        }
        (Binary::Divide, Local(a), Number(b)) => real(b).map_or(Scaled(a), |b| Local(a / b)),
        (Binary::Divide, Number(a), Local(b)) => real(a).map_or(Scaled(1.0 / b), |a| Local(a / b)),

        // (g x)^n = g^n x^n on the principal branch for g > 0.
        (Binary::Power, Local(a), Number(n)) if a > 0.0 => Local(a.powf(real(n)?)),
        (Binary::Power, Scaled(a), Number(n)) if a > 0.0 => Scaled(a.powf(real(n)?)),
        (Binary::Power, Scaled(1.0), Scaled(1.0)) | (Binary::Power, Number(_), Scaled(1.0)) => Scaled(1.0),
        _ => return None,
    })
}

fn call(function: Function, part: Part) -> Option<Part> {
    match (function, part) {
        (_, Number(z)) => Some(Number(number_call(function, z))),
        (_, Local(v)) => {
            let value = number_call(function, C64::new(v, 0.0));
            (value.im == 0.0).then_some(Local(value.re))
        }
        (Function::Sqrt, Scaled(g)) if g > 0.0 => Some(Scaled(g.sqrt())),
        (Function::Re | Function::Im | Function::Conj, Scaled(g)) => Some(Scaled(g)),
        (Function::Abs, Scaled(g)) => Some(Scaled(g.abs())),
        (_, Scaled(1.0)) => Some(Scaled(1.0)),
        _ => None,
    }
}
