//! What the rules read and say.

/// One breach of a rule: where, what, and what to do.
pub(super) type Complaint = String;

/// A file of the repository: its path from the root, with `/`, and its text.
pub(super) struct File {
    pub(super) path: String,
    pub(super) text: String,
}

/// A file, for the tests of the rules.
#[cfg(test)]
pub(super) fn file(path: &str, text: &str) -> File {
    File { path: path.to_owned(), text: text.to_owned() }
}
