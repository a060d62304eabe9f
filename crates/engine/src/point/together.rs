//! Several measured modes of one operating point, each a mode of its own of the model.

use super::PointModel;
use crate::EngineError;
use rijke_network::{Region, Response, Workspace};
use rijke_numerics::{C64, Order};

/// Roots that are one, relative to |s|.
const ONE: f64 = 1e-6;

/// Growth rates around the measured ones among which modes are sought where searches from two measured modes
/// end at one, 1/s.
const BESIDE: f64 = 400.0;

/// The responses of models that differ in nothing but the measured mode that each starts from. Where two
/// searches end at one root, all modes around are sought, and the measured ones are assigned to them in the
/// order of their frequencies, so that the sum of squared distances is least.
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
    let Some(assigned) = models[0].assigned(values, &guesses, work) else { return Ok(all) };
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
    pub(crate) fn assigned(&self, values: &[f64], guesses: &[C64], work: &mut Workspace) -> Option<Vec<C64>> {
        let filled = self.filled(values).ok()?;
        let low = guesses.iter().fold(f64::INFINITY, |a, g| a.min(g.im));
        let high = guesses.iter().fold(f64::NEG_INFINITY, |a, g| a.max(g.im));
        let spacing = self.spacing();
        let omega = [(low - spacing).max(0.05 * low), high + spacing];
        let sigma = [
            guesses.iter().fold(0.0, |a: f64, g| a.min(g.re)) - BESIDE,
            guesses.iter().fold(0.0, |a: f64, g| a.max(g.re)) + BESIDE,
        ];
        let found = self.chain().modes(&*filled, &Region { sigma, omega }, work).ok()?;
        let mut roots: Vec<C64> = found.modes.iter().map(|m| m.s).collect();
        roots.sort_by(|a, b| a.im.total_cmp(&b.im));
        in_order(guesses, &roots)
    }
}

/// For every guess one of the `roots`, which ascend in frequency, in the order of the guesses' frequencies.
fn in_order(guesses: &[C64], roots: &[C64]) -> Option<Vec<C64>> {
    let mut rank: Vec<usize> = (0..guesses.len()).collect();
    rank.sort_by(|a, b| guesses[*a].im.total_cmp(&guesses[*b].im));
    let (n, m) = (guesses.len(), roots.len());
    if m < n {
        return None;
    }
    // best[i][j]: least cost of the first i guesses with roots among the first j.
    let mut best = vec![vec![0.0; m + 1]];
    for i in 1..=n {
        let mut row = vec![f64::INFINITY; m + 1];
        for j in i..=m {
            let cost = (guesses[rank[i - 1]].im - roots[j - 1].im).powi(2);
            row[j] = row[j - 1].min(best[i - 1][j - 1] + cost);
        }
        best.push(row);
    }
    let (mut j, mut found) = (m, vec![C64::ZERO; n]);
    for i in (1..=n).rev() {
        while j > i && best[i][j - 1] <= best[i][j] {
            j -= 1;
        }
        found[rank[i - 1]] = roots[j - 1];
        j -= 1;
    }
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::in_order;
    use rijke_numerics::C64;

    #[test]
    fn exact_guesses_are_assigned_in_order_at_least_cost() {
        let at = |f: &[f64]| f.iter().map(|f| C64::new(-1.0, *f)).collect::<Vec<_>>();
        let found = |guesses: &[f64], roots: &[f64]| {
            in_order(&at(guesses), &at(roots)).map(|all| all.iter().map(|s| s.im).collect::<Vec<_>>())
        };
        assert_eq!(found(&[240.0, 312.0], &[75.0, 230.0, 262.0, 480.0]), Some(vec![230.0, 262.0]));
        assert_eq!(found(&[312.0, 240.0], &[75.0, 230.0, 262.0, 480.0]), Some(vec![262.0, 230.0]));
        assert_eq!(found(&[100.0, 101.0, 300.0], &[99.0, 150.0, 310.0]), Some(vec![99.0, 150.0, 310.0]));
        assert_eq!(found(&[1.0, 2.0], &[1.5]), None);
    }
}
