//! Units of formulas: what a formula multiplies and adds must give the unit that is wanted.

use crate::read::{Binary, Function, Scope};
use crate::run::{Operation, number_binary, number_call};
use rijke_numerics::C64;

/// Exponents of kg, m, s and K.
type Dimension = [f64; 4];

const NONE: Dimension = [0.0; 4];

/// Units that may appear in `unit = "..."`, in base units.
const UNITS: [(&str, Dimension); 11] = [
    ("1", NONE),
    ("rad", NONE),
    ("kg", [1.0, 0.0, 0.0, 0.0]),
    ("m", [0.0, 1.0, 0.0, 0.0]),
    ("s", [0.0, 0.0, 1.0, 0.0]),
    ("K", [0.0, 0.0, 0.0, 1.0]),
    ("Hz", [0.0, 0.0, -1.0, 0.0]),
    ("N", [1.0, 1.0, -2.0, 0.0]),
    ("Pa", [1.0, -1.0, -2.0, 0.0]),
    ("J", [1.0, 2.0, -2.0, 0.0]),
    ("W", [1.0, 2.0, -3.0, 0.0]),
];

/// Whether a unit can be judged: a product of powers of `kg m s K Hz N Pa J W rad 1`, over at most one such
/// product, as `W/(m K)` or `kg/(m^2 s)`.
#[must_use]
pub fn is_unit(unit: &str) -> bool {
    dimension(unit).is_some()
}

/// The dimension of a unit such as `W/(m K)` or `kg/(m^2 s)`; none if it is not made of the units above, as
/// `1/W^k_3`.
fn dimension(unit: &str) -> Option<Dimension> {
    let (above, below) = unit.split_once('/').unwrap_or((unit, ""));
    let product = |text: &str| {
        let text = text.trim();
        let text = text.strip_prefix('(').and_then(|t| t.strip_suffix(')')).unwrap_or(text);
        text.split_whitespace().try_fold(NONE, |sum, word| {
            let (name, power) = word.split_once('^').unwrap_or((word, "1"));
            let power: f64 = power.parse().ok()?;
            let (_, dimension) = UNITS.iter().find(|(known, _)| *known == name)?;
            Some(plus(sum, *dimension, power))
        })
    };
    Some(plus(product(above)?, product(below)?, -1.0))
}

fn plus(a: Dimension, b: Dimension, times: f64) -> Dimension {
    std::array::from_fn(|k| a[k] + times * b[k])
}

/// `kg m^-2 s^-1`.
fn shown(dimension: Dimension) -> String {
    let part = |(name, power): (&str, f64)| match power {
        0.0 => None,
        1.0 => Some(name.to_owned()),
        _ => Some(format!("{name}^{power}")),
    };
    let parts: Vec<String> = ["kg", "m", "s", "K"].into_iter().zip(dimension).filter_map(part).collect();
    if parts.is_empty() { "1".to_owned() } else { parts.join(" ") }
}

/// What is known of the unit of a part of a formula.
#[derive(Clone, Copy)]
enum Unit {
    Known(Dimension),
    /// A number: without unit as a factor, of any unit as a summand.
    Number(C64),
    /// Not to be told, because a parameter is an exponent or a unit is not understood.
    Open,
}

/// Why the units of a program do not agree or are not `wanted`, if so.
pub(crate) fn fault(
    program: &[Operation],
    scope: &Scope,
    parameters: &[&str],
    wanted: &str,
) -> Option<String> {
    let unit = match found(program, scope, parameters) {
        Ok(unit) => unit,
        Err(fault) => return Some(fault),
    };
    let wanted = dimension(wanted)?;
    match unit {
        Unit::Known(unit) if !same(unit, wanted) => {
            Some(format!("its unit is {}, where {} is wanted", shown(unit), shown(wanted)))
        }
        Unit::Number(value) if value != C64::ZERO && !same(NONE, wanted) => {
            Some(format!("it is a number, where {} is wanted", shown(wanted)))
        }
        _ => None,
    }
}

fn same(a: Dimension, b: Dimension) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

/// The unit of a program in postfix order.
fn found(program: &[Operation], scope: &Scope, parameters: &[&str]) -> Result<Unit, String> {
    let stated = |unit: Option<&str>| unit.and_then(dimension).map_or(Unit::Open, Unit::Known);
    let mut stack: Vec<Unit> = Vec::new();
    for operation in program {
        let top = match *operation {
            Operation::Number(z) => Unit::Number(z),
            Operation::Global(index) | Operation::Local(index) | Operation::Analytic(index) => {
                stated(scope.names().get(index).map(|n| n.unit.as_str()))
            }
            Operation::Parameter(index) => stated(parameters.get(index).copied()),
            Operation::Negate => match stack.pop() {
                Some(Unit::Number(value)) => Unit::Number(-value),
                Some(unit) => unit,
                None => Unit::Open,
            },
            Operation::Call(function) => call(function, stack.pop().unwrap_or(Unit::Open))?,
            Operation::Binary(operator) => {
                let right = stack.pop().unwrap_or(Unit::Open);
                binary(operator, stack.pop().unwrap_or(Unit::Open), right)?
            }
        };
        stack.push(top);
    }
    Ok(stack.pop().unwrap_or(Unit::Open))
}

fn call(function: Function, argument: Unit) -> Result<Unit, String> {
    match (function, argument) {
        (_, Unit::Number(z)) => Ok(Unit::Number(number_call(function, z))),
        (Function::Sqrt, Unit::Known(unit)) => Ok(Unit::Known(plus(NONE, unit, 0.5))),
        (Function::Sqrt | Function::Re | Function::Im | Function::Abs | Function::Conj, other) => Ok(other),
        (Function::Arg, _) => Ok(Unit::Known(NONE)),
        (_, Unit::Known(unit)) if !same(unit, NONE) => {
            Err(format!("{} is applied to something of unit {}", function.name(), shown(unit)))
        }
        _ => Ok(Unit::Known(NONE)),
    }
}

fn binary(operator: Binary, left: Unit, right: Unit) -> Result<Unit, String> {
    use Unit::{Known, Number, Open};
    let factor = |unit: Unit| if let Known(d) = unit { d } else { NONE };
    Ok(match (operator, left, right) {
        (operator, Number(a), Number(b)) => Number(number_binary(operator, a, b)),
        // Numbers in formulas have no unit of their own and may be added to anything.
        (Binary::Add | Binary::Subtract, Known(a), Known(b)) if !same(a, b) => {
            let verb = if operator == Binary::Add { "added to" } else { "taken from" };
            return Err(format!("something of unit {} is {verb} something of unit {}", shown(b), shown(a)));
        }
        (Binary::Add | Binary::Subtract, Known(d), _) | (Binary::Add | Binary::Subtract, _, Known(d)) => {
            Known(d)
        }
        (Binary::Power, _, Known(d)) if !same(d, NONE) => {
            return Err(format!("an exponent has the unit {}", shown(d)));
        }
        (Binary::Power, Known(d), Number(power)) if power.im == 0.0 => Known(plus(NONE, d, power.re)),
        (Binary::Power, Known(d), _) if same(d, NONE) => Known(NONE),
        (Binary::Power, Number(_), _) => Known(NONE),
        (_, Open, _) | (_, _, Open) | (Binary::Power, ..) => Open,
        (Binary::Multiply, a, b) => Known(plus(factor(a), factor(b), 1.0)),
        (Binary::Divide, a, b) => Known(plus(factor(a), factor(b), -1.0)),
    })
}
