//! A tree as a list of operations in postfix order, run on jets.

use super::parser::{Binary, Function, Tree};
use crate::{Dual, Here, Surroundings, Symbol};
use rijke_numerics::C64;

/// One step; its operands come before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operation {
    Number(C64),
    Symbol(Symbol),
    Parameter(usize),
    Negate,
    Binary(Binary),
    Call(Function),
}

/// A number that a formula can be run on: a jet, or a value with its derivative in s.
pub(super) trait Analytic: Clone {
    /// The value alone.
    fn value(&self) -> C64;
    /// f(self), given f and its first two derivatives at the value.
    fn compose(&self, derivatives: [C64; 3]) -> Self;
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    fn scale(&self, factor: C64) -> Self;
    fn shift(&self, constant: C64) -> Self;
    /// Real part, imaginary part and conjugate: for what depends on real seeds alone.
    fn re(&self) -> Self;
    fn im(&self) -> Self;
    fn conj(&self) -> Self;
}

/// An operand: most of them carry no derivative, and are cheaper as plain numbers.
pub(super) enum Operand<T> {
    Number(C64),
    Full(T),
}

use Operand::{Full as J, Number as N};

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

/// `program` in given surroundings: what neither s nor a parameter enters is a number. Its value is the same to the last bit,
/// because the operations and their order are.
pub(super) fn folded(program: &[Operation], surroundings: &Surroundings) -> Vec<Operation> {
    let mut short: Vec<Operation> = Vec::with_capacity(program.len());
    for &operation in program {
        let known = match (operation, short.as_slice()) {
            (Operation::Symbol(symbol), _) => surroundings.get(symbol).map(|x| (0, C64::new(x, 0.0))),
            (Operation::Negate, [.., Operation::Number(z)]) => Some((1, -z)),
            (Operation::Binary(operator), [.., Operation::Number(a), Operation::Number(b)]) => {
                match binary::<Dual>(operator, N(*a), N(*b)) {
                    N(z) => Some((2, z)),
                    J(_) => None,
                }
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

/// Runs `program`; `parameter` gives a parameter by its number, `constant` a number as a `T`.
pub(super) fn run<T: Analytic>(
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

/// The operand whose last operation is just before `end`, which moves to its first: the program read backwards needs no
/// stack, and its depth is that of the tree, which the parser limits.
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
        Operation::Symbol(symbol) => match here.surroundings.get(symbol) {
            Some(real) => N(C64::new(real, 0.0)),
            None => here.of_s(symbol).map_or_else(nothing, |x| J(x.clone())),
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

#[inline]
fn binary<T: Analytic>(operator: Binary, left: Operand<T>, right: Operand<T>) -> Operand<T> {
    match (operator, left, right) {
        (Binary::Add, N(a), N(b)) => N(a + b),
        (Binary::Add, N(a), J(b)) | (Binary::Add, J(b), N(a)) => J(b.shift(a)),
        (Binary::Add, J(a), J(b)) => J(a.plus(&b)),
        (Binary::Subtract, N(a), N(b)) => N(a - b),
        (Binary::Subtract, N(a), J(b)) => J(b.scale(-C64::ONE).shift(a)),
        (Binary::Subtract, J(a), N(b)) => J(a.shift(-b)),
        (Binary::Subtract, J(a), J(b)) => J(a.minus(&b)),
        (Binary::Multiply, N(a), N(b)) => N(a * b),
        (Binary::Multiply, N(a), J(b)) | (Binary::Multiply, J(b), N(a)) => J(b.scale(a)),
        (Binary::Multiply, J(a), J(b)) => J(a.times(&b)),
        (Binary::Divide, N(a), N(b)) => N(a / b),
        (Binary::Divide, N(a), J(b)) => J(recip(&b).scale(a)),
        (Binary::Divide, J(a), N(b)) => J(a.scale(b.inv())),
        (Binary::Divide, J(a), J(b)) => J(a.times(&recip(&b))),
        (Binary::Power, N(a), N(b)) => N(number_power(a, b)),
        (Binary::Power, J(a), N(b)) => J(power(&a, b)),
        // 0^k with Re k > 0 is 0 with all its derivatives, where exp(k ln 0) is NaN: no power law of the heater's
        // power would survive the cold rig.
        (Binary::Power, N(a), J(b)) if a == C64::ZERO && b.value().re > 0.0 => J(b.scale(C64::ZERO)),
        (Binary::Power, N(a), J(b)) => J(call(Function::Exp, &b.scale(a.ln()))),
        (Binary::Power, J(a), J(b)) => J(call(Function::Exp, &b.times(&call(Function::Ln, &a)))),
    }
}

fn recip<T: Analytic>(x: &T) -> T {
    let r = x.value().inv();
    x.compose([r, -r * r, 2.0 * r * r * r])
}

/// The integer that `z` is, if it is a small one.
fn small_integer(z: C64) -> Option<i32> {
    let whole = z.im == 0.0 && z.re.fract() == 0.0 && z.re.abs() <= 64.0;
    #[allow(clippy::cast_possible_truncation, reason = "an integer of at most 64 in modulus")]
    whole.then_some(z.re as i32)
}

pub(super) fn number_power(a: C64, b: C64) -> C64 {
    match small_integer(b) {
        Some(n) => a.powi(n),
        None if b.im == 0.0 && a.im == 0.0 && a.re >= 0.0 => C64::new(a.re.powf(b.re), 0.0),
        None => a.powc(b),
    }
}

fn power<T: Analytic>(x: &T, b: C64) -> T {
    let z = x.value();
    match small_integer(b) {
        Some(n) => {
            let k = f64::from(n);
            let slope = if n == 0 { C64::ZERO } else { k * z.powi(n - 1) };
            let curvature = if n == 0 || n == 1 { C64::ZERO } else { k * (k - 1.0) * z.powi(n - 2) };
            x.compose([z.powi(n), slope, curvature])
        }
        None if b.im == 0.0 => {
            let p = b.re;
            x.compose([z.powf(p), p * z.powf(p - 1.0), p * (p - 1.0) * z.powf(p - 2.0)])
        }
        None => call(Function::Exp, &call(Function::Ln, x).scale(b)),
    }
}

/// An analytic function at z with its first two derivatives; none for the four that are not analytic, and `arg`.
fn derivatives(function: Function, z: C64) -> Option<[C64; 3]> {
    Some(match function {
        Function::Sqrt => {
            let root = root(z);
            let slope = 0.5 * root.inv();
            [root, slope, -0.5 * slope / z]
        }
        Function::Exp => [z.exp(); 3],
        Function::Ln => {
            let r = z.inv();
            [z.ln(), r, -r * r]
        }
        Function::Sin => [z.sin(), z.cos(), -z.sin()],
        Function::Cos => [z.cos(), -z.sin(), -z.cos()],
        Function::Tan => {
            let t = z.tan();
            let slope = 1.0 + t * t;
            [t, slope, 2.0 * t * slope]
        }
        Function::Sinh => [z.sinh(), z.cosh(), z.sinh()],
        Function::Cosh => [z.cosh(), z.sinh(), z.cosh()],
        Function::Tanh => {
            let t = z.tanh();
            let slope = 1.0 - t * t;
            [t, slope, -2.0 * t * slope]
        }
        Function::BesselRatio => {
            let r = rijke_network::wall::bessel_ratio(z);
            let slope = 1.0 - r / z - r * r;
            [r, slope, -slope / z + r / (z * z) - 2.0 * r * slope]
        }
        Function::Re | Function::Im | Function::Abs | Function::Arg | Function::Conj => return None,
    })
}

/// The principal square root, in a third of the time of one by way of the argument.
fn root(z: C64) -> C64 {
    let square = z.norm_sqr();
    if !square.is_normal() {
        return z.sqrt();
    }
    let long = (0.5 * (square.sqrt() + z.re.abs())).sqrt();
    let short = 0.5 * z.im.abs() / long;
    let [re, im] = if z.re >= 0.0 { [long, short] } else { [short, long] };
    C64::new(re, im.copysign(z.im))
}

fn call<T: Analytic>(function: Function, x: &T) -> T {
    match (derivatives(function, x.value()), function) {
        (Some(all), _) => x.compose(all),
        (None, Function::Re) => x.re(),
        (None, Function::Im) => x.im(),
        (None, Function::Abs) => call(Function::Sqrt, &x.times(&x.conj()).re()),
        (None, Function::Arg) => call(Function::Ln, x).im(),
        (None, _) => x.conj(),
    }
}

pub(super) fn number_call(function: Function, z: C64) -> C64 {
    let real = |x: f64| C64::new(x, 0.0);
    match (derivatives(function, z), function) {
        (Some([value, ..]), _) => value,
        (None, Function::Re) => real(z.re),
        (None, Function::Im) => real(z.im),
        (None, Function::Abs) => real(z.norm()),
        (None, Function::Arg) => real(z.arg()),
        (None, _) => z.conj(),
    }
}
