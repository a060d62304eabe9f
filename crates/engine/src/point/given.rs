//! A rig at one operating point, for tests.

use crate::{Assembly, Conditions};
use rijke_study::{OneTable, PointState};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The rig of a file's text with its own unknowns, at 293.15 K.
pub(crate) fn at_one_point(rig: &str) -> (Assembly, Conditions) {
    static MADE: AtomicUsize = AtomicUsize::new(0);
    let name = format!("rijke-given-{}-{}", std::process::id(), MADE.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let [file, table] = ["rig.toml", "modes.csv"].map(|name| folder.join(name));
    std::fs::write(&file, rig).unwrap();
    std::fs::write(&table, "growth_rate,growth_rate_sd,frequency,frequency_sd\n-10,1,70,1\n").unwrap();
    let (study, _) = OneTable::read(&file, &table).unwrap().study().unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let point = study.campaign.points[0].clone();
    let layout = study.rig.at(&point, 293.15).unwrap();
    let base = PointState::of_the_rig(&study.rig, &layout, &point, [293.15, 0.0]).unwrap();
    let conditions = Conditions { id: point.id.clone(), point, layout, base, displaced: Vec::new() };
    (Assembly::new(Arc::new(study.rig.clone()), Vec::new(), &BTreeMap::new()).unwrap(), conditions)
}
