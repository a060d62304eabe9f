//! Blocks of many data whose covariance is a diagonal and a few columns.

use super::kernelled::Kernelled;
use super::misfit::Kernel;
use crate::error::InferenceError;
use rijke_numerics::{C64, Matrix};

/// The covariance of a block of many data: C = D + U K U', with a diagonal D of measured variances and
/// independent noises, and the columns of U, each with a coefficient that is normal about zero, of variance
/// K.
///
/// Columns are *nuisances*: unknown amplitudes that are integrated over in closed form, be they real or
/// complex, known in size or with a standard deviation that is one of the noise groups. Cost of a likelihood:
/// O(n q^2) for q columns when noise or size change, O(n q) when they are held. To that may come one
/// *misfit*, an error of the model that is correlated along one coordinate, with a size and a length that are
/// noise groups.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Structured {
    pub(crate) variance: Vec<f64>,
    pub(crate) noise: Vec<(usize, Vec<f64>)>,
    pub(crate) columns: Matrix,
    pub(crate) sources: Vec<Source>,
    /// The misfit.
    pub(crate) kernelled: Option<Kernelled>,
    /// What was wrong with the sizes of what was added, told where the data are made.
    fault: Option<String>,
}

/// Where the variance of one coefficient comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Source {
    /// One: the column carries the standard deviation.
    Unit,
    /// The variance of a noise group.
    Group(usize),
}

/// A misfit that is correlated along a coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct Correlated<'a> {
    /// Group whose "standard deviation" is that of the misfit.
    pub size: usize,
    /// Group whose "standard deviation" is the length, in the unit of the coordinate.
    pub length: usize,
    /// Its smoothness.
    pub kernel: Kernel,
    /// The coordinate of each datum.
    pub coordinate: &'a [f64],
    /// Which of several independent misfits of that size and length acts on each datum: 0 and 1 for real and
    /// imaginary parts.
    pub part: &'a [usize],
}

impl Structured {
    /// Data with these measured variances, which do not float; zero where a noise group gives the variance.
    #[must_use]
    pub fn new(variance: Vec<f64>) -> Self {
        let columns = Matrix::zeros(variance.len(), 0);
        Self { variance, columns, ..Self::default() }
    }

    /// Adds `sd_g`^2 times `factors` to the variances.
    #[must_use]
    pub fn with_noise(mut self, group: usize, factors: Vec<f64>) -> Self {
        self.noise.push((group, factors));
        self
    }

    /// Adds nuisances: the columns of `matrix` (a row for each datum) times coefficients that are normal
    /// about zero with these standard deviations, one for each column. Other sizes are an error of
    /// [`crate::Data::new`].
    #[must_use]
    pub fn with_nuisances(mut self, matrix: &Matrix, sds: &[f64]) -> Self {
        let (n, q) = (matrix.rows(), matrix.columns());
        if sds.len() != q {
            self.fault = Some(format!("{q} columns of nuisances have {} standard deviations", sds.len()));
        }
        let sd = |j: usize| sds.get(j).copied().unwrap_or(f64::NAN);
        let scaled = Matrix::from_fn(n, q, |i, j| matrix[(i, j)] * sd(j));
        self.joined(&scaled, vec![Source::Unit; q])
    }

    /// Adds nuisances whose coefficients share the standard deviation of a noise group.
    #[must_use]
    pub fn with_floated_nuisances(self, matrix: &Matrix, group: usize) -> Self {
        self.joined(matrix, vec![Source::Group(group); matrix.columns()])
    }

    /// Adds a misfit correlated along a coordinate, in parts of up to 2000 data. Let its size and length be
    /// inferred ([`crate::NoiseGroup::inferred`]): a floated size that the data do not need runs to nothing,
    /// and its length then has no meaning. Nuisances beside it must have known standard deviations. Cost of
    /// a likelihood: O(m^3) for every part of m data that differs from the others in coordinates or noise,
    /// and O(n m q) for n data and q columns.
    ///
    /// # Errors
    /// [`InferenceError::BadObservation`] for lists of another length than the data, coordinates that are no
    /// numbers or all equal, a part of too many data.
    pub fn with_misfit(mut self, correlated: &Correlated) -> Result<Self, InferenceError> {
        let n = self.variance.len();
        if correlated.coordinate.len() != n {
            let problem = format!("{} coordinates for {n} data", correlated.coordinate.len());
            return Err(InferenceError::BadObservation { observation: "a misfit".to_owned(), problem });
        }
        let Correlated { size, length, kernel, coordinate, part } = *correlated;
        self.kernelled = Some(Kernelled::new((size, length, kernel), coordinate, part)?);
        Ok(self)
    }

    fn joined(mut self, matrix: &Matrix, sources: Vec<Source>) -> Self {
        let (n, old) = (self.variance.len(), self.columns.columns());
        if matrix.rows() != n {
            let rows = matrix.rows();
            self.fault = Some(format!(
                "nuisances have {rows} rows, not as long as its values, of which there are {n}"
            ));
        }
        self.columns = Matrix::from_fn(n, old + matrix.columns(), |i, j| {
            if j < old {
                self.columns[(i, j)]
            } else if i < matrix.rows() {
                matrix[(i, j - old)]
            } else {
                f64::NAN
            }
        });
        self.sources.extend(sources);
        self
    }

