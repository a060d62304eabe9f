//! What a row states of the errors of its numbers, as one covariance.

use crate::StudyProblem;
use crate::rig::Rig;
use rijke_numerics::{C64, Cholesky, Matrix};
use std::collections::BTreeMap;

/// A number of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Number {
    GrowthRate,
    Frequency,
    /// Microphone, and 0 real, 1 imaginary part, 2 modulus, 3 argument.
    Pressure(usize, usize),
}

/// The errors that a row states, each with the heading of its column.
#[derive(Default)]
pub(super) struct Errors {
    /// Standard deviations, in SI units.
    pub(super) sds: BTreeMap<Number, (String, f64)>,
    /// Covariances of two numbers, in SI units.
    pub(super) covariances: Vec<(Number, Number, String, f64)>,
}

/// A number by its name.
pub(super) fn number(word: &str, rig: &Rig) -> Option<Number> {
    match word {
        "growth_rate" => return Some(Number::GrowthRate),
        "frequency" | "angular_frequency" => return Some(Number::Frequency),
        _ => {}
    }
    let (microphone, part) = word.rsplit_once('_')?;
    let part = ["re", "im", "abs", "arg"].iter().position(|p| *p == part)?;
    let microphone = rig.microphones.names.iter().position(|n| n == microphone)?;
    Some(Number::Pressure(microphone, part))
}

/// `A_B`, where both are names of numbers: the numbers with their names.
pub(super) fn pair<'a>(text: &'a str, rig: &Rig) -> Option<[(Number, &'a str); 2]> {
    text.match_indices('_').find_map(|(k, _)| {
        let (a, b) = (&text[..k], &text[k + 1..]);
        Some([(number(a, rig)?, a), (number(b, rig)?, b)])
    })
}

/// The SI unit of a covariance of two numbers.
pub(super) fn product(a: Number, b: Number) -> String {
    let unit = |number: Number| match number {
        Number::GrowthRate => "s^-1",
        Number::Frequency => "rad s^-1",
        Number::Pressure(_, 3) => "rad",
        Number::Pressure(..) => "",
    };
    let both = format!("{} {}", unit(a), unit(b));
    if both.trim().is_empty() { "1".to_owned() } else { both.trim().to_owned() }
}

/// The covariance of the `numbers` of a row, where those of `pressures` become real and imaginary parts if
/// they are `polar`: standard deviations stand on the diagonal where no covariance states it.
pub(super) fn covariance(
    numbers: &[Number],
    pressures: &[(usize, C64)],
    polar: bool,
    errors: &Errors,
    named: &BTreeMap<Number, String>,
    id: &str,
) -> Result<Matrix, StudyProblem> {
    let n = numbers.len();
    let mut covariance = Matrix::zeros(n, n);
    let place = |n: &Number| numbers.iter().position(|m| m == n);
    let mut stated: Vec<Option<&str>> = vec![None; n];
    for (a, b, heading, value) in &errors.covariances {
        if let (Some(i), Some(j)) = (place(a), place(b)) {
            covariance[(i, j)] = *value;
            covariance[(j, i)] = covariance[(i, j)];
            if i == j {
                stated[i] = Some(heading);
            }
        }
    }
    for (i, number) in numbers.iter().enumerate() {
        match (errors.sds.get(number), stated[i]) {
            (Some((key, sd)), None) if *sd == 0.0 => {
                let need = "above zero: a number without error would count more than all others";
                return Err(StudyProblem::Value { key: key.clone(), value: "0".to_owned(), need });
            }
            (Some((_, sd)), None) => covariance[(i, i)] = sd * sd,
            (None, Some(_)) => {}
            (Some((sd, _)), Some(variance)) => {
                let (first, second) = (sd.clone(), variance.to_owned());
                return Err(StudyProblem::TwoErrors { of: id.to_owned(), first, second });
            }
            (None, None) => {
                let name = named.get(number).map_or("", String::as_str);
                let need =
                    "every number needs a standard deviation X_sd, or a covariance with itself, cov_X_X";
                return Err(StudyProblem::Missing { key: format!("{name}_sd"), need });
            }
        }
    }
    if polar {
        // dp = e^{i a} (dr + i r da), to first order.
        let jacobian = Matrix::from_fn(n, n, |i, j| match (numbers[i], numbers[j]) {
            (Number::Pressure(a, k), Number::Pressure(b, l)) if a == b && k > 1 && l > 1 => {
                let p = pressures.iter().find(|(m, _)| *m == a).map_or(C64::ONE, |p| p.1);
                let unit = p / p.norm();
                let column = if l == 2 { unit } else { C64::I * p };
                if k == 2 { column.re } else { column.im }
            }
            _ => f64::from(u8::from(i == j)),
        });
        covariance = jacobian.product(&covariance).product(&jacobian.transpose());
    }
    // Units far apart make a covariance look singular that is not.
    let size: Vec<f64> = (0..n).map(|i| covariance[(i, i)].sqrt()).collect();
    let scaled = Matrix::from_fn(n, n, |i, j| covariance[(i, j)] / (size[i] * size[j]));
    if size.iter().any(|s| !(*s > 0.0 && s.is_finite())) || Cholesky::new(&scaled).is_err() {
        return Err(StudyProblem::Covariance { of: id.to_owned() });
    }
    Ok(covariance)
}
