//! The stages of a run, and the marks by which a later run knows that one was finished.

use super::hashes;
use super::options::Options;
use crate::workspace::write;
use std::{fs, path::PathBuf};

/// One call of `rijke`.
pub(super) struct Stage {
    /// Subcommand and options.
    pub(super) arguments: Vec<String>,
    /// The folder in which it runs; all others are relative to it.
    base: PathBuf,
    /// Folders that it reads.
    inputs: Vec<String>,
    /// The folder that it makes. Made anew, it has no mark, whoever made it.
    output: String,
    /// Its part of the time of a full run (docs/performance.md), to tell the time left.
    share: f64,
}

/// What a stage took.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Made {
    /// Duration, s.
    pub(super) seconds: f64,
    /// The most memory that it held, MiB; 0 where the system does not tell.
    pub(super) peak_mib: u64,
}

/// A finished stage: what it took, whether it was kept from before, and the hashes of its inputs.
pub(super) type Done = (Made, bool, Vec<(String, String)>);

/// File in the output of a finished stage: fingerprint, hash of the output, duration, memory.
const MARK: &str = ".reproduce";

/// All stages in order.
pub(super) fn stages(options: &Options) -> Vec<Stage> {
    let stage = |text: String, inputs: &[&str], output: &str, share| Stage {
        base: options.base(),
        arguments: text.split(' ').map(String::from).collect(),
        inputs: inputs.iter().map(|i| (*i).to_owned()).collect(),
        output: output.to_owned(),
        share,
    };
    let (only, work) = (options.only.as_ref(), options.study());
    let (observations, base, numbers) =
        (format!("{work}/observations"), format!("{work}/base"), format!("{work}/results/numbers"));
    let rows = only.and_then(|item| item.cold.as_ref());
    let rows = rows.map_or_else(String::new, |rows| format!(" --rows {}", rows.join(",")));
    let repeats = if options.quick { " --repeats 4" } else { "" };
    let seed = options.seed;
    let process = format!("process --virtual-rig --seed {seed}{repeats}{rows} --out {observations} --force");
    let mut stages = vec![stage(process, &[], &observations, 0.4)];
    let mut ranked = vec![&*observations];
    if only.is_none_or(|item| item.cold.is_none()) {
        let infer = format!("flow {work} --out {base} --force");
        stages.push(stage(infer, &[&observations], &base, 0.3));
        ranked.push(&base);
    }
    let until = only.map_or_else(String::new, |item| format!(" --until {}", item.until));
    // One maximum is sought of each posterior, as in the paper; the notes of the laboratory's rows with all
    // checks are in docs/records.
    let rank = format!("rank {work} --one-start --force{until}");
    stages.push(stage(rank, &ranked, &numbers, 0.3));
    stages.push(stage(format!("report {work}"), &[&numbers], &format!("{work}/results/figures"), 0.005));
    stages
}

/// Seconds that the coming stages will take, judged by those that were run; none before the first.
pub(super) fn time_left(before: &[Stage], done: &[Done], coming: &[Stage]) -> Option<f64> {
    let took: f64 = done.iter().map(|(made, ..)| made.seconds).sum();
    let share = |stages: &[Stage]| stages.iter().map(|s| s.share).sum::<f64>();
    (share(before) > 0.0).then(|| took * share(coming) / share(before))
}

impl Stage {
    /// What the stage makes depends on the program, its arguments and the content of what it reads.
    pub(super) fn fingerprint(&self, program: &str, inputs: &[(String, String)]) -> String {
        let inputs: String = inputs.iter().map(|(path, hash)| format!("\n{path} {hash}")).collect();
        hashes::text(&format!("{program}\n{}{inputs}", self.arguments.join("\n")))
    }

    /// Hash of the content of each folder that is read.
    pub(super) fn input_hashes(&self) -> Result<Vec<(String, String)>, String> {
        self.inputs.iter().map(|folder| Ok((folder.clone(), content(&self.base.join(folder))?))).collect()
    }

