//! The steps of a run, and the marks by which a later run knows that one was finished.

use super::{Options, RECORDS, RESULTS};
use crate::root;
use std::{fs, path::PathBuf};

/// One call of `rijke`.
pub(super) struct Step {
    /// Subcommand and options.
    pub(super) arguments: Vec<String>,
    /// The folder that it makes. Made anew, it has no mark, whoever made it.
    output: &'static str,
}

/// File in the output of a finished step: fingerprint and duration.
const MARK: &str = ".reproduce";

/// All steps in order.
pub(super) fn steps(options: &Options) -> Vec<Step> {
    let step = |text: &str, output| Step { arguments: text.split(' ').map(String::from).collect(), output };
    let repeats = if options.quick { " --repeats 4" } else { "" };
    let lab =
        format!("lab --out {RECORDS} --force --row C3 --row C1 --row C2 --seed {}{repeats}", options.seed);
    vec![
        step(&lab, RECORDS),
        step(&format!("process {RECORDS} --force"), "virtual-rig/observations"),
        step(&format!("rank {RECORDS} --out {RESULTS} --force"), "results/numbers"),
        step(&format!("report {RESULTS}"), "results/figures"),
    ]
}

impl Step {
    /// How many seconds the step took, if it was finished with this fingerprint.
    pub(super) fn finished(&self, fingerprint: &str) -> Option<f64> {
        let text = fs::read_to_string(self.place()).ok()?;
        let (found, seconds) = text.trim().split_once(' ')?;
        (found == fingerprint).then(|| seconds.parse().ok())?
    }

    /// Marks the step as finished.
    pub(super) fn mark(&self, fingerprint: &str, seconds: f64) -> Result<(), String> {
        let place = self.place();
        fs::write(&place, format!("{fingerprint} {seconds:.2}\n"))
            .map_err(|e| format!("{}: {e}", place.display()))
    }

    fn place(&self) -> PathBuf {
        root().join(self.output).join(MARK)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_options_reach_the_laboratory() {
        let options = Options { quick: true, seed: 7, fresh: false, check: false, accept: false };
        let steps = steps(&options);
        let command = steps[0].arguments.join(" ");
        assert_eq!(command, "lab --out virtual-rig --force --row C3 --row C1 --row C2 --seed 7 --repeats 4");
        let names: Vec<_> = steps.iter().map(|s| &*s.arguments[0]).collect();
        assert_eq!(names, ["lab", "process", "rank", "report"]);
    }

    #[test]
    fn exact_a_step_is_kept_for_the_same_fingerprint_only() {
        let folder = std::env::temp_dir().join(format!("rijke-steps-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        // An absolute path replaces the root.
        let output: &'static str = Box::leak(folder.display().to_string().into_boxed_str());
        let step = Step { arguments: vec![], output };
        assert_eq!(step.finished("aa"), None);
        step.mark("aa", 1.5).unwrap();
        assert_eq!((step.finished("aa"), step.finished("ab")), (Some(1.5), None));
        fs::remove_dir_all(folder).unwrap();
    }
}
