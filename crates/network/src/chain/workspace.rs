//! Memory of a caller, so that questions asked again and again allocate nothing.

use super::coefficients::Laws;
use super::tangents::Tangents;

/// Memory that is reused from call to call; after the first call with a network of the same size, root
/// searches allocate nothing.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    pub(crate) laws: Laws,
    pub(crate) tangents: Tangents,
}
