//! What manifest and study state beside the records: where the mode lies, and how warm it was.

use rijke_rig::{Observations, RecordSet};
use rijke_signal::ProcessOptions;
use rijke_study::Study;

/// What a study has that does not say where its modes lie, Hz.
const UNSTATED: [f64; 2] = [10.0, 1000.0];

/// The band of the wanted mode, Hz, and for a study what states it.
pub(super) fn band(
    option: Option<&[f64]>,
    set: &RecordSet,
    study: Option<&Study>,
) -> ((f64, f64), Option<String>) {
    let usual = ProcessOptions::default().ping.band_hz;
    let searched = study.map(|s| s.rig.search[1]).filter(|band| *band != UNSTATED);
    let (band, why) = match (option, set.acquisition.band_hz, searched) {
        (Some(&[low, high]), _, _) => return ((low, high), None),
        (_, Some([low, high]), _) => ((low, high), "as `band_hz` of the manifest says"),
        (_, _, Some([low, high])) => ((low, high), "as [search] of rig.toml says"),
        _ => return (usual, None),
    };
    (band, Some(format!("the mode is sought from {} to {} Hz, {why}", band.0, band.1)))
}

/// Gives every point the ambient temperature that the campaign of the study states for it, in place of that
/// of its day; says so.
pub(super) fn temperatures(observations: &mut Observations, study: &Study) -> Option<String> {
    let (mut taken, mut apart) = (Vec::new(), 0.0_f64);
    for point in &mut observations.points {
        let known = study.campaign.point(&point.point.id).and_then(|(_, p)| p.ambient);
        if let Some([temperature, sd]) = known {
            apart = apart.max((temperature - point.ambient.ambient_temperature).abs());
            (point.ambient.ambient_temperature, point.ambient.ambient_temperature_sd) = (temperature, sd);
            taken.push(point.point.id.as_str());
        }
    }
    let (count, all) = (taken.len(), observations.points.len());
    let of_days = if count == all {
        String::new()
    } else {
        format!(", and those of the days for the other {}", all - count)
    };
    (count > 0).then(|| {
        format!(
            "{count} of {all} points have the ambient temperature of campaign.csv (T_amb), up to {apart:.2} K from that of their day{of_days}"
        )
    })
}

/// Warnings of records that hold the same bytes.
pub(crate) fn said_of_twins(twins: &[(String, String)]) -> Vec<String> {
    let said = |(a, b): &(String, String)| {
        format!("{b} holds the same bytes as {a}: look whether it was copied under another name")
    };
    twins.iter().map(said).collect()
}
