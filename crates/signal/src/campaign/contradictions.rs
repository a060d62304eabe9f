//! Points whose repeats differ far more than those of the others: two states or two modes under one name.

use crate::repeats::Repeats;

/// Repeats that scatter by more than so many times the median of the other points are no chance: of four
/// repeats, once in 1e4.
const ODD: f64 = 30.0;

/// Says which points these are, from the pings of every point: growth rate, then angular frequency. Of less
/// than three points nothing is known.
pub(super) fn contradictions(points: &[(&str, &Repeats)]) -> Vec<String> {
    let mut said = Vec::new();
    for (k, (what, unit)) in [("growth rate", "1/s"), ("angular frequency", "rad/s")].into_iter().enumerate()
    {
        let scatter = |r: &Repeats| (r.squares[k] / (r.count as f64 - 1.0)).sqrt();
        let all: Vec<(&str, f64)> =
            points.iter().filter(|(_, r)| r.count > 1).map(|(id, r)| (*id, scatter(r))).collect();
        for (id, own) in &all {
            let mut others: Vec<f64> = all.iter().filter(|(other, _)| other != id).map(|(_, s)| *s).collect();
            others.sort_by(f64::total_cmp);
            let Some(usual) = others.get(others.len() / 2).filter(|_| others.len() > 1) else { continue };
            if *own > ODD * usual && *usual > 0.0 {
                said.push(format!(
                    "{id}: its pings scatter by {own:.3} {unit} in {what}, {:.0} times as much as those of other points: two states or two modes \
                     may stand under one name. Look at them in pings.csv. Scatter is learnt from all points together, so that this one widens the \
                     stated errors of the others",
                    own / usual
                ));
            }
        }
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repeats::combine;
    use rijke_numerics::Matrix;

    fn point(frequencies: [f64; 4]) -> Repeats {
        let of = |(k, f): (usize, &f64)| {
            (k as f64, vec![-10.0 + 0.01 * k as f64, *f], Matrix::diagonal(&[1e-6, 1e-6]))
        };
        combine(&frequencies.iter().enumerate().map(of).collect::<Vec<_>>(), &|k| k.to_string()).unwrap()
    }

    #[test]
    fn message_two_states_under_one_name_are_said_and_usual_scatter_is_not() {
        let usual = [point([1040.0, 1040.01, 1040.02, 1040.0]), point([900.0, 900.03, 900.01, 900.0])];
        let odd = point([1038.6, 1038.61, 1070.0, 1070.01]);
        let names: Vec<(&str, &Repeats)> = vec![("a", &usual[0]), ("b", &usual[1]), ("c", &odd)];
        let said = contradictions(&names);
        assert!(said.len() == 1 && said[0].starts_with("c: its pings scatter by 18.1"), "{said:?}");
        assert!(contradictions(&[("a", &usual[0]), ("b", &usual[1]), ("d", &usual[0])]).is_empty());
    }
}
