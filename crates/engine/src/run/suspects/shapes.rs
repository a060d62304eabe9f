//! Points whose mode shape lies far from a model that fits all others.

use super::doubts::few;
use super::miswired::{Wiring, pairs};
use rijke_numerics::{C64, median};

/// Relative pressures of a mode at a point, as measured and as the model has them.
pub(in crate::run) struct Shape<'a> {
    pub(in crate::run) id: &'a str,
    /// The label of the mode.
    pub(in crate::run) mode: &'a str,
    /// Microphone, measured pressure, the same less that of the model, and its stated standard deviation.
    pub(in crate::run) heard: Vec<(usize, C64, C64, f64)>,
}

/// Residuals of few points, in those of all others together, that give a warning; with two microphones
/// exchanged a point fits that then lies so near.
const ALONE: f64 = 8.0;
const EXCHANGED: f64 = 2.5;
/// Modes of one label that are compared.
const LEAST: usize = 5;

/// What is said of the fewest points whose shapes are far off, when those of all others are not. Pressures
/// are relative to the microphone `reference`; microphones are called `names`.
pub(in crate::run) fn outlying(shapes: &[Shape<'_>], reference: usize, names: &[String]) -> Vec<String> {
    let mut labels: Vec<&str> = shapes.iter().map(|s| s.mode).collect();
    labels.sort_unstable();
    labels.dedup();
    let of = |label: &str| {
        let own: Vec<&Shape<'_>> = shapes.iter().filter(|s| s.mode == label && !s.heard.is_empty()).collect();
        if own.len() < LEAST { Vec::new() } else { of_one_mode(&own, reference, names) }
    };
    labels.into_iter().flat_map(of).collect()
}

fn of_one_mode(shapes: &[&Shape<'_>], reference: usize, names: &[String]) -> Vec<String> {
    // What a microphone has at every point is an error of its gain and not of a point.
    let usual: Vec<C64> = (0..names.len())
        .map(|m| {
            let all = || shapes.iter().flat_map(|s| &s.heard).filter(|h| h.0 == m);
            C64::new(median(all().map(|h| h.2.re).collect()), median(all().map(|h| h.2.im).collect()))
        })
        .collect();
    let distance = |left: Vec<(usize, C64)>| rms(left.into_iter().map(|(m, z)| (z - usual[m]).norm()));
    let own = |s: &Shape<'_>| s.heard.iter().map(|h| (h.0, h.2)).collect();
    let mut order: Vec<(f64, &Shape<'_>)> = shapes.iter().map(|s| (distance(own(s)), *s)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let sd = rms(shapes.iter().flat_map(|s| &s.heard).map(|h| h.3));
    let found = (1..=few(shapes.len())).find_map(|count| {
        let (far, rest) = order.split_at(count);
        let others = rms(rest.iter().map(|(r, _)| *r)).max(sd);
        (far[count - 1].0 > ALONE * others).then_some((far, others))
    });
    let Some((far, others)) = found else { return Vec::new() };
    let said = |(off, shape): &(f64, &Shape<'_>)| {
        let fits = |pair: &[usize; 2]| {
            exchanged(shape, *pair, reference).is_some_and(|left| distance(left) < EXCHANGED * others)
        };
        let all: Vec<usize> = shape.heard.iter().map(|h| h.0).chain([reference]).collect();
        let remedy = pairs(&all).into_iter().find(fits).map_or_else(
            || "check the order, places and gains of its microphones".to_owned(),
            |[a, b]| {
                format!(
                    "with {} and {} exchanged it fits; check whether these two were exchanged there",
                    names[a], names[b]
                )
            },
        );
        let mode = if shape.mode.is_empty() { String::new() } else { format!(" of mode {}", shape.mode) };
        format!(
            "the shape{mode} at {} lies {off:.2} of the reference from the model, {:.0} times as far as at other points: {remedy}",
            shape.id,
            off / others
        )
    };
    far.iter().map(said).collect()
}

/// What is left of the pressures if two microphones were exchanged; none where one was not heard.
fn exchanged(shape: &Shape<'_>, pair: [usize; 2], reference: usize) -> Option<Vec<(usize, C64)>> {
    let measured: Vec<(usize, C64)> = shape.heard.iter().map(|h| (h.0, h.1)).collect();
    let (right, _) = Wiring::Exchanged(pair).put_right(&measured, reference)?;
    Some(right.iter().zip(&shape.heard).map(|((m, z), h)| (*m, z - (h.1 - h.2))).collect())
}

/// Root mean square.
pub(in crate::run) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0_u32, 0.0), |(n, sum), v| (n + 1, sum + v * v));
    (sum / f64::from(count.max(1))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pressures of ten points at microphones 0 (the reference) to 3, with small errors and a wrong gain of
    /// microphone 3; at point 4 `a` and `b` are exchanged, and `wrong` is added to the last one.
    fn said([a, b]: [usize; 2], wrong: f64) -> Vec<String> {
        let ids: Vec<String> = (0..10).map(|k| format!("p{k}")).collect();
        let one = |k: usize| {
            let mut whole = [1.0, 0.8, 0.5 + 0.01 * k as f64, 0.2].map(C64::from);
            let model = whole;
            for (m, z) in whole.iter_mut().enumerate().skip(1) {
                *z += 1e-3 * C64::from_polar(1.0, (7 * k + 3 * m) as f64);
            }
            whole[3] += 0.02;
            if k == 4 {
                whole.swap(a, b);
                whole[3] += wrong;
            }
            let heard = |m: usize| {
                let z = whole[m] / whole[0];
                (m, z, z - model[m], 1e-3)
            };
            Shape { id: &ids[k], mode: "", heard: (1..4).map(heard).collect() }
        };
        let shapes: Vec<Shape<'_>> = (0..10).map(one).collect();
        outlying(&shapes, 0, &["p0", "p1", "p2", "p3"].map(str::to_owned))
    }

    #[test]
    fn behaviour_a_shape_that_alone_is_far_off_is_named() {
        assert!(said([1, 1], 0.0).is_empty());
        let far = said([1, 1], 0.3);
        assert!(
            far.len() == 1 && far[0].starts_with("the shape at p4 lies 0.17 of the reference"),
            "{far:?}"
        );
        assert!(far[0].ends_with("check the order, places and gains of its microphones"), "{far:?}");
    }

    #[test]
    fn behaviour_two_exchanged_microphones_are_named_and_the_reference_may_be_one() {
        for (pair, names) in [([1, 2], "p1 and p2"), ([0, 2], "p2 and p0"), ([2, 3], "p2 and p3")] {
            let far = said(pair, 0.0);
            assert!(
                far.len() == 1 && far[0].contains(&format!("with {names} exchanged it fits")),
                "{pair:?} {far:?}"
            );
        }
    }
}
