//! Points of a study: what is known of them before training, which mode is which, and what a saved model
//! says of any.

pub(super) mod asked;
pub(super) mod beyond;
pub(super) mod elsewhere;
pub(super) mod followed;
pub(super) mod inputs;
pub(super) mod meant;
pub(super) mod predicted;
pub(super) mod ready;
