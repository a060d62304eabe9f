//! Responses, and single frequencies of them or two beside each other, that lie far from a model which fits
//! the others.

use super::measured::Measured;
use rijke_numerics::median;
use rijke_numerics::words::few;

/// A response lies far if the median of its distances is so many times that of the others ...
const RESPONSE: f64 = 4.0;
/// ... of which there are so many at least.
const OTHERS: usize = 2;
/// A frequency lies far if its distance is so many times the median of all ...
const FREQUENCY: f64 = 10.0;
/// ... and so many times those of both neighbours: what a model lacks at a resonance spreads over several.
const ALONE: f64 = 4.0;
/// Numbers that must be there, or nothing is usual.
const FEWEST: usize = 20;
/// Most that are named.
const NAMED: usize = 3;

/// What lies far from the model, in sentences; `distances` are those of all numbers, response after response,
/// over their standard deviations.
pub(super) fn stray(measured: &[Measured], distances: &[Vec<f64>]) -> Vec<String> {
    let all: Vec<f64> = distances.iter().flatten().copied().collect();
    if all.len() < FEWEST {
        return Vec::new();
    }
    // Distances are divided by these.
    let median = |values: Vec<f64>| median(values).max(f64::MIN_POSITIVE);
    let usual = median(all);
    let medians: Vec<f64> = distances.iter().map(|d| median(d.clone())).collect();
    let mut said = Vec::new();
    let far: Vec<(usize, f64)> = (0..medians.len())
        .filter_map(|k| {
            let others: Vec<f64> =
                medians.iter().enumerate().filter(|(j, _)| *j != k).map(|(_, m)| *m).collect();
            let enough = others.len() >= OTHERS;
            let times = medians[k] / median(others);
            (enough && times > RESPONSE).then_some((k, times))
        })
        .collect();
    // Many that lie far are no strays.
    if (1..=NAMED).contains(&far.len()) && 2 * far.len() < medians.len() {
        for (k, times) in &far {
            said.push(format!(
                "the response {} lies {times:.0} times as far from the model as the others: check that it belongs to this point, and in which unit and \
                 reference it was measured",
                measured[*k].label
            ));
        }
    }
    let mut alone: Vec<(f64, String)> = Vec::new();
    for (m, own) in measured.iter().zip(distances) {
        let mut found = |k: usize, wide: usize, what: String| {
            let beside = [k.checked_sub(1), Some(k + wide)].into_iter().flatten().filter_map(|j| own.get(j));
            let beside = beside.fold(0.0, |a: f64, d| a.max(*d));
            let least = own[k..k + wide].iter().fold(f64::INFINITY, |a, d| a.min(*d));
            if least > FREQUENCY * usual && least > ALONE * beside {
                alone.push((least, what));
            }
        };
        let hertz = |k: usize| m.frequency_hz[k];
        for k in 0..own.len() {
            found(k, 1, format!("{:.1} Hz of {}", hertz(k), m.label));
        }
        // Two rows that were exchanged are most often neighbours.
        for k in 1..own.len() {
            found(k - 1, 2, format!("{:.1} and {:.1} Hz of {}", hertz(k - 1), hertz(k), m.label));
        }
    }
    alone.sort_by(|a, b| b.0.total_cmp(&a.0));
    if !alone.is_empty() {
        let places: Vec<&str> = alone.iter().map(|(_, place)| place.as_str()).collect();
        said.push(format!(
            "{}: an outlier, {:.0} times the usual distance from the model, with normal frequencies beside it: look at these rows, \
             which make the noise large for all",
            few(&places, NAMED),
            alone[0].0 / usual
        ));
    }
    said
}

#[cfg(test)]
mod tests {
    use super::stray;
    use crate::response::measured::Measured;

    fn response(label: &str) -> Measured {
        Measured {
            label: label.to_owned(),
            session: 0,
            sources: 0,
            frequency_hz: (0..10).map(|k| 100.0 + 10.0 * f64::from(k)).collect(),
            values: Vec::new(),
            sd: Vec::new(),
            level: Vec::new(),
            factor: Vec::new(),
        }
    }

    #[test]
    fn message_what_lies_far_alone_is_named() {
        let all = ["a", "b", "c"].map(response);
        let usual: Vec<f64> = (0..10).map(|k| 0.7 + 0.1 * f64::from(k)).collect();
        let of = |far: [f64; 3]| far.map(|f| usual.iter().map(|d| f * d).collect::<Vec<f64>>()).to_vec();
        assert!(stray(&all, &of([1.0, 1.5, 0.8])).is_empty());
        let said = stray(&all, &of([1.0, 9.0, 1.2]));
        assert!(said.len() == 1 && said[0].starts_with("the response b lies 8 times"), "{said:?}");
        let mut one = of([1.0; 3]);
        one[2][4] = 40.0;
        let said = stray(&all, &one);
        assert!(said.len() == 1 && said[0].starts_with("140.0 Hz of c: an outlier, 33 times"), "{said:?}");
        // A resonance that the model has at another frequency spreads.
        (one[2][3], one[2][5]) = (25.0, 20.0);
        assert!(stray(&all, &one).is_empty());
        one[2][3] = 0.8;
        let said = stray(&all, &one);
        assert!(
            said.len() == 1 && said[0].starts_with("140.0 and 150.0 Hz of c: an outlier, 17 times"),
            "{said:?}"
        );
    }
}
