//! Operators and functions on plain numbers, and with their derivatives.

use super::analytic::{Analytic, Operand};
use crate::read::{Binary, Function};
use Operand::{Full as J, Number as N};
use rijke_numerics::{C64, ComplexDual};

#[inline]
pub(crate) fn binary<T: Analytic>(operator: Binary, left: Operand<T>, right: Operand<T>) -> Operand<T> {
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
        // 0^k with Re k > 0 is 0 with all its derivatives, where exp(k ln 0) is NaN: no power law of the
        // gauze's power would survive the cold rig.
        (Binary::Power, N(a), J(b)) if a == C64::ZERO && b.value().re > 0.0 => J(b.scale(C64::ZERO)),
        (Binary::Power, N(a), J(b)) => J(call(Function::Exp, &b.scale(above(a).ln()))),
        (Binary::Power, J(a), J(b)) => J(call(Function::Exp, &b.times(&call(Function::Ln, &a)))),
    }
}

pub(crate) fn number_binary(operator: Binary, a: C64, b: C64) -> C64 {
    match binary::<ComplexDual>(operator, N(a), N(b)) {
        N(z) => z,
        J(dual) => dual.value,
    }
}

#[inline]
fn recip<T: Analytic>(x: &T) -> T {
    let r = x.value().inv();
    x.compose([r, -r * r, 2.0 * r * r * r])
}

/// The integer that `z` is, if it is a small one.
#[inline]
fn small_integer(z: C64) -> Option<i32> {
    let whole = z.im == 0.0 && z.re.fract() == 0.0 && z.re.abs() <= 64.0;
    #[allow(clippy::cast_possible_truncation, reason = "an integer of at most 64 in modulus")]
    whole.then_some(z.re as i32)
}

fn number_power(a: C64, b: C64) -> C64 {
    match small_integer(b) {
        Some(n) => a.powi(n),
        None if b.im == 0.0 && a.im == 0.0 && a.re >= 0.0 => C64::new(a.re.powf(b.re), 0.0),
        None => above(a).powc(b),
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
            let (p, z) = (b.re, above(z));
            x.compose([z.powf(p), p * z.powf(p - 1.0), p * (p - 1.0) * z.powf(p - 2.0)])
        }
        None => call(Function::Exp, &call(Function::Ln, x).scale(b)),
    }
}

/// An analytic function at z with its first two derivatives; none for the four that are not analytic, and
/// `arg`.
fn derivatives(function: Function, z: C64) -> Option<[C64; 3]> {
    Some(match function {
        Function::Sqrt => {
            let root = root(above(z));
            let slope = 0.5 * root.inv();
            [root, slope, -0.5 * slope / z]
        }
        Function::Exp => [z.exp(); 3],
        Function::Ln => {
            let r = z.inv();
            [above(z).ln(), r, -r * r]
        }
        Function::Sin => [z.sin(), z.cos(), -z.sin()],
        Function::Cos => [z.cos(), -z.sin(), -z.cos()],
        Function::Tan => {
            let [t, slope, curvature] = tanh(C64::I * z);
            [-C64::I * t, slope, C64::I * curvature]
        }
        Function::Sinh => [z.sinh(), z.cosh(), z.sinh()],
        Function::Cosh => [z.cosh(), z.sinh(), z.cosh()],
        Function::Tanh => tanh(z),
        Function::BesselRatio => {
            let r = rijke_numerics::special::bessel_ratio(z);
            let slope = 1.0 - r / z - r * r;
            [r, slope, -slope / z + r / (z * z) - 2.0 * r * slope]
        }
        Function::Howe => rijke_numerics::howe(z),
        Function::HoweAbove => rijke_numerics::howe_parts(z)[0],
        Function::HoweBelow => rijke_numerics::howe_parts(z)[1],
        Function::Re | Function::Im | Function::Abs | Function::Arg | Function::Conj => return None,
    })
}

/// A number on the cut of the principal branches, moved to its upper side: unary minus makes the imaginary
/// part of a real number -0, which is the lower side.
#[inline]
fn above(z: C64) -> C64 {
    C64::new(z.re, z.im + 0.0)
}

/// tanh z with two derivatives. Far from the imaginary axis cosh z overflows, near it 1 - tanh^2 z cancels.
fn tanh(z: C64) -> [C64; 3] {
    const FAR: f64 = 20.0;
    let [value, slope] = if z.re.abs() < FAR {
        let r = z.cosh().inv();
        [z.sinh() * r, r * r]
    } else {
        let sign = z.re.signum();
        let small = (-2.0 * sign * z).exp();
        let r = (1.0 + small).inv();
        [sign * (1.0 - small) * r, 4.0 * small * r * r]
    };
    [value, slope, -2.0 * value * slope]
}

/// The principal square root, in a third of the time of one by way of the argument.
#[inline]
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

pub(crate) fn call<T: Analytic>(function: Function, x: &T) -> T {
    match (derivatives(function, x.value()), function) {
        (Some(all), _) => x.compose(all),
        (None, Function::Re) => x.re(),
        (None, Function::Im) => x.im(),
        (None, Function::Abs) => call(Function::Sqrt, &x.times(&x.conj()).re()),
        (None, Function::Arg) => call(Function::Ln, x).im(),
        (None, _) => x.conj(),
    }
}

pub(crate) fn number_call(function: Function, z: C64) -> C64 {
    let real = |x: f64| C64::new(x, 0.0);
    match (derivatives(function, z), function) {
        (Some([value, ..]), _) => value,
        (None, Function::Re) => real(z.re),
        (None, Function::Im) => real(z.im),
        (None, Function::Abs) => real(z.norm()),
        (None, Function::Arg) => real(above(z).arg()),
        (None, _) => z.conj(),
    }
}
