//! Likelihood of a block whose covariance is a diagonal, a misfit of an exact kernel in parts, and a few
//! columns.

mod slopes;

use crate::problem::{Kernelled, Structured};
use rijke_numerics::{Cholesky, DenseError, Matrix};

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
}
