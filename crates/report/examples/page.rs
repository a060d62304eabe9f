//! Ranks the models of a study and writes its page: `cargo run --release -p rijke-report --example page --
//! DIR`.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use rijke_engine::run::{Run, Trusted};
use rijke_report::{StudyHead, StudyPage};
use rijke_study::Study;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "examples/quarter-wave".to_owned());
    let study = Study::open(folder.as_ref())?;
    let observations = study.observations()?;
    let head = StudyHead::of(&study, &observations);
    let mut run = Run::new(study, &observations, Trusted::Laplace)?;
    let mut stages = Vec::new();
    while let Some(stage) = run.next_stage()? {
        stages.push(stage);
    }
    StudyPage::new(&head, &stages, &[], &[], None)?.write("page".as_ref())?;
    println!("page/index.html");
    Ok(())
}
