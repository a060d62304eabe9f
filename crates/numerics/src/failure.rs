//! How a step ends when it cannot do its work: one message that names what, where, why and the remedy.

use std::path::Path;
use std::{error::Error, fmt};

/// Why a step stopped: for steps that read and write whole folders, whose faults a user mends by hand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failed {
    /// Who has to act.
    pub kind: Blame,
    /// What is wrong, and where.
    pub message: String,
    /// What caused it, the nearest first.
    pub causes: Vec<String>,
    /// What to do, an imperative sentence.
    pub remedy: Option<String>,
}

/// Who has to act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The maintainers: the computation did not succeed on sound input.
    Work,
    /// The user: files or options.
    Input,
}

impl Failed {
    /// The input is wrong. The message names the file and the place in it.
    #[must_use]
    pub fn bad_input(message: impl fmt::Display) -> Self {
        Self { kind: Blame::Input, message: message.to_string(), causes: Vec::new(), remedy: None }
    }

    /// The input is wrong, as an error of a library says, with what caused it.
    #[must_use]
    pub fn of_input(error: &(impl Error + 'static)) -> Self {
        Self::bad_input(error).because(error)
    }

    /// The input is sound, but the work could not be done.
    #[must_use]
    pub fn of_work(message: impl fmt::Display) -> Self {
        Self { kind: Blame::Work, ..Self::bad_input(message) }
    }

    /// What the user can do about it, as an imperative sentence.
    #[must_use]
    pub fn remedy(mut self, remedy: impl fmt::Display) -> Self {
        self.remedy = Some(remedy.to_string());
        self
    }

    /// Puts the file first, unless the message names it already.
    #[must_use]
    pub fn at(mut self, path: &Path) -> Self {
        let path = path.display().to_string();
        if !self.message.contains(&path) {
            self.message = format!("{path}: {}", self.message);
        }
        self
    }

    fn because(mut self, error: &(dyn Error + 'static)) -> Self {
        let mut cause = error.source();
        while let Some(error) = cause {
            // Many errors print their source themselves: say nothing twice.
            let text = error.to_string();
            if !self.message.contains(&text) && !self.causes.iter().any(|c| c.contains(&text)) {
                self.causes.push(text);
            }
            cause = error.source();
        }
        self
    }
}

/// As a compiler prints it: `error:`, then `because:` and `remedy:`, later lines indented.
impl fmt::Display for Failed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let indented = |text: &str| text.trim_end().replace('\n', "\n  ");
        write!(f, "error: {}", indented(&self.message))?;
        for cause in &self.causes {
            write!(f, "\n  because: {}", indented(cause))?;
        }
        if let Some(remedy) = &self.remedy {
            write!(f, "\n  remedy: {}", indented(remedy))?;
        }
        Ok(())
    }
}

impl Error for Failed {}

/// Turns an error of a library into a failure of a step, and says who must act, the user or the
/// maintainers: `read(path).or_bad_input()?`.
pub trait Classify<T> {
    /// The user's files or options.
    ///
    /// # Errors
    /// [`Failed`].
    fn or_bad_input(self) -> Result<T, Failed>;
    /// The computation.
    ///
    /// # Errors
    /// [`Failed`].
    fn or_failed(self) -> Result<T, Failed>;
}

impl<T, E: Error + 'static> Classify<T> for Result<T, E> {
    fn or_bad_input(self) -> Result<T, Failed> {
        self.map_err(|error| Failed::of_input(&error))
    }

    fn or_failed(self) -> Result<T, Failed> {
        self.map_err(|error| Failed::of_work(&error).because(&error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("microphone 3 is at 1.2 m")]
    struct Outer(#[source] std::num::ParseFloatError);

    #[test]
    fn exact_message_names_file_cause_and_remedy() {
        let error = "x".parse::<f64>().map_err(Outer).or_bad_input().unwrap_err();
        let text = error.at(Path::new("rig.toml")).remedy("Give a position\nbetween 0 and 1 m.").to_string();
        assert_eq!(
            text,
            "error: rig.toml: microphone 3 is at 1.2 m\n  because: invalid float literal\n  \
             remedy: Give a position\n  between 0 and 1 m."
        );
    }

    #[test]
    fn exact_a_path_is_named_once() {
        let error = Failed::of_work("cannot write out/a.csv").at(Path::new("out/a.csv"));
        assert_eq!(error.to_string(), "error: cannot write out/a.csv");
        assert_eq!(error.kind, Blame::Work);
    }
}
