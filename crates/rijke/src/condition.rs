//! Conditions as options name them, and what is said of their surroundings.

use crate::failure::Failure;
use rijke_engine::run::AskedPoint;
use rijke_study::Point;
use std::collections::BTreeMap;

/// What names the day whose error of T_amb a condition shares.
const DAY: &str = "day";

/// `x=0.3,Q=50`, also with `T_amb`, `T_amb_sd` and `day`.
pub(crate) fn condition(flag: &str, text: &str) -> Result<AskedPoint, Failure> {
    let remedy = format!("Write it as {flag} x_g=0.15,Q=12, numbers in SI units.");
    let wrong = |what: String| Failure::bad_input(format!("{flag} {text}: {what}")).remedy(&remedy);
    let mut values = BTreeMap::new();
    let mut day = None;
    for part in text.split(',') {
        let list = || wrong("not a list of factors with numbers".into());
        let (name, value) = part.split_once('=').ok_or_else(list)?;
        let (name, value) = (name.trim(), value.trim());
        let again = if name == DAY {
            day.replace(value.to_owned()).is_some()
        } else {
            let value = value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(list)?;
            values.insert(name.to_owned(), value).is_some()
        };
        if again {
            return Err(wrong(format!("{name} is given twice")));
        }
    }
    Ok(AskedPoint::new(values, day))
}

/// Where the ambient temperature of a condition and its error come from, as far as its words do not say it;
/// `nearest` is the point of which it has all that it does not say.
pub(crate) fn surroundings(asked: &AskedPoint, point: &Point, nearest: &str) -> Option<String> {
    let [kelvin, sd] = point.ambient?;
    let given = |name: &str| asked.values.contains_key(name);
    let temperature = match (given("T_amb"), &asked.day) {
        (true, _) => None,
        (false, None) => Some(format!("that of {nearest}, the nearest point")),
        (false, Some(day)) => Some(format!("that of {nearest}, the nearest point of day {day}")),
    };
    let error = match (given("T_amb_sd"), &asked.day) {
        (true, _) => None,
        (false, None) => {
            Some("the campaign's standard deviation, as an error of this condition alone".to_owned())
        }
        (false, Some(day)) => Some(format!("the error of day {day}")),
    };
    let from: Vec<String> = [temperature, error].into_iter().flatten().collect();
    let missing: Vec<&str> = ["T_amb", "T_amb_sd"].into_iter().filter(|name| !given(name)).collect();
    (!from.is_empty()).then(|| {
        let (from, missing) = (from.join(", with "), missing.join(" and "));
        format!("T_amb = {kelvin} +- {sd} K: {from}; give {missing} in --at for another")
    })
}
