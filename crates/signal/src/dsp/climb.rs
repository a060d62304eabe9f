//! The top of a peak that a grid has found.

/// The place of a maximum of a function, and its value there, from the best of a grid: by steps of half that
/// of the grid, halved so many `times`.
pub(crate) fn climb(
    of: impl Fn(f64) -> f64,
    (mut best, mut most): (f64, f64),
    mut step: f64,
    times: usize,
) -> (f64, f64) {
    for _ in 0..times {
        step *= 0.5;
        for at in [best - step, best + step] {
            let here = of(at);
            if here > most {
                (best, most) = (at, here);
            }
        }
    }
    (best, most)
}
