//! Units of formulas: what a formula multiplies and adds must be of the unit of the coefficient that it gives.

use super::evaluate::Operation;
use super::parser::{Binary, Function};
use super::{Formula, Scope};
use crate::{Candidate, Coefficient, Effect};

/// Exponents of kg, m, s and K.
pub(crate) type Dimension = [f64; 4];

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

/// The dimension of a unit such as `W/(m K)` or `kg/(m^2 s)`; none if it is not made of the units above, as `1/W^k_3`.
pub(crate) fn dimension(unit: &str) -> Option<Dimension> {
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
    Number(f64),
    /// Not to be told, because a parameter is an exponent or has a unit of its own.
    Open,
}

/// Why the units of an effect's formula do not agree, if they do not. Laws that are no formulas are not judged.
///
/// A parameter's unit is that of the catalogue. A part whose unit depends on a parameter, as Q^k, is taken to be right.
#[must_use]
pub fn unit_fault(candidate: &Candidate, effect: &Effect) -> Option<String> {
    let names: Vec<String> = candidate.parameters.iter().map(|p| p.name.clone()).collect();
    let scope = Scope { parameters: &names, place: effect.place, coefficient: effect.coefficient };
    let formula = Formula::parse(&effect.law.text(), &scope).ok()?;
    let units: Vec<Unit> =
        candidate.parameters.iter().map(|p| dimension(&p.unit).map_or(Unit::Open, Unit::Known)).collect();
    let wanted = wanted(effect);
    match found(&formula.program, &units) {
        Err(fault) => Some(fault),
        Ok(Unit::Known(unit)) if !same(unit, wanted) => {
            Some(format!("its unit is {}, where {} is wanted", shown(unit), shown(wanted)))
        }
        Ok(Unit::Number(value)) if value != 0.0 && !same(NONE, wanted) => {
            Some(format!("it is a number, where {} is wanted", shown(wanted)))
        }
        Ok(_) => None,
    }
}

/// The unit of a coefficient, per metre where the law acts along a length.
fn wanted(effect: &Effect) -> Dimension {
    let at_a_place = match effect.coefficient {
        Coefficient::Mu => [1.0, -2.0, -1.0, 0.0],
        Coefficient::Ep => [-1.0, 2.0, 1.0, 0.0],
        Coefficient::Mp | Coefficient::Eu | Coefficient::Reflection => NONE,
    };
    if effect.place.is_distributed() { plus(at_a_place, [0.0, 1.0, 0.0, 0.0], -1.0) } else { at_a_place }
}

fn same(a: Dimension, b: Dimension) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

