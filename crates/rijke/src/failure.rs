//! How a command ends when it cannot do its work: one message that names what, where, why and the remedy.

use rijke_numerics::OutputError;
use std::{error::Error, fmt, path::Path, process::ExitCode};

/// Why a command stopped.
#[derive(Debug)]
pub(crate) struct Failure {
    kind: Kind,
    message: String,
    causes: Vec<String>,
    remedy: Option<String>,
}

/// Who has to act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// The computation did not succeed on sound input: exit status 1.
    Failed,
    /// The user's files or options: exit status 2.
    BadInput,
}

impl Failure {
    /// The input is wrong (exit status 2). The message names the file and the place in it.
    pub(crate) fn bad_input(message: impl fmt::Display) -> Self {
        Self { kind: Kind::BadInput, message: message.to_string(), causes: Vec::new(), remedy: None }
    }

    /// The input is wrong, as an error of a library says, with what caused it.
    pub(crate) fn of_input(error: &(impl Error + 'static)) -> Self {
        Self::bad_input(error).because(error)
    }

    /// The input is sound, but the work could not be done (exit status 1).
    pub(crate) fn failed(message: impl fmt::Display) -> Self {
        Self { kind: Kind::Failed, ..Self::bad_input(message) }
    }

    /// What the user can do about it, as an imperative sentence.
    #[must_use]
    pub(crate) fn remedy(mut self, remedy: impl fmt::Display) -> Self {
        self.remedy = Some(remedy.to_string());
        self
    }

    /// Puts the file first, unless the message names it already.
    #[must_use]
    pub(crate) fn at(mut self, path: &Path) -> Self {
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

    /// The message as one line of JSON.
    pub(crate) fn json(&self) -> String {
        let status = if self.kind == Kind::BadInput { 2 } else { 1 };
        let (error, because, remedy) = (&self.message, &self.causes, &self.remedy);
        serde_json::json!({ "error": error, "because": because, "remedy": remedy, "exit_status": status })
            .to_string()
    }

    /// The exit status of the program.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self.kind {
            Kind::Failed => 1,
            Kind::BadInput => 2,
        })
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Refused { remedy, .. } => Self::bad_input(&error).remedy(remedy),
            _ => Self::failed(&error),
        }
    }
}

/// As a compiler prints it: `error:`, then `because:` and `remedy:`, later lines indented.
impl fmt::Display for Failure {
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

/// Turns an error of a library into a failure of a command, and says who must act, the user or the
/// maintainers: `read(path).or_bad_input()?`.
pub(crate) trait Classify<T> {
    /// The user's files or options: exit status 2.
    fn or_bad_input(self) -> Result<T, Failure>;
    /// The computation: exit status 1.
    fn or_failed(self) -> Result<T, Failure>;
}

impl<T, E: Error + 'static> Classify<T> for Result<T, E> {
    fn or_bad_input(self) -> Result<T, Failure> {
        self.map_err(|error| Failure::of_input(&error))
    }

    fn or_failed(self) -> Result<T, Failure> {
        self.map_err(|error| Failure::failed(&error).because(&error))
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
        let error = Failure::failed("cannot write out/a.csv").at(Path::new("out/a.csv"));
        assert_eq!(error.to_string(), "error: cannot write out/a.csv");
        assert_eq!(error.kind, Kind::Failed);
    }
}
