//! What small changes anywhere along the tube would do to the mode of an operating point.

use crate::{ModelError, PointModel};
use rijke_network::{Root, Station, Workspace};

impl PointModel<'_> {
    /// The mode at these values of the free parameters, and the sensitivities of its eigenvalue to weak devices, area and
    /// temperature along x, at `samples` points of every segment.
    ///
    /// # Errors
    /// [`ModelError::Count`], or [`ModelError::Network`] when there is no eigenvalue near the guess.
    pub fn along(
        &self,
        values: &[f64],
        samples: usize,
        work: &mut Workspace,
    ) -> Result<(Root, Vec<Station>), ModelError> {
        let (filled, root) = self.solve(values, work)?;
        let stations = self.network().along(&filled, &root, samples, work);
        Ok((root, stations.map_err(|source| self.no_answer(source))?))
    }
}
