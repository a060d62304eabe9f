//! Which points of a sample are worth a descent: the rule of single linkage (Rinnooy Kan & Timmer 1987, Math.
//! Program. 39, 57).

/// The place of each point in the order of every coordinate, as numbers in 0..1: its place in the unit cube
/// of the prior.
pub(super) fn ranks(points: &[&[f64]]) -> Vec<Vec<f64>> {
    let size = points.first().map_or(0, |p| p.len());
    let mut ranks = vec![vec![0.0; size]; points.len()];
    for i in 0..size {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| points[a][i].total_cmp(&points[b][i]));
        for (rank, k) in order.into_iter().enumerate() {
            ranks[k][i] = (rank as f64 + 0.5) / points.len() as f64;
        }
    }
    ranks
}

/// The Euclidean distance of two points.
pub(super) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// The distance in a unit cube of `size` dimensions within which a sample of `count` points holds a better
/// one, unless a maximum is near: that of Rinnooy Kan & Timmer with their constant 2.
pub(super) fn reach(count: usize, size: usize) -> f64 {
    if count < 2 || size == 0 {
        return 0.0;
    }
    let (n, d) = (count as f64, size as f64);
    ((libm::tgamma(1.0 + 0.5 * d) * 2.0 * n.ln() / n).powf(1.0 / d)) / std::f64::consts::PI.sqrt()
}
