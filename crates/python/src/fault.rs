//! Errors as Python sees them: what, in which file, at which place, and the remedy.

use pyo3::prelude::*;
use rijke_engine::EngineError;
use rijke_inference::InferenceError;
use rijke_network::NetworkError;
use rijke_network::file::{FileError, NumberError};
use rijke_study::StudyError;

/// An error on its way to Python.
#[derive(Debug)]
pub(crate) struct Fault {
    /// Class in `rijke._errors`.
    class: &'static str,
    message: String,
    file: Option<String>,
    place: Option<String>,
    remedy: Option<String>,
}

/// What a function hands to Python.
pub(crate) type Answer<T> = Result<T, Fault>;

impl Fault {
    /// The caller's files or arguments.
    pub(crate) fn input(message: impl ToString) -> Self {
        let message = message.to_string();
        Self { class: "InputError", message, file: None, place: None, remedy: None }
    }

    /// The input is sound, but the work could not be done.
    pub(crate) fn failed(message: impl ToString) -> Self {
        Self { class: "ComputationError", ..Self::input(message) }
    }

    /// What to do about it.
    pub(crate) fn remedy(self, remedy: &str) -> Self {
        Self { remedy: Some(remedy.to_owned()), ..self }
    }

    /// Which file it is about.
    pub(crate) fn file(self, file: Option<&str>) -> Self {
        Self { file: file.map(String::from), ..self }
    }

    fn place(self, place: String) -> Self {
        Self { place: Some(place), ..self }
    }
}

impl From<Fault> for PyErr {
    fn from(fault: Fault) -> Self {
        Python::attach(|py| {
            let Fault { class, message, file, place, remedy } = fault;
            let class = py.import("rijke._errors").and_then(|module| module.getattr(class));
            match class.and_then(|class| class.call1((message, file, place, remedy))) {
                Ok(value) => Self::from_value(value),
                Err(error) => error,
            }
        })
    }
}

impl From<FileError> for Fault {
    fn from(error: FileError) -> Self {
        let keys = "Correct this table; docs/network-file.md lists the keys that it takes.";
        match error {
            FileError::Syntax { message } => Self::input(message)
                .remedy("Correct the TOML; docs/network-file.md lists the tables and their keys."),
            FileError::Element { line, place, problem } => {
                Self::input(problem).place(format!("line {line}, {place}")).remedy(keys)
            }
            FileError::Flow { line, problem } => {
                Self::input(problem).place(format!("line {line}, [flow]")).remedy(keys)
            }
            FileError::Search { line, .. } => {
                Self::input(error.to_string()).place(format!("line {line}, [search]")).remedy(keys)
            }
            FileError::NoDuct => Self::input(&error).remedy("Add a duct with a length and a diameter."),
            error => Self::input(error).remedy(keys),
        }
    }
}

impl From<NetworkError> for Fault {
    fn from(error: NetworkError) -> Self {
        match error {
            NetworkError::NotConverged { .. } | NetworkError::LostBranch { .. } => Self::failed(error)
                .remedy("Guess nearer to the mode; Network.modes() finds every mode of a region."),
            NetworkError::NotFinite { .. } => {
                Self::failed(error).remedy("Ask at another s: a law has no value there, or it is a mode.")
            }
            error => Self::input(error)
                .remedy("Change the region (growth_rate, frequency_hz), or the element or place named."),
        }
    }
}

impl From<NumberError> for Fault {
    fn from(error: NumberError) -> Self {
        match error {
            NumberError::File(source) => source.into(),
            NumberError::Network(source) => source.into(),
            error => Self::input(error).remedy("Network.numbers() holds every number by name."),
        }
    }
}

impl From<StudyError> for Fault {
    fn from(error: StudyError) -> Self {
        let fault = Self::input(&error.problem)
            .file(Some(&error.file))
            .remedy("Correct the file; docs/study-folder.md describes it.");
        match error.line {
            Some(line) => fault.place(format!("line {line}")),
            None => fault,
        }
    }
}

impl From<EngineError> for Fault {
    fn from(error: EngineError) -> Self {
        match error {
            EngineError::Study(source) => source.into(),
            EngineError::Inference(source) => source.into(),
            EngineError::NotConverged { .. } | EngineError::Dense(_) => Self::failed(error)
                .remedy("Look at the priors: a model that the data do not determine has no maximum."),
            error if error.is_recoverable() => Self::failed(error)
                .remedy("Try parameters nearer to the most probable ones: the mode was lost."),
            error => Self::input(error)
                .remedy("Correct what is named in the study's folder; docs/study-folder.md describes it."),
        }
    }
}

impl From<InferenceError> for Fault {
    fn from(error: InferenceError) -> Self {
        Self::failed(error).remedy("Look at the model, the priors and the data that are named.")
    }
}
