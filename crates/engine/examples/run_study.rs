//! Runs the stages of a study folder and prints its tables: `cargo run --release --example run_study -- DIR`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_engine::run::{Run, Trusted};
use rijke_study::Study;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("name the folder of a study")?;
    let study = Study::open(std::path::Path::new(&folder))?;
    let observations = study.observations()?;
    let mut run = Run::new(study, &observations, Trusted::Laplace)?;
    while let Some(stage) = run.next_stage()? {
        println!(
            "== {} ({} observations): {} ahead, {} goes on",
            stage.title,
            stage.measured.len(),
            stage.winner,
            stage.chosen
        );
        for model in &stage.models {
            let evidence = model.evidence.map(|e| e.per_observation());
            println!("{:<60} {evidence:.6?} {}", model.id, model.remark.as_deref().unwrap_or(""));
            if model.id == stage.chosen {
                for p in &model.parameters {
                    println!("    {} = {:.6e} +- {:.1e} {}", p.name, p.value, p.sd, p.unit);
                }
            }
        }
    }
    Ok(())
}
