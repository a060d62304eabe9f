//! Whose a number of the file is.

/// Whose numbers they are.
#[derive(Clone, Copy)]
pub(super) enum Owner<'a> {
    /// Numbers of a part.
    Part(usize),
    /// Numbers that laws call by a prefix: of an end, or of one coupling of a part.
    Other { name: &'a str, prefix: &'a str, part: Option<usize> },
}

impl Owner<'_> {
    pub(super) fn prefix(&self) -> &str {
        match self {
            Self::Part(_) => "",
            Self::Other { prefix, .. } => prefix,
        }
    }

    /// What laws call the number of a key.
    pub(super) fn name(&self, key: &str) -> String {
        format!("{}{key}", self.prefix())
    }
}