    /// What is wrong with it for `n` data and `groups` groups of noise, if anything.
    pub(crate) fn problem(&self, n: usize, groups: usize) -> Option<String> {
        if self.fault.is_some() {
            return self.fault.clone();
        }
        if self.variance.len() != n || self.noise.iter().any(|(_, s)| s.len() != n) {
            return Some(format!("its variances or factors of noise are not as many as its {n} values"));
        }
        let numbers = self.variance.iter().chain(self.noise.iter().flat_map(|(_, s)| s));
        if let Some(v) = numbers.into_iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
            return Some(format!("a variance is {v}"));
        }
        if let Some(v) = self.columns.as_slice().iter().find(|v| !v.is_finite()) {
            return Some(format!("its columns hold {v}, or are not as long as its values"));
        }
        let named = self.noise.iter().map(|(g, _)| *g).chain(self.sources.iter().filter_map(|s| match s {
            Source::Group(g) => Some(*g),
            _ => None,
        }));
        let named = named.chain(self.kernelled.iter().flat_map(|m| [m.size, m.length]));
        if self.kernelled.is_some() && !self.has_known_columns() {
            return Some("beside a misfit its nuisances must have known standard deviations".to_owned());
        }
        if let Some(group) = named.into_iter().find(|g| *g >= groups) {
            return Some(format!("it names noise group {group}, but there are {groups}"));
        }
        let bare = |i: usize| self.variance[i] == 0.0 && self.noise.iter().all(|(_, s)| s[i] == 0.0);
        (0..n)
            .find(|&i| bare(i))
            .map(|i| format!("value {i} has no independent variance; give it one, or a noise group"))
    }

    /// Whether all columns have coefficients of known size.
    fn has_known_columns(&self) -> bool {
        self.sources.iter().all(|s| *s == Source::Unit)
    }

    /// The diagonal D.
    pub(crate) fn diagonal(&self, sds: &[f64]) -> Vec<f64> {
        let mut d = self.variance.clone();
        for (g, s) in &self.noise {
            let t = sds[*g] * sds[*g];
            for (d, s) in d.iter_mut().zip(s) {
                *d += t * s;
            }
        }
        d
    }

    /// ln of the variance of each coefficient.
    pub(crate) fn ln_variances(&self, sds: &[f64]) -> Vec<f64> {
        let one = |source: &Source| match *source {
            Source::Unit => 0.0,
            Source::Group(g) => 2.0 * sds[g].ln(),
        };
        self.sources.iter().map(one).collect()
    }

    /// Derivatives of these logarithms with respect to ln of the standard deviation of group `g`; the second
    /// derivatives are zero. None if the group acts on no coefficient.
    pub(crate) fn slopes(&self, g: usize) -> Option<Vec<f64>> {
        let one = |source: &Source| if *source == Source::Group(g) { 2.0 } else { 0.0 };
        self.sources.contains(&Source::Group(g)).then(|| self.sources.iter().map(one).collect())
    }

    /// How many data a group acts on.
    pub(crate) fn data_of(&self, group: usize) -> usize {
        let noise = self.noise.iter().filter(|(g, _)| *g == group);
        let data: usize = noise.map(|(_, s)| s.iter().filter(|s| **s > 0.0).count()).sum();
        let columns = self.sources.contains(&Source::Group(group))
            || self.kernelled.iter().any(|m| m.size == group || m.length == group);
        data + if columns { self.variance.len() } else { 0 }
    }

    /// The measured variance of each datum on which a noise acts, in units of its factor there.
    pub(crate) fn floors(&self, group: usize) -> impl Iterator<Item = f64> {
        let noise = self.noise.iter().filter(move |(g, _)| *g == group);
        noise.flat_map(|(_, s)| s.iter().zip(&self.variance).filter(|(s, _)| **s > 0.0).map(|(s, v)| v / s))
    }

    /// A value to start from for each group that acts here: the root mean square of the `residuals`, or the
    /// middle of the lengths.
    pub(crate) fn guesses(&self, residuals: &[f64]) -> Vec<(usize, f64)> {
        let square = residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len().max(1) as f64;
        let size = square.sqrt().max(f64::MIN_POSITIVE.sqrt());
        let noise = self.noise.iter().map(|(g, s)| {
            let mean = s.iter().sum::<f64>() / s.len().max(1) as f64;
            (*g, 0.3 * size / mean.sqrt().max(f64::MIN_POSITIVE))
        });
        let groups = self.sources.iter().filter_map(|s| match s {
            Source::Group(g) => Some((*g, size)),
            _ => None,
        });
        let kernelled = self.kernelled.iter().flat_map(|m| [(m.size, size), (m.length, m.middle)]);
        noise.chain(kernelled).chain(groups).collect()
    }

    /// The covariance as a dense matrix.
    pub(crate) fn dense(&self, sds: &[f64]) -> Matrix {
        let n = self.variance.len();
        let roots: Vec<f64> = self.ln_variances(sds).iter().map(|v| (0.5 * v).exp()).collect();
        let scaled = Matrix::from_fn(n, roots.len(), |i, j| self.columns[(i, j)] * roots[j]);
        let plain =
            scaled.large_product(&scaled.transpose()).plus(1.0, &Matrix::diagonal(&self.diagonal(sds)));
        self.kernelled.iter().fold(plain, |sum, k| sum.plus(1.0, &k.dense(n, sds)))
    }
}

/// Complex columns for data that are real and imaginary parts in turn: each becomes two real ones, for the
/// real and the imaginary part of its coefficient. `columns[j][k]` belongs to datum k.
#[must_use]
pub fn complex_columns(columns: &[Vec<C64>]) -> Matrix {
    let n = columns.first().map_or(0, Vec::len);
    Matrix::from_fn(2 * n, 2 * columns.len(), |row, column| {
        let u = columns[column / 2][row / 2];
        match (row % 2, column % 2) {
            (0, 0) | (1, 1) => u.re,
            (0, _) => -u.im,
            _ => u.im,
        }
    })
}
