//! What small changes anywhere along the tube would do to the mode of an operating point.

use crate::fill::Filled;
use crate::point::EIGENVALUE_TOLERANCE;
use crate::{ModelError, PointModel};
use rijke_network::{Newton, Root, Station, Workspace};

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
        let expected = self.assembly.parameters().len();
        if values.len() != expected {
            return Err(ModelError::Count { expected, found: values.len() });
        }
        let fail = |source| ModelError::Network { point: self.id().to_owned(), source };
        let filled = Filled::new(self, values);
        let settings = Newton { tolerance: EIGENVALUE_TOLERANCE, ..Newton::default() };
        let root = self.network().solve(&filled, self.guess, &settings, work).map_err(fail)?;
        let stations = self.network().along(&filled, &root, samples, work).map_err(fail)?;
        Ok((root, stations))
    }
}