/// The unit of a program in postfix order.
fn found(program: &[Operation], parameters: &[Unit]) -> Result<Unit, String> {
    let mut stack: Vec<Unit> = Vec::new();
    for operation in program {
        let top = match *operation {
            Operation::Number(z) => Unit::Number(z.re),
            Operation::Symbol(symbol) => dimension(symbol.meaning().unit).map_or(Unit::Open, Unit::Known),
            Operation::Parameter(index) => parameters.get(index).copied().unwrap_or(Unit::Open),
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
        (Function::Sqrt, Unit::Known(unit)) => Ok(Unit::Known(plus(NONE, unit, 0.5))),
        (Function::Sqrt | Function::Re | Function::Im | Function::Abs | Function::Conj, other) => Ok(other),
        (_, Unit::Known(unit)) if !same(unit, NONE) => {
            Err(format!("{function:?} is applied to something of unit {}", shown(unit)).to_lowercase())
        }
        _ => Ok(Unit::Known(NONE)),
    }
}

fn binary(operator: Binary, left: Unit, right: Unit) -> Result<Unit, String> {
    use Unit::{Known, Number, Open};
    let factor = |unit: Unit| if let Known(d) = unit { d } else { NONE };
    Ok(match (operator, left, right) {
        // Numbers in formulas have no unit of their own and may be added to anything.
        (Binary::Add | Binary::Subtract, Known(a), Known(b)) if !same(a, b) => {
            let verb = if operator == Binary::Add { "added to" } else { "taken from" };
            return Err(format!("something of unit {} is {verb} something of unit {}", shown(b), shown(a)));
        }
        (Binary::Add | Binary::Subtract, Number(_), Number(_)) => Number(1.0),
        (Binary::Add | Binary::Subtract, Known(d), _) | (Binary::Add | Binary::Subtract, _, Known(d)) => {
            Known(d)
        }
        (Binary::Power, _, Known(d)) if !same(d, NONE) => {
            return Err(format!("an exponent has the unit {}", shown(d)));
        }
        (Binary::Power, Known(d), Number(power)) => Known(plus(NONE, d, power)),
        (Binary::Power, Known(d), _) if same(d, NONE) => Known(NONE),
        (Binary::Power, Number(_), _) => Known(NONE),
        (Binary::Multiply | Binary::Divide, Number(_), Number(_)) => Number(1.0),
        (_, Open, _) | (_, _, Open) | (Binary::Power, ..) => Open,
        (Binary::Multiply, a, b) => Known(plus(factor(a), factor(b), 1.0)),
        (Binary::Divide, a, b) => Known(plus(factor(a), factor(b), -1.0)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Catalogue, SYMBOLS};

    #[test]
    fn exact_every_symbol_has_a_unit_that_is_understood() {
        for meaning in &SYMBOLS {
            assert!(dimension(meaning.unit).is_some(), "{}: {}", meaning.name, meaning.unit);
        }
        assert_eq!(dimension("W/(m K)"), Some([1.0, 1.0, -3.0, -1.0]));
        assert_eq!(dimension("1/(Pa s)"), Some([-1.0, 1.0, 1.0, 0.0]));
        assert_eq!(dimension("1/W^k_3"), None);
    }

    fn fault(unit: &str, effect: &str) -> Option<String> {
        let text = format!(
            "[[candidate]]\nid = \"a\"\nrole = \"r\"\nname = \"n\"\ncite = [\"c\"]\n\
             parameters.k = {{ symbol = \"k\", unit = \"{unit}\", prior = {{ normal = {{ mean = 1.0, sd = 1.0 }} }} }}\n\
             [[candidate.effect]]\n{effect}\n"
        );
        let catalogue = Catalogue::from_toml(&text, "x").unwrap();
        let candidate = &catalogue.candidates()[0];
        unit_fault(candidate, &candidate.effects[0])
    }

    #[test]
    fn exact_units_that_do_not_agree_are_told() {
        let heater = |law: &str| format!("acts_at = \"heater\"\n{law}");
        assert_eq!(fault("1/W", &heater("eu = \"-k*Q_h\"")), None);
        assert_eq!(
            fault("1", &heater("eu = \"-k*Q_h\"")).unwrap(),
            "its unit is kg m^2 s^-3, where 1 is wanted"
        );
        assert_eq!(fault("s", &heater("eu = \"exp(-s*k)\"")), None);
        assert_eq!(
            fault("1", &heater("eu = \"exp(-s*k)\"")).unwrap(),
            "exp is applied to something of unit s^-1"
        );
        assert_eq!(
            fault("1", &heater("mu = \"k*(rho + c)\"")).unwrap(),
            "something of unit m s^-1 is added to something of unit kg m^-3"
        );
        assert_eq!(fault("1", &heater("mu = \"k\"")).unwrap(), "its unit is 1, where kg m^-2 s^-1 is wanted");
        // A drag at a place is not one per metre.
        assert_eq!(fault("1", &heater("mu = \"k*wall_mu*D\"")), None);
        assert!(fault("1", "acts_at = \"prongs\"\nmu = \"k*wall_mu*D\"").is_some());
        assert_eq!(fault("1/W^k", &heater("eu = \"k*Q_h^2\"")), None, "not to be told");
        assert_eq!(fault("m", &heater("eu = \"Q_h^k\"")).unwrap(), "an exponent has the unit m");
        assert_eq!(fault("K", &heater("eu = \"(T - 273.15)/k\"")), None, "numbers have any unit");
    }
}
