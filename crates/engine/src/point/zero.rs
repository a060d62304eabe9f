//! Laws that are zero.

use super::model::PointModel;

impl PointModel<'_> {
    /// The candidate and the effect of every law between the ends that is zero at s = i omega; nothing in
    /// rigs whose lengths are unknown. An end may well reflect nothing.
    pub(crate) fn zero_laws(&self, values: &[f64], omega: f64) -> Vec<[usize; 2]> {
        let found = self.law_values(values, omega);
        let laws = self.laws.iter().zip(found).filter(|(_, value)| value.norm() == 0.0);
        laws.map(|(law, _)| law)
            .filter(|law| !self.effect(law).place.is_end())
            .map(|l| [l.candidate, l.effect])
            .collect()
    }
}
