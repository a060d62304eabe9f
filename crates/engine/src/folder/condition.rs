//! Conditions, grids and frequencies as options name them.

use crate::run::AskedPoint;
use rijke_numerics::{Failed, range};
use rijke_study::Study;
use rijke_study::plan::{MapGrid, Selection};
use std::collections::BTreeMap;

/// What names the day whose error of T_amb a condition shares.
const DAY: &str = "day";

/// `x=0.3,Q=50`, also with `T_amb`, `T_amb_sd` and `day`, of the option `flag`.
///
/// # Errors
/// Text of another form; the remedy shows the right one.
pub fn condition(flag: &str, text: &str) -> Result<AskedPoint, Failed> {
    let remedy = format!("Write it as {flag} x_g=0.15,Q=12, numbers in SI units.");
    let wrong = |what: String| Failed::bad_input(format!("{flag} {text}: {what}")).remedy(&remedy);
    let mut values = BTreeMap::new();
    let mut day = None;
    for part in text.split(',') {
        let list = || wrong(format!("`{part}` is not a factor with its number"));
        let (name, value) = part.split_once('=').ok_or_else(list)?;
        let (name, value) = (name.trim(), value.trim());
        let again = if name == DAY {
            day.replace(value.to_owned()).is_some()
        } else {
            let value = value.parse::<f64>().ok().filter(|v| v.is_finite());
            let value = value.ok_or_else(|| wrong(format!("`{}` is not a number", part.trim())))?;
            values.insert(name.to_owned(), value).is_some()
        };
        if again {
            return Err(wrong(format!("{name} is given twice")));
        }
    }
    Ok(AskedPoint::new(values, day))
}

/// `x_g,Q`, or `x_g=0.1:0.6,Q=0:80` with the ends of ranges; those of the points that `among` means, where
/// they are left out.
///
/// # Errors
/// Text of another form; the remedy shows the right one.
pub fn grid(text: &str, study: &Study, among: &Selection) -> Result<MapGrid, Failed> {
    let known = study.campaign.factors.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(", ");
    let bad = |what: String| {
        Failed::bad_input(format!("--map {text}: {what}"))
            .remedy(format!("Give two of: {known}; with a range as --map x=0.1:0.6,y=0:80, in SI units."))
    };
    let both: Vec<&str> = text.split(',').collect();
    let [x, y] = both[..] else { return Err(bad("takes two factors with a comma between".into())) };
    let over = |k: usize| {
        let points = study.campaign.points.iter().filter(|p| among.holds(&study.campaign, p));
        let values = points.map(|p| p.factors[k]).filter(|v| v.is_finite());
        Some(range(values)).filter(|[low, high]| low < high)
    };
    let axis = |text: &str| {
        let (name, range) = text.split_once('=').map_or((text, None), |(name, range)| (name, Some(range)));
        let name = name.trim();
        let k = study.campaign.factor(name).ok_or_else(|| bad(format!("there is no factor `{name}`")))?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite());
        let ends = range.map(|range| {
            let ends = range.split_once(':').and_then(|(low, high)| Some([number(low)?, number(high)?]));
            ends.ok_or_else(|| bad(format!("`{range}` is no range, two numbers with a colon between")))
        });
        Ok::<_, Failed>((k, ends.transpose()?.or_else(|| over(k))))
    };
    let (x, y) = (axis(x)?, axis(y)?);
    MapGrid::new(&study.campaign, [x.0, y.0], [x.1, y.1]).map_err(|problem| bad(problem.to_string()))
}

/// More frequencies than this are a slip of the step.
const MOST: f64 = 1e5;

/// A frequency, or `from:to:step`, Hz, of the option `--at-hz`.
///
/// # Errors
/// Text of another form; the remedy shows the right one.
pub fn frequencies(text: &str) -> Result<Vec<f64>, Failed> {
    Ok(text.split(',').map(one_or_range).collect::<Result<Vec<_>, _>>()?.concat())
}

fn one_or_range(text: &str) -> Result<Vec<f64>, Failed> {
    let wrong = |what: &str| {
        Failed::bad_input(format!("--at-hz {text}: {what}"))
            .remedy("Give frequencies in Hz, as 100,200 or from:to:step as in --at-hz 100:2000:10.")
    };
    let numbers: Option<Vec<f64>> = text.split(':').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some([hertz]) if hertz.is_finite() && *hertz > 0.0 => Ok(vec![*hertz]),
        Some([from, to, step]) if *from > 0.0 && to >= from && *step > 0.0 && to.is_finite() => {
            let count = ((to - from) / step + 1e-9).floor();
            if count > MOST {
                return Err(wrong(&format!("these are {count} frequencies; {MOST} are the most")));
            }
            Ok((0..=count as usize).map(|k| from + step * k as f64).collect())
        }
        _ => Err(wrong("neither a frequency nor a range")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_frequencies_are_numbers_and_ranges() {
        assert_eq!(frequencies("100,200:400:100").ok(), Some(vec![100.0, 200.0, 300.0, 400.0]));
        assert!(frequencies("100,").is_err() && frequencies("400:100:1").is_err());
    }
}
