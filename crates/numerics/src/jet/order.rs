//! How many derivatives there are, and where second ones stand.

/// How many derivatives to carry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Order {
    /// The value alone.
    Value,
    /// Value and gradient.
    First,
    /// Value, gradient and Hessian.
    Second,
}

/// Place of (i, j) in a symmetric matrix that is packed as its lower triangle, row by row: (0,0), (1,0),
/// (1,1), (2,0), ...
#[must_use]
pub fn packed(i: usize, j: usize) -> usize {
    let (row, column) = if i >= j { (i, j) } else { (j, i) };
    row * (row + 1) / 2 + column
}
