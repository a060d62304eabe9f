//! Several measured modes of one operating point, each a mode of its own of the model.

use super::PointModel;
use crate::EngineError;
use rijke_network::{Region, Response, Workspace};
use rijke_numerics::{C64, Order, range};

/// Roots that are one, relative to |s|.
const ONE: f64 = 1e-6;

/// Growth rates around the measured ones among which modes are sought at most where searches from two
/// measured modes end at one, 1/s.
const BESIDE: f64 = 400.0;

/// The first distance from the measured modes in which modes are sought, as a part of that between modes.
const CLOSE: f64 = 0.05;

/// The responses of models that differ in nothing but the measured mode that each starts from. Where two
/// searches end at one root, all modes around are sought, and the measured ones are assigned to them so that
/// the sum of squared distances in the plane of s is least.
///
/// # Errors
/// As [`PointModel::respond`].
pub(crate) fn respond_together(
    models: &[PointModel<'_>],
    values: &[f64],
    order: Order,
    work: &mut Workspace,
) -> Result<Vec<Response>, EngineError> {
    let all = models.iter().map(|m| m.respond(values, order, work)).collect::<Result<Vec<_>, _>>()?;
    let roots: Vec<C64> = all.iter().map(|r| r.s.value()).collect();
    if !has_twins(&roots) {
        return Ok(all);
    }
    let guesses: Vec<C64> = models.iter().map(|m| m.guess).collect();
    // One of two that end at one mode has another, which lies no nearer: a search ends at what is near.
    let moved = guesses.iter().zip(&roots).map(|(guess, root)| (guess - root).norm()).fold(0.0, f64::max);
    let Some(assigned) = models[0].assigned(values, &guesses, moved, work) else { return Ok(all) };
    let again = models.iter().zip(&assigned).map(|(m, s)| m.respond_near(values, *s, order, work));
    // A mode that is lost on the way leaves what was found before, which is refused later if it stays.
    Ok(again.collect::<Result<Vec<_>, _>>().unwrap_or(all))
}

fn has_twins(roots: &[C64]) -> bool {
    let same = |a: &C64, b: &C64| (a - b).norm() < ONE * a.norm();
    roots.iter().enumerate().any(|(k, a)| roots[..k].iter().any(|b| same(a, b)))
}

impl PointModel<'_> {
    /// A mode of the model for every guess, no two the same; none where there are fewer modes than guesses.
    /// The first search reaches at least to `beyond` from the guesses, rad/s.
    pub(crate) fn assigned(
        &self,
        values: &[f64],
        guesses: &[C64],
        beyond: f64,
        work: &mut Workspace,
    ) -> Option<Vec<C64>> {
        let filled = self.filled(values).ok()?;
        let ends = |of: &dyn Fn(&C64) -> f64| range(guesses.iter().map(of));
        let (growth, omega) = (ends(&|g| g.re), ends(&|g| g.im));
        let spacing = self.spacing();
        let mut distance = beyond.clamp(CLOSE * spacing, spacing.max(BESIDE));
        loop {
            let widest = distance >= spacing.max(BESIDE);
            let (beside, above) = (distance.min(BESIDE), distance.min(spacing));
            let growth = if widest { [growth[0].min(0.0), growth[1].max(0.0)] } else { growth };
            let region = Region {
                sigma: [growth[0] - beside, growth[1] + beside],
                omega: [(omega[0] - above).max(0.05 * omega[0]), omega[1] + above],
            };
            let found = self.chain().modes(&*filled, &region, work).ok();
            let roots: Vec<C64> = found.iter().flat_map(|found| found.modes.iter().map(|m| m.s)).collect();
            let assigned = nearest(guesses, &roots);
            match assigned {
                // No mode farther away can belong to one of them.
                Some((cost, all)) if widest || cost <= beside.min(above).powi(2) => return Some(all),
                None if widest => return None,
                _ => distance *= 2.0,
            }
        }
    }
}

