//! The rig at every operating point of a study: `cargo run --release -p rijke-study --example points -- DIR`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_study::Study;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "examples/quarter-wave".to_owned());
    let study = Study::open(folder.as_ref())?;
    for point in &study.campaign.points {
        let layout = study.rig.at(point, 293.15)?;
        println!("{}: {} ducts, {} m", point.id, layout.ducts.len(), layout.length);
    }
    Ok(())
}
