//! Likelihood of a block whose covariance is a diagonal, a misfit of an exact kernel in parts, and a few columns.

mod slopes;

use crate::structured::{Source, Structured};
use crate::{InferenceError, Kernel};
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::{Cholesky, DenseError, Matrix, Stream};

/// A misfit by its kernel, exact at any length: parts of data that do not hear each other share its size and length.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Kernelled {
    pub(crate) size: usize,
    pub(crate) length: usize,
    pub(crate) kernel: Kernel,
    coordinate: Vec<f64>,
    /// The rows of each part.
    parts: Vec<Vec<usize>>,
    /// A length to start from.
    pub(crate) middle: f64,
}

impl Kernelled {
    pub(crate) fn new(
        (size, length, kernel): (usize, usize, Kernel),
        coordinate: &[f64],
        part: &[usize],
    ) -> Result<Self, InferenceError> {
        let bad = |problem: String| {
            Err(InferenceError::BadObservation { observation: "a misfit".to_owned(), problem })
        };
        if coordinate.len() != part.len() {
            return bad(format!("{} coordinates and {} parts", coordinate.len(), part.len()));
        }
        let low = coordinate.iter().copied().fold(f64::INFINITY, f64::min);
        let high = coordinate.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !(low < high && (high - low).is_finite() && coordinate.iter().all(|x| x.is_finite())) {
            return bad(format!("its coordinate runs from {low} to {high}"));
        }
        let count = part.iter().max().map_or(0, |p| p + 1);
        let mut parts = vec![Vec::new(); count];
        for (row, &p) in part.iter().enumerate() {
            parts[p].push(row);
        }
        parts.retain(|rows| !rows.is_empty());
        let longest = parts.iter().map(Vec::len).max().unwrap_or(0);
        if longest > MOST {
            return bad(format!("a part of it has {longest} data, more than {MOST}; take fewer frequencies"));
        }
        let middle = 0.1 * (high - low);
        Ok(Self { size, length, kernel, coordinate: coordinate.to_vec(), parts, middle })
    }

    /// Correlations within a part and their first two derivatives with respect to ln of the length.
    fn correlations(&self, rows: &[usize], length: f64) -> [Matrix; 3] {
        let n = rows.len();
        let mut all = [Matrix::zeros(n, n), Matrix::zeros(n, n), Matrix::zeros(n, n)];
        for i in 0..n {
            for j in 0..=i {
                let x = self.coordinate[rows[i]] - self.coordinate[rows[j]];
                for (m, v) in all.iter_mut().zip(self.kernel.correlation_in_length(x, length)) {
                    (m[(i, j)], m[(j, i)]) = (v, v);
                }
            }
        }
        all
    }

    /// The covariance of the misfit as a dense matrix.
    pub(crate) fn dense(&self, n: usize, sds: &[f64]) -> Matrix {
        let mut all = Matrix::zeros(n, n);
        for rows in &self.parts {
            let [c, ..] = self.correlations(rows, sds[self.length]);
            for (i, a) in rows.iter().enumerate() {
                for (j, b) in rows.iter().enumerate() {
                    all[(*a, *b)] = sds[self.size].powi(2) * c[(i, j)];
                }
            }
        }
        all
    }
}

/// Most data of one part: its covariance is dense.
const MOST: usize = 2000;

/// B of one part, and what size and length do to it: each part's matrices, shared by parts that are the same.
struct Part {
    factor: Cholesky,
    inverse: Matrix,
    /// B^-1 B_g of the size and of the length.
    turned: [Matrix; 2],
    /// B_g of both, and B_gh: size twice, length twice, both.
    slopes: [Matrix; 2],
    bends: [Matrix; 3],
}

/// C = B + U K U', B block diagonal, with M = I + K^1/2 U'B^-1 U K^1/2.
pub(crate) struct KernelFactor {
    parts: Vec<Part>,
    /// For every part of the misfit the place of its matrices.
    of: Vec<usize>,
    columns: Matrix,
    /// B^-1 U K^1/2.
    solved: Matrix,
    factor: Cholesky,
    ln_det: f64,
}

