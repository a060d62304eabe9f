//! What manifest and study state beside the records: where the mode lies, and the mains.

use rijke_rig::RecordSet;
use rijke_signal::ProcessOptions;
use rijke_study::Study;

/// The band of the wanted mode, Hz, and for a study what states it.
pub(crate) fn band(
    option: Option<[f64; 2]>,
    set: &RecordSet,
    study: Option<&Study>,
) -> ((f64, f64), Option<String>) {
    let usual = ProcessOptions::default().ping.band_hz;
    let recorded = study.and_then(|s| s.rig.ping_band_hz);
    let searched = study.filter(|s| s.rig.search_is_stated[1]).map(|s| s.rig.search[1]);
    let (band, why) = match (option, set.acquisition.band_hz, recorded, searched) {
        (Some([low, high]), _, _, _) => return ((low, high), None),
        (_, Some([low, high]), _, _) => ((low, high), "as `band_hz` of the manifest says"),
        (_, _, Some([low, high]), _) => ((low, high), "as `band_hz` of rig.toml says"),
        (_, _, _, Some([low, high])) => ((low, high), "as [search] of rig.toml says"),
        _ => return (usual, None),
    };
    (band, Some(format!("the mode is sought from {} to {} Hz, {why}", band.0, band.1)))
}

/// The frequency of the mains, Hz, if option, manifest or study state it.
pub(crate) fn mains(option: Option<f64>, set: &RecordSet, study: Option<&Study>) -> Option<f64> {
    option.or(set.acquisition.mains_hz).or_else(|| study?.rig.mains_hz)
}
