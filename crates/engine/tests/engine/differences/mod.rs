//! The modes of a network file whose names are replaced by numbers in its text, with derivatives by
//! differences: the slow way, which shares no law, no layout and no derivative with the engine.

use rijke_inference::{Forward, ForwardError, Prediction};
use rijke_network::{Newton, Workspace, file::read};
use rijke_numerics::{C64, Matrix, Order};

/// A network file, and the modes that are predicted.
pub(crate) struct ByDifferences {
    /// The text, without the tables of the unknowns.
    pub(crate) text: String,
    /// Names of the unknowns, and the step of each.
    pub(crate) unknowns: Vec<(String, f64)>,
    /// For every mode the name and the value of its factor, growth rate (1/s) and angular frequency (rad/s).
    pub(crate) modes: Vec<(String, f64, [f64; 2])>,
}

impl ByDifferences {
    /// Growth rate and angular frequency of every mode in turn.
    ///
    /// # Errors
    /// A text that is no network, or has no such mode.
    pub(crate) fn values(&self, unknowns: &[f64]) -> Result<Vec<f64>, ForwardError> {
        let mut all = Vec::new();
        for (factor, value, near) in &self.modes {
            let mut text = self.text.replace(&format!("\"${factor}\""), &format!("{value:e}"));
            for ((name, _), value) in self.unknowns.iter().zip(unknowns) {
                text = text.replace(&format!("\"${name}\""), &format!("{value:e}"));
            }
            let built = read(&text).map_err(ForwardError::recoverable)?;
            let guess = C64::new(near[0], near[1]);
            let root = built.network.solve(&built.laws, guess, &Newton::default(), &mut Workspace::default());
            let s = root.map_err(ForwardError::recoverable)?.s;
            all.extend([s.re, s.im]);
        }
        Ok(all)
    }
}

impl Forward for ByDifferences {
    fn predict(&self, at: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let values = self.values(at)?;
        let mut jacobian = Matrix::default();
        if order >= Order::First {
            jacobian = Matrix::zeros(values.len(), at.len());
            for (i, (_, step)) in self.unknowns.iter().enumerate() {
                let side = |sign: f64| {
                    let mut moved = at.to_vec();
                    moved[i] += sign * step;
                    self.values(&moved)
                };
                for (row, (up, down)) in side(1.0)?.iter().zip(&side(-1.0)?).enumerate() {
                    jacobian[(row, i)] = (up - down) / (2.0 * step);
                }
            }
        }
        Ok(Prediction { values, jacobian, curvature: Vec::new() })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}

/// The ducted flame of the examples: gain, delay and second-order response.
pub(crate) fn ducted_flame() -> ByDifferences {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/ducted-flame/");
    let file = |name: &str| std::fs::read_to_string(format!("{folder}{name}")).unwrap();
    let text = file("second-order.toml");
    let rows = file("modes.csv");
    let rows = rows.lines().filter(|l| !l.starts_with('#')).skip(1);
    let modes = rows.map(|row| {
        let cells: Vec<f64> = row.split(',').map(|c| c.parse().unwrap()).collect();
        ("chamber_length".to_owned(), cells[0], [cells[1], std::f64::consts::TAU * cells[3]])
    });
    let unknowns = [("end", 3e-6), ("n", 5e-5), ("delay", 1e-7), ("a1", 4e-8), ("a2", 2e-11)];
    ByDifferences {
        modes: modes.collect(),
        text: text.split("[unknown.").next().unwrap_or_default().to_owned(),
        unknowns: unknowns.map(|(name, step)| (name.to_owned(), step)).to_vec(),
    }
}