impl KernelFactor {
    pub(crate) fn new(structured: &Structured, k: &Kernelled, sds: &[f64]) -> Result<Self, DenseError> {
        let diagonal = structured.diagonal(sds);
        let variance = sds[k.size].powi(2);
        let (mut parts, mut of, mut keys) = (Vec::new(), Vec::new(), Vec::<(Vec<f64>, Vec<f64>)>::new());
        let mut ln_det = 0.0;
        for rows in &k.parts {
            let key: (Vec<f64>, Vec<f64>) = (
                rows.iter().map(|&r| k.coordinate[r]).collect(),
                rows.iter().map(|&r| diagonal[r]).collect(),
            );
            let known = keys.iter().position(|other| *other == key);
            let index = match known {
                Some(index) => index,
                None => {
                    let [c, first, second] = k.correlations(rows, sds[k.length]);
                    let n = rows.len();
                    let scaled = |m: &Matrix, f: f64| Matrix::zeros(n, n).plus(f * variance, m);
                    let b = scaled(&c, 1.0).plus(1.0, &Matrix::diagonal(&key.1));
                    let factor = Cholesky::new(&b)?;
                    let inverse = factor.inverse();
                    let slopes = [scaled(&c, 2.0), scaled(&first, 1.0)];
                    let turned = [0, 1].map(|g| inverse.large_product(&slopes[g]));
                    let bends = [scaled(&c, 4.0), scaled(&second, 1.0), scaled(&first, 2.0)];
                    parts.push(Part { factor, inverse, turned, slopes, bends });
                    keys.push(key);
                    parts.len() - 1
                }
            };
            ln_det += parts[index].factor.ln_det();
            of.push(index);
        }
        let roots: Vec<f64> = structured.ln_variances(sds).iter().map(|v| (0.5 * v).exp()).collect();
        let columns =
            Matrix::from_fn(diagonal.len(), roots.len(), |i, j| structured.columns[(i, j)] * roots[j]);
        let mut known = Self {
            parts,
            of,
            columns,
            solved: Matrix::default(),
            factor: Cholesky::new(&Matrix::identity(1))?,
            ln_det,
        };
        known.solved = known.inside(k, &known.columns, |part| &part.inverse);
        let gram = known.columns.transpose().large_product(&known.solved);
        let even = Matrix::from_fn(roots.len(), roots.len(), |i, j| 0.5 * (gram[(i, j)] + gram[(j, i)]));
        if !roots.is_empty() {
            known.factor = Cholesky::new(&even.plus(1.0, &Matrix::identity(roots.len())))?;
            known.ln_det += known.factor.ln_det();
        }
        Ok(known)
    }

    /// A block-diagonal matrix, by its parts, times X.
    fn inside(&self, k: &Kernelled, x: &Matrix, matrix: impl Fn(&Part) -> &Matrix) -> Matrix {
        let mut out = Matrix::zeros(x.rows(), x.columns());
        if x.columns() == 0 {
            return out;
        }
        for (rows, &index) in k.parts.iter().zip(&self.of) {
            let own = Matrix::from_fn(rows.len(), x.columns(), |i, j| x[(rows[i], j)]);
            let product = matrix(&self.parts[index]).large_product(&own);
            for (i, &row) in rows.iter().enumerate() {
                for j in 0..x.columns() {
                    out[(row, j)] = product[(i, j)];
                }
            }
        }
        out
    }

    /// C^-1 X.
    fn solve(&self, k: &Kernelled, x: &Matrix) -> Matrix {
        let mut out = self.inside(k, x, |part| &part.inverse);
        if self.columns.columns() > 0 {
            let along = self.solved.transpose().large_product(x);
            let inner: Vec<Vec<f64>> = (0..x.columns())
                .map(|j| self.factor.solve(&(0..along.rows()).map(|i| along[(i, j)]).collect::<Vec<_>>()))
                .collect();
            let inner = Matrix::from_fn(along.rows(), x.columns(), |i, j| inner[j][i]);
            out = out.plus(-1.0, &self.solved.large_product(&inner));
        }
        out
    }

    /// A draw of the noise.
    pub(crate) fn draw(&self, k: &Kernelled, stream: &mut Stream) -> Vec<f64> {
        let mut normal =
            |n: usize| -> Vec<f64> { (0..n).map(|_| stream.sample::<f64, _>(StandardNormal)).collect() };
        let mut out = self.columns.times(&normal(self.columns.columns()));
        out.resize(self.columns.rows(), 0.0);
        for (rows, &index) in k.parts.iter().zip(&self.of) {
            let smooth = self.parts[index].factor.lower().times(&normal(rows.len()));
            for (&row, s) in rows.iter().zip(smooth) {
                out[row] += s;
            }
        }
        out
    }
}

/// Whether all columns of a structure have coefficients of known size.
pub(crate) fn known_columns(structured: &Structured) -> bool {
    structured.sources.iter().all(|s| *s == Source::Unit)
}
