//! What a set of records says of where it comes from.

/// The source of the records of a campaign, made with `seed`.
pub(crate) fn source(campaign: &str, seed: u64) -> String {
    format!("{SOURCE}, {campaign}, seed {seed}")
}

const SOURCE: &str = "virtual laboratory";

/// The seed of the laboratory that made the records whose source is `source`; none if they come from
/// elsewhere.
#[must_use]
pub fn seed_of(source: &str) -> Option<u64> {
    let (_, seed) = source.strip_prefix(SOURCE)?.rsplit_once(", seed ")?;
    seed.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_the_source_names_its_seed() {
        assert_eq!(seed_of(&source("any campaign, seed 3", 17)), Some(17));
        assert_eq!(seed_of("laboratory of a friend, seed 3"), None);
    }
}
