//! Where the wall loss lives: the paper's lumped jumps against the exact lossy line.

use crate::catalogue::{catalogue, chosen};
use crate::{Check, StudyError};
use rijke_model::{Assembly, Conditions, PointModel, Scheme, Workspace};
use rijke_numerics::{C64, Order};
use rijke_rig::Rig;
use serde::{Deserialize, Serialize};

/// Convergence of the lumped scheme for the empty tube.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LumpedConvergence {
    /// Growth rate and angular frequency of the exact line, 1/s and rad/s.
    pub exact: [f64; 2],
    /// One row per number of elements.
    pub rows: Vec<LumpedRow>,
    /// What was found.
    pub checks: Vec<Check>,
}

/// The lumped scheme with one number of elements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LumpedRow {
    /// Number of elements.
    pub elements: usize,
    /// Growth rate and angular frequency, 1/s and rad/s.
    pub eigenvalue: [f64; 2],
    /// Relative error of the growth rate; negative if the decay is too slow.
    pub growth_rate_error: f64,
    /// Relative error of the angular frequency.
    pub angular_frequency_error: f64,
    /// log2 of the error of the row before over this one: the order of convergence.
    pub order: Option<f64>,
}

/// Errors of the lumped scheme at 20 C with eta = 1 and Levine-Schwinger ends, for 10 to 640 elements.
///
/// # Errors
/// Those of the model; none for the rig of the paper.
pub fn lumped_convergence(rig: &Rig) -> Result<LumpedConvergence, StudyError> {
    let exact = eigenvalue(rig, Scheme::Line { elements: 1 })?;
    let mut rows: Vec<LumpedRow> = Vec::new();
    for elements in [10, 20, 40, 80, 160, 320, 640] {
        let s = eigenvalue(rig, Scheme::Lumped { elements })?;
        let error = s.re / exact.re - 1.0;
        rows.push(LumpedRow {
            elements,
            eigenvalue: [s.re, s.im],
            growth_rate_error: error,
            angular_frequency_error: s.im / exact.im - 1.0,
            order: rows.last().map(|before| (before.growth_rate_error / error).log2()),
        });
    }
    let at_40 = rows[2].growth_rate_error;
    let order = rows.last().and_then(|r| r.order).unwrap_or(f64::NAN);
    let checks = vec![
        Check {
            statement:
                "With N = 40 lumped elements the decay rate is about 2.9 % low, because the two end half \
                        elements, where velocity is largest, get no loss."
                    .to_owned(),
            holds: (at_40 + 0.029).abs() < 0.005,
            figure: format!("{:.2} %", 100.0 * at_40),
            explanation: None,
        },
        Check {
            statement: "The error of the lumped scheme falls in inverse proportion to N.".to_owned(),
            holds: (order - 1.0).abs() < 0.05,
            figure: format!("order {order:.3}"),
            explanation: None,
        },
    ];
    Ok(LumpedConvergence { exact: [exact.re, exact.im], rows, checks })
}

fn eigenvalue(rig: &Rig, scheme: Scheme) -> Result<C64, StudyError> {
    let ids = ["wall.rayleigh", "ends.levine-schwinger"];
    let assembly = Assembly::new(rig.clone(), chosen(&catalogue()?, &ids)?)?.with_scheme(scheme);
    let conditions = Conditions::empty_tube(rig, 293.15)?;
    let model = PointModel::new(&assembly, &conditions, &[rig.microphones.reference])?;
    Ok(model.respond(&[1.0], Order::Value, &mut Workspace::default())?.s.value())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_the_lumped_scheme_converges_to_the_line_at_first_order() {
        let found = lumped_convergence(&Rig::juniper_yoko_2022()).unwrap();
        assert!((found.rows[6].order.unwrap() - 1.0).abs() < 0.02, "{:?}", found.rows);
        assert!(found.checks.iter().all(|c| c.holds), "{:?}", found.checks);
    }
}
