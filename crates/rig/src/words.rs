//! Parts of messages.

/// A record shorter than what must come before it.
pub(crate) fn too_short(have: usize, quiet: usize) -> String {
    match have {
        0 => "0 samples: the file holds no record; export it again, or record it again".to_owned(),
        _ => format!(
            "{have} samples, but the quiet stretch alone is {quiet}; correct the quiet length in the manifest"
        ),
    }
}

/// Names in a row.
pub(crate) fn listed(names: &[String]) -> String {
    if names.is_empty() { "no names".to_owned() } else { format!("`{}`", names.join("`, `")) }
}
