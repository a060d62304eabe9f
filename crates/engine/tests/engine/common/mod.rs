//! What several tests use.

pub(crate) mod folder;
pub(crate) mod tube;
