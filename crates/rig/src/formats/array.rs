//! A numeric array of a file, and what else the file holds.

/// A numeric array with at most two dimensions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
    /// Column by column.
    pub(crate) values: Vec<f64>,
    /// 2^(bits - 1) for signed integers, which are fractions of full scale; none for all others, which are in
    /// Pa.
    pub(crate) largest: Option<f64>,
}

/// What a file of arrays holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Contents {
    /// The format, in words.
    pub(crate) format: &'static str,
    /// The numeric arrays.
    pub(crate) arrays: Vec<Array>,
    /// Names and kinds of what is no numeric array of at most two dimensions.
    pub(crate) others: Vec<String>,
}

impl Array {
    /// Time runs along the longer dimension, so that a record and its transpose are the same.
    pub(crate) fn samples(&self) -> usize {
        self.rows.max(self.columns)
    }

    pub(crate) fn channels(&self) -> usize {
        self.rows.min(self.columns)
    }

    pub(crate) fn at(&self, channel: usize, sample: usize) -> f64 {
        let (row, column) = if self.rows >= self.columns { (sample, channel) } else { (channel, sample) };
        self.values[row + column * self.rows]
    }

    /// `p (15000 x 8)`.
    pub(crate) fn described(&self) -> String {
        format!("{} ({} x {})", self.name, self.rows, self.columns)
    }
}

/// Largest file of arrays that is read, bytes. All of it is held; a longer record goes into WAV or text,
/// which are read a block at a time.
pub(crate) const LARGEST: u64 = 1 << 30;
