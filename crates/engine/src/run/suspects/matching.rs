//! Whether the modes that were measured are those of the model.

use crate::point::respond_together;
use crate::{Assembly, EngineError, NamedGaussian, Observed, PointModel};
use rayon::prelude::*;
use rijke_network::Workspace;
use rijke_numerics::{InOrder, Order};
use rijke_study::hertz;

/// Parts of the distance between modes by which a measured mode may differ from the one of the model that is
/// found from it.
const SAME_MODE: f64 = 0.35;

/// Checks that the modes that were measured are modes of the model at the mean of what is known, or at the
/// median of a prior, and that two of a point are two.
pub(in crate::run) fn check_modes(
    assembly: &Assembly,
    points: &[Observed],
    known: &[NamedGaussian],
) -> Result<(), EngineError> {
    let middle = |p: &rijke_inference::Parameter| {
        let earlier = known.iter().rev().find_map(|k| {
            let place = k.names.iter().position(|n| *n == p.name)?;
            Some(k.mean[place])
        });
        earlier.unwrap_or_else(|| p.prior.quantile(0.5))
    };
    let values: Vec<f64> = assembly.parameters().iter().map(middle).collect();
    let groups: Vec<&[Observed]> = points.chunk_by(|a, b| a.conditions.id == b.conditions.id).collect();
    let of_a_point = |group: &&[Observed]| {
        let model = |o: &Observed| Ok(PointModel::new(assembly, &o.conditions, &[])?.starting_from(o.near));
        let models = group.iter().map(model).collect::<Result<Vec<_>, EngineError>>()?;
        let work = &mut Workspace::default();
        Ok(match respond_together(&models, &values, Order::Value, work) {
            Ok(all) => all.iter().map(|r| Some(r.s.value().im)).collect(),
            Err(_) => {
                // A search that is lost ends nowhere: the nearest of all modes around says more.
                let one = |(m, o): (&PointModel<'_>, &Observed)| {
                    let work = &mut Workspace::default();
                    let near = m.respond(&values, Order::Value, work).ok().map(|r| r.s.value().im);
                    near.or_else(|| Some(m.assigned(&values, &[o.near], 0.0, work)?[0].im))
                };
                models.iter().zip(*group).map(one).collect::<Vec<_>>()
            }
        })
    };
    let found: Vec<Vec<Option<f64>>> =
        groups.par_iter().map(of_a_point).in_order::<Result<_, EngineError>>()?;
    let found: Vec<Option<f64>> = found.into_iter().flatten().collect();
    for (k, (o, omega)) in points.iter().zip(&found).enumerate() {
        let layout = &o.conditions.layout;
        let spacing = std::f64::consts::PI / o.conditions.base.travel_time(0.0, layout.length);
        let point = o.conditions.id.clone();
        let measured_hz = hertz(o.near.im);
        let Some(omega) = *omega else { continue };
        if (omega - o.near.im).abs() > SAME_MODE * spacing {
            return Err(EngineError::OtherMode { point, measured_hz, described_hz: hertz(omega).abs() });
        }
        let twin = (0..k).find(|&j| {
            points[j].conditions.id == point
                && found[j].is_some_and(|w| (w - omega).abs() < 1e-6 * omega.abs())
        });
        if let Some(j) = twin {
            let (first_hz, described_hz) = (hertz(points[j].near.im), hertz(omega));
            return Err(EngineError::AmbiguousModes {
                point,
                first_hz,
                second_hz: measured_hz,
                described_hz,
            });
        }
    }
    Ok(())
}