    /// What the stage took, if it was finished with this fingerprint and its output is as it left it.
    pub(super) fn finished(&self, fingerprint: &str) -> Result<Option<Made>, String> {
        let Ok(text) = fs::read_to_string(self.mark_file()) else { return Ok(None) };
        let words: Vec<_> = text.split_whitespace().collect();
        let [found, output, seconds, peak_mib] = words[..] else { return Ok(None) };
        if found != fingerprint || output != content(&self.base.join(&self.output))? {
            return Ok(None);
        }
        let made = |(seconds, peak_mib)| Made { seconds, peak_mib };
        Ok(seconds.parse().ok().zip(peak_mib.parse().ok()).map(made))
    }

    /// Marks the stage as finished.
    pub(super) fn mark(&self, fingerprint: &str, made: &Made) -> Result<(), String> {
        let (place, output) = (self.mark_file(), content(&self.base.join(&self.output))?);
        let text = format!("{fingerprint} {output} {:.2} {}\n", made.seconds, made.peak_mib);
        write(&place, text)
    }

    fn mark_file(&self) -> PathBuf {
        self.base.join(&self.output).join(MARK)
    }
}

/// One hash of all files of a folder.
fn content(folder: &std::path::Path) -> Result<String, String> {
    let files = hashes::folder(folder, folder)?;
    Ok(hashes::text(&files.iter().map(|(name, hash)| format!("{name} {hash}\n")).collect::<String>()))
}

#[cfg(test)]
mod tests {
    use super::super::items;
    use super::*;

    fn options(only: Option<&str>) -> Options {
        let only = only.map(|name| items::parse(name).unwrap());
        Options { only, quick: true, seed: 7, fresh: false, check: false, accept: false, into: None }
    }

    fn commands(only: Option<&str>) -> Vec<String> {
        stages(&options(only)).iter().map(|s| s.arguments.join(" ")).collect()
    }

    #[test]
    fn exact_options_reach_the_stages() {
        let all = commands(None);
        assert_eq!(
            all[0],
            "process --virtual-rig --seed 7 --repeats 4 --out virtual-rig/quick/observations --force"
        );
        assert_eq!(all[1], "flow virtual-rig/quick --out virtual-rig/quick/base --force");
        assert_eq!(all[2], "rank virtual-rig/quick --one-start --force");
        let cold = commands(Some("heater"));
        assert!(cold.len() == 3 && cold[0].contains("--rows C1,C2,C3,H0"), "{cold:?}");
        assert!(cold[1].ends_with("--until heater"), "{cold:?}");
    }

    #[test]
    fn exact_a_stage_is_kept_only_with_its_fingerprint_and_untouched_output() {
        let folder = std::env::temp_dir().join(format!("rijke-stages-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let base = folder.clone();
        let stage = Stage { base, arguments: vec![], inputs: vec![], output: ".".into(), share: 1.0 };
        fs::write(folder.join("a.csv"), "1").unwrap();
        assert_eq!(stage.finished("aa").unwrap(), None);
        let made = Made { seconds: 1.5, peak_mib: 70 };
        stage.mark("aa", &made).unwrap();
        assert_eq!(stage.finished("aa").unwrap(), Some(made));
        assert_eq!(stage.finished("ab").unwrap(), None);
        fs::write(folder.join("a.csv"), "2").unwrap();
        assert_eq!(stage.finished("aa").unwrap(), None, "the output was changed by hand");
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn exact_time_left_follows_the_stages_that_were_run() {
        let stages = stages(&options(None));
        assert_eq!(time_left(&[], &[], &stages), None);
        let done: Vec<Done> = vec![(Made { seconds: 20.0, peak_mib: 0 }, false, vec![])];
        let left = time_left(&stages[..1], &done, &stages[1..]).unwrap();
        assert!((left - 20.0 * 0.605 / 0.4).abs() < 1e-9, "{left}");
    }
}