/// For every guess a root of its own, so that the sum of squared distances is least, and that sum; none where
/// there are fewer roots than guesses. Each guess in turn takes a root along the path that costs least, on
/// which others change theirs: R. Jonker & A. Volgenant, Computing 38 (1987) 325.
fn nearest(guesses: &[C64], roots: &[C64]) -> Option<(f64, Vec<C64>)> {
    let (n, m) = (guesses.len(), roots.len());
    if m < n {
        return None;
    }
    let cost = |i: usize, j: usize| (guesses[i] - roots[j]).norm_sqr();
    // Prices of roots; which guess has each.
    let (mut price, mut owner) = (vec![0.0; m], vec![None; m]);
    for first in 0..n {
        // By root: the least cost of a path that ends there, and the guess before it.
        let (mut least, mut before) = (vec![f64::INFINITY; m], vec![first; m]);
        let mut done = vec![false; m];
        let (mut guess, mut far) = (first, 0.0);
        let last = loop {
            let own = owner.iter().position(|o| *o == Some(guess));
            let base = own.map_or(0.0, |j| cost(guess, j) - price[j]);
            for j in (0..m).filter(|j| !done[*j]) {
                let through = far + cost(guess, j) - price[j] - base;
                if through < least[j] {
                    (least[j], before[j]) = (through, guess);
                }
            }
            let open = (0..m).filter(|j| !done[*j]);
            let next = open.min_by(|a, b| least[*a].total_cmp(&least[*b]))?;
            done[next] = true;
            far = least[next];
            match owner[next] {
                Some(other) => guess = other,
                None => break next,
            }
        };
        for j in (0..m).filter(|j| done[*j]) {
            price[j] += least[j] - far;
        }
        let mut at = last;
        loop {
            let guess = before[at];
            let left = owner.iter().position(|o| *o == Some(guess));
            owner[at] = Some(guess);
            match left {
                Some(left) => at = left,
                None => break,
            }
        }
    }
    let of = |i: usize| (0..m).find(|j| owner[*j] == Some(i));
    let taken: Vec<usize> = (0..n).map(of).collect::<Option<_>>()?;
    let sum = taken.iter().enumerate().map(|(i, j)| cost(i, *j)).sum();
    Some((sum, taken.into_iter().map(|j| roots[j]).collect()))
}

#[cfg(test)]
mod tests {
    use super::nearest;
    use rijke_numerics::C64;

    #[test]
    fn exact_guesses_are_assigned_at_least_cost() {
        let at = |f: &[f64]| f.iter().map(|f| C64::new(-1.0, *f)).collect::<Vec<_>>();
        let found = |guesses: &[f64], roots: &[f64]| {
            nearest(&at(guesses), &at(roots)).map(|(_, all)| all.iter().map(|s| s.im).collect::<Vec<_>>())
        };
        assert_eq!(found(&[240.0, 312.0], &[75.0, 230.0, 262.0, 480.0]), Some(vec![230.0, 262.0]));
        assert_eq!(found(&[312.0, 240.0], &[75.0, 230.0, 262.0, 480.0]), Some(vec![262.0, 230.0]));
        assert_eq!(found(&[100.0, 101.0, 300.0], &[99.0, 150.0, 310.0]), Some(vec![99.0, 150.0, 310.0]));
        assert_eq!(found(&[1.0, 2.0], &[1.5]), None);
        // A mode of the flame and one of the tube, of which the frequencies have changed places.
        let (flame, tube) = (C64::new(-228.0, 525.0), C64::new(-10.0, 543.0));
        let roots = [C64::new(-11.0, 530.0), C64::new(-200.0, 540.0)];
        assert_eq!(nearest(&[flame, tube], &roots).unwrap().1, [roots[1], roots[0]]);
    }

    /// The least cost over all ways to give the guesses from number `k` on roots of their own.
    fn least(guesses: &[C64], roots: &mut Vec<C64>, k: usize) -> f64 {
        if k == guesses.len() {
            return 0.0;
        }
        let mut best = f64::INFINITY;
        for j in 0..roots.len() {
            let root = roots.remove(j);
            best = best.min((guesses[k] - root).norm_sqr() + least(guesses, roots, k + 1));
            roots.insert(j, root);
        }
        best
    }

    #[test]
    fn oracle_no_other_assignment_costs_less() {
        // Spread over a square without a pattern: multiples of irrational numbers, less their whole parts.
        let at = |k: usize, by: f64| 9.0 * (k as f64 * by).fract();
        let place = |k: usize| C64::new(at(k, 2.0_f64.sqrt()), at(k, 3.0_f64.sqrt()));
        for case in 0..200 {
            let guesses: Vec<C64> = (0..1 + case % 4).map(|k| place(11 * case + k)).collect();
            let mut roots: Vec<C64> = (4..11 - case % 3).map(|k| place(11 * case + k)).collect();
            let (cost, all) = nearest(&guesses, &roots).unwrap();
            let exact = least(&guesses, &mut roots, 0);
            assert!((cost - exact).abs() < 1e-9 * (1.0 + exact), "{cost} {exact}");
            assert!(all.iter().enumerate().all(|(k, a)| !all[..k].contains(a)));
        }
    }
}
