//! What a set of records says of where it comes from.

/// The source of the records of a campaign, made with `seed`.
pub(crate) fn source(campaign: &str, seed: u64) -> String {
    format!("virtual laboratory, {campaign}, seed {seed}")
}
